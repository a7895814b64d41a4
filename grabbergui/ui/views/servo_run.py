"""Runs the servoing window on a pilot."""

from __future__ import annotations

import signal
from pathlib import Path
from types import FrameType

from PyQt5.QtCore import QTimer

from grabbergui.servo.calibration_choice import CalibrationFor
from grabbergui.servo.pilot import Pilot
from grabbergui.ui.app import application, look
from grabbergui.ui.controllers.servoing import ServoController
from grabbergui.ui.theme import Theme, dress
from grabbergui.ui.views.servo_window import ServoWindow

SIGNALS_MS = 200
"Python runs signal handlers only between its own instructions; the event loop must let it."


def run(
    pilot: Pilot,
    calibration: CalibrationFor,
    seconds: float | None,
    screenshot: Path | None = None,
    theme: Theme = Theme.AUTO,
) -> None:
    """Show a running pilot until the window is closed or the time is up.

    A loop that ended by an error is shown with its reason, and may be started again. With `screenshot` the
    window's own picture is saved before it closes. Of `theme`, see `app.look`.
    """
    app = application()
    dress(app, look(theme, screenshot is not None))
    window = ServoWindow()
    controller = ServoController(window, pilot, calibration)

    def close() -> None:
        if screenshot is not None:
            window.grab().save(str(screenshot))
        window.close()

    signals = QTimer()
    signals.timeout.connect(lambda: None)
    signals.start(SIGNALS_MS)
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
        signals.stop()
        controller.close()
        window.deleteLater()
        app.processEvents()
