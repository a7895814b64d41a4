"""The status strip: the message of the moment, and figures."""

from __future__ import annotations

from collections.abc import Sequence

from PyQt5.QtCore import QSize, Qt
from PyQt5.QtGui import QResizeEvent
from PyQt5.QtWidgets import QAction, QHBoxLayout, QLabel, QToolButton, QWidget

from grabbergui.models.language import localized
from grabbergui.models.messages import UserMessage
from grabbergui.models.status import Tone, rate_text
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.shown_text import set_tooltip
from grabbergui.ui.widgets.labels import ElidedLabel, restyle
from grabbergui.ui.widgets.message_line import MessageLine

LEAST_TITLE = 60
"Pixels kept for the title before figures are hidden for it."
TEXT_ROOM = 13
"Pixels above and below the text, for the buttons of messages."
LEAST_SHARE, NOTABLE_SHARE, LARGE_SHARE = 0.0005, 0.01, 0.1
"Shares of saturated samples from which they are shown, stand out, and need no decimal."
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
    clippingButton: QToolButton
    zoomBox: QWidget
    zoomLayout: QHBoxLayout
    zoomLabel: QLabel

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("status_strip", self)
        self._figures = (self.lossLabel, self.rateLabel, self.formatLabel, self.bandwidthLabel)
        self._by_importance: tuple[QLabel | QToolButton, ...] = (
            self.clippingButton, self.lossLabel, self.rateLabel, self.formatLabel,
            self.bandwidthLabel)  # fmt: skip
        "Figures that a message may replace, most important first. The zoom stays: its buttons are controls."
        # The same with and without a message, so that nothing moves when one comes.
        self.setFixedHeight(self.fontMetrics().height() + TEXT_ROOM)
        self._measured = ""
        self._saturated: float | None = None
        self.setClipping("")
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

    def setMessages(self, messages: Sequence[UserMessage]) -> None:
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
            self.tr("{0} fps · {1} shown").format(
                rate_text(camera), rate_text(painted) if painted < 1 else f"{painted:.0f}"
            ),
        )

    def setBandwidth(self, bytes_per_second: float) -> None:
        """Show the payload per second."""
        self._show(self.bandwidthLabel, localized(f"{bytes_per_second / 1e6:.1f} MB/s"))

    def setLosses(self, text: str, tone: Tone, detail: str) -> None:
        """Show the losses, their severity, and every counter in the tooltip."""
        self._show(self.lossLabel, text)
        set_tooltip(self.lossLabel, detail)
        restyle(self.lossLabel, "tone", tone.value)

    def setClipping(self, text: str) -> None:
        """Show how much of the frame is saturated and black; if empty, about how much is saturated."""
        self._measured = text
        self._show_clipping()

    def setSaturated(self, share: float | None) -> None:
        """Show about how much of the frame is saturated if that is not measured; None if unknown."""
        self._saturated = share
        self._show_clipping()

    def _show_clipping(self) -> None:
        share = self._saturated or 0.0
        about = self.tr("Clipping") if self._saturated is not None else ""
        if share >= LEAST_SHARE:
            digits = 0 if share >= LARGE_SHARE else 1
            about = localized(self.tr("{0} saturated").format(f"{share:.{digits}%}"))
        self._show(self.clippingButton, self._measured or about)
        restyle(self.clippingButton, "tone", "busy" if share >= NOTABLE_SHARE else "idle")

    def setZoom(self, zoom: float, fitted: bool) -> None:
        """Show the screen pixels for one of the frame; 0 is no image."""
        text = f"{zoom:.0%}" + (self.tr(" · fitted") if fitted else "")
        self._show(self.zoomLabel, text if zoom else "")

    def addZoomActions(self, actions: Sequence[QAction]) -> None:
        """Add a button for each of these actions beside the zoom."""
        for action in actions:
            button = QToolButton(self.zoomBox)
            button.setDefaultAction(action)
            button.setAutoRaise(True)
            button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            self.zoomLayout.addWidget(button)

    def clearFigures(self) -> None:
        """Show that nothing streams."""
        self.clippingButton.setMinimumWidth(0)
        self.setSaturated(None)
        for label in self._figures:
            label.clear()
            label.setMinimumWidth(0)

    def _show(self, label: QLabel | QToolButton, text: str) -> None:
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
        room = self.width() - margins.left() - margins.right() - LEAST_TITLE
        for part in (self.stateLabel, self.zoomBox):
            room -= part.sizeHint().width() + gap
        self.zoomBox.setVisible(room >= 0)
        room -= least - LEAST_TITLE
        for part in self._by_importance:
            empty = not part.text()
            room -= 0 if empty else part.sizeHint().width() + gap
            part.setVisible(room >= 0 and not empty)
