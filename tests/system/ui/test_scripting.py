"""Scripts that use the window without a screen: what they can do, and the exit code."""

import os
import signal
import subprocess
from pathlib import Path

import pytest
from PyQt5.QtGui import QImage

from grabbergui.core.errors import UsageError
from grabbergui.ui.run.scripting import load_script, run_script
from patience import PATIENCE, PROGRAM
from programs import window_command

EXAMPLE = Path(__file__).parents[3] / "resources" / "scripts" / "check_camera.py"


@pytest.fixture
def run(app, tmp_path, monkeypatch):
    """Runs a script in this process; its exit code."""
    monkeypatch.chdir(tmp_path)

    def run_it(text):
        script = tmp_path / "script.py"
        script.write_text(f"app.patience = {PATIENCE}\n{text}")
        return run_script(load_script(script), app.program)

    return run_it


def test_the_example_runs_and_says_that_the_camera_is_fit(run, tmp_path, capsys):
    assert run(EXAMPLE.read_text()) == 0
    assert "nothing lost" in capsys.readouterr().out
    assert QImage(str(tmp_path / "camera.png")).width() >= 1000


def test_it_has_the_windows_own_objects(run, tmp_path, capsys):
    code = run("""
app.open("sim:?width=320&height=240")
app.set("Gain", 6)
assert app.get("Gain").value == 6 == app.grabber.feature("Gain").value
app.until(app.window.actionUndo.isEnabled)
app.window.actionUndo.trigger()
app.until(lambda: app.get("Gain").value == 0)
app.execute("TimestampLatch")
frame = app.wait_for_frames(3)
assert (frame.width, frame.height) == (320, 240)
app.program.opener.open_additional("sim:colour")
app.until(lambda: len(app.window.gallery.tiles) == 2)
app.screenshot("tiles/gallery.png", app.window.gallery)
app.close()
assert not app.messages, app.messages
print("through")
""")
    assert (code, capsys.readouterr().out) == (0, "through\n")
    assert QImage(str(tmp_path / "tiles" / "gallery.png")).width() > 200


ENDS = (
    ("app.get('Gain')", 1, "nothing is open"),
    ("app.end(7)", 7, ""),
    ("import sys\nsys.exit(5)", 5, ""),
    ("import sys\nsys.exit('no good')", 1, "no good\n"),
    ("assert 1 > 2, 'one is not more'", 1, "AssertionError: one is not more\n"),
    ("app.open('sim:nonsense')", 1, "no simulated camera 'nonsense'"),
    ("app.open('sim:?width=320')\napp.set('Gain', 1000)", 1, "Gain=1000"),
    ("app.until(lambda: False, 0.1, 'it is never')", 1, "it is never after 0.1 s"),
    ("app.patience = 0.1\napp.until(lambda: False)", 1, "after 0.1 s"),
    ("app.window.close()\napp.wait(1)\nprint('never')", 1, ""),
)
"""Scripts, what their exit code is, and what they leave on stderr; the last one takes the window away."""


def test_the_exit_code_says_how_it_went(run, capsys):
    for text, code, said in ENDS:
        assert run(text) == code, text
        out, errors = capsys.readouterr()
        assert said in errors and "never" not in out
        if said and "exit" not in text:
            assert "script.py" in errors and "grabbergui/ui" not in errors, "the script's own lines only"


def test_who_does_not_wait_for_the_source_is_told_how(run, capsys):
    script = """
import threading

opening, connection = threading.Event(), app.program.opener
create = connection.create
connection.create = lambda uri: opening.wait(60) and create(uri)
connection.connect_to("sim:")
try:
    app.wait_for_frames()
finally:
    opening.set()
"""
    assert run(script) == 1
    assert "sim: is not open yet; call app.wait_for_source() first" in capsys.readouterr().err


def test_a_source_that_was_refused_before_the_script_began_ends_the_wait(run, app, capsys):
    program = app.program
    refusals: list[str] = []
    program.opener.reports.failed.connect(refusals.append)
    program.begin("sim:nonsense")
    app.until(lambda: refusals)
    assert run("app.wait_for_source()") == 1
    assert "no simulated camera 'nonsense'" in capsys.readouterr().err


@pytest.mark.parametrize(("text", "said"), [("def (", "is no Python"), (None, "there is no script")])
def test_what_is_no_script_is_wrong_usage(tmp_path, text, said):
    script = tmp_path / "script.py"
    if text is not None:
        script.write_text(text)
    with pytest.raises(UsageError, match=said):
        load_script(script)


def started(tmp_path, text, *options):
    """The program itself, without a screen."""
    script = tmp_path / "script.py"
    script.write_text(f"app.patience = {PATIENCE}\n{text}")
    environment = {**os.environ, "HOME": str(tmp_path)}
    environment.pop("QT_QPA_PLATFORM", None)
    command = window_command(*options, "--script", str(script))
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
    )


def test_a_source_on_the_command_line_is_open_already(tmp_path):
    text = "app.wait_for_source()\nprint(app.wait_for_frames().width)"
    process = started(tmp_path, text + "\napp.end(4)", "sim:?width=320&height=240&fps=10")
    out, _ = process.communicate(timeout=PROGRAM)
    assert (process.returncode, out) == (4, "320\n")


def test_a_source_on_the_command_line_that_does_not_open_ends_the_wait(tmp_path):
    process = started(tmp_path, "app.wait_for_source()\nprint('never')", "gentl:/no/such.cti")
    out, errors = process.communicate(timeout=PROGRAM)
    assert (process.returncode, out) == (1, "") and "no GenTL producer" in errors


def test_a_shipped_script_is_found_from_any_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert load_script(Path("resources/scripts/check_camera.py")) == load_script(EXAMPLE)
    assert load_script(Path("check_camera.py")) == load_script(EXAMPLE)


def test_a_time_limit_ends_it_with_a_failure(tmp_path):
    process = started(tmp_path, "app.wait(30)\nprint('never')", "--duration", "1")
    out, errors = process.communicate(timeout=PROGRAM)
    assert (process.returncode, out) == (1, "") and "Traceback" not in errors


def test_an_interrupt_ends_it(tmp_path):
    process = started(tmp_path, "print('up', flush=True)\napp.wait(30)\nprint('never')")
    try:
        assert process.stdout.readline() == "up\n"
        process.send_signal(signal.SIGTERM)
        out, errors = process.communicate(timeout=PROGRAM)
    finally:
        if process.poll() is None:
            process.kill()
            process.communicate()
    assert (process.returncode, out) == (1, "") and "Traceback" not in errors
