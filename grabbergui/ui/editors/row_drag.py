"""Dragging a feature's row by its name."""

from __future__ import annotations

from PyQt5.QtCore import QByteArray, QMimeData, QPoint, Qt
from PyQt5.QtGui import QDrag, QDropEvent, QMouseEvent
from PyQt5.QtWidgets import QApplication, QWidget

FEATURE_MIME = "application/x-grabbergui-feature"
"""What is dragged: the feature's name in UTF-8."""


def dragged_feature(event: QDropEvent) -> str:
    """The name of the feature that is dragged; empty where it is something else."""
    data = event.mimeData()
    if data is None or not data.hasFormat(FEATURE_MIME):
        return ""
    return bytes(data.data(FEATURE_MIME)).decode("utf-8", "replace")


class RowDrag:
    """Tells a drag from a click; the row passes on what the mouse does where no control takes it."""

    def __init__(self, row: QWidget, name: str) -> None:
        self._row = row
        self._name = name
        self._pressed: QPoint | None = None

    def press(self, event: QMouseEvent) -> None:
        """A button went down."""
        self._pressed = event.pos() if event.button() == Qt.MouseButton.LeftButton else None

    def move(self, event: QMouseEvent) -> None:
        """The mouse moved with a button down; far enough, the row is dragged until it is let go."""
        if self._pressed is None:
            return
        if (event.pos() - self._pressed).manhattanLength() >= QApplication.startDragDistance():
            self._pressed = None
            self._drag()

    def _drag(self) -> None:
        data = QMimeData()
        data.setData(FEATURE_MIME, QByteArray(self._name.encode()))
        drag = QDrag(self._row)
        drag.setMimeData(data)
        drag.setPixmap(self._row.grab())
        drag.exec_(Qt.DropAction.CopyAction)
