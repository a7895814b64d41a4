"""Keys that stop a robot, whatever has the focus in a window."""

from __future__ import annotations

from collections.abc import Sequence

from PyQt5.QtCore import QEvent, QObject, Qt, pyqtSignal
from PyQt5.QtGui import QKeyEvent
from PyQt5.QtWidgets import QWidget


class StopKeys(QObject):
    """Catches its keys in a window and all of its children, before any of these handles them."""

    pressed = pyqtSignal()

    def __init__(self, window: QWidget, keys: Sequence[Qt.Key]) -> None:
        """Watch the children that the window has now."""
        super().__init__(window)
        self.keys = tuple(keys)
        """The keys that stop now; may be changed."""
        for watched in (window, *window.findChildren(QWidget)):
            watched.installEventFilter(self)

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Take a stop key; a key that is held down counts once."""
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
