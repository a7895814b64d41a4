"""The newest message on one line, which keeps its place: nothing moves when it comes or goes."""

from __future__ import annotations

from collections.abc import Sequence

from PyQt5.QtCore import QPoint, Qt, pyqtSignal
from PyQt5.QtGui import QMouseEvent, QResizeEvent
from PyQt5.QtWidgets import QFrame, QHBoxLayout, QLabel, QToolButton, QVBoxLayout, QWidget

from grabbergui.models.messages import Message
from grabbergui.ui import icons
from grabbergui.ui.loader import load_form
from grabbergui.ui.widgets.elided_label import ElidedLabel
from grabbergui.ui.widgets.message_stack import MessageList, fill_offers, message_icon
from grabbergui.ui.widgets.styled import restyle

LIST_WIDTH = 560
"Pixels of the list of all messages."


class MessageLine(QFrame):
    """Shows the first of some messages; a button shows all of them, in full. Setters in, signals out."""

    dismissed = pyqtSignal(Message)

    iconLabel: QLabel
    textLabel: ElidedLabel
    offersLayout: QHBoxLayout
    moreButton: QToolButton
    closeButton: QToolButton

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("message_line", self)
        self._messages: tuple[Message, ...] = ()
        self._popup: QFrame | None = None
        self.closeButton.clicked.connect(self._on_close_clicked)
        self.moreButton.clicked.connect(self.showAll)
        icons.apply(self)
        self.setMessages(())

    @property
    def messages(self) -> list[str]:
        """The texts of all messages, the newest first."""
        return [message.text for message in self._messages]

    @property
    def fullWidth(self) -> int:
        """Pixels that the first message takes with all of its text."""
        text = self.textLabel.fontMetrics().horizontalAdvance(self.textLabel.text())
        return self.sizeHint().width() - self.textLabel.sizeHint().width() + text

    def setMessages(self, messages: Sequence[Message]) -> None:
        """Show the first of these, and how many there are besides."""
        before = self._messages[0] if self._messages else None
        self._messages = tuple(messages)
        first = self._messages[0] if self._messages else None
        if first != before:
            self._show(first)
        for widget in (self.iconLabel, self.textLabel, self.closeButton):
            widget.setVisible(first is not None)
        self._show_more()

    def showAll(self) -> None:
        """Open the list of all messages above the line."""
        popup = QFrame(self, Qt.WindowType.Popup)
        popup.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        popup.setProperty("messages", True)
        layout = QVBoxLayout(popup)
        layout.setContentsMargins(1, 1, 1, 1)
        listed = MessageList(popup)
        listed.setMessages(self._messages)
        listed.dismissed.connect(self.dismissed)
        listed.dismissed.connect(self._on_list_dismissed)
        layout.addWidget(listed)
        popup.setFixedWidth(max(LIST_WIDTH, self.width()))
        height = max(layout.heightForWidth(popup.width()), popup.sizeHint().height())
        popup.setFixedHeight(height)
        popup.move(self.mapToGlobal(QPoint(self.width() - popup.width(), -height - 2)))
        popup.show()
        self._popup = popup

    def mouseReleaseEvent(self, event: QMouseEvent | None) -> None:
        """A click on the text shows all of it."""
        super().mouseReleaseEvent(event)
        if self._messages:
            self.showAll()

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """See whether the text still fits."""
        super().resizeEvent(event)
        self._show_more()

    def _show(self, message: Message | None) -> None:
        self.textLabel.setText(message.sentence if message is not None else "")
        self.setAccessibleName(self.textLabel.text())
        fill_offers(self.offersLayout, message.offers if message is not None else ())
        if message is not None:
            self.iconLabel.setPixmap(icons.pixmap(message_icon(message.severity), self, 18))
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
