"""All rows of a view: who shows which feature, and what people do with any of them."""

from __future__ import annotations

from PyQt5.QtCore import QObject, QPoint, pyqtSignal
from PyQt5.QtWidgets import QWidget

from grabbergui.core.features import Feature, FeatureDescription
from grabbergui.ui.editors.feature_row import FeatureRow


class FeatureRows(QObject):
    """Brings features to the rows that show them; a feature may have several rows, or none yet."""

    edited = pyqtSignal(str, object)
    executed = pyqtSignal(str)
    held = pyqtSignal(str)
    released = pyqtSignal(str)
    menuRequested = pyqtSignal(str, QPoint)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._features: dict[str, Feature] = {}
        self._rows: dict[str, list[FeatureRow]] = {}
        self._by_auto: dict[str, list[FeatureRow]] = {}
        self._lock = ""

    def make(
        self, description: FeatureDescription, parent: QWidget | None = None, *, indented: bool = False
    ) -> FeatureRow:
        """A new row, filled in where the feature is known."""
        row = FeatureRow(description, parent, indented=indented)
        row.edited.connect(self.edited)
        row.executed.connect(self.executed)
        row.held.connect(self.held)
        row.released.connect(self.released)
        row.menuRequested.connect(self.menuRequested)
        row.setLocked(self._lock)
        self._rows.setdefault(row.name, []).append(row)
        if (feature := self._features.get(row.name)) is not None:
            self._show(row, feature)
        return row

    def rows(self, name: str) -> list[FeatureRow]:
        """The rows of a feature."""
        return self._rows.get(name, [])

    def setFeature(self, feature: Feature) -> None:
        """Show a feature wherever it has a row, also as the automatic mode of another."""
        self._features[feature.name] = feature
        for row in self._rows.get(feature.name, ()):
            self._show(row, feature)
        for row in self._by_auto.get(feature.name, ()):
            row.setAuto(feature)

    def setLocked(self, reason: str) -> None:
        """Lock every row, those to come too, and say why; with no reason, unlock them."""
        self._lock = reason
        for rows in self._rows.values():
            for row in rows:
                row.setLocked(reason)

    def clear(self) -> None:
        """Forget features and rows; who made the rows deletes them."""
        self._features.clear()
        self._rows.clear()
        self._by_auto.clear()

    def _show(self, row: FeatureRow, feature: Feature) -> None:
        row.setFeature(feature)
        if not feature.auto:
            return
        listeners = self._by_auto.setdefault(feature.auto, [])
        if row not in listeners:
            listeners.append(row)
            if (auto := self._features.get(feature.auto)) is not None:
                row.setAuto(auto)
