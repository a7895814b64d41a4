"""The servoing window in a process of its own, so that its painting takes no time from the loop.

`servo_in_own_process` is called by the loop's process, `main` is the window's.
"""

from __future__ import annotations

import logging
import os
import pickle
import signal
import subprocess
import sys
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from PyQt5.QtCore import QTimer

from grabbergui.calibration.calibration_choice import CalibrationChoice, CalibrationFor
from grabbergui.core.errors import GrabberError
from grabbergui.core.scheduling import single_threaded
from grabbergui.servo.hand_eye.stand import HandEyeStand
from grabbergui.servo.models.servo_proxy import CLOSED, HEARTBEAT_PERIOD, RunnerProxy, RunnerServer
from grabbergui.servo.runner import HELD, Runner
from grabbergui.servo.ui.windows import hand_eye, servo
from grabbergui.ui.application import application, require_display
from grabbergui.ui.run.standalone import UnsavedError
from grabbergui.ui.theme import Theme

log = logging.getLogger(__name__)

WINDOW_PROGRAM = ["-m", "grabbergui.servo.ui.servo_process"]
"Python's arguments for the window's process."
_UNSAVED, _HAND_EYE = 3, 4
"Exit status of the window's process if its screenshot could not be written; to calibrate hand and eye."
_LOOK_S = 0.1
"Seconds between checks whether the window is still there."
_END_S = 5.0
"Seconds that it may take to end."


@dataclass(frozen=True)
class _Options:
    """How the window is shown."""

    seconds: float | None
    screenshot: Path | None
    theme: Theme
    hand_eye: bool
    "Whether hand and eye can be calibrated."


def servo_in_own_process(
    runner: Runner,
    calibration: CalibrationFor,
    seconds: float | None,
    screenshot: Path | None = None,
    theme: Theme = Theme.AUTO,
    stop: threading.Event | None = None,
    stand: HandEyeStand | None = None,
) -> str:
    """Show a running runner until its window is closed; return why it ended otherwise, or nothing.

    With a `stand` of the runner's robot and gate, hand and eye can be calibrated: in this process, between
    two windows, while no loop runs. The robot is stopped when the window's process dies or hangs. Where only
    a field of view is known, the window offers to calibrate, and runs in this process instead.
    Raises SourceUnavailableError without a display.
    """
    require_display()
    options = _Options(seconds, screenshot, theme, stand is not None)
    try:
        while True:
            show = _show_here if _assumed(calibration) else _show_once
            failure, hand_eye_wanted = show(runner, calibration, options, stop)
            if stand is None or not hand_eye_wanted or (stop is not None and stop.is_set()):
                return failure
            runner.stop()  # two loops must not command one robot
            stand.config = runner.config
            hand_eye(stand, theme=theme, stop=stop)
            runner.start(held=HELD)
    finally:
        if stand is not None:
            stand.close()


def _show_here(
    runner: Runner, calibration: CalibrationFor, options: _Options, stop: threading.Event | None
) -> tuple[str, bool]:
    """Show the window once in this process; return as `_show_once` does."""
    seconds, screenshot, theme = options.seconds, options.screenshot, options.theme
    try:
        return "", servo(runner, calibration, seconds, screenshot, theme, stop, hand_eye=options.hand_eye)
    except UnsavedError as error:
        return str(error), False


def _show_once(
    runner: Runner, calibration: CalibrationFor, options: _Options, stop: threading.Event | None
) -> tuple[str, bool]:
    """Show the window once; return why it ended if not by the user, and whether calibration was asked for."""
    process = subprocess.Popen(
        [sys.executable, *WINDOW_PROGRAM],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=os.environ | {"PYTHONSAFEPATH": "1"},
    )
    assert process.stdin is not None
    assert process.stdout is not None
    server = RunnerServer(runner, calibration, process.stdin, process.stdout)
    interrupted = False
    try:
        pickle.dump(options, process.stdin)
        process.stdin.flush()
        server.open()
        while not server.closed.wait(_LOOK_S):
            if stop is not None and stop.is_set():
                interrupted = True
                runner.emergency_stop("interrupted")
                break
    except OSError as error:
        log.error("the window has not started: %s", error)
        runner.emergency_stop(CLOSED)
    finally:
        server.close()
        status = _end(process, starting=interrupted and not server.shown)
    failure = f"the window has ended unexpectedly (exit status {status})"
    if status == _UNSAVED:
        failure = f"the screenshot could not be written to {options.screenshot}"
    return "" if status in (0, _HAND_EYE) else failure, status == _HAND_EYE


def _end(process: subprocess.Popen[bytes], *, starting: bool) -> int:
    """Close the window by the end of its pipes; return its exit status, 0 if it hung and was killed.

    One that is still `starting`, which takes seconds on a busy computer, is killed at once.
    """
    assert process.stdin is not None
    assert process.stdout is not None
    # In the background: a report that is being written to a window that hangs holds the pipe.
    closing = threading.Thread(target=_close, args=(process.stdin,), daemon=True)
    closing.start()
    try:
        status = process.wait(0 if starting else _END_S)
    except subprocess.TimeoutExpired:
        if not starting:
            log.warning("the window does not answer, and is ended")
        process.kill()
        process.wait()
        status = 0
    closing.join()
    _close(process.stdout)
    return status


def _close(pipe: IO[bytes]) -> None:
    try:
        pipe.close()
    except OSError:
        log.debug("the window had closed its pipe")


def _assumed(calibration: CalibrationFor) -> bool:
    """Return whether only a field of view is known of the camera, which the window offers to improve."""
    if not isinstance(calibration, CalibrationChoice):
        return False
    try:
        return calibration(640, 480).nominal
    except GrabberError:  # the calibration is of images of another shape
        return False


def main() -> None:
    """Show the window until it is closed or the loop's process ends."""
    # The loop's process gets Ctrl+C too; it stops the robot and closes the window.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    single_threaded()
    # Stdout is the pipe of the requests: prints go to stderr.
    to_loop, from_loop = os.fdopen(os.dup(sys.stdout.fileno()), "wb"), sys.stdin.buffer
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    options = pickle.load(from_loop)
    ended = threading.Event()
    proxy = RunnerProxy(from_loop, to_loop, ended.set)
    app = application()
    heartbeat = QTimer(app)
    heartbeat.timeout.connect(proxy.heartbeat)
    heartbeat.start(round(HEARTBEAT_PERIOD * 1000))
    proxy.open()  # a signal without a listener yet does no harm: the next report follows in 40 ms
    status, calibration, seconds = 0, proxy.calibration, options.seconds
    try:
        if servo(
            proxy, calibration, seconds, options.screenshot, options.theme, ended, hand_eye=options.hand_eye
        ):
            status = _HAND_EYE
    except UnsavedError:
        status = _UNSAVED
    finally:
        proxy.close()
    sys.exit(status)


if __name__ == "__main__":
    main()
