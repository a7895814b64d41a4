"""Event filters that keep the mouse wheel and the window's shortcuts from editors."""

from __future__ import annotations

from collections.abc import Callable

from PyQt5.QtCore import QEvent, QObject, Qt
from PyQt5.QtGui import QKeyEvent, QKeySequence
from PyQt5.QtWidgets import QWidget


class WheelGuard(QObject):
    """Lets the wheel reach its widget only while that has the focus; otherwise the panel scrolls."""

    def __init__(self, widget: QWidget) -> None:
        super().__init__(widget)
        widget.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        widget.installEventFilter(self)

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Ignore a wheel event without focus, so that it goes on to the parent."""
        if (
            event is not None
            and event.type() == QEvent.Type.Wheel
            and isinstance(watched, QWidget)
            and not watched.hasFocus()
        ):
            event.ignore()
            return True
        return False


_UNDO = (QKeySequence.StandardKey.Undo, QKeySequence.StandardKey.Redo)
_EDITING = (
    QKeySequence.StandardKey.Copy,
    QKeySequence.StandardKey.Cut,
    QKeySequence.StandardKey.Paste,
    QKeySequence.StandardKey.SelectAll,
)
_MOVING = (Qt.Key.Key_Left, Qt.Key.Key_Right, Qt.Key.Key_Home, Qt.Key.Key_End, Qt.Key.Key_Up, Qt.Key.Key_Down,
           Qt.Key.Key_Backspace, Qt.Key.Key_Delete)  # fmt: skip


class ShortcutGuard(QObject):
    """Keeps a line edit or spin box from taking the window's keys with Ctrl for itself.

    On X11 such a field clears itself on Ctrl+U and moves its cursor on Ctrl+E, and it takes Ctrl+Z even where
    nothing was typed. Here it keeps what belongs to editing text; undo and redo only while `typing`.
    """

    def __init__(self, field: QWidget, typing: Callable[[], bool]) -> None:
        super().__init__(field)
        self._typing = typing
        field.installEventFilter(self)

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Keep the window's keys from the field: the question whether it wants them, and the press itself."""
        if not isinstance(event, QKeyEvent) or not self._belongs_to_window(event):
            return False
        if event.type() not in (QEvent.Type.ShortcutOverride, QEvent.Type.KeyPress):
            return False
        event.ignore()
        return True

    def _belongs_to_window(self, event: QKeyEvent) -> bool:
        if any(event.matches(key) for key in _UNDO):
            return not self._typing()
        if not event.modifiers() & Qt.KeyboardModifier.ControlModifier:
            return False
        return event.key() not in _MOVING and not any(event.matches(key) for key in _EDITING)
