"""The windows of calibration, which run without the main window."""

from __future__ import annotations

import logging
import threading
from pathlib import Path

from PyQt5.QtCore import QTimer
from PyQt5.QtWidgets import QDialog, QWidget

from grabbergui.calibration.boards import BoardSettings
from grabbergui.calibration.calibration_choice import CalibrationChoice
from grabbergui.core.errors import GrabberError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.ui.application import application, closed_by, look
from grabbergui.ui.controllers.calibration_dialogs import CalibratingController, CalibrationChooser
from grabbergui.ui.theme import Theme, dress
from grabbergui.ui.views.calibration_dialogs import (
    CalibrationChoiceDialog,
    CalibrationDialog,
    CalibrationPage,
)

log = logging.getLogger(__name__)


class Screenshot:
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
    shot = Screenshot(screenshot)
    controller = CalibratingController(dialog, grabber, saved.append, settings)

    def end() -> None:
        shot.take(dialog)
        dialog.done(QDialog.DialogCode.Rejected)

    if seconds is not None:
        controller.go(CalibrationPage.VIEWS)
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
