"""Leaves undo and redo to the window, unless something is being typed."""

from __future__ import annotations

from collections.abc import Callable

from PyQt5.QtCore import QEvent, QObject
from PyQt5.QtGui import QKeyEvent, QKeySequence
from PyQt5.QtWidgets import QWidget


class UndoGuard(QObject):
    """A line edit or spin box takes Ctrl+Z for itself while it has the focus, even where nothing was typed.

    Here it does so only while `typing` says that somebody types.
    """

    def __init__(self, field: QWidget, typing: Callable[[], bool]) -> None:
        super().__init__(field)
        self._typing = typing
        field.installEventFilter(self)

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Keep the question whether the key is wanted from the field."""
        if not isinstance(event, QKeyEvent) or event.type() != QEvent.Type.ShortcutOverride:
            return False
        undoing = event.matches(QKeySequence.StandardKey.Undo) or event.matches(QKeySequence.StandardKey.Redo)
        if not undoing or self._typing():
            return False
        event.ignore()
        return True
