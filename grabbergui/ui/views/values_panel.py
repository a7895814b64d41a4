"""Values over time, a curve each."""

from __future__ import annotations

from collections.abc import Mapping

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QComboBox, QLabel, QPushButton, QScrollArea, QVBoxLayout, QWidget

from grabbergui.core.features import FeatureDescription
from grabbergui.models.features.value_history import ValueHistory
from grabbergui.ui.loader import load_form
from grabbergui.ui.widgets.curve_row import CurveRow

_SPANS = (10.0, 60.0, 600.0, 3600.0)
"""Seconds, as in the form's box."""


class ValuesPanel(QWidget):
    """Setters for the curves and their samples; signals for what is wanted."""

    removed = pyqtSignal(str)
    """A curve is not wanted any more."""
    pauseToggled = pyqtSignal(bool)
    clearRequested = pyqtSignal()
    saveRequested = pyqtSignal()
    spanChanged = pyqtSignal()
    """Another part of the past is to be shown: `setSamples` is to follow."""

    spanBox: QComboBox
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
            self._arrange()

    def setSamples(self, histories: Mapping[str, ValueHistory], now: float) -> None:
        """Show what was read up to `now`, in seconds since the epoch."""
        span = _SPANS[self.spanBox.currentIndex()]
        for name, row in self._rows.items():
            history = histories.get(name)
            if history is None or len(history) == 0:
                row.clear()
                continue
            times, values = history.since(now - span)
            row.setSamples(times - now, values, span)

    def _arrange(self) -> None:
        anything = bool(self._rows)
        self.hintLabel.setVisible(not anything)
        self.scrollArea.setVisible(anything)
        for button in (self.pauseButton, self.saveButton, self.clearButton):
            button.setEnabled(anything)
