"""The command line as a person uses it, on the simulated camera."""

import json
import subprocess
import sys

import pytest

from grabbergui.cli import main
from patience import PATIENCE, PROGRAM

SMALL = "sim:?width=64&height=48&fps=100"


def run(capsys, *arguments):
    """Exit code, stdout, stderr."""
    try:
        code = main(arguments)
    except SystemExit as error:  # argparse's own
        code = error.code
    printed = capsys.readouterr()
    return code, printed.out, printed.err


def test_list_names_the_simulated_camera(capsys):
    code, out, _ = run(capsys, "list", "--json", "--timeout", "0.2")

    assert code == 0
    found = json.loads(out)
    camera = next(info for info in found if info["uri"] == "sim:")
    assert {"uri", "vendor", "model", "serial", "address"} <= camera.keys()
    assert camera["serial"]


def test_the_human_readable_list_has_a_heading_and_aligned_columns(capsys):
    code, out, _ = run(capsys, "list", "--timeout", "0.2")

    heading, *rows = out.splitlines()
    assert code == 0 and rows
    assert all(row[heading.index("SERIAL") - 1] == " " for row in rows)


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["get", "sim:", "ExposureTim"], "has no feature ExposureTim; did you mean ExposureTime"),
        (["get", "sim:", "TimestampLatch"], "TimestampLatch is a command and has no value"),
        (["set", "sim:", "Width=99999"], "Width=99999: out of range; allowed: 16 … 4096 px, step 8"),
        (["set", "sim:", "Width=much"], "Width=much: not a whole number; allowed: 16"),
        (["set", "sim:", "SensorWidth=8"], "SensorWidth is read-only"),
        (["set", "sim:", "TLParamsLocked=0"], "TLParamsLocked is set by the stream alone"),
        (["run", "sim:", "Width"], "Width is no command"),
        (
            ["grab", "sim:", "--set", "PixelFormat=Mono9"],
            "PixelFormat=Mono9: no such entry; allowed: one of",
        ),
        (["get", "gige:192.0.2.1/nonsense", "Width"], "192.0.2.1/nonsense"),
    ],
)
def test_what_fails_is_one_clear_line_and_exit_code_1(capsys, arguments, line):
    code, out, err = run(capsys, *arguments)

    assert (code, out) == (1, "")
    assert line in err and err.count("\n") == 1


def test_optional_arguments_are_divided_by_options(capsys, tmp_path):
    path = tmp_path / "copy.bin"

    code, out, _ = run(capsys, "files", SMALL, "get", "--json", "LUTLuminance", str(path))

    assert code == 0
    assert json.loads(out) == {"file": "LUTLuminance", "size": 8192, "path": str(path)}


def test_a_script_with_a_line_that_is_refused_has_failed():
    for lines, expected in (("set Gain 3\nset Gain 1e9\nget Gain\n", 1), ("set Gain 3\n", 0)):
        done = subprocess.run(
            [sys.executable, "-m", "grabbergui", "terminal", SMALL],
            input=lines, capture_output=True, text=True, timeout=PROGRAM,
        )  # fmt: skip
        assert done.returncode == expected
        assert "Gain = 3" in done.stdout and ("1e9" in done.stderr) == bool(expected)


def test_the_module_runs_and_a_closed_pipe_is_no_error():
    command = [sys.executable, "-m", "grabbergui", "features", "sim:"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout is not None and process.stderr is not None
    process.stdout.close()
    assert process.stderr.read() == b""
    process.stderr.close()
    assert process.wait(PATIENCE) == 0
