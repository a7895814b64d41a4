"""The calibration dialog, and the choice for a camera that has no calibration."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PyQt5.QtCore import QObject

from grabbergui.calibration import printed_sheet
from grabbergui.calibration.boards import BoardSettings
from grabbergui.calibration.calibration_choice import CalibrationChoice
from grabbergui.core.errors import UsageError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.models.calibrating import CalibratingModel, CalibrationSolution
from grabbergui.models.error_text import error_text
from grabbergui.ui.file_dialogs import FileDialogs
from grabbergui.ui.gui_thread import Bridge
from grabbergui.ui.views.calibration_dialogs import (
    CalibrationChoiceDialog,
    CalibrationDialog,
    CalibrationPage,
)


class CalibratingController(QObject):
    """Leads through the steps. Make it on the GUI thread, for a source that streams.

    It ends with its dialog. `on_saved` is called for every file that was written.
    """

    def __init__(
        self,
        dialog: CalibrationDialog,
        grabber: FrameGrabber,
        on_saved: Callable[[Path], None] = lambda path: None,
        settings: BoardSettings | None = None,
    ) -> None:
        super().__init__(dialog)
        self.dialog = dialog
        self.model = CalibratingModel(grabber, settings)
        self._files = FileDialogs(dialog)
        self._on_saved = on_saved
        self._solution: CalibrationSolution | None = None
        self._chosen: int | None = None
        self._saved = 0
        "Views of the calibration that was saved last."
        self._bridge = Bridge(self)
        self._bridge.bind(self.model.ready, self._on_model_ready)
        self._bridge.bind(self.model.solved, self._on_model_solved)
        self._bridge.bind(self.model.unsolved, self._on_model_unsolved)
        self._bridge.bind(self.model.saved, self._on_model_saved)
        self._bridge.bind(self.model.failed, dialog.messages.showError)
        dialog.setBoard(self.model.settings)
        dialog.boardChosen.connect(self._on_dialog_board_chosen)
        dialog.printRequested.connect(self._ask_print)
        dialog.nextRequested.connect(self._on_dialog_next_requested)
        dialog.backRequested.connect(self._on_dialog_back_requested)
        dialog.againRequested.connect(self.model.begin_again)
        dialog.moreRequested.connect(lambda: self.go(CalibrationPage.VIEWS))
        dialog.usedChanged.connect(self.model.solve)
        dialog.viewChosen.connect(self._on_dialog_view_chosen)
        dialog.viewChanged.connect(self.model.set_viewport)
        dialog.closing.connect(self.close)
        self.model.open()

    def close(self) -> None:
        """Release the source; the thread ends after the current frame. May be called twice."""
        self._bridge.close()
        self.model.close(0)

    def print_to(self, path: Path) -> None:
        """Save the board for printing."""
        try:
            sheet = printed_sheet.save(self.model.settings.board(), path)
        except (UsageError, OSError) as error:
            self.dialog.messages.showError(self.tr("the board could not be saved: {0}").format(error))
            return
        text = self.tr("Saved as {0}: print it on {1} at 100 %")
        self.dialog.messages.showNotice(text.format(path, sheet.paper))

    def save_to(self, path: Path) -> None:
        """Save the calibration."""
        self.model.save(path)

    def _on_dialog_board_chosen(self, settings: BoardSettings) -> None:
        try:
            self.model.choose(settings)
        except UsageError as error:
            self.dialog.setBoardProblem(error_text(error))
            self.dialog.messages.showError(error_text(error))
        else:
            self.dialog.setBoardProblem("")
            self.dialog.messages.dismissAll()

    def _on_dialog_next_requested(self) -> None:
        step = self.dialog.step
        if step is CalibrationPage.BOARD:
            self.go(CalibrationPage.VIEWS)
        elif step is CalibrationPage.VIEWS:
            self.model.collect(False)
            self.model.solve()
        else:
            self._ask_save()

    def _on_dialog_back_requested(self) -> None:
        self.go(
            CalibrationPage.VIEWS if self.dialog.step is CalibrationPage.RESULT else CalibrationPage.BOARD
        )

    def _on_dialog_view_chosen(self, number: int) -> None:
        self._chosen = number
        self._show_view()

    def go(self, step: CalibrationPage) -> None:
        """Show a page; views are taken while their page is shown."""
        self._chosen = None
        self.dialog.setStep(step)
        self.model.collect(step is CalibrationPage.VIEWS)

    def _ask_print(self) -> None:
        name = f"{self.model.settings.kind}.pdf"
        kinds = "PDF (*.pdf);;PNG (*.png)"
        if path := self._files.to_save(self.tr("Save the board"), str(Path.home() / name), kinds):
            self.print_to(path)

    def _ask_save(self) -> None:
        name = f"{self.model.name}.yaml"
        kinds = "camera_info (*.yaml)"
        if path := self._files.to_save(self.tr("Save the calibration"), str(Path.home() / name), kinds):
            self.save_to(path)

    def _on_model_ready(self) -> None:
        preview = self.model.take()
        self.dialog.unsaved = 0 if self._saved == len(self.model.images) else len(self.model.images)
        if preview is not None and self._chosen is None:
            self.dialog.setPreview(preview, self.model.wanted)

    def _on_model_solved(self, solution: CalibrationSolution) -> None:
        self._solution = solution
        if solution.request != self.model.requests:  # other views were ticked since
            return
        self.dialog.setSolution(solution)
        if self.dialog.step is CalibrationPage.VIEWS:
            self.go(CalibrationPage.RESULT)
        self._show_view()

    def _on_model_unsolved(self, reason: str) -> None:
        self.dialog.messages.showError(reason)
        if self.dialog.step is CalibrationPage.VIEWS:
            self.model.collect(True)
        elif self._solution is not None:  # what *Save* writes
            self.dialog.setSolution(self._solution)

    def _on_model_saved(self, path: Path) -> None:
        text = self.tr("Saved as {0}. Publish it with `grabbergui serve … --ros2 NAME --calibration {0}`")
        self.dialog.messages.showNotice(text.format(path))
        self._saved, self.dialog.unsaved = len(self.model.images), 0
        self._on_saved(path)

    def _show_view(self) -> None:
        solution, number, images = self._solution, self._chosen, self.model.images
        if solution is not None and number is not None and number < min(len(images), len(solution.corners)):
            self.dialog.setView(images[number], solution, number)


class CalibrationChooser(QObject):
    """Accepts its dialog once there is a `choice`. The source must be open; it is started to calibrate it."""

    def __init__(self, dialog: CalibrationChoiceDialog, grabber: FrameGrabber) -> None:
        super().__init__(dialog)
        self.choice: CalibrationChoice | None = None
        """The choice of the user."""
        self.calibrating: CalibrationDialog | None = None
        """The calibration dialog that is open on top, if any."""
        self._dialog, self._grabber = dialog, grabber
        dialog.calibrateRequested.connect(self._calibrate)
        dialog.fileRequested.connect(self._ask_file)
        dialog.nominalRequested.connect(self._assume)

    def use(self, path: Path) -> None:
        """Take a file's calibration, or report its fault."""
        try:
            self.choice = CalibrationChoice.file(path, self._grabber)
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
        kinds = "camera_info (*.yaml *.yml *.ini)"
        if path := FileDialogs(self._dialog).to_open(self.tr("Open a calibration"), kinds, Path.home()):
            self.use(path)

    def _assume(self, degrees: float) -> None:
        self.choice = CalibrationChoice.nominal(degrees)
        self._dialog.accept()
