"""The programs in the library's pages: each is run, if the library that it is about is installed."""

from __future__ import annotations

import ast
import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from patience import PROGRAM

DOCS = Path(__file__).parents[3] / "docs"
BLOCK = re.compile(r"```python\n(.*?)```", re.DOTALL)
SMALL = "sim:?width=640&height=480&fps=100&exposure=2000"
PAGES = ("first-script.md", "cookbook.md", "logging.md")
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


def programs(page: str) -> list[str]:
    return BLOCK.findall((DOCS / page).read_text("utf-8"))


@pytest.mark.parametrize("page", PAGES)
def test_every_program_of_a_page_runs(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert programs(page)
    for program in programs(page):
        text = re.sub(r'"(?:gige|v4l2):\w*"', f'"{SMALL}"', program)
        exec(compile(text, page, "exec"), {"__name__": "__main__"})
    assert page == "logging.md" or capsys.readouterr().out


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
