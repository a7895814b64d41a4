"""The dialog that calibrates a camera step by step, and the one that offers to."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PyQt5.QtCore import QSignalBlocker, Qt, pyqtSignal
from PyQt5.QtGui import QCloseEvent, QKeyEvent
from PyQt5.QtWidgets import (
    QComboBox,
    QCommandLinkButton,
    QDialog,
    QDoubleSpinBox,
    QLabel,
    QMessageBox,
    QProgressBar,
    QPushButton,
    QSpinBox,
    QStackedWidget,
    QTreeWidget,
    QTreeWidgetItem,
    QWidget,
)

from grabbergui.calibration.boards import KINDS, BoardSettings
from grabbergui.calibration.collector import FEWEST_VIEWS, ViewVerdict
from grabbergui.core.calibration import NOMINAL_FIELD_OF_VIEW
from grabbergui.core.drawing import BAD, GOOD, Drawing, Stroke, crosses
from grabbergui.core.pixels import DisplayImage
from grabbergui.models.calibrating import BoardPreview, CalibrationSolution, Preview, verdict_text
from grabbergui.models.language import counted, localized
from grabbergui.models.markup import markup, table
from grabbergui.models.unavailable import Unavailable
from grabbergui.ui.actions import set_available
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.screen import fit_screen
from grabbergui.ui.shown_text import question_box, set_rich, set_tooltip
from grabbergui.ui.widgets.detections import CoverageItem, CoverageView, DrawingItem
from grabbergui.ui.widgets.image_canvas import ImageCanvas
from grabbergui.ui.widgets.labels import set_verdict, steps_markup
from grabbergui.ui.widgets.messages import MessageStack

NAME_WIDTH = 360
"Pixels of a camera's name in the title; the tooltip has the whole name."
DICTIONARIES = ("4X4_50", "4X4_100", "5X5_100", "5X5_250", "6X6_250", "7X7_250", "ARUCO_ORIGINAL")
"""The usual ones of printed boards; the command line accepts all others."""
CROSSES = 110
"""How many times larger the image is than a cross on a corner."""
NOT_KEPT = (250, 180, 40)
"""The colour of corners in a frame that is no view."""
ENLARGED = 100
"""How many times too long errors are drawn."""

_TONES = {
    ViewVerdict.KEPT: "good",
    ViewVerdict.KNOWN: "busy",
    ViewVerdict.MOVING: "busy",
    ViewVerdict.NOT_SEEN: "bad",
}


class CalibrationPage(Enum):
    """The pages, in order."""

    BOARD = 0
    VIEWS = 1
    RESULT = 2


class CalibratingDialog(QDialog):
    """A dialog of several pages beside the live image, in which the detected corners are marked."""

    viewChanged = pyqtSignal(object, object)
    """The visible Region of the image, and (width, height) in screen pixels that it takes."""
    closing = pyqtSignal()

    messages: MessageStack
    canvas: ImageCanvas
    verdictLabel: QLabel
    imageLabel: QLabel
    stepsLabel: QLabel
    pages: QStackedWidget
    backButton: QPushButton
    closeButton: QPushButton
    nextButton: QPushButton

    def __init__(self, form: str | Path, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form(form, self)
        fit_screen(self)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowFlag(Qt.WindowType.WindowMaximizeButtonHint)
        self.drawing = DrawingItem()
        """The corners over the image."""
        self.canvas.addOverlay(self.drawing)
        self.canvas.viewChanged.connect(self.viewChanged)

    def done(self, result: int) -> None:
        """Emit `closing`, whichever button or key closes the dialog."""
        self.closing.emit()
        super().done(result)

    def _show_image(self, preview: Preview, colour: tuple[int, int, int]) -> None:
        """Show a frame, and a cross of that colour on each corner that is seen."""
        if preview.image is None:
            return
        size, corners = preview.size, preview.corners
        self.canvas.setImage(preview.image, *size)
        found = Drawing([] if corners is None else crosses(corners, size[0] / CROSSES, colour))
        self.drawing.setDrawing(found, *size)
        self.imageLabel.setText(f"{size[0]} × {size[1]}")


class CalibrationDialog(CalibratingDialog):
    """Setters and signals; the controller leads through the steps."""

    boardChosen = pyqtSignal(object)
    """BoardSettings that were changed by hand."""
    printRequested = pyqtSignal()
    nextRequested = pyqtSignal()
    backRequested = pyqtSignal()
    againRequested = pyqtSignal()
    moreRequested = pyqtSignal()
    usedChanged = pyqtSignal(object)
    """Numbers of the views that are ticked."""
    viewChosen = pyqtSignal(int)

    kindBox: QComboBox
    columnsBox: QSpinBox
    rowsBox: QSpinBox
    squareBox: QDoubleSpinBox
    markerBox: QDoubleSpinBox
    dictionaryBox: QComboBox
    printButton: QPushButton
    hintLabel: QLabel
    progress: QProgressBar
    coverageLabel: QLabel
    coverage: CoverageView
    againButton: QPushButton
    resultLabel: QLabel
    views: QTreeWidget
    moreButton: QPushButton

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("calibration", parent)
        self.cells = CoverageItem()
        self.canvas.addOverlay(self.cells)
        self.dictionaryBox.addItems(DICTIONARIES)
        for column, width in enumerate((96, 90)):
            self.views.setColumnWidth(column, width)
        for box in (self.columnsBox, self.rowsBox, self.squareBox, self.markerBox):
            box.setKeyboardTracking(False)
            box.valueChanged.connect(self._on_board_edited)
        self.kindBox.currentIndexChanged.connect(self._on_board_edited)
        self.dictionaryBox.currentIndexChanged.connect(self._on_board_edited)
        self.printButton.clicked.connect(lambda: self.printRequested.emit())
        self.nextButton.clicked.connect(lambda: self.nextRequested.emit())
        self.backButton.clicked.connect(lambda: self.backRequested.emit())
        self.againButton.clicked.connect(lambda: self.againRequested.emit())
        self.moreButton.clicked.connect(lambda: self.moreRequested.emit())
        self.unsaved = 0
        """Views that are lost if the dialog is closed now."""
        self.question: QMessageBox | None = None
        """The question whether to discard them, while it is open."""
        self.closeButton.clicked.connect(self._on_close_clicked)
        self.views.itemChanged.connect(self._on_views_item_changed)
        self.views.currentItemChanged.connect(self._on_views_current_item_changed)
        self.setStep(CalibrationPage.BOARD)

    @property
    def step(self) -> CalibrationPage:
        """The page that is shown."""
        return CalibrationPage(self.pages.currentIndex())

    def setStep(self, step: CalibrationPage) -> None:
        """Show a page."""
        self.pages.setCurrentIndex(step.value)
        steps = (self.tr("Board"), self.tr("Views"), self.tr("Result"))
        set_rich(self.stepsLabel, steps_markup(steps, step.value))
        set_available(self.backButton, Unavailable.PAGE if step is CalibrationPage.BOARD else None)
        self.nextButton.setText(
            {
                CalibrationPage.BOARD: self.tr("Take &views"),
                CalibrationPage.VIEWS: self.tr("&Finish"),
                CalibrationPage.RESULT: self.tr("&Save…"),
            }[step]
        )
        set_available(self.nextButton, Unavailable.VIEWS if step is CalibrationPage.VIEWS else None)
        self.cells.setVisible(step is CalibrationPage.VIEWS)

    def setBoard(self, settings: BoardSettings) -> None:
        """Show the chosen board."""
        blockers = [
            QSignalBlocker(box)
            for box in (self.kindBox, self.columnsBox, self.rowsBox, self.squareBox, self.markerBox,
                        self.dictionaryBox)
        ]  # fmt: skip
        self.kindBox.setCurrentIndex(KINDS.index(settings.kind))
        self.columnsBox.setValue(settings.columns)
        self.rowsBox.setValue(settings.rows)
        self.squareBox.setValue(1e3 * settings.square)
        self.markerBox.setValue(1e3 * settings.marker)
        if self.dictionaryBox.findText(settings.dictionary) < 0:
            self.dictionaryBox.addItem(settings.dictionary)
        self.dictionaryBox.setCurrentText(settings.dictionary)
        del blockers
        self._enable_markers()

    def setBoardProblem(self, problem: str) -> None:
        """Show why no views of the chosen board can be taken; empty if they can."""
        set_available(self.nextButton, problem)

    def setPreview(self, preview: BoardPreview, wanted: int) -> None:
        """Show the newest frame and the coverage."""
        if preview.image is None:
            set_verdict(self.verdictLabel, self.tr("no images arrive from the camera"), "bad")
        else:
            self._show_image(preview, GOOD if preview.verdict is ViewVerdict.KEPT else NOT_KEPT)
            self.cells.setCells(preview.coverage.cells, *preview.size)
            if preview.verdict is not None:
                set_verdict(self.verdictLabel, *self._verdict_text(preview.verdict))
        self.coverage.setCoverage(preview.coverage)
        self.coverageLabel.setText(self.tr("{0:.0%} of the image is covered").format(preview.coverage.part))
        self.progress.setMaximum(wanted)
        self.progress.setValue(min(preview.views, wanted))
        self.hintLabel.setText(preview.hint)
        if self.step is CalibrationPage.VIEWS:
            set_available(self.nextButton, None if preview.views >= FEWEST_VIEWS else Unavailable.VIEWS)

    def setSolution(self, solution: CalibrationSolution) -> None:
        """Show a calibration and every view's error."""
        result = solution.result
        matrix, spread = result.calibration.matrix, result.uncertainty
        rows: tuple[tuple[str, str], ...] = (
            (
                self.tr("Error"),
                markup(self.tr("<b>{0:.3f} px</b> over {1} views"), result.rms, len(solution.used)),
            ),
            (
                self.tr("Focal lengths"),
                f"{matrix[0, 0]:.1f} ± {spread[0]:.1f}, {matrix[1, 1]:.1f} ± {spread[1]:.1f} px",
            ),
            (
                self.tr("Centre"),
                f"{matrix[0, 2]:.1f} ± {spread[2]:.1f}, {matrix[1, 2]:.1f} ± {spread[3]:.1f} px",
            ),
            (self.tr("Distortion"), " ".join(f"{value:.4f}" for value in result.calibration.distortion)),
        )
        set_rich(self.resultLabel, table((name, localized(text)) for name, text in rows))
        with QSignalBlocker(self.views):
            current = self.views.indexOfTopLevelItem(self.views.currentItem())
            self.views.clear()
            for number, corners in enumerate(solution.corners):
                used = number in solution.used
                row = QTreeWidgetItem(
                    [f"{number + 1}", str(len(corners)), localized(f"{result.error_of(number):.3f} px")]
                )
                row.setCheckState(0, Qt.CheckState.Checked if used else Qt.CheckState.Unchecked)
                for column in (1, 2):
                    row.setTextAlignment(column, int(Qt.AlignmentFlag.AlignRight))
                row.setDisabled(False)
                if not used:
                    row.setText(2, self.tr("{0}, left out").format(row.text(2)))
                self.views.addTopLevelItem(row)
            if current >= 0:
                self.views.setCurrentItem(self.views.topLevelItem(current))

    def setView(self, image: DisplayImage, solution: CalibrationSolution, number: int) -> None:
        """Show a kept view with its errors enlarged, instead of the live image."""
        size = solution.result.calibration.width, solution.result.calibration.height
        self.canvas.setImage(image, *size)
        self.drawing.setDrawing(
            _errors(solution.corners[number], solution.result.residuals[number], size[0]), *size
        )
        text = self.tr("view {0}, errors enlarged {1} times").format(number + 1, ENLARGED)
        set_verdict(self.verdictLabel, text, "idle")

    def _on_close_clicked(self) -> None:
        self.close()

    def closeEvent(self, event: QCloseEvent | None) -> None:
        """Ask before views are lost, whether the button or the title bar closes the dialog."""
        if event is None or not self.unsaved or not self.isVisible():
            super().closeEvent(event)
            return
        event.ignore()
        self.ask_to_discard(self.reject)

    def ask_to_discard(self, proceed: Callable[[], None]) -> None:
        """Ask whether the unsaved views may be lost, and call `proceed` if so."""
        if self.question is not None:
            self.question.raise_()
            return
        self.question = box = question_box(
            self,
            counted(self.unsaved, self.tr("Discard the view?"), self.tr("Discard {0} views?")),
            self.tr("The calibration that is computed from them has not been saved."),
        )
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        discard = box.addButton(self.tr("Discard them"), QMessageBox.ButtonRole.DestructiveRole)
        keep = box.addButton(self.tr("Keep them"), QMessageBox.ButtonRole.RejectRole)
        box.setDefaultButton(keep)
        box.setEscapeButton(keep)

        def answered() -> None:
            self.question = None
            if box.clickedButton() is discard:
                proceed()

        box.finished.connect(lambda _: answered())
        box.open()

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Let Escape close the dialog only before there are views, which would be lost."""
        if event is None or event.key() != Qt.Key.Key_Escape or not self.progress.value():
            super().keyPressEvent(event)

    @property
    def board(self) -> BoardSettings:
        """The settings of the first page."""
        return BoardSettings(
            KINDS[self.kindBox.currentIndex()],
            self.columnsBox.value(),
            self.rowsBox.value(),
            1e-3 * self.squareBox.value(),
            1e-3 * self.markerBox.value(),
            self.dictionaryBox.currentText(),
        )

    def _on_board_edited(self) -> None:
        self._enable_markers()
        self.boardChosen.emit(self.board)

    def _enable_markers(self) -> None:
        for box in (self.markerBox, self.dictionaryBox):
            set_available(box, None if self.kindBox.currentIndex() == 0 else Unavailable.MARKERS)

    def _on_views_item_changed(self, item: QTreeWidgetItem, column: int) -> None:
        rows = (self.views.topLevelItem(number) for number in range(self.views.topLevelItemCount()))
        ticked = [row is not None and row.checkState(0) == Qt.CheckState.Checked for row in rows]
        self.usedChanged.emit(tuple(number for number, used in enumerate(ticked) if used))

    def _on_views_current_item_changed(self, item: QTreeWidgetItem | None) -> None:
        if item is not None:
            self.viewChosen.emit(self.views.indexOfTopLevelItem(item))

    def _verdict_text(self, verdict: ViewVerdict) -> tuple[str, str]:
        """Return text and tone of a verdict; obstacles to a view matter only while views are taken."""
        if verdict is ViewVerdict.NOT_SEEN or self.step is CalibrationPage.VIEWS:
            return verdict_text(verdict), _TONES[verdict]
        return self.tr("the board is seen"), "good"


def _errors(corners: NDArray[np.float32], residuals: NDArray[np.float64], width: int) -> Drawing:
    """A cross on each corner, and a line to where it should be, enlarged."""
    lines = [
        Stroke(np.array([corner, corner + ENLARGED * error]), BAD, weight=2)
        for corner, error in zip(corners.astype(np.float64), residuals, strict=True)
    ]
    return Drawing([*crosses(corners, width / 160, GOOD), *lines])


class CalibrationChoiceDialog(QDialog):
    """Setters and signals; it stays open until its controller accepts it."""

    calibrateRequested = pyqtSignal()
    fileRequested = pyqtSignal()
    nominalRequested = pyqtSignal(float)
    """The horizontal field of view to assume, in degrees."""

    titleLabel: QLabel
    calibrateButton: QCommandLinkButton
    fileButton: QCommandLinkButton
    nominalButton: QCommandLinkButton
    degreesBox: QDoubleSpinBox
    problemLabel: QLabel
    cancelButton: QPushButton

    def __init__(self, camera: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("calibration_choice", self)
        title = self.tr("{0} is not calibrated")
        short = self.titleLabel.fontMetrics().elidedText(camera, Qt.TextElideMode.ElideMiddle, NAME_WIDTH)
        self.titleLabel.setText(title.format(short))
        set_tooltip(self.titleLabel, title.format(camera))
        self.degreesBox.setValue(NOMINAL_FIELD_OF_VIEW)
        self.setProblem("")
        self.calibrateButton.clicked.connect(lambda: self.calibrateRequested.emit())
        self.fileButton.clicked.connect(lambda: self.fileRequested.emit())
        self.nominalButton.clicked.connect(lambda: self.nominalRequested.emit(self.degreesBox.value()))
        self.cancelButton.clicked.connect(self.reject)

    def setProblem(self, text: str) -> None:
        """Show why the choice cannot be used; empty if it can."""
        self.problemLabel.setText(text)
        self.problemLabel.setVisible(bool(text))
