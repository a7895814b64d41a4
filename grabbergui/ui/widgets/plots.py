"""Plots of one line a channel or a value in the window's colours; the scale of an image in false colour."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PyQt5.QtCore import QEvent, Qt
from PyQt5.QtGui import QColor, QPalette, QShowEvent
from PyQt5.QtWidgets import QVBoxLayout, QWidget

from grabbergui.models.language import localized
from grabbergui.ui.shown_text import name_axis

CHANNEL_COLOURS = {"R": "#e5484d", "G": "#30a46c", "B": "#3e7bfa", "U": "#3e7bfa", "V": "#e5484d"}
"""Colours of the channels that have one; others are drawn in the colour of text."""
LABEL_ROOM = 44
"Width of a time's label beneath a plot in pixels."


MOST_MARKS, MOST_NAMED = 60, 8
"Moments that a plot marks, and that it also names; more would hide its lines."


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
        self._marks: list[pg.InfiniteLine] = []
        # The value at the top of an axis is half above it.
        self.plotItem.layout.setContentsMargins(0, self.fontMetrics().height() // 2, 0, 0)
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

    def setMarks(self, marks: Sequence[tuple[float, str]]) -> None:
        """Mark moments by vertical lines: x and name. Of more than `MOST_MARKS`, the last are shown."""
        marks = marks[-MOST_MARKS:]
        while len(self._marks) > len(marks):
            self.removeItem(self._marks.pop())
        while len(self._marks) < len(marks):
            self._marks.append(pg.InfiniteLine(angle=90, label="", labelOpts={"position": 0.9}))
            self.addItem(self._marks[-1], ignoreBounds=True)
        ink = self.palette().color(QPalette.ColorRole.PlaceholderText)
        for line, (x, name) in zip(self._marks, marks, strict=True):
            line.setPos(x)
            line.setPen(pg.mkPen(ink, style=Qt.PenStyle.DashLine))
            line.label.setColor(ink)
            line.label.setFormat(name if len(marks) <= MOST_NAMED else "")

    def marks(self) -> list[float]:
        """Return where the marks are."""
        return [line.value() for line in self._marks]

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
