"""Sharpness over time, to focus a lens by."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg
from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import QPushButton, QWidget

from grabbergui.models.language import localized
from grabbergui.models.measuring.measurement import HISTORY_SECONDS
from grabbergui.ui.loader import load_form
from grabbergui.ui.widgets.channel_plot import ChannelPlot
from grabbergui.ui.widgets.elided_label import ElidedLabel


class FocusPanel(QWidget):
    """Setters for the scores; signals for what is to be scored."""

    regionRequested = pyqtSignal()
    """A region is to be drawn."""
    wholeRequested = pyqtSignal()
    resetRequested = pyqtSignal()

    scoreLabel: ElidedLabel
    regionButton: QPushButton
    wholeButton: QPushButton
    resetButton: QPushButton
    plot: ChannelPlot

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("focus_panel", self)
        self._best = pg.InfiniteLine(
            angle=0, movable=False, pen=pg.mkPen("#30a46c", style=Qt.PenStyle.DashLine)
        )
        self.plot.addItem(self._best)
        self.plot.showSeconds()
        self.plot.setXRange(-HISTORY_SECONDS / 2, 0, padding=0)
        self.plot.setToolTip(self.tr("Sharpness over the last seconds; dashed: the best"))
        self.regionButton.clicked.connect(self.regionRequested)
        self.wholeButton.clicked.connect(self.wholeRequested)
        self.resetButton.clicked.connect(self.resetRequested)
        self.clear()

    def setScores(self, scores: Sequence[tuple[float, float]], best: float) -> None:
        """Show scores with their times in seconds, the newest last, and the best so far."""
        times, values = np.array(scores).T
        self.plot.setChannels(times - times[-1], {"sharpness": values})
        self._best.setValue(best)
        self._best.setVisible(best > 0)
        share = values[-1] / best if best else 0
        text = self.tr("Sharpness {0:.2f}    best {1:.2f}    {2:.0%} of the best")
        self.scoreLabel.setText(localized(text.format(values[-1], best, share)))

    def setWhat(self, region: str) -> None:
        """Say what is scored."""
        self.wholeButton.setEnabled(bool(region))
        self.scoreLabel.setToolTip(region or self.tr("of the whole picture"))

    def clear(self) -> None:
        """Nothing was scored."""
        self.plot.clearChannels()
        self._best.hide()
        self.scoreLabel.setText("–")
