"""Plots of one line a channel or a value in the window's colours; the scale of an image in false colour."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PyQt5.QtCore import QEvent, QPointF, QRect, QRectF, QSize, Qt, pyqtSignal
from PyQt5.QtGui import QColor, QImage, QPainter, QPaintEvent, QPalette, QShowEvent
from PyQt5.QtWidgets import QLabel, QToolButton, QVBoxLayout, QWidget

from grabbergui.core.features import FeatureDescription
from grabbergui.models.features.feature_text import breakable
from grabbergui.models.features.number_text import in_unit, number_text, quantity_text, shown_unit
from grabbergui.models.image.quantities import NO_DATA, ColourScale
from grabbergui.models.language import localized
from grabbergui.ui.shown_text import name_axis, set_tooltip
from grabbergui.ui.windows import load_form

CHANNEL_COLOURS = {"R": "#e5484d", "G": "#30a46c", "B": "#3e7bfa", "U": "#3e7bfa", "V": "#e5484d"}
"""Colours of the channels that have one; others are drawn in the colour of text."""
LABEL_ROOM = 44
"Width of a time's label beneath a plot in pixels."


class ValueAxis(pg.AxisItem):  # type: ignore[misc]  # the library has no types
    """An axis whose numbers have the decimal sign of the window's language."""

    def tickStrings(self, values: list[float], scale: float, spacing: float) -> list[str]:
        """Return the labels of values."""
        return [localized(text) for text in super().tickStrings(values, scale, spacing)]


class SecondsAxis(pg.AxisItem):  # type: ignore[misc]  # the library has no types
    """An axis with the unit at every value: a title would take a line of the plot."""

    def tickStrings(self, values: list[float], scale: float, spacing: float) -> list[str]:
        """Return the labels of seconds before now."""
        return [localized(f"{value:g} s") if value else "0" for value in values]

    def tickSpacing(self, low: float, high: float, size: float) -> list[tuple[float, float]]:
        """Space the ticks as far as their labels need."""
        (widest, offset), *finer = super().tickSpacing(low, high, size)
        while 0 < widest < (high - low) * LABEL_ROOM / max(size, LABEL_ROOM):
            widest *= 2
        return [(widest, offset), *finer]


class ChannelPlot(pg.PlotWidget):  # type: ignore[misc]  # the library has no types
    """Lines of channels or values; the mouse neither zooms nor moves them."""

    def __init__(self, parent: QWidget | None = None) -> None:
        axes = {side: ValueAxis(side) for side in ("left", "bottom")}
        super().__init__(parent, background=None, enableMenu=False, axisItems=axes)
        self.setMouseEnabled(False, False)
        self.hideButtons()
        self._lines: dict[str, pg.PlotDataItem] = {}
        self._filled: bool = False
        self._colours: dict[str, str] = {}
        "Colours of lines that are no channels of an image."
        self._dress()

    def setFilled(self, filled: bool) -> None:
        """Set whether the areas below the lines are filled."""
        self._filled = filled
        self._dress()

    def setLine(self, name: str, x: NDArray[Any], values: NDArray[Any], colour: str) -> None:
        """Show one more line, which is broken where a value is NaN, in a colour; empty: that of text."""
        self._colours[name] = colour
        if name not in self._lines:
            self._lines[name] = self.plot()
        self._lines[name].setData(x, values, stepMode=None, connect="finite")
        self._dress()

    def removeLine(self, name: str) -> None:
        """Remove a line; does nothing if it is not shown."""
        if (line := self._lines.pop(name, None)) is not None:
            self.removeItem(line)

    def showSeconds(self) -> None:
        """Label the lower axis in seconds before now."""
        self.setAxisItems({"bottom": SecondsAxis("bottom")})
        self._dress()

    def nameAxes(self, bottom: str, left: str) -> None:
        """Write names at the axes; their values stay as they are, without a power of ten."""
        for side, name in (("bottom", bottom), ("left", left)):
            self.getAxis(side).enableAutoSIPrefix(False)
            name_axis(self, side, name)

    def setChannels(
        self, x: NDArray[Any], channels: dict[str, NDArray[Any]], *, broken: bool = False
    ) -> None:
        """Show these lines and no others. With one more `x` than values, they are steps.

        A line leads over values that are NaN, unless it is to be `broken` there.
        """
        for name in self._lines.keys() - channels.keys():
            self.removeItem(self._lines.pop(name))
        for name, values in channels.items():
            if name not in self._lines:
                self._lines[name] = self.plot()
                self._dress()
            if len(x) > len(values):
                self._lines[name].setData(x, values, stepMode="center")
            elif broken:
                self._lines[name].setData(x, values, stepMode=None, connect="finite")
            else:
                known = np.isfinite(values)
                self._lines[name].setData(x[known], values[known], stepMode=None)

    def clearChannels(self) -> None:
        """Remove all lines."""
        for line in self._lines.values():
            self.removeItem(line)
        self._lines.clear()

    def values(self, name: str) -> NDArray[Any] | None:
        """Return the shown values of a channel."""
        return self._lines[name].yData if name in self._lines else None

    def changeEvent(self, event: QEvent) -> None:
        """Adopt the colours of another theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange and hasattr(self, "_lines"):
            self._dress()

    def _dress(self) -> None:
        ink = self.palette().color(QPalette.ColorRole.PlaceholderText)
        for side in ("left", "bottom"):
            axis = self.getAxis(side)
            axis.setPen(ink)
            axis.setTextPen(ink)
        text = self.palette().color(QPalette.ColorRole.WindowText)
        for name, line in self._lines.items():
            colour = QColor(self._colours.get(name) or CHANNEL_COLOURS.get(name) or text)
            line.setPen(pg.mkPen(colour, width=1))
            colour.setAlphaF(0.25)
            line.setFillLevel(0 if self._filled else None)
            line.setBrush(colour if self._filled else None)


class PlotPlace(QWidget):
    """Holds a plot that is made when it is first shown or used: a window starts with four hidden ones.

    `furnish` is called with the new plot.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.furnish: Callable[[ChannelPlot], None] = lambda _: None
        self._layout = QVBoxLayout(self)
        self._layout.setContentsMargins(0, 0, 0, 0)
        self._plot: ChannelPlot | None = None

    @property
    def made(self) -> ChannelPlot | None:
        """The plot; None before its first use."""
        return self._plot

    @property
    def plot(self) -> ChannelPlot:
        """The plot, made now at the latest."""
        if self._plot is None:
            self._plot = ChannelPlot(self)
            self._plot.setAccessibleName(self.accessibleName())
            self.setAccessibleName("")
            self._layout.addWidget(self._plot)
            self.furnish(self._plot)
        return self._plot

    def showEvent(self, event: QShowEvent | None) -> None:
        """Make the plot if this is the first time."""
        self.plot.show()
        super().showEvent(event)


