"""An overview of every shortcut, by menu."""

from __future__ import annotations

from collections.abc import Iterator

from PyQt5.QtGui import QKeySequence
from PyQt5.QtWidgets import QAction, QDialog, QLabel, QMenu, QMenuBar, QPushButton, QWidget

from grabbergui.ui.loader import load_form

KEY_WIDTH = 110
"Pixels of the keys' column, the same in every table."


class ShortcutsDialog(QDialog):
    """Two columns of menus; deleted when it is closed."""

    leftLabel: QLabel
    rightLabel: QLabel
    closeButton: QPushButton

    def __init__(self, menubar: QMenuBar, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("shortcuts_dialog", self)
        tables = [table for action in menubar.actions() if (table := _table(action.menu()))]
        # The longest menu on one side, all others on the other.
        tables.sort(key=len, reverse=True)
        self.leftLabel.setText(tables[0])
        self.rightLabel.setText("".join(tables[1:]))
        self.closeButton.clicked.connect(self.accept)
        self.setMinimumHeight(self.heightForWidth(self.width()))


def _table(menu: QMenu | None) -> str:
    if menu is None:
        return ""
    rows = "".join(
        f"<tr><td width='{KEY_WIDTH}'><b>{action.shortcut().toString(QKeySequence.NativeText)}</b></td>"
        f"<td>{_plain(action.iconText())}</td></tr>"
        for action in _actions(menu)
        if not action.shortcut().isEmpty()
    )
    return f"<h3>{_plain(menu.title())}</h3><table>{rows}</table>" if rows else ""


def _actions(menu: QMenu) -> Iterator[QAction]:
    for action in menu.actions():
        inner = action.menu()
        if inner is not None:
            yield from _actions(inner)
        else:
            yield action


def _plain(text: str) -> str:
    return text.replace("&", "").rstrip("…")
