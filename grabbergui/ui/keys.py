"""Keys and the wheel: stop keys of a robot, menus, shortcuts beside text fields, the wheel over controls."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PyQt5.QtCore import QEvent, QObject, Qt, pyqtSignal
from PyQt5.QtGui import QKeyEvent, QKeySequence
from PyQt5.QtWidgets import (
    QAction,
    QFrame,
    QWidget,
)

_COMMANDING = Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.AltModifier
_UNDO = (QKeySequence.StandardKey.Undo, QKeySequence.StandardKey.Redo)
_EDITING = (
    QKeySequence.StandardKey.Copy,
    QKeySequence.StandardKey.Cut,
    QKeySequence.StandardKey.Paste,
    QKeySequence.StandardKey.SelectAll,
)
_MOVING = (Qt.Key.Key_Left, Qt.Key.Key_Right, Qt.Key.Key_Home, Qt.Key.Key_End, Qt.Key.Key_Up, Qt.Key.Key_Down,
           Qt.Key.Key_Backspace, Qt.Key.Key_Delete)  # fmt: skip


class StopKeys(QObject):
    """Catches its keys in a window and all of its children, before any of these handles them."""

    pressed = pyqtSignal()

    def __init__(self, window: QWidget, keys: Sequence[Qt.Key]) -> None:
        """Watch the window and its present children."""
        super().__init__(window)
        self.keys = tuple(keys)
        """The keys that stop now; may be changed."""
        for watched in (window, *window.findChildren(QWidget)):
            watched.installEventFilter(self)

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Emit for a stop key; a key that is held down counts once."""
        if isinstance(event, QKeyEvent) and event.key() in self.keys:
            if event.type() == QEvent.Type.ShortcutOverride:
                event.accept()
                return True
            if event.type() == QEvent.Type.KeyPress:
                event.accept()
                if not event.isAutoRepeat():
                    self.pressed.emit()
                return True
        return super().eventFilter(watched, event)


class Popup(QFrame):
    """A popup that closes on a shortcut of its window and triggers the action; Qt ignores the key."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent, Qt.WindowType.Popup)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._window = parent.window()

    def event(self, event: QEvent | None) -> bool:
        """Take the keys of application-wide shortcuts, too, so that the popup closes first."""
        if event is not None and event.type() == QEvent.Type.ShortcutOverride:
            event.accept()
            return True
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Trigger the action of a shortcut."""
        if event is not None and self._window is not None:
            pressed = QKeySequence(int(event.modifiers()) | event.key())
            for action in self._window.findChildren(QAction):
                everywhere = action.shortcutContext() != Qt.ShortcutContext.WidgetWithChildrenShortcut
                if everywhere and action.isEnabled() and action.shortcut() == pressed:
                    self.close()
                    action.trigger()
                    return
        super().keyPressEvent(event)


class MenuKeys(QObject):
    """Gives an open menu the letters of its mnemonics; shortcuts of the image would take them."""

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Accept a key without Ctrl, so that no shortcut is tried."""
        if not isinstance(event, QKeyEvent) or event.type() != QEvent.Type.ShortcutOverride:
            return False
        if event.modifiers() & Qt.KeyboardModifier.ControlModifier:
            return False
        event.accept()
        return True


class WheelGuard(QObject):
    """Lets the wheel reach its widget only while that has the focus; otherwise the panel scrolls."""

    def __init__(self, widget: QWidget) -> None:
        super().__init__(widget)
        widget.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        widget.installEventFilter(self)

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Ignore a wheel event without focus, so that the parent gets it."""
        if (
            event is not None
            and event.type() == QEvent.Type.Wheel
            and isinstance(watched, QWidget)
            and not watched.hasFocus()
        ):
            event.ignore()
            return True
        return False


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
        """Keep the window's keys from the field, both the shortcut override and the key press.

        The field's own keys are no shortcuts, and are not offered to the widgets around it.
        """
        if not isinstance(event, QKeyEvent):
            return False
        overriding = event.type() == QEvent.Type.ShortcutOverride
        if not event.modifiers() & _COMMANDING:
            if overriding and event.key() in _MOVING:
                event.accept()
                return True
            return False
        if not (overriding or event.type() == QEvent.Type.KeyPress) or not self._belongs_to_window(event):
            return False
        event.ignore()
        return True

    def _belongs_to_window(self, event: QKeyEvent) -> bool:
        if any(event.matches(key) for key in _UNDO):
            return not self._typing()
        if not event.modifiers() & Qt.KeyboardModifier.ControlModifier:
            return False
        return event.key() not in _MOVING and not any(event.matches(key) for key in _EDITING)
