"""Runs the servoing window on a pilot."""

from __future__ import annotations

import threading
from pathlib import Path

from PyQt5.QtCore import QTimer

from grabbergui.calibration.choice import CalibrationFor
from grabbergui.servo.pilot import Pilot
from grabbergui.ui.app import application, closed_by, look
from grabbergui.ui.controllers.servoing import ServoController
from grabbergui.ui.theme import Theme, dress
from grabbergui.ui.views.servo_window import ServoWindow


def run(
    pilot: Pilot,
    calibration: CalibrationFor,
    seconds: float | None,
    screenshot: Path | None = None,
    theme: Theme = Theme.AUTO,
    stop: threading.Event | None = None,
) -> None:
    """Show a running pilot until the window is closed or the time is up.

    A loop that ended by an error is shown with its reason, and may be started again. With `screenshot` the
    window's own picture is saved before it closes. Of `theme`, see `app.look`. Setting `stop` stops the
    robot, then closes the window.
    """
    app = application()
    dress(app, look(theme, screenshot is not None))
    window = ServoWindow()
    controller = ServoController(window, pilot, calibration)

    def close() -> None:
        if screenshot is not None:
            window.grab().save(str(screenshot))
        window.close()

    def interrupted() -> None:
        pilot.emergency_stop("interrupted")
        window.close()

    if seconds is not None:
        QTimer.singleShot(round(seconds * 1000), close)
    try:
        with closed_by(stop, interrupted):
            window.show()
            app.exec_()
    finally:
        controller.close()
        window.deleteLater()
        app.processEvents()
