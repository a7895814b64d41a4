"""Messages: in full; the first one in a line, in the status strip with its figures; notes over the image."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PyQt5.QtCore import QEvent, QPoint, QRect, QSize, Qt, QTimer, pyqtSignal
from PyQt5.QtGui import QMouseEvent, QResizeEvent
from PyQt5.QtWidgets import (
    QFrame,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QScrollArea,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from grabbergui.models.diagnosis import Stage
from grabbergui.models.language import localized, translate
from grabbergui.models.markup import Markup, joined, markup
from grabbergui.models.messages import Message, MessageModel, Offer, Severity
from grabbergui.models.status import Tone
from grabbergui.ui.shown_text import set_rich, set_tooltip
from grabbergui.ui.theme import icon_pixmap
from grabbergui.ui.widgets.labels import ElidedLabel, restyle
from grabbergui.ui.windows import Popup, load_form

# -- in full -------------------------------------------------------------------------------------
_ICONS = {Severity.ERROR: "error", Severity.WARNING: "error", Severity.NOTICE: "info"}
"Names of the icons before messages."


def _fill_offers(layout: QHBoxLayout, offers: Sequence[Offer]) -> None:
    """Fill a layout with a button for each offer."""
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
        self._severity = message.severity
        self._draw_icon()
        _fill_offers(self.offersLayout, message.offers)
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

    dismissed = pyqtSignal(Message)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._bars: list[MessageBar] = []
        self._layout = QVBoxLayout(self)
        self._layout.setContentsMargins(0, 0, 0, 0)
        self._layout.setSpacing(1)

    def setMessages(self, messages: Sequence[Message]) -> None:
        """Replace the messages shown."""
        for old in self._bars:
            self._layout.removeWidget(old)
            old.hide()
            old.deleteLater()
        self._bars = [MessageBar(message, self) for message in messages]
        for bar, message in zip(self._bars, messages, strict=True):
            bar.dismissed.connect(lambda message=message: self.dismissed.emit(message))
            self._layout.addWidget(bar)


MOST_STACKED = 4
"Most messages shown at once."
EXPIRY_MS = 500
"Milliseconds between two checks for expired messages."


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
        self._model.post(Message(text, Severity.ERROR))

    def showNotice(self, text: str) -> None:
        """Show a message that goes away by itself."""
        self._model.notice(text)

    def showOffer(self, text: str, label: str, act: Callable[[], None]) -> Message:
        """Show a message with a button for its remedy, until it is dismissed."""
        message = Message(text, offers=(Offer(label, act),))
        self._model.post(message)
        return message

    def dismiss(self, message: Message) -> None:
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


# -- in one line ---------------------------------------------------------------------------------
LIST_WIDTH = 560
"Width of the list of all messages in pixels."


class MessageLine(QFrame):
    """Shows the first message in one line; a button opens the list of all, in full."""

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

    def setMessages(self, messages: Sequence[Message]) -> None:
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

    def _show(self, message: Message | None) -> None:
        self.textLabel.setText(message.sentence if message is not None else "")
        self.setAccessibleName(self.textLabel.text())
        _fill_offers(self.offersLayout, message.offers if message is not None else ())
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


# -- over the image ------------------------------------------------------------------------------
class ImageNote(QFrame):
    """Shows why there is no image, the remedy, and the stage at which the image is lost."""

    summaryLabel: QLabel
    adviceLabel: QLabel
    stageLabel: QLabel

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("image_note", self)
        self.hide()

    def setNote(self, summary: str, advice: str = "", stage: Stage | None = None) -> None:
        """Show a note; with no summary, none. `stage` is where the image is lost."""
        self.summaryLabel.setText(summary)
        self.adviceLabel.setText(advice)
        self.adviceLabel.setVisible(bool(advice))
        set_rich(self.stageLabel, _way(stage) if stage is not None else Markup())
        self.stageLabel.setVisible(stage is not None)
        self.setAccessibleName(f"{summary} {advice}")
        set_tooltip(self, f"{summary}\n{advice}".strip())  # in a low window its end may be cut off
        restyle(self, "tone", "info" if stage is None else "busy")
        self.setVisible(bool(summary))


def _way(end: Stage) -> Markup:
    """Return the stages: those passed, the one that fails, which is marked, and the rest."""
    stages = list(Stage)
    parts = []
    for index, stage in enumerate(stages):
        before, at = index < stages.index(end), stage is end
        mark = "✓" if before else "✗" if at else "·"
        text = f"{mark} {_stage_name(stage)}"
        parts.append(markup("<b>{0}</b>", text) if at else text)
    return joined(parts, "&nbsp;&nbsp; ")


def _stage_name(stage: Stage) -> str:
    names = {
        Stage.CONTROL: translate("ImageNote", "control"),
        Stage.PACKETS: translate("ImageNote", "packets"),
        Stage.FRAMES: translate("ImageNote", "frames"),
        Stage.CONVERSION: translate("ImageNote", "conversion"),
        Stage.DISPLAY: translate("ImageNote", "display"),
    }
    return names[stage]


# -- the status strip ----------------------------------------------------------------------------
LEAST_TITLE = 60
"Pixels kept for the title before figures are hidden for it."
TEXT_ROOM = 20
"Pixels above and below the text, for the buttons of messages."
MOST_MESSAGE = 640
"Most pixels of a message for which figures are hidden; its button shows a longer one in full."


class StatusStrip(QWidget):
    """Figures keep their places while they change; the least important are hidden for lack of room."""

    stateLabel: QLabel
    titleLabel: ElidedLabel
    messages: MessageLine
    formatLabel: QLabel
    rateLabel: QLabel
    bandwidthLabel: QLabel
    lossLabel: QLabel

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("status_strip", self)
        self._figures = (self.lossLabel, self.rateLabel, self.formatLabel, self.bandwidthLabel)
        "The most important first."
        # The same with and without a message, so that nothing moves when one comes.
        self.setFixedHeight(self.fontMetrics().height() + TEXT_ROOM)
        self.setMessages(())

    def minimumSizeHint(self) -> QSize:
        """Return room for the state alone."""
        return QSize(self.stateLabel.sizeHint().width(), self.height())

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Show as many figures as there is room for."""
        super().resizeEvent(event)
        self._fit()

    def setState(self, text: str, tone: Tone) -> None:
        """Show the source's state."""
        self.stateLabel.setText(f"● {text}")
        restyle(self.stateLabel, "tone", tone.value)

    def setTitle(self, title: str, *shorter: str) -> None:
        """Show the name of the open source, or a shorter one for little room; messages replace it."""
        self.titleLabel.setTexts(title, *shorter)

    def setMessages(self, messages: Sequence[Message]) -> None:
        """Show the first of these messages in place of the title."""
        self.messages.setMessages(messages)
        self.messages.setVisible(bool(messages))
        self.titleLabel.setVisible(not messages)
        self._fit()

    def setFormat(self, text: str) -> None:
        """Show resolution and pixel format."""
        self._show(self.formatLabel, text)

    def setRates(self, camera: float, painted: float) -> None:
        """Show frames per second from the camera, and images painted per second."""
        self._show(
            self.rateLabel,
            localized(self.tr("{0:.1f} fps · {1:.0f} shown").format(camera, painted)),
        )

    def setBandwidth(self, bytes_per_second: float) -> None:
        """Show the payload per second."""
        self._show(self.bandwidthLabel, localized(f"{bytes_per_second / 1e6:.1f} MB/s"))

    def setLosses(self, text: str, tone: Tone, detail: str) -> None:
        """Show the losses, their severity, and every counter in the tooltip."""
        self._show(self.lossLabel, text)
        set_tooltip(self.lossLabel, detail)
        restyle(self.lossLabel, "tone", tone.value)

    def clearFigures(self) -> None:
        """Show that nothing streams."""
        for label in self._figures:
            label.clear()
            label.setMinimumWidth(0)

    def _show(self, label: QLabel, text: str) -> None:
        """Keep the figure's width at its maximum, so that one more digit does not move its neighbours."""
        if text != label.text():
            label.setText(text)
            label.setMinimumWidth(max(label.minimumWidth(), label.sizeHint().width()))
            self._fit()

    def _fit(self) -> None:
        layout = self.layout()
        gap = layout.spacing() if layout is not None else 0
        margins = layout.contentsMargins() if layout is not None else self.contentsMargins()
        least = min(self.messages.fullWidth, MOST_MESSAGE) if self.messages.messages else LEAST_TITLE
        room = self.width() - margins.left() - margins.right() - least
        room -= self.stateLabel.sizeHint().width() + gap
        for label in self._figures:
            room -= label.sizeHint().width() + gap
            label.setVisible(room >= 0)
