"""The windows that run without the main window: calibration, and visual servoing.

The servoing window is a process of its own, so that its painting takes no time from the loop:
`servo_in_own_process` is called by the loop's process, `main` is the window's.
"""

from __future__ import annotations

import logging
import threading
from pathlib import Path

from PyQt5.QtCore import QTimer
from PyQt5.QtWidgets import QDialog, QWidget

from grabbergui.calibration.boards import BoardSettings
from grabbergui.calibration.calibration_choice import CalibrationChoice, CalibrationFor
from grabbergui.calibration.hand_eye import HandEyeResult
from grabbergui.core.errors import GrabberError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.models.servo_proxy import Run
from grabbergui.servo.hand_eye_stand import HandEyeStand
from grabbergui.ui.application import application, closed_by, look
from grabbergui.ui.controllers.calibration_dialogs import CalibratingController, CalibrationChooser
from grabbergui.ui.controllers.hand_eye import ENDING_S, HandEyeController
from grabbergui.ui.controllers.servoing import ServoController
from grabbergui.ui.file_dialogs import FileDialogs
from grabbergui.ui.theme import Theme, dress
from grabbergui.ui.views.calibration_dialogs import CalibrationChoiceDialog, CalibrationDialog, Step
from grabbergui.ui.views.hand_eye_dialog import HandEyeDialog
from grabbergui.ui.views.servo_window import ServoWindow

log = logging.getLogger(__name__)


class _Screenshot:
    """A window's screenshot of itself, taken when its time is up."""

    def __init__(self, path: Path | None) -> None:
        self._path, self._failed = path, False

    def take(self, window: QWidget) -> None:
        """Save it, if one is wanted."""
        if self._path is not None:
            self._failed = not window.grab().save(str(self._path))

    def check(self) -> None:
        """Raise UnsavedError if it could not be saved."""
        if self._failed:
            raise UnsavedError(f"the screenshot could not be written to {self._path}")


class UnsavedError(GrabberError):
    """A screenshot could not be written."""


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
    `screenshot` it saves a screenshot of itself then. Setting `stop` closes it. Raises UnsavedError.
    """
    app = application()
    dress(app, look(theme, screenshot is not None))
    dialog = CalibrationDialog()
    saved: list[Path] = []
    shot = _Screenshot(screenshot)
    controller = CalibratingController(dialog, grabber, saved.append, settings)

    def end() -> None:
        shot.take(dialog)
        dialog.done(QDialog.DialogCode.Rejected)

    if seconds is not None:
        controller.go(Step.VIEWS)
        QTimer.singleShot(round(seconds * 1000), end)
    try:
        with closed_by(stop, lambda: dialog.done(QDialog.DialogCode.Rejected)):
            dialog.exec_()
    finally:
        controller.close()
    shot.check()
    return saved[-1] if saved else None


def choose_calibration(
    grabber: FrameGrabber, theme: Theme = Theme.AUTO, stop: threading.Event | None = None
) -> CalibrationChoice | None:
    """Ask what to do about a camera without a calibration; return the choice, None if there was none.

    The source must stream, because one answer is to calibrate it. Setting `stop` closes the question.
    """
    app = application()
    dress(app, look(theme))
    dialog = CalibrationChoiceDialog(grabber.info.title)
    chooser = CalibrationChooser(dialog, grabber)
    with closed_by(stop, dialog.reject):
        dialog.exec_()
    dialog.deleteLater()
    return chooser.choice


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
    shot = _Screenshot(screenshot)

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
