"""Messages: in full; the first one in a line, in the status strip with its figures; notes over the image."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PyQt5.QtCore import QEvent, QTimer, pyqtSignal
from PyQt5.QtWidgets import (
    QBoxLayout,
    QFrame,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from grabbergui.models.messages import MessageModel, Offer, Severity, UserMessage
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.theme import icon_pixmap

_ICONS = {Severity.ERROR: "error", Severity.WARNING: "error", Severity.NOTICE: "info"}
"Names of the icons before messages."
MOST_STACKED = 4
"Most messages shown at once."
EXPIRY_MS = 500
"Milliseconds between two checks for expired messages."


def fill_offers(layout: QBoxLayout, offers: Sequence[Offer]) -> None:
    """Fill a layout with a button for each offer. Buttons with the same labels stay: one may be pressed."""
    buttons = [item.widget() for item in map(layout.itemAt, range(layout.count())) if item is not None]
    present = [button for button in buttons if isinstance(button, QPushButton)]
    if [button.text() for button in present] == [offer.label for offer in offers]:
        for button in present:
            button.clicked.disconnect()
    else:
        while (item := layout.takeAt(0)) is not None:
            if (old := item.widget()) is not None:
                old.hide()
                old.deleteLater()
        present = [QPushButton(offer.label) for offer in offers]
        for button in present:
            button.setObjectName("offerButton")
            layout.addWidget(button)
    for button, offer in zip(present, offers, strict=True):
        button.clicked.connect(lambda _, act=offer.act: act())


class MessageBar(QFrame):
    """One message, in as many lines as it takes."""

    dismissed = pyqtSignal()

    iconLabel: QLabel
    textLabel: QLabel
    offersLayout: QHBoxLayout
    closeButton: QToolButton

    def __init__(self, message: UserMessage, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("message_bar", self)
        self.setProperty("message", message.severity.value)
        self.textLabel.setText(message.sentence)
        self.setAccessibleName(message.sentence)
        self._severity = message.severity
        self._draw_icon()
        fill_offers(self.offersLayout, message.offers)
        self.closeButton.clicked.connect(self.dismissed)

    def changeEvent(self, event: QEvent | None) -> None:
        """Draw the icon in the colours of another theme."""
        super().changeEvent(event)
        if event is not None and event.type() == QEvent.Type.PaletteChange and hasattr(self, "_severity"):
            self._draw_icon()

    def _draw_icon(self) -> None:
        self.iconLabel.setPixmap(icon_pixmap(_ICONS[self._severity], self, 18))


class MessageList(QWidget):
    """A list of messages, the first on top."""

    dismissed = pyqtSignal(UserMessage)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._bars: list[MessageBar] = []
        self._layout = QVBoxLayout(self)
        self._layout.setContentsMargins(0, 0, 0, 0)
        self._layout.setSpacing(1)

    def setMessages(self, messages: Sequence[UserMessage]) -> None:
        """Replace the messages shown."""
        for old in self._bars:
            self._layout.removeWidget(old)
            old.hide()
            old.deleteLater()
        self._bars = [MessageBar(message, self) for message in messages]
        for bar, message in zip(self._bars, messages, strict=True):
            bar.dismissed.connect(lambda message=message: self.dismissed.emit(message))
            self._layout.addWidget(bar)


class MessageStack(MessageList):
    """The messages of one window, the newest on top; hidden while there are none."""

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
        return [message.text for message in self._model.shown(None)[:MOST_STACKED]]

    def showError(self, text: str) -> None:
        """Show an error message until it is dismissed."""
        self._model.post(UserMessage(text, Severity.ERROR))

    def showNotice(self, text: str) -> None:
        """Show a message that goes away by itself."""
        self._model.notice(text)

    def showOffer(self, text: str, label: str, act: Callable[[], None]) -> UserMessage:
        """Show a message with a button for its remedy, until it is dismissed."""
        message = UserMessage(text, offers=(Offer(label, act),))
        self._model.post(message)
        return message

    def dismiss(self, message: UserMessage) -> None:
        """Remove a message; does nothing if it is gone already."""
        self._model.dismiss(message)

    def dismissAll(self) -> None:
        """Remove every message."""
        self._model.dismiss_all()

    def _on_model_changed(self) -> None:
        messages = self._model.shown(None)[:MOST_STACKED]
        self.setMessages(messages)
        self.setVisible(bool(messages))
        if messages and not self._timer.isActive():
            self._timer.start()
        elif not messages:
            self._timer.stop()
