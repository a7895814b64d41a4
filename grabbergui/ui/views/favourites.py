"""The few controls that matter, at hand above the picture."""

from __future__ import annotations

from collections.abc import Sequence

from PyQt5.QtWidgets import QHBoxLayout, QLabel, QWidget

from grabbergui.core.features import Feature, FeatureDescription
from grabbergui.ui.editors.feature_row import FeatureRow
from grabbergui.ui.editors.feature_rows import FeatureRows
from grabbergui.ui.loader import load_form


class FavouritesStrip(QWidget):
    """Some features side by side, larger than in the panel."""

    cards: QHBoxLayout
    hintLabel: QLabel

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("favourites", self)
        self.rows = FeatureRows(self)
        """Every row, with what people do in them as signals."""
        self._shown: list[QWidget] = []

    def setFavourites(self, descriptions: Sequence[FeatureDescription]) -> None:
        """Show these features, left to right."""
        self.rows.clear()
        for widget in self._shown:
            self.cards.removeWidget(widget)
            widget.hide()
            widget.deleteLater()
        self._shown = []
        for description in descriptions:
            card = self._card(description)
            self.cards.insertWidget(len(self._shown), card, 1)
            self._shown.append(card)
        self.hintLabel.setVisible(not descriptions)

    def setFeature(self, feature: Feature) -> None:
        """Show a feature that is among the favourites, or the automatic mode of one."""
        self.rows.setFeature(feature)

    def _card(self, description: FeatureDescription) -> FeatureRow:
        row = self.rows.make(description, self)
        font = row.font()
        font.setPointSizeF(font.pointSizeF() * 1.1)
        row.setFont(font)
        row.standBesideOthers()
        row.setMinimumWidth(190)
        row.setMaximumWidth(460)
        return row
