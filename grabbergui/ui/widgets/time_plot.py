"""Some curves over the last seconds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pyqtgraph as pg
from numpy.typing import NDArray
from PyQt5.QtCore import QEvent
from PyQt5.QtGui import QPalette
from PyQt5.QtWidgets import QWidget

from grabbergui.servo.overlay import AXIS_COLOURS


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
        """What is shown of a curve."""
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
