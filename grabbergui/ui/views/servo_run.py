"""Runs the servoing window on a pilot."""

from __future__ import annotations

import signal
import sys
from collections import deque
from collections.abc import Callable
from types import FrameType

from PyQt5.QtCore import QObject, QTimer
from PyQt5.QtWidgets import QApplication

from grabbergui.core.calibration import Calibration
from grabbergui.core.frame import Frame
from grabbergui.servo import overlay, report
from grabbergui.servo.loop import Turn
from grabbergui.servo.pilot import Pilot
from grabbergui.servo.state_machine import State
from grabbergui.ui.views.servo_window import ServoWindow

PICTURE_MS, PLOTS_MS = 66, 500
KEPT_TURNS = 1000
"Of the curves: about fifteen seconds."


class ServoPresenter(QObject):
    """Shows the newest of a pilot at the pace of the eye, whatever the loop's."""

    def __init__(
        self,
        window: ServoWindow,
        pilot: Pilot,
        calibration: Callable[[int, int], Calibration],
    ) -> None:
        """Make it on the GUI thread; `close` it before the pilot is gone."""
        super().__init__(window)
        self._window, self._pilot, self._calibration = window, pilot, calibration
        self._turns: deque[Turn] = deque(maxlen=KEPT_TURNS)
        self._newest: tuple[Turn, Frame] | None = None
        # The loop's thread only leaves things here; appending and replacing need no lock.
        pilot.turned.connect(self._on_turned)
        window.stopPressed.connect(lambda: pilot.emergency_stop("stopped in the window"))
        window.resumePressed.connect(pilot.resume)
        self._timers = [self._every(PICTURE_MS, self._show_picture), self._every(PLOTS_MS, self._show_plots)]

    def close(self) -> None:
        """Let go of the pilot. May be called twice."""
        self._pilot.turned.disconnect(self._on_turned, missing_ok=True)
        for timer in self._timers:
            timer.stop()

    def _every(self, milliseconds: int, slot: Callable[[], None]) -> QTimer:
        timer = QTimer(self)
        timer.timeout.connect(slot)
        timer.start(milliseconds)
        return timer

    def _on_turned(self, turn: Turn, frame: Frame | None) -> None:
        self._turns.append(turn)
        if frame is not None:
            self._newest = turn, frame

    def _show_picture(self) -> None:
        if self._turns:
            turn = self._turns[-1]
            self._window.setState(turn.state.value, turn.reason)
            self._window.setStopped(turn.state is State.STOPPED)
        newest, self._newest = self._newest, None
        if newest is not None:
            turn, frame = newest
            calibration = self._calibration(frame.width, frame.height)
            self._window.setPicture(overlay.draw(frame.rgb(), turn, self._pilot.loop.sighting, calibration))

    def _show_plots(self) -> None:
        # Every fourth turn is finer than the screen; drawing must not hold up the loop's thread.
        turns = list(self._turns)[::4]
        if len(turns) > 1:
            self._window.setPlots(report.plot(turns))


def run(
    pilot: Pilot,
    calibration: Callable[[int, int], Calibration],
    seconds: float | None,
) -> None:
    """Show a running pilot until the window is closed, the loop ends, or the time is up."""
    app = QApplication.instance() or QApplication(sys.argv[:1])
    window = ServoWindow()
    presenter = ServoPresenter(window, pilot, calibration)

    def close() -> None:
        window.close()

    def close_when_ended() -> None:
        if not pilot.running:
            window.close()

    ended = QTimer()
    ended.timeout.connect(close_when_ended)
    ended.start(200)
    if seconds is not None:
        QTimer.singleShot(round(seconds * 1000), close)
    # An exception out of a slot would end the process without a stop: Ctrl-C stops, then closes.
    before = signal.getsignal(signal.SIGINT)

    def interrupted(number: int, frame: FrameType | None) -> None:
        pilot.emergency_stop("interrupted")
        window.close()

    signal.signal(signal.SIGINT, interrupted)
    try:
        window.show()
        app.exec_()
    finally:
        signal.signal(signal.SIGINT, before)
        ended.stop()
        presenter.close()