# -- one value over time -------------------------------------------------------------------------
AXIS_WIDTH = 56
"""Width of the value axis, the same for all, so that the curves of several rows are aligned."""

RANGE_DIGITS = 5
"Significant digits of the ends of the range shown."
STEADY_MARGIN = 0.1
"""Share of a constant value that is shown above and below it."""


class CurveRow(QWidget):
    """The plot of one value over time, with its name and range; a signal to remove it."""

    removed = pyqtSignal(str)

    titleLabel: QLabel
    valueLabel: QLabel
    rangeLabel: QLabel
    removeButton: QToolButton
    plot: ChannelPlot

    def __init__(self, description: FeatureDescription, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("curve_row", self)
        self.name = description.name
        self._unit = ""
        self.titleLabel.setText(breakable(description.title))
        set_tooltip(self.titleLabel, description.name)
        self.plot.setAccessibleName(self.tr("{0} over time").format(description.title))
        self.plot.showSeconds()
        self.plot.getAxis("left").setWidth(AXIS_WIDTH)
        self.plot.setDownsampling(auto=True, mode="peak")
        self.plot.setClipToView(True)
        self.removeButton.clicked.connect(lambda: self.removed.emit(self.name))

    def setUnit(self, unit: str) -> None:
        """Set the value's unit, shown with the next samples."""
        self._unit = unit

    def setOverlaid(self, colour: str) -> None:
        """Be the legend, in this colour, of a curve in another plot; with an empty colour, show it here."""
        self.plot.setVisible(not colour)
        self.titleLabel.setStyleSheet(f"color: {colour};" if colour else "")

    def setSamples(self, times: NDArray[np.float64], values: NDArray[np.float64], span: float) -> None:
        """Show samples with their times in seconds before now (negative), over the last `span` seconds."""
        self.plot.setXRange(-span, 0, padding=0)
        self.plot.setChannels(times, {self.name: values}, broken=True)
        finite = values[np.isfinite(values)]
        if len(finite) == 0:
            self.valueLabel.setText("–")
            self.rangeLabel.clear()
            return
        low, high, last = float(finite.min()), float(finite.max()), float(values[-1])
        if high > low:
            self.plot.enableAutoRange(axis="y")
        else:  # the automatic range would enlarge rounding errors
            margin = abs(low) * STEADY_MARGIN or 1.0
            self.plot.setYRange(low - margin, low + margin, padding=0)
        # One unit for value, range and axis, so that they can be compared.
        shown = shown_unit(max(abs(low), abs(high)), self._unit)
        self.plot.getAxis("left").setScale(in_unit(1.0, self._unit, shown))
        text = quantity_text(last, self._unit, shown_in=shown)
        self.valueLabel.setText(text if np.isfinite(last) else "–")
        ends = (number_text(in_unit(end, self._unit, shown), RANGE_DIGITS) for end in (low, high))
        self.rangeLabel.setText(" … ".join(ends))

    def clear(self) -> None:
        """Show that nothing was read."""
        self.plot.clearChannels()
        self.valueLabel.setText("–")
        self.rangeLabel.clear()


# -- the scale of false colours ------------------------------------------------------------------
SCALE_MARGIN = 6
"Between a scale and the edge of its image, pixels."
_SCALE_HEIGHT = 260
_LEAST_ROOM = 4
"A scale takes at most 1/_LEAST_ROOM of the width of its image; beyond, it is text."
_BAR = 16
"Width of the colours, pixels."
_EDGE = 10
_TICK = 5
_BACK = QColor(0, 0, 0, 150)
"The image behind may have any colour."
_TEXT = QColor(255, 255, 255)


class ScaleBar(QWidget):
    """Paints a `ColourScale` from its largest value down to its smallest, below it the mark of no data."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self._scale: ColourScale | None = None
        self._colours = QImage()
        self.hide()

    @property
    def scale(self) -> ColourScale | None:
        """The scale that is shown."""
        return self._scale

    def setScale(self, scale: ColourScale | None) -> bool:
        """Show a scale, or none; return whether it differs from the one shown before."""
        if scale == self._scale:
            return False
        self._scale = scale
        self.setVisible(scale is not None)
        if scale is not None:
            column = np.ascontiguousarray(scale.colours[::-1].reshape(256, 1, 3))
            self._colours = QImage(column.tobytes(), 1, 256, 3, QImage.Format.Format_RGB888).copy()
            self.setAccessibleName(self.tr("Scale of the colours: {0}").format(_scale_text(scale)))
            self.update()
        return True

    def sizeHint(self) -> QSize:
        """Return room for the longest text."""
        metrics, scale = self.fontMetrics(), self._scale
        texts = [self._no_data()]
        if scale is not None:
            texts += [scale.unit, *(localized(scale.text(tick)) for tick in scale.ticks)]
        width = max(metrics.horizontalAdvance(text) for text in texts)
        return QSize(width + _BAR + _TICK + 3 * _EDGE, 200)

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Draw colours, ticks and the hatching."""
        scale = self._scale
        if scale is None:
            return
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(_BACK)
        painter.drawRoundedRect(QRectF(self.rect()), 6, 6)
        painter.setPen(_TEXT)
        line = self.fontMetrics().height()
        top = _EDGE + (line + 4 if scale.unit else line // 2)
        bottom = self.height() - 2 * _EDGE - line
        right = self.width() - _EDGE
        if scale.unit:
            painter.drawText(QRectF(0, _EDGE - 2, right, line), Qt.AlignmentFlag.AlignRight, scale.unit)
        painter.drawImage(QRectF(_EDGE, top, _BAR, bottom - top), self._colours)
        for tick in scale.ticks:
            y = bottom - (tick - scale.low) / (scale.high - scale.low) * (bottom - top)
            painter.drawLine(QPointF(_EDGE + _BAR, y), QPointF(_EDGE + _BAR + _TICK, y))
            place = QRectF(0, y - line / 2, right, line)
            painter.drawText(place, Qt.AlignmentFlag.AlignRight, localized(scale.text(tick)))
        swatch = QRectF(_EDGE, self.height() - _EDGE - line, _BAR, line)
        dark, light = (QColor(grey, grey, grey) for grey in NO_DATA)
        painter.fillRect(swatch, dark)
        painter.setBrush(Qt.BrushStyle.BDiagPattern)
        painter.fillRect(swatch, painter.brush())
        painter.setPen(light)
        painter.drawRect(swatch)
        painter.setPen(_TEXT)
        painter.drawText(QRectF(0, swatch.top(), right, line), Qt.AlignmentFlag.AlignRight, self._no_data())

    def _no_data(self) -> str:
        return self.tr("no data")


def place_scale(bar: ScaleBar, room: QRect, margin: int = SCALE_MARGIN, *, needed: bool = False) -> str:
    """Put a scale at the right edge of `room`.

    Return its text instead where it would hide the image, unless it is `needed`.
    """
    scale = bar.scale
    if scale is None:
        return ""
    size = bar.sizeHint()
    small = not needed and (size.width() * _LEAST_ROOM > room.width() or room.height() < size.height())
    bar.setVisible(not small)
    if small:
        return _scale_text(scale)
    height = min(_SCALE_HEIGHT, room.height() - 2 * margin)
    bar.setGeometry(room.right() - margin - size.width(), room.top() + margin, size.width(), height)
    bar.raise_()
    return ""


def _scale_text(scale: ColourScale) -> str:
    """Return the ends of a scale."""
    return localized(f"{scale.text(scale.low)} – {scale.text(scale.high)} {scale.unit}".strip())
