"""The servoing window: the picture with its detections, the robot, states, curves, emergency stop."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PyQt5.QtCore import QSignalBlocker, Qt, pyqtSignal
from PyQt5.QtGui import QColor
from PyQt5.QtWidgets import (
    QDoubleSpinBox,
    QLabel,
    QPushButton,
    QSplitter,
    QTreeWidget,
    QTreeWidgetItem,
    QWidget,
)

from grabbergui.core.pixels import DisplayImage
from grabbergui.models.language import localized
from grabbergui.models.servoing import CURVE_SECONDS, Entry, Posture, Tuning, state_text
from grabbergui.servo.overlay import Drawing, colour_of
from grabbergui.servo.state_machine import State
from grabbergui.ui.editors.feature_editor import WheelGuard
from grabbergui.ui.theme import dot
from grabbergui.ui.widgets.keyboard import StopKeys
from grabbergui.ui.widgets.message_stack import MessageStack
from grabbergui.ui.widgets.picture_canvas import PictureCanvas
from grabbergui.ui.widgets.robot_view import RobotView
from grabbergui.ui.widgets.servo_widgets import DrawingItem, StateStrip, TimePlot
from grabbergui.ui.windows import load_form

STOP_KEYS = (Qt.Key.Key_Space, Qt.Key.Key_Escape)


class ServoWindow(QWidget):
    """Setters and signals, without logic."""

    stopPressed = pyqtSignal()
    startPressed = pyqtSignal()
    handEyePressed = pyqtSignal()
    tuningChanged = pyqtSignal(object)
    """A Tuning that was set by hand."""
    viewChanged = pyqtSignal(object, object)
    """The visible Region of the picture, and (width, height) in screen pixels that it takes."""

    messages: MessageStack
    states: StateStrip
    reasonLabel: QLabel
    handEyeButton: QPushButton
    startButton: QPushButton
    stopButton: QPushButton
    sides: QSplitter
    canvas: PictureCanvas
    history: QTreeWidget
    headGainBox: QDoubleSpinBox
    headFastestBox: QDoubleSpinBox
    armGainBox: QDoubleSpinBox
    armFastestBox: QDoubleSpinBox
    rateBox: QDoubleSpinBox
    speedBox: QDoubleSpinBox
    robotView: RobotView
    distancePlot: TimePlot
    anglePlot: TimePlot
    velocityPlot: TimePlot
    turnPlot: TimePlot

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("servo", self)
        self.sides.setSizes([760, 600])
        self.drawing = DrawingItem()
        """The overlay of the picture."""
        self.canvas.addOverlay(self.drawing)
        self.canvas.viewChanged.connect(self.viewChanged)
        self.distancePlot.setUp(self.tr("Hand to goal, mm"), (), CURVE_SECONDS, 10)
        self.anglePlot.setUp(self.tr("Hand to goal, °"), (), CURVE_SECONDS, 2)
        self.velocityPlot.setUp(self.tr("Velocity of the hand, mm/s"), "xyz", CURVE_SECONDS, 20)
        self.turnPlot.setUp(self.tr("Turning of the hand, °/s"), "xyz", CURVE_SECONDS, 5, shows_time=True)
        self.history.setColumnWidth(0, 76)
        self.history.setColumnWidth(1, 196)
        self.stopButton.clicked.connect(lambda: self.stopPressed.emit())
        self.startButton.clicked.connect(lambda: self.startPressed.emit())
        self.handEyeButton.clicked.connect(lambda: self.handEyePressed.emit())
        self._boxes = (
            self.headGainBox,
            self.headFastestBox,
            self.armGainBox,
            self.armFastestBox,
            self.rateBox,
            self.speedBox,
        )
        for box in self._boxes:
            WheelGuard(box)
            box.setKeyboardTracking(False)
            box.valueChanged.connect(self._on_box_value_changed)
        # Whatever has the focus, a button or a number being typed.
        StopKeys(self, STOP_KEYS).pressed.connect(self.stopPressed)

    # -- setters ---------------------------------------------------------------------------------
    def setPicture(self, image: DisplayImage, width: int, height: int, drawing: Drawing) -> None:
        """Show a picture of that size and what lies over it."""
        self.canvas.setPicture(image, width, height)
        self.drawing.setDrawing(drawing, width, height)

    def setPosture(self, posture: Posture | None) -> None:
        """Show where the robot is."""
        self.robotView.setPosture(posture)

    def setState(self, state: State, reason: str) -> None:
        """Tell the state and why."""
        self.states.setState(state)
        self.reasonLabel.setText(reason)
        self.startButton.setEnabled(state is State.STOPPED)

    def setHandEyeAvailable(self, available: bool) -> None:
        """Show whether hand and eye can be calibrated now."""
        self.handEyeButton.setEnabled(available)

    def addEntry(self, entry: Entry) -> None:
        """Add a line to the history."""
        row = QTreeWidgetItem([localized(f"{entry.time:.2f} s"), state_text(entry.state), entry.reason])
        row.setIcon(1, dot(QColor(*colour_of(entry.state))))
        row.setTextAlignment(0, int(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter))
        row.setToolTip(2, entry.reason)
        self.history.addTopLevelItem(row)
        self.history.scrollToItem(row)

    def setCurves(self, curves: NDArray[np.float64]) -> None:
        """Show curves (n, 9): seconds before now, error in m and rad, twist in m/s and rad/s."""
        times, degrees = curves[:, 0], 180 / math.pi
        self.distancePlot.setCurves(times, curves[:, 1:2] * 1e3)
        self.anglePlot.setCurves(times, curves[:, 2:3] * degrees)
        self.velocityPlot.setCurves(times, curves[:, 3:6] * 1e3)
        self.turnPlot.setCurves(times, curves[:, 6:9] * degrees)

    def setTuning(self, tuning: Tuning) -> None:
        """Show gains, limits and rate."""
        for box, value in zip(self._boxes, _values(tuning), strict=True):
            with QSignalBlocker(box):
                box.setValue(value)

    # -- inside ----------------------------------------------------------------------------------
    def _on_box_value_changed(self) -> None:
        self.tuningChanged.emit(Tuning(*(box.value() for box in self._boxes)))


def _values(tuning: Tuning) -> Sequence[float]:
    return (
        tuning.head_gain,
        tuning.head_fastest,
        tuning.arm_gain,
        tuning.arm_fastest,
        tuning.rate,
        tuning.speed,
    )
