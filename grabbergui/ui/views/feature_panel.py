"""The panel of all features, by category."""

from __future__ import annotations

from collections.abc import Collection

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QComboBox, QLabel, QLineEdit, QVBoxLayout, QWidget

from grabbergui.core.features import Category, Feature, FeatureDescription, Visibility
from grabbergui.models.feature_filter import visible_names
from grabbergui.ui.loader import load_form
from grabbergui.ui.widgets.feature_row import FeatureRow
from grabbergui.ui.widgets.feature_rows import FeatureRows
from grabbergui.ui.widgets.pacer import Pacer
from grabbergui.ui.widgets.section import Section

MOST_FOUND = 200
"""Rows that a search shows at most; who sees more than that types another letter."""

_LEVELS = (Visibility.BEGINNER, Visibility.EXPERT, Visibility.GURU)


class FeaturePanel(QWidget):
    """Sections with a row for each feature, a filter, and for whom: beginners, experts, gurus.

    Rows are made when their section is first opened, a few milliseconds a turn of the event loop.
    """

    watchedChanged = pyqtSignal(frozenset)
    """Names of the features that can be seen."""

    filterEdit: QLineEdit
    levelBox: QComboBox
    messageLabel: QLabel
    content: QWidget
    sections: QVBoxLayout

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("feature_panel", self)
        self.rows = FeatureRows(self)
        """Every row, with what people do in them as signals."""
        self._pacer = Pacer(self)
        self._section: Section | None = None
        self._watched: frozenset[str] = frozenset()
        self.filterEdit.textChanged.connect(self._arrange)
        self.levelBox.currentIndexChanged[int].connect(self._arrange)
        self._arrange()

    def setTree(self, root: Category | None, opened: Collection[str] = ()) -> None:
        """Show another camera's features, with the sections open that hold these features; or none."""
        self._pacer.clear()
        self.rows.clear()
        if self._section is not None:
            self.sections.removeWidget(self._section)
            self._section.hide()
            self._section.deleteLater()
            self._section = None
        if root is not None:
            self._section = Section(root, self._make_row, self._pacer, frozenset(opened), self.content)
            self._section.removeHeader()
            self._section.toggled.connect(self._arrange)
            self.sections.insertWidget(0, self._section)
        self._arrange()

    def setFeature(self, feature: Feature) -> None:
        """Show a feature wherever it has a row."""
        self.rows.setFeature(feature)

    @property
    def watched(self) -> frozenset[str]:
        """Names of the features that can be seen."""
        return self._watched

    def section(self, name: str) -> Section | None:
        """The section of a category, once it was made."""
        return next((s for s in self.content.findChildren(Section) if s.category.name == name), None)

    def _make_row(self, description: FeatureDescription, parent: QWidget, indented: bool) -> FeatureRow:
        return self.rows.make(description, parent, indented=indented)

    def _arrange(self) -> None:
        """Show what level and filter let through."""
        watched: frozenset[str] = frozenset()
        message = ""
        self.filterEdit.setEnabled(self._section is not None)
        self.levelBox.setEnabled(self._section is not None)
        if self._section is None:
            message = self.tr("The camera's controls appear here once one is connected.")
        else:
            text = self.filterEdit.text().strip()
            names = visible_names(self._section.category, _LEVELS[self.levelBox.currentIndex()], text)
            if text and len(names) > MOST_FOUND:
                message = self.tr("{0} more match; type another letter.").format(len(names) - MOST_FOUND)
                names = names[:MOST_FOUND]
            elif not names:
                message = self.tr("Nothing matches; Guru shows every feature.")
            self._section.arrange(frozenset(names), bool(text))
            watched = frozenset(self._section.names_on_show())
        self.messageLabel.setText(message)
        self.messageLabel.setVisible(bool(message))
        if watched != self._watched:
            self._watched = watched
            self.watchedChanged.emit(watched)
