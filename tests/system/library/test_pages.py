"""The programs in the library's pages: each is run, if the library that it is about is installed."""

from __future__ import annotations

import ast
import importlib.util
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import grabbergui
from grabbergui.core.pfnc import by_name
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige.server import GigeCamera
from patience import PROGRAM

DOCS = Path(__file__).parents[3] / "docs"
BLOCK = re.compile(r"```python\n(.*?)```", re.DOTALL)
SMALL = "sim:?width=640&height=480&fps=100&exposure=2000"
PAGES = (
    "../README.md",
    "first-script.md",
    "cookbook.md",
    "logging.md",
    "library.md",
    "rig.md",
    "tuning.md",
    "usb3-vision.md",
)
QUIET = ("logging.md", "tuning.md", "usb3-vision.md")
"""Pages whose programs print nothing."""
NET = f"127.95.{os.getpid() % 250 + 1}"
"Network of this test run alone: others may run at the same time."
ADDRESSES = (f"{NET}.1", f"{NET}.2")
INSTEAD = (
    (r"""["']gige:(?:left|GV01|192\.168\.0\.10)["']""", f'"gige:{ADDRESSES[0]}"'),
    (r"""["']gige:(?:right|GV02)["']""", f'"gige:{ADDRESSES[1]}"'),
    (r'"(?:gige|v4l2):\w*"', f'"{SMALL}"'),
    (r"\(100\b", "(5"),
    (r"trigger_group\(\)", "trigger_group(ahead=3)"),
)
"""What takes the place of cameras, numbers of frames, and the time that a busy machine needs to trigger."""
PEERS = {
    "grabbergui": "grabbergui",
    "pypylon": "pypylon",
    "harvesters": "harvesters",
    "Aravis": "gi",
    "OpenCV": "cv2",
}
SYSTEM_PYTHON = "/usr/bin/python3"
FAKE_CAMERA = """
import gi
gi.require_version("Aravis", "0.8")
from gi.repository import Aravis
Aravis.disable_interface("GigEVision")
Aravis.disable_interface("USB3Vision")
Aravis.enable_interface("Fake")
"""


class Times:
    """True so many times: for a loop that a user ends."""

    def __init__(self, times: int) -> None:
        self._left = times

    def __bool__(self) -> bool:
        self._left -= 1
        return self._left >= 0


def programs(page: str) -> list[str]:
    return BLOCK.findall((DOCS / page).read_text("utf-8"))


@contextmanager
def what_the_text_has(program: str) -> Iterator[dict[str, Any]]:
    """Yield the names of a page's text, with which a program without imports goes on."""
    names: dict[str, Any] = {"__name__": "__main__"}
    with ExitStack() as stack:
        if "import " not in program:
            camera = stack.enter_context(grabbergui.open(f"{SMALL}&pixel_format=BayerRG8"))
            names |= {"np": np, "grabbergui": grabbergui, "camera": camera, "frame": camera.grab()}
            names["running"] = Times(2)
            if "cameras" in program and "open_all" not in program:
                names["cameras"] = stack.enter_context(grabbergui.open_all([f"gige:{a}" for a in ADDRESSES]))
        yield names


@pytest.fixture
def two_cameras() -> Iterator[None]:
    small = {reg.WIDTH: 64, reg.HEIGHT: 48, reg.EXPOSURE_TIME: 2000.0, reg.FRAME_RATE: 50.0}
    small[reg.PIXEL_FORMAT] = by_name("BayerRG8").code
    cameras = [GigeCamera(address, power_on=small) for address in ADDRESSES]
    yield
    for camera in cameras:
        camera.close()


@pytest.mark.usefixtures("two_cameras")
@pytest.mark.parametrize("page", PAGES)
def test_every_program_of_a_page_runs(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    left, right = (f"gige:{address}" for address in ADDRESSES)
    (tmp_path / "stereo.yaml").write_text(f"cameras:\n  left: {left}\n  right: {right}\n")
    assert programs(page)
    for program in programs(page):
        text = program
        for pattern, instead in INSTEAD:
            text = re.sub(pattern, instead, text)
        with what_the_text_has(program) as names:
            exec(compile(text, page, "exec"), names)
    assert page in QUIET or capsys.readouterr().out


def peers() -> dict[str, list[str]]:
    """Return the programs of the page about other libraries, in the order of the jobs."""
    found: dict[str, list[str]] = {name: [] for name in PEERS}
    text = (DOCS / "migration.md").read_text("utf-8")
    for name, program in re.findall(r"^(\w+):\n\n```python\n(.*?)```", text, re.DOTALL | re.MULTILINE):
        found[name].append(program)
    return found


def lines_of(program: str) -> int:
    return sum(bool(line.strip()) for line in program.splitlines())


def test_the_lines_are_counted_as_they_are() -> None:
    rows = re.findall(
        r"^\| (?:one|100|three) [^|]*\|(.*)\|$", (DOCS / "migration.md").read_text("utf-8"), re.MULTILINE
    )
    order = ("grabbergui", "OpenCV", "pypylon", "harvesters", "Aravis")
    for job, row in enumerate(rows):
        programs_of_job = [peers()[name][job : job + 1] for name in order]
        lines = [str(lines_of(*each)) if each else "–" for each in programs_of_job]
        assert [cell.strip() for cell in row.split("|")] == lines
    assert len(rows) == 3


@pytest.mark.parametrize("job", range(3))
@pytest.mark.parametrize("name", PEERS)
def test_the_same_job_with_another_library(
    name: str, job: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if name == "OpenCV" and job == 2:
        return  # it cannot do that
    program = peers()[name][job]
    ast.parse(program)
    environment, python = dict(os.environ, PYTHONPATH=str(DOCS.parent)), sys.executable
    if name == "grabbergui":
        program = program.replace('"gige:"', f'"{SMALL}"')
    elif name == "Aravis":
        python, program = SYSTEM_PYTHON, FAKE_CAMERA + program.replace("new(None)", 'new("Fake_1")')
        numpy = importlib.util.find_spec("numpy")
        assert numpy is not None and numpy.origin is not None
        for folder in ("numpy", "numpy.libs"):
            (tmp_path / folder).symlink_to(Path(numpy.origin).parents[1] / folder)
        environment["PYTHONPATH"] = str(tmp_path)
        check = "import gi, numpy; gi.require_version('Aravis', '0.8')"
        if (
            not Path(SYSTEM_PYTHON).exists()
            or subprocess.run(
                [SYSTEM_PYTHON, "-c", check], env=environment, capture_output=True, timeout=PROGRAM
            ).returncode
        ):
            pytest.skip("Debian's gir1.2-aravis-0.8 and python3-gi are not installed for this Python")
    elif name == "OpenCV" or importlib.util.find_spec(PEERS[name]) is None:
        pytest.skip(f"{name} is not installed, or there is no webcam; the program was only parsed")
    elif name == "harvesters":
        import genicam

        producer = Path(genicam.__file__).parent / "viky.cti"
        if job:
            pytest.skip("the producer's camera has no exposure time; the program was only parsed")
        program = program.replace("producer.cti", str(producer))
    elif name == "pypylon":
        environment["PYLON_CAMEMU"] = "1"
    done = subprocess.run(
        [python, "-c", program],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        timeout=PROGRAM,
    )
    assert done.returncode == 0, done.stderr
