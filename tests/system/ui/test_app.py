"""The program: run without a display it leaves its image; what goes wrong is said in a line."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest
from PyQt5.QtGui import QImage

from grabbergui.ui.run import program
from patience import PATIENCE, PROGRAM
from programs import ALONE

CODE = f"""
import sys
from pathlib import Path
from grabbergui.ui.run import window
window.SCREENSHOT_PATIENCE = {PATIENCE}
"""
SMALL = "sim:?width=640&height=480&fps=10"


def run(code, tmp_path, window=CODE):
    environment = {**os.environ, "HOME": str(tmp_path), "XDG_RUNTIME_DIR": str(tmp_path)}
    environment.pop("QT_QPA_PLATFORM", None)
    return subprocess.run(
        [sys.executable, "-c", window + code],
        capture_output=True,
        text=True,
        timeout=PROGRAM,
        env=environment,
    )


def colours_in_the_middle(file):
    image = QImage(str(file))
    assert (image.width(), image.height()) >= (1000, 700)
    return len({image.pixel(x, 450) for x in range(300, 900, 3)})


def test_offscreen_it_runs_a_while_and_leaves_its_image(tmp_path):
    target = tmp_path / "window.png"
    for seconds in (3, 9, 40):  # on a busy machine the first frame comes late
        begun = time.monotonic()
        done = run(
            ALONE + f"sys.exit(window.run({SMALL!r}, offscreen=True, duration={seconds},"
            f" screenshot=Path({json.dumps(str(target))})))",
            tmp_path,
        )
        assert time.monotonic() - begun > seconds
        if done.returncode == 0 and colours_in_the_middle(target) > 10:
            break
    assert done.returncode == 0, done.stderr
    path, rate, unit = done.stdout.split()
    assert (path, unit) == (str(target), "frames/s")
    assert float(rate) > 0
    assert colours_in_the_middle(target) > 10, "the middle shows no image"


def test_the_screenshot_alone_ends_it_too_in_both_looks(tmp_path):
    done = run(
        ALONE + f"folder = Path({json.dumps(str(tmp_path))})\n"
        f"print([window.run({SMALL!r}, offscreen=True, theme=theme, screenshot=folder / f'{{theme}}.png')"
        " for theme in ('light', 'dark')])",
        tmp_path,
    )
    assert done.stdout.splitlines()[-1] == "[0, 0]", done.stderr
    light, dark = (
        QImage(str(tmp_path / f"{theme}.png")).pixelColor(1270, 5).lightness() for theme in ("light", "dark")
    )
    assert light > 200 and dark < 60


def test_without_a_frame_it_fails_with_one_clear_line_with_a_screenshot_or_without(tmp_path):
    done = run(
        ALONE + "print([window.run('nonsense:', offscreen=True, duration=1, screenshot=screenshot)"
        " for screenshot in (Path('never.png'), None)])",
        tmp_path,
    )
    assert done.stdout == "[1, 1]\n"
    said = done.stderr.splitlines()
    assert len(said) == 2 and all("no known kind" in line for line in said)


def test_an_interrupt_ends_it_cleanly(tmp_path):
    environment = {**os.environ, "HOME": str(tmp_path), "XDG_RUNTIME_DIR": str(tmp_path)}
    code = (
        CODE
        + ALONE
        + "from grabbergui.cli import main; "
        + "window.QTimer.singleShot(0, lambda: print('up', flush=True)); "
        + "sys.exit(main(['gui', '--offscreen', 'sim:']))"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
    )
    try:
        assert process.stdout.readline() == "up\n"
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=PROGRAM)
    finally:
        if process.poll() is None:
            process.kill()
            process.communicate()
    assert process.returncode == 0, errors
    assert "Traceback" not in errors


def test_what_nobody_caught_is_shown_and_the_window_goes_on(tmp_path):
    done = run(
        ALONE + "from grabbergui.models.messages import MessageModel as M; shown = []\n"
        "def show(self, text):\n"
        "    shown.append(text)\n"
        "    window.QTimer.singleShot(0, window.QCoreApplication.quit)\n"
        "M.error = show\n"
        "def fault(): raise RuntimeError('a fault')\n"
        "begin = window.Program.begin\n"
        "def broken(self, uri):\n"
        "    begin(self, uri)\n"
        "    window.QTimer.singleShot(0, fault)\n"
        "window.Program.begin = broken\n"
        "window.run('sim:', offscreen=True, duration=60)\n"
        "print(shown)",
        tmp_path,
    )
    assert done.returncode == 0, done.stderr
    assert "internal error: RuntimeError: a fault" in done.stdout


def test_offscreen_nothing_is_written_to_stderr(tmp_path):
    environment = {**os.environ, "HOME": str(tmp_path)}
    environment.pop("QT_QPA_PLATFORM", None)
    environment.pop("XDG_RUNTIME_DIR", None)
    script = tmp_path / "script.py"
    script.write_text(
        f"app.patience = {PATIENCE}; app.open('sim:colour'); app.until(lambda: not app.window.image.empty)"
    )
    done = subprocess.run(
        [sys.executable, "-m", "grabbergui", "gui", "--offscreen", "--script", str(script)],
        capture_output=True,
        text=True,
        timeout=PROGRAM,
        env=environment,
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_what_qt_warns_of_is_logged(tmp_path):
    done = run(
        "import logging; logging.basicConfig(format='%(levelname)s %(name)s %(message)s')\n"
        "from PyQt5.QtCore import qWarning; from grabbergui.ui.application import log_qt_messages\n"
        "log_qt_messages(); qWarning(b'a real one'); qWarning(b'This plugin does not support raise()')",
        tmp_path,
        window="",
    )
    assert done.stderr == "WARNING Qt a real one\n"


def test_it_shows_a_grabber_that_is_open_already_and_an_event_closes_it(tmp_path):
    target = tmp_path / "window.png"
    done = run(
        ALONE
        + f"""
