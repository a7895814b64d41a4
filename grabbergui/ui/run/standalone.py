"""The windows that run without the main window: calibration, and visual servoing."""

from __future__ import annotations

import threading
from pathlib import Path

from PyQt5.QtCore import QTimer
from PyQt5.QtWidgets import QDialog

from grabbergui.calibration.boards import BoardSettings
from grabbergui.calibration.camera_info import CalibrationChoice, CalibrationFor
from grabbergui.calibration.hand_eye import HandEyeResult
from grabbergui.core.grabber import FrameGrabber
from grabbergui.models.servo_proxy import Run
from grabbergui.servo.hand_eye_stand import HandEyeStand
from grabbergui.ui.controllers.calibration_dialogs import CalibratingController, CalibrationChooser
from grabbergui.ui.controllers.hand_eye import ENDING_S, HandEyeController
from grabbergui.ui.controllers.servoing import ServoController
from grabbergui.ui.run.application import application, closed_by, look
from grabbergui.ui.theme import Theme, dress
from grabbergui.ui.views.calibration_dialogs import CalibrationChoiceDialog, CalibrationDialog, Step
from grabbergui.ui.views.hand_eye_dialog import HandEyeDialog
from grabbergui.ui.views.servo_window import ServoWindow
from grabbergui.ui.windows import FileDialogs


def calibrate(
    grabber: FrameGrabber,
    settings: BoardSettings | None = None,
    screenshot: Path | None = None,
    seconds: float | None = None,
    theme: Theme = Theme.AUTO,
    stop: threading.Event | None = None,
) -> Path | None:
    """Calibrate a camera in a dialog; return the file that was saved last, if any, once it is closed.

    The source must stream. With `seconds` the dialog takes views at once and closes after that time; with
    `screenshot` it saves a picture of itself then. Setting `stop` closes it.
    """
    app = application()
    dress(app, look(theme, screenshot is not None))
    dialog = CalibrationDialog()
    saved: list[Path] = []
    controller = CalibratingController(dialog, grabber, saved.append, settings)

    def end() -> None:
        if screenshot is not None:
            dialog.grab().save(str(screenshot))
        dialog.done(QDialog.DialogCode.Rejected)

    if seconds is not None:
        controller.go(Step.VIEWS)
        QTimer.singleShot(round(seconds * 1000), end)
    try:
        with closed_by(stop, lambda: dialog.done(QDialog.DialogCode.Rejected)):
            dialog.exec_()
    finally:
        controller.close()
    return saved[-1] if saved else None


def choose_calibration(grabber: FrameGrabber, theme: Theme = Theme.AUTO) -> CalibrationChoice | None:
    """Ask what to do about a camera without a calibration; return the choice, None if there was none.

    The source must stream, because one answer is to calibrate it.
    """
    app = application()
    dress(app, look(theme))
    dialog = CalibrationChoiceDialog(grabber.info.title)
    chooser = CalibrationChooser(dialog, grabber)
    dialog.exec_()
    dialog.deleteLater()
    return chooser.choice


def hand_eye(
    stand: HandEyeStand,
    seconds: float | None = None,
    screenshot: Path | None = None,
    theme: Theme = Theme.AUTO,
    stop: threading.Event | None = None,
) -> HandEyeResult | None:
    """Show the hand–eye calibration until its dialog is closed or the time is up; return the newest result.

    The robot rests on return. Setting `stop` stops it, then closes the dialog.
    """
    app = application()
    dress(app, look(theme, screenshot is not None))
    dialog = HandEyeDialog()
    controller = HandEyeController(dialog, stand, FileDialogs(dialog), dialog)
    model = controller.model

    def end() -> None:
        if screenshot is not None:
            dialog.grab().save(str(screenshot))
        dialog.reject()

    if seconds is not None:
        QTimer.singleShot(round(seconds * 1000), end)
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
    stand: HandEyeStand | None = None,
) -> None:
    """Show a running runner until the window is closed or the time is up.

    A loop that ended with an error is shown with its reason, and may be started again. With `screenshot` a
    picture of the window is saved before it closes. Setting `stop` stops the robot, then closes the window.
    With a `stand` of the runner's robot and gate, hand and eye can be calibrated from the window.
    """
    app = application()
    dress(app, look(theme, screenshot is not None))
    window = ServoWindow()
    controller = ServoController(window, runner, calibration, stand)

    def close() -> None:
        if screenshot is not None:
            window.grab().save(str(screenshot))
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
        if stand is not None:
            stand.close()
        window.deleteLater()
        app.processEvents()
