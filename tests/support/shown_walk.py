"""Finds each place of a window that would render text from outside as rich text."""

from PyQt5.QtCore import QAbstractListModel, QAbstractTableModel, QModelIndex, Qt
from PyQt5.QtWidgets import (
    QAbstractItemView,
    QAction,
    QApplication,
    QComboBox,
    QGraphicsTextItem,
    QGraphicsView,
    QLabel,
    QTextEdit,
    QWidget,
)

RAW = '<img src="/dev/null"'
"""The beginning of the mark's element, which is escaped where text is rich."""
ROLES = (Qt.ItemDataRole.ToolTipRole, Qt.ItemDataRole.StatusTipRole, Qt.ItemDataRole.WhatsThisRole)


def rendered(text):
    """Return whether Qt, where it guesses, would render the mark in a text."""
    return isinstance(text, str) and RAW in text and Qt.mightBeRichText(text)


class Walk:
    """Goes through everything that exists of some windows."""

    def __init__(self):
        self.found = []
        "Where the mark is rendered."
        self.places = set()
        "Kinds of places at which the mark is shown."
        self.longest = 0
        "Characters of the longest text."

    def window(self, top):
        for widget in [top, *top.findChildren(QWidget)]:
            self._widget(widget)
        for action in top.findChildren(QAction):
            self._note(action.toolTip(), "action's tooltip", action)
        return self

    def _note(self, text, place, where, *, as_rich=None):
        if isinstance(text, str) and "/dev/null" in text:
            self.places.add(place)
            self.longest = max(self.longest, len(text))
        if rendered(text) if as_rich is None else as_rich and RAW in text:
            self.found.append(f"{place} of {type(where).__name__} {where.objectName()}: {text[:80]}")

    def _widget(self, widget):
        for place in ("toolTip", "statusTip", "whatsThis"):
            self._note(getattr(widget, place)(), place, widget)
        if isinstance(widget, QLabel):
            rich = {Qt.PlainText: False, Qt.RichText: True}.get(widget.textFormat())
            self._note(widget.text(), "label", widget, as_rich=rich)
        if isinstance(widget, QTextEdit):
            self._note(widget.document().toHtml(), "document", widget, as_rich=True)
        if isinstance(widget, QComboBox):
            self._model(widget.model(), widget)
        if isinstance(widget, QAbstractItemView) and widget.model() is not None:
            self._model(widget.model(), widget)
        if isinstance(widget, QGraphicsView) and widget.scene() is not None:
            for item in widget.scene().items():
                self._note(item.toolTip(), "item's tooltip", widget)
                if isinstance(item, QGraphicsTextItem):
                    self._note(item.toHtml(), "graphics text", widget, as_rich=True)

    def _model(self, model, where):
        columns = 1 if isinstance(model, QAbstractListModel) else model.columnCount()
        for section in range(columns):
            for role in ROLES:
                self._note(model.headerData(section, Qt.Horizontal, role), "header's tooltip", where)
        self._rows(model, columns, QModelIndex(), where)

    def _rows(self, model, columns, parent, where):
        for row in range(model.rowCount(parent)):
            for column in range(columns):
                index = model.index(row, column, parent)
                self._note(index.data(), "cell", where, as_rich=False)
                for role in ROLES:
                    self._note(index.data(role), "cell's tooltip", where)
            if not isinstance(model, QAbstractListModel | QAbstractTableModel):
                self._rows(model, columns, model.index(row, 0, parent), where)


def walk(*tops):
    """Walk through windows and all else that is open."""
    QApplication.processEvents()
    found = Walk()
    for top in {*tops, *QApplication.topLevelWidgets()}:
        found.window(top)
    return found