import threading, time
from grabbergui import sources
from grabbergui.core.shared import SharedGrabber
from grabbergui.core.uri import SourceUri
grabber = sources.create(SourceUri.parse("sim:"))
grabber.open()
grabber.start()
stop, target = threading.Event(), Path({json.dumps(str(target))})

def stop_once_it_is_shown():
    while not target.exists():
        time.sleep(0.05)
    stop.set()

threading.Thread(target=stop_once_it_is_shown, daemon=True).start()
code = window.run(grabber.info.uri, offscreen=True, screenshot=target,
               create=lambda _: SharedGrabber(grabber), stop=stop, duration=60)
assert stop.is_set() and grabber.streaming, "the grabber belongs to whoever opened it"
grabber.close()
sys.exit(code)""",
        tmp_path,
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == "" and target.exists()


@pytest.fixture(scope="module")
def loaded(tmp_path_factory):
    """The modules that a window has loaded which is about to be shown."""
    done = run(
        "import os; os.environ['QT_QPA_PLATFORM'] = 'offscreen'; "
        "from grabbergui.ui.run.program import Program; "
        "from grabbergui.ui.application import Preferences; "
        "from grabbergui.ui.views.main_window import MainWindow; "
        "qt = window.application(); program = Program(MainWindow(), Preferences(None)); "
        "print(*sorted(sys.modules), flush=True); program.shut_down(5); os._exit(0)",
        tmp_path_factory.mktemp("home"),
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


def test_the_window_starts_without_what_is_opened_later(loaded):
    """Calibration, servo and the networks took as long to import as all the rest of the window."""
    assert "grabbergui.ui.run.program" in loaded
    late = ("grabbergui.servo", "grabbergui.net", "grabbergui.models.calibrating", "rclpy", "pinocchio")
    early = [name for name in loaded if name.startswith(late)]
    assert not early


def test_the_window_loads_nothing_that_only_other_windows_need(loaded):
    late = ("grabbergui.servo", "grabbergui.driver.gige", "genicam", "mcap")
    assert not [name for name in loaded if name.startswith(late)]


def test_others_are_looked_for_once_the_named_source_shows_an_image(app, monkeypatch):
    order = []
    monkeypatch.setattr(program, "SEARCH_AFTER_MS", 1000 * 3600)
    monkeypatch.setattr(app.program.source_controls.source_list, "start", lambda: order.append("search"))
    app.window.image.painted.connect(lambda: order.append("image"))
    app.program.begin("sim:")
    app.watch(3)
    assert order.index("image") < order.index("search")
    assert order.count("search") == 1


def test_others_are_looked_for_although_the_named_source_shows_nothing(app, monkeypatch):
    monkeypatch.setattr(program, "SEARCH_AFTER_MS", 10)
    searches = []
    monkeypatch.setattr(app.program.source_controls.source_list, "start", lambda: searches.append(1))
    app.program.begin("nonsense:")
    app.until(lambda: searches)
