"""The first message, in one line."""

from __future__ import annotations

from collections.abc import Sequence

from PyQt5.QtCore import QEvent, QPoint, QRect, Qt, pyqtSignal
from PyQt5.QtGui import QMouseEvent, QResizeEvent
from PyQt5.QtWidgets import (
    QFrame,
    QHBoxLayout,
    QLabel,
    QScrollArea,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from grabbergui.models.messages import UserMessage
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.keys import Popup
from grabbergui.ui.theme import icon_pixmap
from grabbergui.ui.widgets.labels import ElidedLabel, restyle
from grabbergui.ui.widgets.messages import _ICONS, MessageList, fill_offers

LIST_WIDTH = 560
"Width of the list of all messages in pixels."


class MessageLine(QFrame):
    """Shows the first message in one line; a button opens the list of all, in full."""

    dismissed = pyqtSignal(UserMessage)

    iconLabel: QLabel
    textLabel: ElidedLabel
    offersLayout: QHBoxLayout
    moreButton: QToolButton
    closeButton: QToolButton

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("message_line", self)
        self._messages: tuple[UserMessage, ...] = ()
        self._popup: QFrame | None = None
        self.closeButton.clicked.connect(self._on_close_clicked)
        self.moreButton.clicked.connect(self.showAll)
        self.setMessages(())

    @property
    def messages(self) -> list[str]:
        """The texts of all messages, the newest first."""
        return [message.text for message in self._messages]

    @property
    def fullWidth(self) -> int:
        """Return the pixels that the first message needs for all of its text."""
        text = self.textLabel.fontMetrics().horizontalAdvance(self.textLabel.text())
        return self.sizeHint().width() - self.textLabel.sizeHint().width() + text

    def setMessages(self, messages: Sequence[UserMessage]) -> None:
        """Show the first of these messages, and the number of the others."""
        before = self._messages[0] if self._messages else None
        self._messages = tuple(messages)
        first = self._messages[0] if self._messages else None
        if first != before:
            self._show(first)
        for widget in (self.iconLabel, self.textLabel, self.closeButton):
            widget.setVisible(first is not None)
        self._show_more()

    def showAll(self) -> None:
        """Open the list of all messages above the line; it scrolls if there is not enough room."""
        popup = Popup(self)
        popup.setProperty("messages", True)
        layout = QVBoxLayout(popup)
        layout.setContentsMargins(1, 1, 1, 1)
        listed = MessageList(popup)
        listed.setMessages(self._messages)
        listed.dismissed.connect(self.dismissed)
        listed.dismissed.connect(self._on_list_dismissed)
        area = QScrollArea(popup)
        area.setFrameShape(QFrame.Shape.NoFrame)
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        area.setWidgetResizable(True)
        area.setWidget(listed)
        layout.addWidget(area)
        for part in (popup, *listed.findChildren(QWidget)):
            part.ensurePolished()  # the style sheet may set another font, and a border
        corner = self.mapToGlobal(QPoint(self.width(), -2))
        screen = self.screen()
        room = screen.availableGeometry() if screen is not None else QRect(QPoint(0, 0), corner)
        width = max(LIST_WIDTH, self.width())
        border = 2 + 2 * popup.contentsRect().left()
        height = min(listed.heightForWidth(width - border) + border, corner.y() - room.top())
        popup.setFixedSize(width, height)
        popup.move(max(room.left(), corner.x() - width), corner.y() - height)
        popup.show()
        self._popup = popup

    def mouseReleaseEvent(self, event: QMouseEvent | None) -> None:
        """Open the list on a click on the text."""
        super().mouseReleaseEvent(event)
        if self._messages:
            self.showAll()

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Check whether the text still fits."""
        super().resizeEvent(event)
        self._show_more()

    def changeEvent(self, event: QEvent | None) -> None:
        """Draw the icon in the colours of another theme."""
        super().changeEvent(event)
        if event is not None and event.type() == QEvent.Type.PaletteChange and hasattr(self, "_messages"):
            self._draw_icon()

    def _draw_icon(self) -> None:
        if self._messages:
            self.iconLabel.setPixmap(icon_pixmap(_ICONS[self._messages[0].severity], self, 18))

    def _show(self, message: UserMessage | None) -> None:
        texts = (message.sentence, message.cause_first) if message is not None else ("",)
        self.textLabel.setTexts(*texts)
        self.setAccessibleName(self.textLabel.text())
        fill_offers(self.offersLayout, message.offers if message is not None else ())
        if message is not None:
            self._draw_icon()
        restyle(self, "message", message.severity.value if message is not None else "")

    def _show_more(self) -> None:
        others = len(self._messages) - 1
        width = self.textLabel.fontMetrics().horizontalAdvance(self.textLabel.text())
        elided = bool(self._messages) and width > self.textLabel.width()
        self.moreButton.setText(self.tr("{0} more").format(others) if others > 0 else "…")
        self.moreButton.setVisible(others > 0 or elided)

    def _on_list_dismissed(self) -> None:
        if self._popup is not None:
            self._popup.close()
            self._popup = None

    def _on_close_clicked(self) -> None:
        if self._messages:
            self.dismissed.emit(self._messages[0])
