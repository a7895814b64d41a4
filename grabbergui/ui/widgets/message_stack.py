"""Messages at the top: never lost at once, gone with a click. Over the picture, so that it does not move."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum

from PyQt5.QtCore import QTimer, pyqtSignal
from PyQt5.QtWidgets import QFrame, QLabel, QPushButton, QToolButton, QVBoxLayout, QWidget

from grabbergui.ui import icons
from grabbergui.ui.loader import load_form

MOST = 4
"Messages shown at once; older ones make way."
NOTICE_SECONDS = 6.0
"How long a notice stays by itself; errors stay until dismissed."


class Tone(Enum):
    """How serious a message is."""

    ERROR = "error"
    INFO = "info"


class MessageBar(QFrame):
    """One message; the same one again only counts up."""

    dismissed = pyqtSignal()

    iconLabel: QLabel
    textLabel: QLabel
    actionButton: QPushButton
    closeButton: QToolButton

    def __init__(self, text: str, tone: Tone, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("message_bar", self)
        self.text = text
        self.tone = tone
        self._times = 1
        self.setProperty("message", tone.value)
        self.textLabel.setText(_sentence(text))
        self.setAccessibleName(text)
        self.iconLabel.setPixmap(icons.pixmap(tone.value, self, 18))
        icons.apply(self)
        self.closeButton.clicked.connect(self.dismissed)

    def offer(self, label: str, action: Callable[[], None]) -> None:
        """Show a button that does something about it."""
        self.actionButton.setText(label)
        self.actionButton.clicked.connect(lambda: action())
        self.actionButton.show()

    def again(self) -> None:
        """It was said once more."""
        self._times += 1
        self.textLabel.setText(f"{_sentence(self.text)}  (×{self._times})")


def _sentence(text: str) -> str:
    """As it is shown: beginning large, where it begins with a word and not with a name."""
    first, _, _ = text.partition(" ")
    return text[0].upper() + text[1:] if first.isalpha() and first.islower() else text


class MessageStack(QWidget):
    """Messages, the newest on top."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._bars: list[MessageBar] = []
        self._layout = QVBoxLayout(self)
        self._layout.setContentsMargins(0, 0, 0, 0)
        self._layout.setSpacing(1)
        self.hide()

    @property
    def messages(self) -> list[str]:
        """What is shown, the newest first."""
        return [bar.text for bar in self._bars]

    def showError(self, text: str) -> None:
        """Show a message until it is dismissed."""
        self._add(text, Tone.ERROR)

    def showNotice(self, text: str) -> None:
        """Show a message that goes away by itself."""
        bar = self._add(text, Tone.INFO)
        QTimer.singleShot(int(NOTICE_SECONDS * 1000), bar.dismissed)

    def showOffer(self, text: str, label: str, action: Callable[[], None]) -> MessageBar:
        """Show a message with a button that does something about it, until it is dismissed."""
        bar = self._add(text, Tone.INFO)
        bar.offer(label, action)
        return bar

    def dismiss(self, bar: MessageBar) -> None:
        """Remove a message; does nothing where it is gone already."""
        self._remove(bar)

    def dismissAll(self) -> None:
        """Remove every message."""
        for bar in list(self._bars):
            self._remove(bar)

    def _add(self, text: str, tone: Tone) -> MessageBar:
        if self._bars and (self._bars[0].text, self._bars[0].tone) == (text, tone):
            self._bars[0].again()
            return self._bars[0]
        bar = MessageBar(text, tone, self)
        bar.dismissed.connect(lambda: self.dismiss(bar))
        self._bars.insert(0, bar)
        self._layout.insertWidget(0, bar)
        for old in self._bars[MOST:]:
            self._remove(old)
        self.show()
        return bar

    def _remove(self, bar: MessageBar) -> None:
        if bar in self._bars:
            self._bars.remove(bar)
            self._layout.removeWidget(bar)
            bar.hide()
            bar.deleteLater()
        self.setVisible(bool(self._bars))
