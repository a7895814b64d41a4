"""The windows of a robot, shown until they are closed: hand–eye calibration, and servoing."""

from __future__ import annotations

import threading
from pathlib import Path

from PyQt5.QtCore import QTimer

from grabbergui.calibration.calibration_choice import CalibrationFor
from grabbergui.servo.hand_eye.solver import HandEyeResult
from grabbergui.servo.hand_eye.stand import HandEyeStand
from grabbergui.servo.models.servo_proxy import Run
from grabbergui.servo.ui.hand_eye_controller import ENDING_S, HandEyeController
from grabbergui.servo.ui.hand_eye_dialog import HandEyeDialog
from grabbergui.servo.ui.servo_controller import ServoController
from grabbergui.servo.ui.servo_window import ServoWindow
from grabbergui.ui.application import application, closed_by, look
from grabbergui.ui.file_dialogs import FileDialogs
from grabbergui.ui.run.standalone import Screenshot
from grabbergui.ui.theme import Theme, dress


def hand_eye(
    stand: HandEyeStand, theme: Theme = Theme.AUTO, stop: threading.Event | None = None
) -> HandEyeResult | None:
    """Show the hand–eye calibration until its dialog is closed; return the newest result.

    The robot rests on return. Setting `stop` stops it, then closes the dialog.
    """
    dress(application(), look(theme))
    dialog = HandEyeDialog()
    controller = HandEyeController(dialog, stand, FileDialogs(dialog), dialog)
    model = controller.model
    try:
        with closed_by(stop, dialog.reject):
            dialog.exec_()
    finally:
        model.close(ENDING_S)
    return None if model.solution is None else model.solution.result


def servo(
    runner: Run,
    calibration: CalibrationFor,
    seconds: float | None,
    screenshot: Path | None = None,
    theme: Theme = Theme.AUTO,
    stop: threading.Event | None = None,
    *,
    hand_eye: bool = False,
) -> bool:
    """Show a running runner until the window is closed or the time is up.

    A loop that ended with an error is shown with its reason, and may be started again. With `screenshot` an
    image of the window is saved before it closes. Setting `stop` stops the robot, then closes the window.
    Return whether the user closed it to calibrate hand and eye, which it offers with `hand_eye`.
    Raises UnsavedError if the screenshot cannot be saved.
    """
    app = application()
    dress(app, look(theme, screenshot is not None))
    window = ServoWindow()
    controller = ServoController(window, runner, calibration, hand_eye=hand_eye)
    shot = Screenshot(screenshot)

    def close() -> None:
        shot.take(window)
        window.close()

    def interrupted() -> None:
        runner.emergency_stop("interrupted")
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
    shot.check()
    return controller.hand_eye_wanted
