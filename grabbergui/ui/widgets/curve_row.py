"""One value over time: its name and its last value on the left, the curve on the right."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QLabel, QToolButton, QWidget

from grabbergui.core.features import FeatureDescription
from grabbergui.models.features.text import breakable, number_text, unit_text
from grabbergui.ui import icons
from grabbergui.ui.loader import load_form
from grabbergui.ui.widgets.channel_plot import ChannelPlot

AXIS_WIDTH = 56
"""The same for all, so that the curves of several rows stand below each other."""

RANGE_DIGITS = 5


class CurveRow(QWidget):
    """Setters for the samples; a signal where nobody wants to see them any more."""

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
        self.titleLabel.setToolTip(description.name)
        self.plot.setAccessibleName(self.tr("{0} over time").format(description.title))
        self.plot.showSeconds()
        self.plot.getAxis("left").setWidth(AXIS_WIDTH)
        self.plot.setDownsampling(auto=True, mode="peak")
        self.plot.setClipToView(True)
        self.removeButton.clicked.connect(lambda: self.removed.emit(self.name))
        icons.apply(self)

    def setUnit(self, unit: str) -> None:
        """Say what the value is in; shown with the next samples."""
        self._unit = unit_text(unit)

    def setOverlaid(self, colour: str) -> None:
        """Be the legend, in that colour, of a curve that another plot shows; empty: show it here."""
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
        last = float(values[-1])
        self.valueLabel.setText(f"{number_text(last)} {self._unit}".rstrip() if np.isfinite(last) else "–")
        low, high = (number_text(float(end), RANGE_DIGITS) for end in (finite.min(), finite.max()))
        self.rangeLabel.setText(f"{low} … {high}")

    def clear(self) -> None:
        """Nothing was read."""
        self.plot.clearChannels()
        self.valueLabel.setText("–")
        self.rangeLabel.clear()
