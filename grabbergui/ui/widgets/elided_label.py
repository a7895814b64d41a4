"""A label that shortens its text where there is no room for all of it."""

from __future__ import annotations

from PyQt5.QtCore import QSize, Qt
from PyQt5.QtGui import QPainter, QPaintEvent
from PyQt5.QtWidgets import QLabel, QStyle, QStyleOption, QWidget


class ElidedLabel(QLabel):
    """One line of plain text; the whole of it is in the tooltip.

    Of a camera's name the middle is left out: the serial number at its end tells it from the others.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setMinimumWidth(24)
        self.elide_mode = Qt.TextElideMode.ElideRight

    def setText(self, text: str | None) -> None:
        """Show a text."""
        super().setText(text)
        self.setToolTip(text or "")

    def sizeHint(self) -> QSize:
        """As wide as there is room."""
        return QSize(24, super().sizeHint().height())

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Draw as much as fits, with dots where something is missing."""
        painter, option = QPainter(self), QStyleOption()
        option.initFrom(self)
        text = self.fontMetrics().elidedText(self.text(), self.elide_mode, self.width())
        style = self.style()
        if style is not None:
            enabled = bool(option.state & QStyle.StateFlag.State_Enabled)
            flags = int(Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft)
            style.drawItemText(
                painter, self.rect(), flags, option.palette, enabled, text, self.foregroundRole()
            )
