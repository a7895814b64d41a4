"""The histogram of the whole frame, with the levels that are shown."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from PyQt5.QtCore import QSignalBlocker, pyqtSignal
from PyQt5.QtWidgets import QCheckBox, QPushButton, QWidget

from grabbergui.models.language import localized
from grabbergui.models.measuring.channels import Histogram
from grabbergui.ui.loader import load_form
from grabbergui.ui.widgets.channel_plot import ChannelPlot
from grabbergui.ui.widgets.elided_label import ElidedLabel

HEADROOM = 1.1
"Of the plot, over the highest count between its ends."


class HistogramPanel(QWidget):
    """Setters for the histogram and the levels; a signal for levels that were dragged."""

    levelsDragged = pyqtSignal(float, float)
    """What is to be shown as black and as white, as fractions of the sensor's range."""
    levelsReset = pyqtSignal()

    figuresLabel: ElidedLabel
    logBox: QCheckBox
    fitButton: QPushButton
    resetButton: QPushButton
    plot: ChannelPlot

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("histogram_panel", self)
        self._histogram: Histogram | None = None
        self._range = 256
        self.plot.setFilled(True)
        self.plot.hideAxis("left")
        self.levels = pg.LinearRegionItem((0, 256), swapMode="block", bounds=(0, 256))
        self.levels.setZValue(10)
        self.levels.setBrush(pg.mkBrush(128, 128, 128, 28))
        self.levels.setHoverBrush(pg.mkBrush(128, 128, 128, 48))
        self.plot.addItem(self.levels)
        self.plot.setXRange(0, 256, padding=0.01)
        self.levels.sigRegionChanged.connect(self._on_levels_region_changed)
        self.fitButton.clicked.connect(self._on_fit_clicked)
        self.resetButton.clicked.connect(self.levelsReset)
        self.logBox.toggled.connect(self._draw)

    def setHistogram(self, histogram: Histogram) -> None:
        """Show what was measured."""
        if 1 << histogram.depth != self._range:
            self._set_range(1 << histogram.depth)
        self._histogram = histogram
        titles = {"grey": self.tr("grey")}  # others are letters
        means = "  ".join(
            f"{titles.get(name, name)} {histogram.mean(name):.1f}" for name in histogram.channels
        )
        text = self.tr("Mean {0}    {1:.2%} saturated    {2:.2%} black")
        self.figuresLabel.setText(localized(text.format(means, histogram.saturated, histogram.black)))
        self._draw()

    def setLevels(self, black: float, white: float) -> None:
        """Show which values are shown as black and as white, as fractions of the range."""
        with QSignalBlocker(self.levels):
            self.levels.setRegion((black * self._range, white * self._range))

    def clear(self) -> None:
        """Nothing is measured."""
        self._histogram = None
        self.figuresLabel.clear()
        self.plot.clearChannels()

    def _set_range(self, values: int) -> None:
        black, white = (edge / self._range for edge in self.levels.getRegion())
        self._range = values
        self.plot.setXRange(0, values, padding=0.01)
        with QSignalBlocker(self.levels):
            self.levels.setBounds((0, values))
            self.levels.setRegion((black * values, white * values))

    def _draw(self) -> None:
        histogram = self._histogram
        if histogram is None:
            return
        counts = {name: histogram.binned(name) for name in histogram.channels}
        bins = next(iter(counts.values())).size
        if self.logBox.isChecked():
            counts = {name: np.log10(count + 1) for name, count in counts.items()}
        self.plot.setChannels(self._edges(bins), dict(counts))
        # What is clipped towers over all the rest: it may end above the plot.
        inner = max(count[1:-1].max() for count in counts.values())
        self.plot.setYRange(0, HEADROOM * (inner or max(count.max() for count in counts.values()) or 1))

    def _edges(self, bins: int) -> np.ndarray:
        return np.linspace(0, self._range, bins + 1)

    def _on_fit_clicked(self) -> None:
        if self._histogram is not None:
            black, white = self._histogram.levels()
            self.setLevels(black, white)
            self.levelsDragged.emit(black, white)

    def _on_levels_region_changed(self) -> None:
        black, white = self.levels.getRegion()
        self.levelsDragged.emit(black / self._range, white / self._range)
