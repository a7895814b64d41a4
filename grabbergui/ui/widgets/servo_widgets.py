"""Widgets of the servo window: the states in a row, curves over time, drawings over the image.

Only windows that need visual servoing import them, and with them `grabbergui.servo`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pyqtgraph as pg
from numpy.typing import NDArray
from PyQt5.QtCore import QEvent, QPointF, QRectF, QSize, Qt
from PyQt5.QtGui import QColor, QFontMetricsF, QPainter, QPaintEvent, QPalette, QPen, QPolygonF
from PyQt5.QtWidgets import QSizePolicy, QStyleOptionGraphicsItem, QWidget

from grabbergui.models.servoing import state_text
from grabbergui.servo.overlay import AXIS_COLOURS, Drawing, colour_of
from grabbergui.servo.state_machine import State
from grabbergui.ui.widgets.picture_items import PictureOverlay

_WAY = (State.SEARCHING, State.CENTRING, State.WAITING, State.APPROACHING, State.REACHED)
"From one to the next when all goes well."


_APART = (State.FOLLOWING, State.STUCK, State.LOST, State.STOPPED)
"From anywhere."


_GAP, _ARROW, _PADDING = 6.0, 16.0, 11.0


class StateStrip(QWidget):
    """One setter."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self._state: State | None = None

    @property
    def state(self) -> State | None:
        """The lit state."""
        return self._state

    def setState(self, state: State) -> None:
        """Light one."""
        if state is not self._state:
            self._state = state
            self.setAccessibleName(state_text(state))
            self.update()

    def sizeHint(self) -> QSize:
        """All of them in a row."""
        return QSize(round(self._places()[-1][1].right()) + 2, self.fontMetrics().height() + 12)

    def minimumSizeHint(self) -> QSize:
        """None is ever left out."""
        return self.sizeHint()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Draw them."""
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
        """Short enough for a row of seven."""
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
    """Setters only; neither zoomed nor moved by the mouse. Gaps where a value is not finite."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent, background=None)
        self.setMouseEnabled(False, False)
        self.setMenuEnabled(False)
        self.hideButtons()
        self.setMinimumHeight(72)
        self.showGrid(x=False, y=True, alpha=0.15)
        self.getAxis("left").setWidth(44)
        self._lines: list[pg.PlotDataItem] = []

    def setUp(
        self, title: str, names: Sequence[str], seconds: float, least: float, shows_time: bool = False
    ) -> None:
        """Say what is shown: a title with its unit, the curves' names (none where there is one), how long.

        `least` is what the axis spans at least, so that noise about zero does not look like something.
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
        """Times (n,) in seconds before now, values (n, curves)."""
        for line, column in zip(self._lines, values.T, strict=True):
            line.setData(times, column)

    def values(self, curve: int = 0) -> NDArray[Any] | None:
        """The shown samples of a curve."""
        values: NDArray[Any] | None = self._lines[curve].yData
        return values

    def changeEvent(self, event: QEvent) -> None:
        """Follow the window from light to dark."""
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
        key = "".join(
            f' &nbsp;<span style="color: rgb{colour}">{name}</span>'
            for name, colour in zip(self._names, colours, strict=False)
        )
        text = palette.color(QPalette.ColorRole.WindowText).name()
        self.setTitle(f'<span style="color: {text}">{self._title}</span>{key}', size="9pt", justify="left")


_HALO = QColor(0, 0, 0, 130)


class DrawingItem(PictureOverlay):
    """Shows a Drawing in a scene whose unit is the frame's pixel."""

    def __init__(self) -> None:
        super().__init__(20)
        self._drawing = Drawing()

    @property
    def drawing(self) -> Drawing:
        """What is shown."""
        return self._drawing

    def setDrawing(self, drawing: Drawing, width: int, height: int) -> None:
        """Show it over a picture of that size."""
        self._drawing = drawing
        self.cover(width, height)

    def paint(
        self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None
    ) -> None:
        """Draw every line over a darker one, so that it stands out from whatever is below."""
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for stroke in self._drawing.strokes:
            # A pixel's centre is a whole number there, here its corner is.
            line = QPolygonF([QPointF(float(x) + 0.5, float(y) + 0.5) for x, y in stroke.points])
            for ink, width in ((_HALO, stroke.weight + 2), (QColor(*stroke.colour), stroke.weight)):
                pen = QPen(ink, width)
                pen.setCosmetic(True)
                pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
                painter.setPen(pen)
                if stroke.closed:
                    painter.drawPolygon(line)
                else:
                    painter.drawPolyline(line)
        self._words(painter)

    def _words(self, painter: QPainter) -> None:
        """At the size of the window's text, whatever the zoom."""
        to_screen = painter.transform()
        painter.resetTransform()
        font = painter.font()
        font.setBold(True)
        painter.setFont(font)
        for label in self._drawing.labels:
            place = to_screen.map(QPointF(label.place[0] + 0.5, label.place[1] + 0.5))
            painter.setPen(_HALO)
            for shift in (QPointF(1, 1), QPointF(-1, 1), QPointF(1, -1), QPointF(-1, -1)):
                painter.drawText(place + shift, label.text)
            painter.setPen(QColor(*label.colour))
            painter.drawText(place, label.text)
        painter.setTransform(to_screen)


def _text_on(colour: QColor) -> QColor:
    """Black or white, whichever is read better on a colour."""
    luminance = 0.299 * colour.red() + 0.587 * colour.green() + 0.114 * colour.blue()
    return QColor("black") if luminance > 120 else QColor("white")
