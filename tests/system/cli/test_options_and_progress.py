"""Options that a command does not have, progress on a terminal, and the fields of `--json`."""

from __future__ import annotations

import json
import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest

from grabbergui import __version__
from grabbergui.cli import COMMANDS, command_parsers, main
from grabbergui.cli.json_output import JSON_OUTPUT
from grabbergui.driver.gige.privilege import served_uris
from patience import PROGRAM

SMALL = "sim:?width=64&height=48&fps=100"


def run(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int | str | None, str, str]:
    try:
        code: int | str | None = main(arguments)
    except SystemExit as error:
        code = error.code
    printed = capsys.readouterr()
    return code, printed.out, printed.err


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("grab sim: --timout 5", "grab has no option --timout; did you mean --timeout?"),
        ("grab sim: --time 5", "grab has no option --time; did you mean --timeout?"),  # no abbreviation
        ("record sim: --ot run.mcap", "record has no option --ot; did you mean --out?"),
        ("list --jsn", "list has no option --jsn; did you mean --json?"),
        ("--offscren", "gui has no option --offscren; did you mean --offscreen?"),
        ("list -x", "list has no option -x; `grabbergui list --help` lists them"),
        ("list here", "list takes no further argument, such as 'here'"),
    ],
)
def test_an_unknown_option_is_named_with_what_was_meant(
    capsys: pytest.CaptureFixture[str], line: str, message: str
) -> None:
    code, _, err = run(capsys, *line.split())
    assert code == 2 and err.splitlines()[-1] == f"grabbergui: {message}"


@pytest.mark.parametrize("command", ["list", "grab", "serve", "gui"])
def test_the_version_is_printed_after_a_command_too(capsys: pytest.CaptureFixture[str], command: str) -> None:
    assert run(capsys, command, "--version") == (0, f"grabbergui {__version__}\n", "")


def on_terminal(*arguments: str) -> str:
    """Run a command whose stderr is a terminal; return what it wrote there."""
    ours, its = pty.openpty()
    with subprocess.Popen(
        [sys.executable, "-m", "grabbergui", *arguments], stdout=subprocess.PIPE, stderr=its
    ) as process:
        os.close(its)
        written = b""
        try:
            while block := os.read(ours, 4096):
                written += block
        except OSError:  # the other end is closed
            pass
        os.close(ours)
        assert process.wait(PROGRAM) == 0
    return written.decode()


@pytest.mark.parametrize(
    ("command", "shown"),
    [
        (["record", SMALL, "-t", "1", "--out", "run.mcap"], "; Ctrl-C ends it"),
        (["grab", SMALL, "-n", "60", "--out", "frames"], " of 60 frames"),
        (["files", SMALL, "get", "LUTLuminance"], "LUTLuminance"),
    ],
)
def test_progress_is_shown_on_a_terminal_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: list[str], shown: str
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[3]))
    written = on_terminal(*command)
    assert shown in written and written.endswith("\r\033[K")
    if command[0] != "record":
        return
    monkeypatch.chdir(tmp_path.parent)
    (tmp_path.parent / "run.mcap").unlink(missing_ok=True)
    piped = subprocess.run(
        [sys.executable, "-m", "grabbergui", *command], capture_output=True, text=True, timeout=PROGRAM
    )
    assert (piped.returncode, piped.stderr) == (0, "")


def fields_of(output: object) -> set[str]:
    first = output[0] if isinstance(output, list) else output
    return set(first) if isinstance(first, dict) else set()


def test_every_command_with_json_has_its_output_documented() -> None:
    offered = {name for name, (_, parser) in command_parsers().items() if "--json" in parser.format_help()}
    assert offered == set(JSON_OUTPUT) & set(COMMANDS)


@pytest.mark.parametrize(
    "line",
    [
        "list --timeout 0.2",
        "features SOURCE",
        "save SOURCE saved.yaml",
        "load SOURCE made.yaml",
        "diff SOURCE made.yaml",
        "files SOURCE",
        "report SOURCE --out report.zip",
        "grab SOURCE -n 2",
        "record SOURCE -n 2 --out run.mcap",
    ],
)
def test_json_has_the_documented_fields(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, line: str
) -> None:
    monkeypatch.chdir(tmp_path)
    if "made.yaml" in line:
        run(capsys, "save", f"{SMALL}&gain=3", "made.yaml")
    command, *words = line.replace("SOURCE", SMALL).split()
    code, out, err = run(capsys, command, *words, "--json")
    assert fields_of(json.loads(out)) == set(JSON_OUTPUT[command].fields), (code, err)


@pytest.mark.parametrize(
    ("command", "uris"),
    [
        ("python -m grabbergui serve gige: --yarp /cam --ros2 /camera", ["yarp:/cam", "ros2:/camera"]),
        ("/usr/bin/grabbergui serve --yarp=/cam", ["yarp:/cam"]),
        ("grabbergui serve gige: --window", []),
        ("grabbergui rig serve s.yaml --yarp /stereo", ["yarp:/stereo/CAMERA"]),
        ("arv-viewer --yarp /cam", []),
    ],
)
def test_a_server_of_ours_is_recognised_by_its_command_line(command: str, uris: list[str]) -> None:
    assert list(served_uris(command.split())) == uris
