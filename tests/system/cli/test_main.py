"""Common to all commands: unknown words, signals, and output that cannot be written."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from grabbergui.cli import EXIT_FAILURE, EXIT_HUNG_UP, EXIT_INTERRUPTED, EXIT_TERMINATED, machine, main
from patience import PROGRAM

PROGRAM_LINE = [sys.executable, "-m", "grabbergui"]


def run(*arguments, **keywords):
    return subprocess.run(
        [*PROGRAM_LINE, *arguments], stderr=subprocess.PIPE, text=True, timeout=PROGRAM, **keywords
    )


@pytest.mark.parametrize(
    ("word", "meant"),
    [
        ("lits", "grabbergui list"),
        ("read", "grabbergui get"),
        ("write", "grabbergui set"),
        ("sim", "grabbergui sim:"),
        ("192.168.0.10", "grabbergui gige:192.168.0.10"),
        (__file__, f"grabbergui file:{__file__}"),
        ("zzz", "grabbergui --help"),
    ],
)
def test_an_unknown_command_is_answered_with_a_suggestion(word, meant, capsys):
    assert main([word]) == 2
    assert f"`{meant}`" in capsys.readouterr().err


def test_no_window_opens_on_a_source_of_no_kind(capsys):
    assert main(["foo:bar"]) == 2
    assert "no known kind" in capsys.readouterr().err


def test_a_file_of_settings_is_for_the_camera_opened_last(tmp_path, monkeypatch, capsys):
    path, runs = tmp_path / "my camera.yaml", []
    monkeypatch.setattr(
        "grabbergui.ui.run.window.run", lambda *arguments, **options: runs.append((arguments, options)) or 0
    )
    assert main([path.as_uri()]) == 2
    assert f"{path} does not exist" in capsys.readouterr().err
    path.write_text("device: x\nfeatures: {}\n")
    assert main([path.as_uri()]) == 0
    assert main([(tmp_path / "recording.mcap").as_uri()]) == 0
    assert [(arguments[0], options["settings"]) for arguments, options in runs] == [
        (None, path),
        ((tmp_path / "recording.mcap").as_uri(), None),
    ]


def test_without_a_display_the_window_reports_it():
    environment = {
        name: value
        for name, value in os.environ.items()
        if name not in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")
    }
    done = run("sim:", env=environment)
    assert done.returncode == 1
    assert len(done.stderr.splitlines()) == 1 and "--offscreen" in done.stderr


@pytest.mark.skipif(sys.platform != "linux", reason="names a display of X11")
def test_a_display_that_is_not_there_ends_it_without_a_core_dump():
    environment = {**os.environ, "DISPLAY": ":4711"}
    environment.pop("QT_QPA_PLATFORM", None)
    environment.pop("WAYLAND_DISPLAY", None)
    done = run("sim:", env=environment)
    assert done.returncode == 1
    assert "could not connect to display :4711" in done.stderr


def test_the_end_of_a_program_searches_no_garbage():
    code = (
        "import atexit, gc, sys\n"
        "atexit.register(lambda: print(gc.get_freeze_count() > 1000))\n"
        "from grabbergui.__main__ import main\n"
        "sys.argv = ['grabbergui', '--version']\n"
        "main()"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=PROGRAM)
    assert done.stdout.splitlines()[-1] == "True", "objects that the last collections skip"


def test_an_interrupt_while_it_loads_says_nothing():
    code = (
        "import importlib, signal; from grabbergui.cli import main\n"
        "importlib.import_module = lambda name: signal.raise_signal(signal.SIGINT)\n"
        "main(['list'])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=PROGRAM)
    assert (done.returncode, done.stdout, done.stderr) == (-signal.SIGINT, "", "")


def test_an_interrupt_before_the_command_line_is_imported_says_nothing():
    code = (
        "import builtins, signal\n"
        "from grabbergui.__main__ import main\n"
        "load = builtins.__import__\n"
        "def interrupted(name, *rest, **more):\n"
        "    if name.startswith('grabbergui.cli'): signal.raise_signal(signal.SIGINT)\n"
        "    return load(name, *rest, **more)\n"
        "builtins.__import__ = interrupted\n"
        "main()"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=PROGRAM)
    assert (done.returncode, done.stdout, done.stderr) == (-signal.SIGINT, "", "")


@pytest.mark.parametrize(
    ("number", "code"),
    [
        (signal.SIGINT, EXIT_INTERRUPTED),
        (signal.SIGTERM, EXIT_TERMINATED),
        (signal.SIGHUP, EXIT_HUNG_UP),
    ],
)
def test_what_is_open_is_closed_on_a_signal(number, code, monkeypatch, capsys):
    from grabbergui.driver.device_grabber import DeviceGrabber

    closed = []
    close = DeviceGrabber.close
    monkeypatch.setattr(DeviceGrabber, "close", lambda self: (closed.append(self), close(self))[1])
    monkeypatch.setattr(DeviceGrabber, "feature_tree", lambda self: signal.raise_signal(number))
    assert main(["features", "sim:"]) == code
    assert len(closed) == 1
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_search_holds_nothing_that_a_signal_must_wait_for(number, monkeypatch, capsys):
    seen = []
    monkeypatch.setattr(machine.sources, "discover", lambda *_: seen.append(signal.getsignal(number)) or [])
    before = signal.getsignal(number)
    assert main(["list"]) == 0
    assert seen == [signal.SIG_DFL]
    assert signal.getsignal(number) is before


@pytest.mark.skipif(sys.platform != "linux", reason="always has a display")
def test_a_window_without_a_display_names_the_option_to_do_without():
    places = ("QT_QPA_PLATFORM", "DISPLAY", "WAYLAND_DISPLAY")
    env = {name: value for name, value in os.environ.items() if name not in places}
    failed = run("calibrate", "sim:", "--window", env=env)
    assert failed.returncode == EXIT_FAILURE
    assert len(failed.stderr.splitlines()) == 1 and "leave out --window" in failed.stderr


def test_a_damaged_image_is_reported_in_one_line(tmp_path):
    _, content = cv2.imencode(".tiff", np.random.default_rng(1).integers(0, 255, (40, 60), np.uint8))
    (tmp_path / "0.tiff").write_bytes(content.tobytes()[:1000])
    failed = run("grab", f"file:{tmp_path}")
    assert failed.returncode == EXIT_FAILURE
    assert len(failed.stderr.splitlines()) == 1 and "cut short" in failed.stderr


@pytest.mark.parametrize(
    ("command", "code", "kind"),
    [
        ("get sim: NoSuchFeature", 1, "FeatureNotFoundError"),
        ("events sim: NoSuchEvent", 1, "FeatureValueError"),
        ("features file:missing", 2, "MissingFileError"),
        ("features foo:bar", 2, "UsageError"),
        ("grab sim: -n 0", 2, "UsageError"),
        ("list --lively", 2, "UsageError"),
        ("lits", 2, "UsageError"),
        ("save sim: taken/x/camera.yaml", 2, "MissingFileError"),
        ("record sim: --out taken", 2, "ExistingFileError"),
        ("record sim: --out taken/movie.mp4", 2, "ExistingFileError"),
        ("files sim: get LUTLuminance taken", 2, "ExistingFileError"),
        ("record sim: --set ExposureTime=-1 --out new", 1, "FeatureValueError"),
    ],
)
def test_a_script_reads_why_a_command_failed(command, code, kind, tmp_path, monkeypatch, capsys):
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "movie.frames.jsonl").touch()
    monkeypatch.chdir(tmp_path)
    assert main(command.split()) == code
    printed = capsys.readouterr()
    message = printed.err.splitlines()[-1].removeprefix("grabbergui: ")
    assert printed.out == "", "a person reads it on stderr"
    assert main([*command.split(), "--json"]) == code
    printed = capsys.readouterr()
    assert json.loads(printed.out) == {"error": {"type": kind, "message": message}}
    assert printed.err.splitlines()[-1] == f"grabbergui: {message}"


@pytest.mark.skipif(not Path("/dev/full").is_char_device(), reason="there is no /dev/full")
def test_a_failure_that_cannot_be_printed_keeps_its_exit_code():
    with Path("/dev/full").open("w") as full:
        done = run("get", "foo:bar", "X", "--json", stdout=full)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1 and "no known kind" in done.stderr


@pytest.mark.skipif(not Path("/dev/full").is_char_device(), reason="there is no /dev/full")
def test_a_failure_keeps_its_exit_code_where_nothing_at_all_can_be_printed():
    """As behind a terminal that was closed."""
    with Path("/dev/full").open("w") as full:
        line = [*PROGRAM_LINE, "get", "foo:bar", "X"]
        assert subprocess.run(line, stdout=full, stderr=full, timeout=PROGRAM).returncode == 2


@pytest.mark.parametrize("encoding", ["ascii", "latin-1"])
def test_a_terminal_without_unicode_is_written_to_in_other_letters(encoding):
    shown = run("features", "sim:", env={**os.environ, "PYTHONIOENCODING": encoding}, stdout=-1)
    assert shown.returncode == 0, shown.stderr
    assert "ExposureTime = 10000 us (10 ... 1000000" in shown.stdout


def test_a_reader_that_has_had_enough_is_no_fault():
    read, write = os.pipe()
    os.close(read)
    try:
        done = run("--help", stdout=write)
    finally:
        os.close(write)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.skipif(not Path("/dev/full").is_char_device(), reason="there is no /dev/full")
def test_a_full_disk_is_reported_in_one_line():
    with Path("/dev/full").open("w") as full:
        done = run("list", stdout=full)
    assert done.returncode == 1
    assert done.stderr == "grabbergui: No space left on device\n"


@pytest.mark.skipif(os.name == "nt", reason="a POSIX shell closes it")
def test_a_closed_stderr_takes_no_message_to_stdout_and_no_file(tmp_path):
    """Whatever is opened next would be file 2, where libraries in C write their messages."""
    closed = ["sh", "-c", 'exec "$@" 2>&-', "sh"]
    done = subprocess.run(
        [*closed, *PROGRAM_LINE, "get", "sim:", "NoSuchFeature"], stdout=subprocess.PIPE, timeout=PROGRAM
    )
    assert (done.returncode, done.stdout) == (1, b"")
    script = (
        "import os, grabbergui.__main__ as m; m._open_standard_streams(); print(os.open('x', os.O_CREAT))"
    )
    line = [*closed, sys.executable, "-c", script]
    opened = subprocess.run(line, stdout=subprocess.PIPE, timeout=PROGRAM, cwd=tmp_path)
    assert int(opened.stdout) > 2
