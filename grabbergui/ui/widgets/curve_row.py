"""The curve of one value over time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QLabel, QToolButton, QWidget

from grabbergui.core.features import FeatureDescription
from grabbergui.models.features.feature_text import breakable
from grabbergui.models.features.number_text import in_unit, number_text, quantity_text, shown_unit
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.shown_text import set_tooltip
from grabbergui.ui.widgets.labels import ShrinkingLabel
from grabbergui.ui.widgets.plots import ChannelPlot

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
    rangeLabel: ShrinkingLabel
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
