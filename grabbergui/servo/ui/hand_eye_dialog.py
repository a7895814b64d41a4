"""The dialog that calibrates hand and eye: setup, plan, run, result."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from PyQt5.QtCore import QSignalBlocker, Qt, pyqtSignal
from PyQt5.QtGui import QColor
from PyQt5.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QLabel,
    QLineEdit,
    QProgressBar,
    QPushButton,
    QRadioButton,
    QSpinBox,
    QTreeWidget,
    QTreeWidgetItem,
    QWidget,
)

from grabbergui.calibration.boards import BoardSettings
from grabbergui.core.drawing import BAD, GOOD
from grabbergui.models.language import localized, translate
from grabbergui.models.markup import Markup, markup, table
from grabbergui.models.unavailable import Unavailable
from grabbergui.servo.config import MarkerConfig
from grabbergui.servo.hand_eye.run import Step
from grabbergui.servo.models.hand_eye import Happened, Setup, Solution, TargetPreview
from grabbergui.servo.models.hand_eye_text import comparison_text, duration_text, result_rows, signed
from grabbergui.servo.ui.hand_eye_view import HandEyePage
from grabbergui.ui.actions import set_available
from grabbergui.ui.keys import StopKeys, WheelGuard
from grabbergui.ui.shown_text import set_cell_tooltip, set_rich
from grabbergui.ui.theme import dot
from grabbergui.ui.views import calibration_dialogs
from grabbergui.ui.widgets.labels import set_verdict, steps_markup

DICTIONARIES = (*calibration_dialogs.DICTIONARIES, "tag36h11", "tag25h9", "tag16h5")
KINDS = ("single", "grid", "charuco")
_BOARD = BoardSettings()
PRINTED = MarkerConfig(
    kind=_BOARD.kind,
    dictionary=_BOARD.dictionary,
    size=_BOARD.marker,
    columns=_BOARD.columns,
    rows=_BOARD.rows,
    pitch=_BOARD.square,
)
"""The board that the calibration of a camera saves for printing."""
BUSY = (240, 160, 30)


class HandEyeDialog(calibration_dialogs.CalibratingDialog):
    """Setters and signals, without logic. Implements `bases.HandEyeView`."""

    setupChanged = pyqtSignal(object)
    """A Setup that was changed by hand."""
    nextRequested = pyqtSignal()
    backRequested = pyqtSignal()
    stopPressed = pyqtSignal()
    useToggled = pyqtSignal(bool)
    publishToggled = pyqtSignal(bool)

    stopButton: QPushButton
    robotLabel: QLabel
    headButton: QRadioButton
    handButton: QRadioButton
    fixedButton: QRadioButton
    eyeLabel: QLabel
    kindBox: QComboBox
    dictionaryBox: QComboBox
    idBox: QSpinBox
    columnsBox: QSpinBox
    rowsBox: QSpinBox
    sizeBox: QDoubleSpinBox
    pitchBox: QDoubleSpinBox
    viewsBox: QSpinBox
    speedBox: QSpinBox
    printedButton: QPushButton
    planLabel: QLabel
    agreeBox: QCheckBox
    agreeLabel: QLabel
    stateLabel: QLabel
    progress: QProgressBar
    remainingLabel: QLabel
    events: QTreeWidget
    resultLabel: QLabel
    comparedLabel: QLabel
    poses: QTreeWidget
    mountEdit: QLineEdit
    frameEdit: QLineEdit
    useButton: QPushButton
    publishButton: QPushButton

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(Path(__file__).with_name("forms") / "hand_eye.ui", parent)
        self.dictionaryBox.addItems(DICTIONARIES)
        self._eyes = {"head": self.headButton, "hand": self.handButton, "fixed": self.fixedButton}
        self._refused: Mapping[str, str] = {}
        self._numbers = (
            self.idBox,
            self.columnsBox,
            self.rowsBox,
            self.sizeBox,
            self.pitchBox,
            self.viewsBox,
            self.speedBox,
        )
        for box in self._numbers:
            WheelGuard(box)
            box.setKeyboardTracking(False)
            box.valueChanged.connect(self._on_setup_edited)
        self.kindBox.currentIndexChanged.connect(self._on_setup_edited)
        self.dictionaryBox.currentIndexChanged.connect(self._on_setup_edited)
        for button in self._eyes.values():
            button.toggled.connect(self._on_eye_toggled)
        self.printedButton.clicked.connect(self._on_printed_clicked)
        self.agreeBox.toggled.connect(self._on_agree_toggled)
        self.nextButton.clicked.connect(lambda: self.nextRequested.emit())
        self.backButton.clicked.connect(lambda: self.backRequested.emit())
        self.stopButton.clicked.connect(lambda: self.stopPressed.emit())
        self.useButton.toggled.connect(self.useToggled)
        self.publishButton.toggled.connect(self.publishToggled)
        self.closeButton.clicked.connect(self.reject)
        self.events.setColumnWidth(0, 72)
        for column, width in enumerate((58, 96)):
            self.poses.setColumnWidth(column, width)
        self._stop_keys = StopKeys(self, ())
        self._stop_keys.pressed.connect(self.stopPressed)
        self._running = False
        self.setPage(HandEyePage.SETUP)

    @property
    def page(self) -> HandEyePage:
        """The page that is shown."""
        return HandEyePage(self.pages.currentIndex())

    def setPage(self, page: HandEyePage) -> None:
        """Show a page."""
        self.pages.setCurrentIndex(page.value)
        names = (self.tr("Setup"), self.tr("Plan"), self.tr("Motion"), self.tr("Result"))
        set_rich(self.stepsLabel, steps_markup(names, page.value))
        self.nextButton.setText(
            {
                HandEyePage.SETUP: self.tr("&Next"),
                HandEyePage.PLAN: self.tr("&Let the robot move"),
                HandEyePage.MOTION: self.tr("C&ompute"),
                HandEyePage.RESULT: self.tr("&Save…"),
            }[page]
        )
        self.backButton.setText(
            self.tr("Start a&gain") if page in (HandEyePage.MOTION, HandEyePage.RESULT) else self.tr("Bac&k")
        )
        self.agreeBox.setChecked(False)
        if page is HandEyePage.MOTION:
            self.events.clear()
            self.remainingLabel.clear()
            self.progress.setValue(0)
            self.stateLabel.setText(self.tr("Starting"))
        self.setRunning(False)
        # Space presses buttons and ticks boxes while nothing moves; Escape never closes the dialog.
        keys = [Qt.Key.Key_Escape] + [Qt.Key.Key_Space] * (page is HandEyePage.MOTION)
        self._stop_keys.keys = tuple(keys)

    def setRobot(self, name: str, refused: Mapping[str, str]) -> None:
        """Show the robot, and for each place of the camera why it cannot be calibrated (empty: it can)."""
        set_rich(self.robotLabel, markup(self.tr("Where is the camera of <b>{0}</b>?"), name))
        self._refused = refused
        for eye, button in self._eyes.items():
            set_available(button, refused[eye])
        self._show_eye()
        self._enable()

    def setSetup(self, setup: Setup) -> None:
        """Show eye, target, number of poses and speed."""
        marker = setup.marker
        boxes = (*self._eyes.values(), self.kindBox, self.dictionaryBox, *self._numbers)
        blockers = [QSignalBlocker(box) for box in boxes]
        self._eyes[setup.eye].setChecked(True)
        self.kindBox.setCurrentIndex(KINDS.index(marker.kind))
        if self.dictionaryBox.findText(marker.dictionary) < 0:
            self.dictionaryBox.addItem(marker.dictionary)
        self.dictionaryBox.setCurrentText(marker.dictionary)
        self.idBox.setValue(marker.target)
        self.columnsBox.setValue(marker.columns)
        self.rowsBox.setValue(marker.rows)
        self.sizeBox.setValue(1e3 * marker.size)
        self.pitchBox.setValue(1e3 * (marker.pitch or 1.25 * marker.size))
        self.viewsBox.setValue(setup.views)
        self.speedBox.setValue(round(100 * setup.speed))
        del blockers
        self._show_eye()
        self._enable()

    def setPreview(self, preview: TargetPreview) -> None:
        """Show the newest frame, and whether the target is seen in it."""
        problem = preview.problem
        set_verdict(self.verdictLabel, problem or self.tr("the target is seen"), "bad" if problem else "good")
        self._show_image(preview, BUSY if problem else GOOD)

    def setPlan(self, plan: Markup) -> None:
        """Show what the robot will do."""
        set_rich(self.planLabel, plan)

    def setRunning(self, running: bool, *, enough: bool = False) -> None:
        """Show whether the robot moves; `enough` views of one that rests can be computed."""
        self._running = running
        first = Unavailable.PAGE if self.page is HandEyePage.SETUP else None
        set_available(self.backButton, Unavailable.PATIENCE if running else first)
        self._enable(enough=enough)

    def addEvent(self, event: Happened) -> None:
        """Show an event of a run."""
        self.progress.setMaximum(event.wanted)
        self.progress.setValue(event.views)
        self.stateLabel.setText(event.text[:1].upper() + event.text[1:])
        if event.views < event.wanted:
            self.remainingLabel.setText(self.tr("{0} left").format(duration_text(event.remaining)))
        else:
            self.remainingLabel.clear()
        if event.step is Step.MOVING:
            return
        row = QTreeWidgetItem([localized(f"{event.seconds:.1f} s"), event.text])
        row.setTextAlignment(0, int(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignTop))
        set_cell_tooltip(row, 1, event.text)
        if event.step in (Step.VIEW, Step.SKIPPED):
            row.setIcon(1, dot(QColor(*(GOOD if event.step is Step.VIEW else BUSY))))
        self.events.addTopLevelItem(row)
        self.events.scrollToItem(row)

    def setEnded(self, text: str, *, enough: bool) -> None:
        """Show how a run ended that has no result."""
        self.setRunning(False, enough=enough)
        self.stateLabel.setText(text)
        self.remainingLabel.clear()

    def setSolution(self, solution: Solution, unusable: str) -> None:
        """Show a result; `unusable` is why servoing cannot use it (empty: it can)."""
        rows = result_rows(solution.result, solution.placement)
        set_rich(self.resultLabel, table(rows))
        compared = self.tr("No other calibration of this camera is known")
        if solution.compared is not None:
            compared = self.tr("Differs by {0}").format(comparison_text(*solution.compared))
        self.comparedLabel.setText(compared)
        self.poses.clear()
        for number, (error, joints) in enumerate(zip(solution.result.errors, solution.joints, strict=True)):
            text = self.tr("left out") if math.isnan(error) else localized(f"{error:.2f} px")
            angles = "  ".join(signed(angle, 0) for angle in np.degrees(joints))
            row = QTreeWidgetItem([str(number + 1), text, angles])
            row.setTextAlignment(1, int(Qt.AlignmentFlag.AlignRight))
            set_cell_tooltip(row, 2, angles)
            row.setIcon(1, dot(QColor(*(BAD if math.isnan(error) else GOOD))))
            self.poses.addTopLevelItem(row)
        self.mountEdit.setText(solution.placement.mount)
        self.frameEdit.setText(solution.placement.frame)
        set_available(self.useButton, unusable)
        self.setInUse(False)

    def setInUse(self, in_use: bool) -> None:
        """Show whether servoing uses the result."""
        with QSignalBlocker(self.useButton):
            self.useButton.setChecked(in_use)
        self.useButton.setText(self.tr("In &use") if in_use else self.tr("&Use now"))

    def setPublished(self, published: bool) -> None:
        """Show whether the camera's frame is on tf."""
        with QSignalBlocker(self.publishButton):
            self.publishButton.setChecked(published)
        self.publishButton.setText(self.tr("On &tf") if published else self.tr("Publish in &tf"))
        reason = translate("Unavailable", "The name is published: stop publishing it first.")
        for edit in (self.mountEdit, self.frameEdit):
            set_available(edit, reason if published else None)

    def showError(self, text: str) -> None:
        """Show an error message."""
        self.messages.showError(text)

    def showNotice(self, text: str) -> None:
        """Show a message that goes away by itself."""
        self.messages.showNotice(text)

    def dismissAll(self) -> None:
        """Remove every message."""
        self.messages.dismissAll()

    @property
    def setup(self) -> Setup:
        """The choices of the first page."""
        eye = next(eye for eye, button in self._eyes.items() if button.isChecked())
        kind = KINDS[self.kindBox.currentIndex()]
        first = {"id" if kind == "single" else "first": self.idBox.value()}
        marker = MarkerConfig(
            kind=kind,
            dictionary=self.dictionaryBox.currentText(),
            size=1e-3 * self.sizeBox.value(),
            columns=self.columnsBox.value(),
            rows=self.rowsBox.value(),
            pitch=0.0 if kind == "single" else 1e-3 * self.pitchBox.value(),
            **first,
        )
        return Setup(eye, marker, self.viewsBox.value(), 1e-2 * self.speedBox.value())

    @property
    def frames(self) -> tuple[str, str]:
        """The frames' names: mount, camera."""
        return self.mountEdit.text().strip(), self.frameEdit.text().strip()

    def _enable(self, *, enough: bool = False) -> None:
        eye = next((eye for eye, button in self._eyes.items() if button.isChecked()), "head")
        rests = None if enough else Unavailable.VIEWS
        unticked = translate("Unavailable", "Tick the box above first.")
        reasons = {
            HandEyePage.SETUP: self._refused.get(eye),
            HandEyePage.PLAN: None if self.agreeBox.isChecked() else unticked,
            HandEyePage.MOTION: Unavailable.PATIENCE if self._running else rests,
            HandEyePage.RESULT: None,
        }
        set_available(self.nextButton, reasons[self.page])
        single = translate("Unavailable", "A single marker has no rows and columns.")
        for box in (self.columnsBox, self.rowsBox, self.pitchBox):
            set_available(box, None if self.kindBox.currentIndex() else single)

    def _show_eye(self) -> None:
        eye = next((eye for eye, button in self._eyes.items() if button.isChecked()), "head")
        self.eyeLabel.setText(
            self._refused.get(eye, "")
            or self.tr("Bring the board into the middle of the image; it must not move on its own.")
        )

    def _on_setup_edited(self) -> None:
        self._show_eye()
        self._enable()
        self.setupChanged.emit(self.setup)

    def _on_eye_toggled(self, checked: bool) -> None:
        if checked:
            self._on_setup_edited()

    def _on_printed_clicked(self) -> None:
        setup = self.setup
        self.setSetup(Setup(setup.eye, PRINTED, setup.views, setup.speed))
        self.setupChanged.emit(self.setup)

    def _on_agree_toggled(self) -> None:
        self._enable()
