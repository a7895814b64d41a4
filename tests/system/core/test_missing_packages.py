"""An import that fails is one line with the command that helps, wherever it happens."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from patience import PROGRAM

ROOT = Path(__file__).parents[3]


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
    ("module", "arguments", "message"),
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
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, module: str, arguments: list[str], message: str
) -> None:
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    monkeypatch.chdir(tmp_path)
    done = run_without([module], *arguments)
    assert done.returncode == 1 and len(done.stderr.splitlines()) == 1, done.stderr
    assert message in done.stderr and "pip install" in done.stderr


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
