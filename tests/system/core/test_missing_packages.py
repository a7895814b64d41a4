"""An import that fails is one line with the command that helps, wherever it happens."""

from __future__ import annotations

import platform
import re
import subprocess
import sys
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from grabbergui.core.missing_packages import explained, install_command, window_has_wheels
from grabbergui.doctor.findings import Level
from grabbergui.doctor.packages import NEEDED, loadable, opencv
from patience import PROGRAM

ROOT = Path(__file__).parents[3]
LIBPYTHON = "libpython3.11.so.1.0: cannot open shared object file: No such file or directory"


@pytest.mark.parametrize(
    ("error", "said"),
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
def test_the_reason_and_the_remedy_are_one_line(error: ImportError, said: str) -> None:
    assert said in explained(error)
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


def run_without(modules: list[str], *arguments: str, script: str = "") -> subprocess.CompletedProcess[str]:
    """Run a command, or a script, where importing these modules fails."""
    block = f"""
import sys
class Finder:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {modules!r}:
            raise ModuleNotFoundError(f"No module named '{{name}}'", name=name)
sys.meta_path.insert(0, Finder())
"""
    command = script or "from grabbergui.__main__ import main; sys.argv[0] = 'grabbergui'; sys.exit(main())"
    return subprocess.run(
        [sys.executable, "-c", block + command, *arguments], capture_output=True, text=True, timeout=PROGRAM
    )


@pytest.mark.parametrize(
    ("module", "arguments", "said"),
    [
        (
            "PyQt5",
            ["gui", "sim:", "--offscreen"],
            "the window needs PyQt5, which cannot be loaded: the package PyQt5",
        ),
        ("genicam", ["grab", "sim:"], "the package genicam is not installed"),
        ("numpy", ["grab", "sim:"], "the package numpy is not installed"),
        ("psutil", ["grab", "gige:"], "the package psutil is not installed"),
        (
            "av",
            ["record", "sim:?width=64&height=48", "--out", "x.mp4", "-n", "1"],
            "x.mp4 cannot be recorded",
        ),
    ],
)
def test_a_command_names_the_remedy_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, module: str, arguments: list[str], said: str
) -> None:
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    monkeypatch.chdir(tmp_path)
    done = run_without([module], *arguments)
    assert done.returncode == 1 and len(done.stderr.splitlines()) == 1, done.stderr
    assert said in done.stderr and "pip install" in done.stderr


def test_everything_but_the_window_works_without_qt(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    monkeypatch.chdir(tmp_path)
    small = "sim:?width=64&height=48&fps=100"
    qt = ["PyQt5", "pyqtgraph", "superqt"]
    for arguments in (
        ["grab", small, "-n", "2", "--out", "frames"],
        ["get", small, "Gain"],
        ["list", "--timeout", "0.2"],
    ):
        done = run_without(qt, *arguments)
        assert done.returncode == 0, done.stderr
    script = f"import grabbergui\nwith grabbergui.open({small!r}) as c: print(c.grab().rgb().shape)"
    assert run_without(qt, script=script).stdout == "(48, 64, 3)\n"


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
