"""The servoing window: the image with its detections, the robot, states, curves, emergency stop."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PyQt5.QtCore import QEvent, QPointF, QRectF, QSignalBlocker, QSize, Qt, pyqtSignal
from PyQt5.QtGui import QColor, QFontMetricsF, QPainter, QPaintEvent, QPalette, QPen
from PyQt5.QtWidgets import (
    QDoubleSpinBox,
    QLabel,
    QPushButton,
    QSizePolicy,
    QSplitter,
    QTreeWidget,
    QTreeWidgetItem,
    QWidget,
)

from grabbergui.core.drawing import Drawing
from grabbergui.core.pixels import DisplayImage
from grabbergui.models.language import localized, translate
from grabbergui.models.markup import joined, markup
from grabbergui.models.unavailable import Unavailable
from grabbergui.servo.models.servoing import CURVE_SECONDS, Entry, Posture, Tuning, state_text
from grabbergui.servo.overlay import AXIS_COLOURS, colour_of
from grabbergui.servo.state_machine import State
from grabbergui.servo.ui.robot_view import RobotView
from grabbergui.ui.actions import set_available
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.keys import StopKeys, WheelGuard
from grabbergui.ui.shown_text import set_cell_tooltip, set_plot_title
from grabbergui.ui.theme import dot
from grabbergui.ui.widgets.detections import DrawingItem
from grabbergui.ui.widgets.image_canvas import ImageCanvas
from grabbergui.ui.widgets.messages import MessageStack
from grabbergui.ui.widgets.plots import ValueAxis

_WAY = (State.SEARCHING, State.CENTRING, State.WAITING, State.APPROACHING, State.REACHED)
"The states of a run without incidents, in order."
_APART = (State.FOLLOWING, State.STUCK, State.LOST, State.STOPPED)
"States that any other may lead to."
_GAP, _ARROW, _PADDING = 6.0, 16.0, 11.0
STOP_KEYS = (Qt.Key.Key_Space, Qt.Key.Key_Escape)
MOST_ENTRIES = 1000
"Most lines of the history; beyond, the oldest are removed."


class StateStrip(QWidget):
    """Names all states in a row, and lights the current one."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self._state: State | None = None

    @property
    def state(self) -> State | None:
        """The lit state."""
        return self._state

    def setState(self, state: State) -> None:
        """Light a state."""
        if state is not self._state:
            self._state = state
            self.setAccessibleName(state_text(state))
            self.update()

    def sizeHint(self) -> QSize:
        """Return room for all states in a row."""
        return QSize(round(self._places()[-1][1].right()) + 2, self.fontMetrics().height() + 12)

    def minimumSizeHint(self) -> QSize:
        """Return room for all states: none is left out."""
        return self.sizeHint()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Draw the states."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        line = self.palette().color(QPalette.ColorRole.Mid)
        muted = self.palette().color(QPalette.ColorRole.PlaceholderText)
        places = self._places()
        for index, (state, place) in enumerate(places):
            lit = state is self._state
            colour = QColor(*colour_of(state))
            painter.setPen(QPen(colour if lit else line, 1.2))
            painter.setBrush(colour if lit else Qt.GlobalColor.transparent)
            radius = place.height() / 2
            painter.drawRoundedRect(place, radius, radius)
            painter.setPen(_text_on(colour) if lit else muted)
            painter.drawText(place, Qt.AlignmentFlag.AlignCenter, self._name(state))
            if index and state in _WAY:
                self._arrow(
                    painter, QPointF(places[index - 1][1].right(), place.center().y()), place.left(), muted
                )
        painter.end()

    def _name(self, state: State) -> str:
        """Return a short name, of which nine fit in a row."""
        return self.tr("waiting") if state is State.WAITING else state_text(state)

    def _places(self) -> list[tuple[State, QRectF]]:
        metrics = QFontMetricsF(self.font())
        height, x = metrics.height() + 8, 1.0
        places = []
        for state in (*_WAY, *_APART):
            width = metrics.horizontalAdvance(self._name(state)) + 2 * _PADDING
            places.append((state, QRectF(x, 2.0, width, height)))
            x += width + (_ARROW if state in _WAY[:-1] else _GAP)
            x += 3 * _GAP if state is _WAY[-1] else 0.0
        return places

    @staticmethod
    def _arrow(painter: QPainter, start: QPointF, end: float, colour: QColor) -> None:
        painter.setPen(QPen(colour, 1.2))
        tip = QPointF(end - 3, start.y())
        painter.drawLine(QPointF(start.x() + 3, start.y()), tip)
        for side in (-3, 3):
            painter.drawLine(tip, QPointF(tip.x() - 3, tip.y() + side))


