"""Runs the calibration dialogs alone on a source that is open."""

from __future__ import annotations

import threading
from pathlib import Path

from PyQt5.QtCore import QTimer
from PyQt5.QtWidgets import QDialog

from grabbergui.calibration.boards import BoardSettings
from grabbergui.calibration.choice import CalibrationChoice
from grabbergui.core.grabber import FrameGrabber
from grabbergui.ui.app import application, closed_by, look
from grabbergui.ui.controllers.calibrating import CalibratingController
from grabbergui.ui.controllers.choosing_calibration import CalibrationChooser
from grabbergui.ui.theme import Theme, dress
from grabbergui.ui.views.calibration_choice_dialog import CalibrationChoiceDialog
from grabbergui.ui.views.calibration_dialog import CalibrationDialog, Step


def run(
    grabber: FrameGrabber,
    settings: BoardSettings | None = None,
    screenshot: Path | None = None,
    seconds: float | None = None,
    theme: Theme = Theme.AUTO,
    stop: threading.Event | None = None,
) -> Path | None:
    """Show it until it is closed, and return the file of the calibration that was saved last, if any.

    The source must stream. With `seconds` it takes views at once and closes by itself after that time; with
    `screenshot` it saves its own picture then. Setting `stop` closes it.
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


def choose(grabber: FrameGrabber, theme: Theme = Theme.AUTO) -> CalibrationChoice | None:
    """Say that a camera is not calibrated and ask what to do; None where nothing was chosen.

    The source must stream, so that it can be calibrated at once.
    """
    app = application()
    dress(app, look(theme))
    dialog = CalibrationChoiceDialog(grabber.info.title)
    chooser = CalibrationChooser(dialog, grabber)
    dialog.exec_()
    dialog.deleteLater()
    return chooser.choice
