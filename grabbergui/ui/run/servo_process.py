"""The servoing window in a process of its own, so that its painting takes no time from the loop.

`show` is called by the loop's process, `main` is the window's.
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

from grabbergui.calibration.camera_info import CalibrationChoice, CalibrationFor
from grabbergui.core.errors import GrabberError
from grabbergui.core.priority import single_threaded
from grabbergui.models.servo_proxy import CLOSED, HEARTBEAT_PERIOD, RunnerProxy, RunnerServer
from grabbergui.servo.hand_eye_stand import HandEyeStand
from grabbergui.servo.runner import Runner
from grabbergui.ui.run import standalone
from grabbergui.ui.run.application import application, require_display
from grabbergui.ui.theme import Theme

log = logging.getLogger(__name__)

PROGRAM = ["-m", "grabbergui.ui.run.servo_process"]
"Python's arguments for the window's process."
HELD = "ready: nothing moves until Start is pressed"
"State of the robot after hand and eye were calibrated."
_LOOK_S = 0.1
"Seconds between checks whether the window is still there."
_END_S = 5.0
"Seconds that it may take to end."


@dataclass(frozen=True)
class Options:
    """How the window is shown."""

    seconds: float | None
    screenshot: Path | None
    theme: Theme
    hand_eye: bool
    "Whether hand and eye can be calibrated."


def show(
    runner: Runner,
    calibration: CalibrationFor,
    seconds: float | None,
    screenshot: Path | None = None,
    theme: Theme = Theme.AUTO,
    stop: threading.Event | None = None,
    stand: HandEyeStand | None = None,
) -> str:
    """Show a running runner until its window is closed; return why it ended otherwise, or nothing.

    With a `stand` of the runner's robot and gate, hand and eye can be calibrated. That window is in this
    process, between two of the other: no loop runs meanwhile.

    Takes what `standalone.servo` takes. The robot is stopped when the window's process dies or hangs. Where
    only a field of view is known, the window offers to calibrate, and runs in this process instead.
    Raises SourceUnavailableError without a display.
    """
    require_display()
    if _assumed(calibration):
        standalone.servo(runner, calibration, seconds, screenshot, theme, stop, stand)
        return ""
    options = Options(seconds, screenshot, theme, stand is not None)
    try:
        while True:
            failure, hand_eye_wanted = _show(runner, calibration, options, stop)
            if stand is None or not hand_eye_wanted or (stop is not None and stop.is_set()):
                return failure
            runner.stop()  # two loops must not command one robot
            stand.config = runner.config
            standalone.hand_eye(stand, theme=theme, stop=stop)
            runner.start(held=HELD)
    finally:
        if stand is not None:
            stand.close()


def _show(
    runner: Runner, calibration: CalibrationFor, options: Options, stop: threading.Event | None
) -> tuple[str, bool]:
    """Show the window once; return why it ended if not by the user, and whether calibration was asked for."""
    process = subprocess.Popen(
        [sys.executable, *PROGRAM],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=os.environ | {"PYTHONSAFEPATH": "1"},
    )
    assert process.stdin is not None
    assert process.stdout is not None
    server = RunnerServer(runner, calibration, process.stdin, process.stdout)
    try:
        pickle.dump(options, process.stdin)
        process.stdin.flush()
        server.open()
        while not server.closed.wait(_LOOK_S):
            if stop is not None and stop.is_set():
                runner.emergency_stop("interrupted")
                break
    except OSError as error:
        log.error("the window has not started: %s", error)
        runner.emergency_stop(CLOSED)
    finally:
        server.close()
        status = _end(process)
    failure = f"the window has ended unexpectedly (exit status {status})" if status else ""
    return failure, server.hand_eye_wanted


def _end(process: subprocess.Popen[bytes]) -> int:
    """Close the window, which its pipes' end does unless it hangs; return its exit status."""
    assert process.stdin is not None
    assert process.stdout is not None
    # In the background: a report that is being written to a window that hangs holds the pipe.
    closing = threading.Thread(target=_close, args=(process.stdin,), daemon=True)
    closing.start()
    try:
        process.wait(_END_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    closing.join()
    _close(process.stdout)
    return process.returncode


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
    """Be the window until it is closed or the loop's process ends."""
    # The loop's process gets it too, stops, and closes the window.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    single_threaded()
    # Nothing that prints may come between the requests.
    to_loop, from_loop = os.fdopen(os.dup(sys.stdout.fileno()), "wb"), sys.stdin.buffer
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    options = pickle.load(from_loop)
    ended = threading.Event()
    proxy = RunnerProxy(from_loop, to_loop, ended.set, calibrates_hand_eye=options.hand_eye)
    app = application()
    heartbeat = QTimer(app)
    heartbeat.timeout.connect(proxy.heartbeat)
    heartbeat.start(round(HEARTBEAT_PERIOD * 1000))
    proxy.open()  # its signals may come before anybody listens: the next report is 40 ms away
    standalone.servo(proxy, proxy.calibration, options.seconds, options.screenshot, options.theme, ended)
    proxy.close()


if __name__ == "__main__":
    main()