class TimePlot(pg.PlotWidget):  # type: ignore[misc]  # the library has no types
    """Curves over time, with gaps where a value is not finite. The mouse neither zooms nor moves them."""

    def __init__(self, parent: QWidget | None = None) -> None:
        axes = {side: ValueAxis(side) for side in ("left", "bottom")}
        super().__init__(parent, background=None, enableMenu=False, axisItems=axes)
        self.setMouseEnabled(False, False)
        self.hideButtons()
        self.setMinimumHeight(72)
        self.showGrid(x=False, y=True, alpha=0.15)
        self.getAxis("left").setWidth(44)
        self._lines: list[pg.PlotDataItem] = []

    def setUp(
        self, title: str, names: Sequence[str], seconds: float, least: float, shows_time: bool = False
    ) -> None:
        """Set the title with its unit, the names of the curves (none for a single one), and the time span.

        `least` is the least span of the value axis, so that noise about zero does not fill the plot.
        """
        self._title = title
        self._names = tuple(names)
        self._lines = [self.plot(connect="finite") for _ in names or ("",)]
        self.setXRange(-seconds, 0, padding=0)
        self.getViewBox().setLimits(minYRange=least)
        # A curve, not an endless line: so zero is always in view.
        self.plot([-seconds, 0], [0, 0], pen=pg.mkPen((128, 128, 128, 120), width=1))
        if not shows_time:
            self.getAxis("bottom").setStyle(showValues=False)
        self.setAccessibleName(title)
        self._dress()

    def setCurves(self, times: NDArray[Any], values: NDArray[Any]) -> None:
        """Show times (n,) in seconds before now and values (n, curves)."""
        for line, column in zip(self._lines, values.T, strict=True):
            line.setData(times, column)

    def values(self, curve: int = 0) -> NDArray[Any] | None:
        """Return the shown samples of a curve."""
        values: NDArray[Any] | None = self._lines[curve].yData
        return values

    def changeEvent(self, event: QEvent) -> None:
        """Adopt the colours of another theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange and getattr(self, "_lines", None):
            self._dress()

    def _dress(self) -> None:
        palette = self.palette()
        ink = palette.color(QPalette.ColorRole.PlaceholderText)
        for side in ("left", "bottom"):
            self.getAxis(side).setPen(ink)
            self.getAxis(side).setTextPen(ink)
        colours = AXIS_COLOURS if self._names else (palette.color(QPalette.ColorRole.Highlight).getRgb()[:3],)
        for line, colour in zip(self._lines, colours, strict=False):
            line.setPen(pg.mkPen(colour, width=1.5))
        key = joined(
            markup(' &nbsp;<span style="color: rgb{0}">{1}</span>', colour, name)
            for name, colour in zip(self._names, colours, strict=False)
        )
        text = palette.color(QPalette.ColorRole.WindowText).name()
        set_plot_title(self, markup('<span style="color: {0}">{1}</span>{2}', text, self._title, key))


def _text_on(colour: QColor) -> QColor:
    """Black or white, whichever is read better on a colour."""
    luminance = 0.299 * colour.red() + 0.587 * colour.green() + 0.114 * colour.blue()
    return QColor("black") if luminance > 120 else QColor("white")


class ServoWindow(QWidget):
    """Setters and signals, without logic."""

    stopPressed = pyqtSignal()
    startPressed = pyqtSignal()
    handEyePressed = pyqtSignal()
    tuningChanged = pyqtSignal(object)
    """A Tuning that was set by hand."""
    viewChanged = pyqtSignal(object, object)
    """The visible Region of the image, and (width, height) in screen pixels that it takes."""

    messages: MessageStack
    states: StateStrip
    reasonLabel: QLabel
    limitsLabel: QLabel
    handEyeButton: QPushButton
    startButton: QPushButton
    stopButton: QPushButton
    sides: QSplitter
    canvas: ImageCanvas
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
        load_form(Path(__file__).with_name("forms") / "servo.ui", self)
        self.sides.setSizes([760, 600])
        self.drawing = DrawingItem()
        """The detections drawn over the image."""
        self.canvas.addOverlay(self.drawing)
        self.canvas.viewChanged.connect(self.viewChanged)
        self.distancePlot.setUp(self.tr("Hand to goal, mm"), (), CURVE_SECONDS, 10)
        self.anglePlot.setUp(self.tr("Hand to goal, °"), (), CURVE_SECONDS, 2)
        self.velocityPlot.setUp(self.tr("Velocity of the hand, mm/s"), "xyz", CURVE_SECONDS, 20)
        self.turnPlot.setUp(self.tr("Rotation of the hand, °/s"), "xyz", CURVE_SECONDS, 5, shows_time=True)
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
        # These keys stop whatever has the focus, a button or a number being typed.
        StopKeys(self, STOP_KEYS).pressed.connect(self.stopPressed)

    def setImage(self, image: DisplayImage, width: int, height: int, drawing: Drawing) -> None:
        """Show an image of that size, and the drawing over it."""
        self.canvas.setImage(image, width, height)
        self.drawing.setDrawing(drawing, width, height)

    def setPosture(self, posture: Posture | None) -> None:
        """Show where the robot is."""
        self.robotView.setPosture(posture)

    def setState(self, state: State, reason: str) -> None:
        """Show the state and its reason."""
        self.states.setState(state)
        self.reasonLabel.setText(reason)
        set_available(self.startButton, None if state is State.STOPPED else Unavailable.PATIENCE)

    def setLimits(self, text: str) -> None:
        """Show what is measured of the hand beside its limits."""
        self.limitsLabel.setText(text)

    def setHandEyeAvailable(self, available: bool) -> None:
        """Show whether hand and eye can be calibrated now, and why not."""
        reason = translate("Unavailable", "Hand and eye of this robot cannot be calibrated here.")
        set_available(self.handEyeButton, None if available else reason)

    def addEntry(self, entry: Entry) -> None:
        """Add a line to the history."""
        row = QTreeWidgetItem([localized(f"{entry.time:.2f} s"), state_text(entry.state), entry.reason])
        row.setIcon(1, dot(QColor(*colour_of(entry.state))))
        row.setTextAlignment(0, int(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter))
        set_cell_tooltip(row, 2, entry.reason)
        self.history.addTopLevelItem(row)
        if self.history.topLevelItemCount() > MOST_ENTRIES:
            self.history.takeTopLevelItem(0)
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
