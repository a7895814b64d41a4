"""Finds a calibration for a camera that has none, with the person's help."""

from __future__ import annotations

from pathlib import Path

from PyQt5.QtCore import QObject
from PyQt5.QtWidgets import QFileDialog

from grabbergui.calibration.choice import CalibrationChoice
from grabbergui.core.errors import UsageError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.models.error_text import error_text
from grabbergui.ui.controllers.calibrating import CalibratingController
from grabbergui.ui.views.calibration_choice_dialog import CalibrationChoiceDialog
from grabbergui.ui.views.calibration_dialog import CalibrationDialog


class CalibrationChooser(QObject):
    """Accepts its dialog once there is a `choice`. The source must be open; it is started to calibrate it."""

    def __init__(self, dialog: CalibrationChoiceDialog, grabber: FrameGrabber) -> None:
        super().__init__(dialog)
        self.choice: CalibrationChoice | None = None
        """What was chosen."""
        self.calibrating: CalibrationDialog | None = None
        """Open on top of the dialog."""
        self._dialog, self._grabber = dialog, grabber
        dialog.calibrateRequested.connect(self._calibrate)
        dialog.fileRequested.connect(self._ask_file)
        dialog.nominalRequested.connect(self._assume)

    def use(self, path: Path) -> None:
        """Take a file's calibration, or say what is wrong with it."""
        try:
            self.choice = CalibrationChoice.file(path)
        except (UsageError, OSError) as error:
            self._dialog.setProblem(error_text(error))
        else:
            self._dialog.accept()

    def _calibrate(self) -> None:
        self.calibrating = dialog = CalibrationDialog(self._dialog)
        dialog.closing.connect(self._on_calibrating_closing)
        CalibratingController(dialog, self._grabber, self._on_saved)
        dialog.open()

    def _on_calibrating_closing(self) -> None:
        self.calibrating = None

    def _on_saved(self, path: Path) -> None:
        if self.calibrating is not None:
            self.calibrating.reject()
        self.use(path)

    def _ask_file(self) -> None:
        path, _ = QFileDialog.getOpenFileName(
            self._dialog, self.tr("Open a calibration"), str(Path.home()), "camera_info (*.yaml *.yml)"
        )
        if path:
            self.use(Path(path))

    def _assume(self, degrees: float) -> None:
        self.choice = CalibrationChoice.nominal(degrees)
        self._dialog.accept()
