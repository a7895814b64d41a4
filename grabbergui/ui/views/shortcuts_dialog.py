"""An overview of every shortcut, by menu."""

from __future__ import annotations

from collections.abc import Iterator

from PyQt5.QtCore import QSize
from PyQt5.QtGui import QKeySequence
from PyQt5.QtWidgets import QAction, QDialog, QLabel, QMenu, QMenuBar, QPushButton, QScrollArea, QWidget

from grabbergui.ui.loader import load_form

KEY_WIDTH = 110
"Pixels of the keys' column at least, the same in every table."
SCROLL_BAR = 20
"Pixels that the scroll bar may take beside the tables."
MOST_OF_SCREEN = 0.9
"In width and height."
KEY_GAP = "&nbsp;" * 4
"Behind the keys, whose names are longer in other languages: rich text of Qt knows no padding of cells."


class ShortcutsDialog(QDialog):
    """Two columns of menus; deleted when it is closed."""

    scrollArea: QScrollArea
    content: QWidget
    leftLabel: QLabel
    rightLabel: QLabel
    closeButton: QPushButton

    def __init__(self, menubar: QMenuBar, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("shortcuts_dialog", self)
        tables = [table for action in menubar.actions() if (table := self._table(action.menu()))]
        columns = ["", ""]
        # As high as each other: the longest menu first, each where there is more room.
        for table in sorted(tables, key=_height, reverse=True):
            columns[_height(columns[1]) < _height(columns[0])] += table
        self.leftLabel.setText(columns[0])
        self.rightLabel.setText(columns[1])
        self.closeButton.clicked.connect(self.accept)
        self._take_room()

    def _take_room(self) -> None:
        """Show everything at once where the screen has room for it; else it is scrolled."""
        hint = self.content.sizeHint()
        width = hint.width() + SCROLL_BAR
        wanted = QSize(width, self.content.heightForWidth(width)) + self.size() - self.scrollArea.size()
        screen = self.screen()
        self.resize(wanted.boundedTo(screen.availableSize() * MOST_OF_SCREEN) if screen else wanted)

    def _table(self, menu: QMenu | None) -> str:
        if menu is None:
            return ""
        rows = "".join(
            f"<tr><td width='{KEY_WIDTH}' style='white-space:pre'>"
            f"<b>{self._keys(action.shortcut())}</b>{KEY_GAP}</td>"
            f"<td>{_plain(action.iconText())}</td></tr>"
            for action in _actions(menu)
            if not action.shortcut().isEmpty()
        )
        return f"<h3>{_plain(menu.title())}</h3><table>{rows}</table>" if rows else ""

    def _keys(self, keys: QKeySequence) -> str:
        """The keys as they are printed on a keyboard; Qt spells them out: Mayúsculas."""
        return keys.toString(QKeySequence.PortableText).replace("Shift", self.tr("Shift"))


def _height(tables: str) -> int:
    """Lines of some tables: their rows, and as much as two for each title."""
    return tables.count("<tr>") + 2 * tables.count("<h3>")


def _actions(menu: QMenu) -> Iterator[QAction]:
    for action in menu.actions():
        inner = action.menu()
        if inner is not None:
            yield from _actions(inner)
        else:
            yield action


def _plain(text: str) -> str:
    return text.replace("&", "").rstrip("…")
