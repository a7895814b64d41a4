"""Values over time, a curve each."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QCheckBox, QComboBox, QLabel, QPushButton, QScrollArea, QVBoxLayout, QWidget

from grabbergui.core.features import FeatureDescription
from grabbergui.models.features.value_watch import ValueHistory
from grabbergui.ui.loader import load_form
from grabbergui.ui.widgets.plots import ChannelPlot, CurveRow

_SPANS = (10.0, 60.0, 600.0, 3600.0)
"""Seconds, as in the form's box."""

COLOURS = ("#2f7ed8", "#d9480f", "#2b8a3e", "#9c36b5", "#c92a2a", "#0b7285")
"""Of curves in one plot, in their order; legible on light and dark."""


class ValuesPanel(QWidget):
    """Setters for the curves and their samples; signals for the requested actions."""

    removed = pyqtSignal(str)
    """A curve is not wanted any more."""
    pauseToggled = pyqtSignal(bool)
    clearRequested = pyqtSignal()
    saveRequested = pyqtSignal()
    spanChanged = pyqtSignal()
    """Another part of the past is to be shown: `setSamples` is to follow."""

    spanBox: QComboBox
    togetherBox: QCheckBox
    overlay: ChannelPlot
    pauseButton: QPushButton
    saveButton: QPushButton
    clearButton: QPushButton
    hintLabel: QLabel
    scrollArea: QScrollArea
    content: QWidget
    curves: QVBoxLayout

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("values_panel", self)
        self._rows: dict[str, CurveRow] = {}
        if (viewport := self.scrollArea.viewport()) is not None:
            viewport.setAutoFillBackground(False)
        self.content.setAutoFillBackground(False)
        self.spanBox.currentIndexChanged[int].connect(lambda _: self.spanChanged.emit())
        self.pauseButton.toggled.connect(self.pauseToggled)
        self.overlay.showSeconds()
        self.overlay.hideAxis("left")  # each curve has a range of its own
        self.overlay.setAccessibleName(self.tr("All curves over time"))
        self.togetherBox.toggled.connect(lambda _: self._arrange())
        self.togetherBox.toggled.connect(lambda _: self.spanChanged.emit())
        self.clearButton.clicked.connect(self.clearRequested)
        self.saveButton.clicked.connect(self.saveRequested)
        self._arrange()

    def row(self, name: str) -> CurveRow | None:
        """The row of a value."""
        return self._rows.get(name)

    def addCurve(self, description: FeatureDescription) -> None:
        """Make room for one more curve; does nothing where it is shown already."""
        if description.name in self._rows:
            return
        row = CurveRow(description, self.content)
        row.removed.connect(self.removed)
        self._rows[row.name] = row
        self.curves.addWidget(row)
        self._arrange()

    def setUnits(self, units: Mapping[str, str]) -> None:
        """Say what the values are in."""
        for name, unit in units.items():
            if (row := self._rows.get(name)) is not None:
                row.setUnit(unit)

    def removeCurve(self, name: str) -> None:
        """Show one curve less."""
        row = self._rows.pop(name, None)
        if row is not None:
            self.curves.removeWidget(row)
            row.hide()
            row.deleteLater()
            self.overlay.removeLine(name)
            self._arrange()

    def setSamples(self, histories: Mapping[str, ValueHistory], now: float) -> None:
        """Show what was read up to `now`, in seconds since the epoch."""
        span = _SPANS[self.spanBox.currentIndex()]
        self.overlay.setXRange(-span, 0, padding=0)
        for (name, row), colour in zip(self._rows.items(), itertools.cycle(COLOURS), strict=False):
            history = histories.get(name)
            if history is None or len(history) == 0:
                row.clear()
                self.overlay.removeLine(name)
                continue
            times, values = history.since(now - span)
            row.setSamples(times - now, values, span)
            if self.togetherBox.isChecked():
                self.overlay.setLine(name, times - now, over_own_range(values), colour)

    def _arrange(self) -> None:
        anything = bool(self._rows)
        self.hintLabel.setVisible(not anything)
        self.scrollArea.setVisible(anything)
        together = self.togetherBox.isChecked()
        self.overlay.setVisible(anything and together)
        for row, colour in zip(self._rows.values(), itertools.cycle(COLOURS), strict=False):
            row.setOverlaid(colour if together else "")
        for button in (self.pauseButton, self.saveButton, self.clearButton):
            button.setEnabled(anything)


def over_own_range(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return values as fractions of their range, 0 … 1; a value that never changes stays in the middle."""
    if not np.isfinite(values).any():
        return values
    low, high = np.nanmin(values), np.nanmax(values)
    return (values - low) / (high - low) if high > low else values - low + 0.5
