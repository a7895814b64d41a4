"""Messages in full, one below the other, for windows that say little; and a list of them over any window."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PyQt5.QtCore import QTimer, pyqtSignal
from PyQt5.QtWidgets import QFrame, QHBoxLayout, QLabel, QPushButton, QToolButton, QVBoxLayout, QWidget

from grabbergui.models.messages import Message, MessageModel, Offer, Severity
from grabbergui.ui import icons
from grabbergui.ui.loader import load_form

MOST = 4
"Messages shown at once."
EXPIRY_MS = 500
"Between two looks whether a message has had its time."
_ICONS = {Severity.ERROR: "error", Severity.WARNING: "error", Severity.NOTICE: "info"}


def message_icon(severity: Severity) -> str:
    """The name of the icon before a message."""
    return _ICONS[severity]


def fill_offers(layout: QHBoxLayout, offers: Sequence[Offer]) -> None:
    """Have a button for each offer in a layout, and no others."""
    while (item := layout.takeAt(0)) is not None:
        if (old := item.widget()) is not None:
            old.hide()
            old.deleteLater()
    for offer in offers:
        button = QPushButton(offer.label)
        button.setObjectName("offerButton")
        button.clicked.connect(lambda _, act=offer.act: act())
        layout.addWidget(button)


class MessageBar(QFrame):
    """One message, in as many lines as it takes."""

    dismissed = pyqtSignal()

    iconLabel: QLabel
    textLabel: QLabel
    offersLayout: QHBoxLayout
    closeButton: QToolButton

    def __init__(self, message: Message, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("message_bar", self)
        self.setProperty("message", message.severity.value)
        self.textLabel.setText(message.sentence)
        self.setAccessibleName(message.sentence)
        self.iconLabel.setPixmap(icons.pixmap(message_icon(message.severity), self, 18))
        fill_offers(self.offersLayout, message.offers)
        icons.apply(self)
        self.closeButton.clicked.connect(self.dismissed)


class MessageList(QWidget):
    """Some messages, the first on top."""

    dismissed = pyqtSignal(Message)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._bars: list[MessageBar] = []
        self._layout = QVBoxLayout(self)
        self._layout.setContentsMargins(0, 0, 0, 0)
        self._layout.setSpacing(1)

    def setMessages(self, messages: Sequence[Message]) -> None:
        """Show these and no others."""
        for old in self._bars:
            self._layout.removeWidget(old)
            old.hide()
            old.deleteLater()
        self._bars = [MessageBar(message, self) for message in messages]
        for bar, message in zip(self._bars, messages, strict=True):
            bar.dismissed.connect(lambda message=message: self.dismissed.emit(message))
            self._layout.addWidget(bar)


class MessageStack(MessageList):
    """The messages of a window of its own, the newest on top; not there while there is none."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._model = MessageModel()
        self._model.changed.connect(self._on_model_changed)
        self.dismissed.connect(self._model.dismiss)
        self._timer = QTimer(self)
        self._timer.setInterval(EXPIRY_MS)
        self._timer.timeout.connect(self._model.expire)
        self.hide()

    @property
    def messages(self) -> list[str]:
        """The texts shown, the newest first."""
        return [message.text for message in self._model.shown(None)[:MOST]]

    def showError(self, text: str) -> None:
        """Show what did not work, until it is dismissed."""
        self._model.post(Message(text, Severity.ERROR))

    def showNotice(self, text: str) -> None:
        """Show a message that goes away by itself."""
        self._model.notice(text)

    def showOffer(self, text: str, label: str, act: Callable[[], None]) -> Message:
        """Show a message with a button that does something about it, until it is dismissed."""
        message = Message(text, offers=(Offer(label, act),))
        self._model.post(message)
        return message

    def dismiss(self, message: Message) -> None:
        """Remove a message; does nothing where it is gone already."""
        self._model.dismiss(message)

    def dismissAll(self) -> None:
        """Remove every message."""
        self._model.dismiss_all()

    def _on_model_changed(self) -> None:
        messages = self._model.shown(None)[:MOST]
        self.setMessages(messages)
        self.setVisible(bool(messages))
        if messages and not self._timer.isActive():
            self._timer.start()
        elif not messages:
            self._timer.stop()
