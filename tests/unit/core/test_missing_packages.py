"""An import that fails is one line with the command that helps, wherever it happens."""

from __future__ import annotations

import platform
import re
import sys
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from grabbergui.core.missing_packages import explained, install_command, window_has_wheels
from grabbergui.doctor.findings import Level
from grabbergui.doctor.packages import NEEDED, loadable, opencv

ROOT = Path(__file__).parents[3]
LIBPYTHON = "libpython3.11.so.1.0: cannot open shared object file: No such file or directory"


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (
            ImportError(LIBPYTHON),
            "the system's library libpython3.11.so.1.0 is missing: sudo apt-get install",
        ),
        (ImportError(LIBPYTHON, name="genicam"), "sudo apt-get install libpython3.11"),
        (
            ImportError("libGL.so.1: cannot open shared object file", name="cv2"),
            "library libGL.so.1, which cv2 needs, is missing",
        ),
        (ImportError("libGL.so.1: cannot open shared object file", name="cv2"), "apt-get install libgl1 "),
        (
            ImportError("libodd.so.7: cannot open", name="odd"),
            "the package of your system that contains it",
        ),
        (ModuleNotFoundError("No module named 'yaml'", name="yaml"), "-m pip install PyYAML"),
        (
            ModuleNotFoundError("No module named 'PyQt5'", name="PyQt5.QtCore"),
            "the package PyQt5 is not installed",
        ),
        (
            ImportError("undefined symbol: x\nin y.so", name="av"),
            "cannot be loaded (undefined symbol: x in y.so)",
        ),
    ],
)
def test_the_reason_and_the_remedy_are_one_line(error: ImportError, message: str) -> None:
    assert message in explained(error)
    assert "\n" not in explained(error)


@pytest.mark.parametrize(
    ("system", "machine", "wheels"),
    [
        ("linux", "x86_64", True),
        ("linux", "aarch64", False),
        ("linux", "armv7l", False),
        ("darwin", "arm64", True),
        ("win32", "AMD64", True),
        ("win32", "ARM64", False),
    ],
)
def test_the_window_is_required_where_it_has_wheels(
    monkeypatch: pytest.MonkeyPatch, system: str, machine: str, wheels: bool
) -> None:
    (line,) = re.findall(r'^    "(PyQt5>.*)",$', (ROOT / "pyproject.toml").read_text("utf-8"), re.MULTILINE)
    qt = Requirement(line)
    assert qt.marker is not None
    assert qt.marker.evaluate({"sys_platform": system, "platform_machine": machine}) is wheels
    monkeypatch.setattr(sys, "platform", system)
    monkeypatch.setattr(platform, "machine", lambda: machine)
    assert window_has_wheels() is wheels
    assert ("apt-get install python3-pyqt5" in install_command("PyQt5")) is not wheels


def test_the_doctor_names_what_cannot_be_loaded() -> None:
    def load(module: str) -> None:
        if module in ("genicam.genapi", "PyQt5.QtWidgets"):
            raise ImportError(LIBPYTHON, name=module)

    broken, window = loadable(load)
    assert broken.level is Level.PROBLEM and broken.remedy.startswith("sudo apt-get install libpython3.11")
    assert window.level is Level.NOTE and "all else can" in window.text
    (fine,) = loadable(lambda module: None)
    assert fine.level is Level.GOOD and len(NEEDED) > 5


def test_two_opencvs_are_a_problem() -> None:
    assert not list(opencv(["opencv-python-headless"]))
    (finding,) = opencv(["opencv-python-headless", "opencv-python"])
    assert finding.level is Level.PROBLEM and "cv2.imshow" in finding.remedy


@pytest.mark.parametrize(
    ("error", "line"),
    [
        (
            ImportError("libGL.so.1: cannot open shared object file", name="cv2.x"),
            "the system's library libGL.so.1, which cv2 needs, is missing:"
            " sudo apt-get install libgl1 (or your system's package with it)",
        ),
        (
            ImportError("libodd-2.so.7: cannot open", name="_genapi"),
            "the system's library libodd-2.so.7, which genicam needs, is missing:"
            " install the package of your system that contains it",
        ),
        (
            ModuleNotFoundError("No module named 'usb'", name="usb.core"),
            "the package usb is not installed: /usr/bin/python3 -m pip install pyusb",
        ),
        (
            ModuleNotFoundError("No module named 'av'", name="av"),
            "the package av is not installed: /usr/bin/python3 -m pip install av",
        ),
        (
            ImportError("undefined symbol: x\nin libav.so.7", name="av"),
            "the package av is installed, but cannot be loaded (undefined symbol: x in libav.so.7):"
            " install grabbergui again in a new environment",
        ),
        (
            ImportError("broken"),
            "the package in question is installed, but cannot be loaded (broken):"
            " install grabbergui again in a new environment",
        ),
    ],
)
def test_a_reason_and_a_remedy(monkeypatch: pytest.MonkeyPatch, error: ImportError, line: str) -> None:
    monkeypatch.setattr(sys, "executable", "/usr/bin/python3")
    assert explained(error) == line


def test_the_window_where_it_has_no_wheels_is_debians(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(platform, "machine", lambda: "aarch64")
    monkeypatch.setattr(sys, "base_prefix", "/usr")
    monkeypatch.setattr(sys, "base_exec_prefix", "/usr")
    monkeypatch.setattr(sys, "version_info", (3, 11, 2))
    monkeypatch.setattr(sys, "prefix", "/usr")
    assert install_command("PyQt5") == "sudo apt-get install python3-pyqt5"
    monkeypatch.setattr(sys, "prefix", "/home/ada/my env")
    make = "/usr/bin/python3.11 -m venv --system-site-packages --upgrade '/home/ada/my env'"
    assert install_command("PyQt5") == f"sudo apt-get install python3-pyqt5 && {make}"
