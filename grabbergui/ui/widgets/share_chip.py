"""The button in the status bar that says whether the camera is shared, or comes from another computer."""

from __future__ import annotations

from PyQt5.QtCore import QEvent, Qt
from PyQt5.QtWidgets import QToolButton, QWidget

from grabbergui.ui.shown_text import set_tooltip
from grabbergui.ui.theme import icon


class ShareChip(QToolButton):
    """An icon, and a few words if there is something to say; a click opens the dialog."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("shareChip")
        self.setAutoRaise(True)
        self.setProperty("iconName", "share")
        self.setIcon(icon("share", self.palette()))
        self.setText("")

    def setState(self, text: str, detail: str) -> None:
        """Show these words, none for a local camera that is not shared; `detail` is the tooltip."""
        style = Qt.ToolButtonStyle.ToolButtonTextBesideIcon if text else Qt.ToolButtonStyle.ToolButtonIconOnly
        self.setToolButtonStyle(style)
        self.setText(text)
        self.setAccessibleName(detail)
        set_tooltip(self, detail)

    def changeEvent(self, event: QEvent | None) -> None:
        """Draw the icon in the colours of another theme."""
        super().changeEvent(event)
        if event is not None and event.type() == QEvent.Type.PaletteChange and self.property("iconName"):
            self.setIcon(icon("share", self.palette()))
