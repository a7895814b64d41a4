"""The status strip, and the states of a servo loop in a row."""

from __future__ import annotations

from collections.abc import Sequence

from PyQt5.QtCore import QPointF, QRectF, QSize, Qt
from PyQt5.QtGui import QColor, QFontMetricsF, QPainter, QPaintEvent, QPalette, QPen, QResizeEvent
from PyQt5.QtWidgets import QLabel, QSizePolicy, QWidget

from grabbergui.models.language import localized
from grabbergui.models.messages import Message
from grabbergui.models.servoing import state_text
from grabbergui.models.status import Tone
from grabbergui.servo.overlay import colour_of
from grabbergui.servo.state_machine import State
from grabbergui.ui.loader import load_form
from grabbergui.ui.widgets.labels import ElidedLabel, restyle
from grabbergui.ui.widgets.message_stack import MessageLine

LEAST_TITLE = 60
"Pixels kept for the title before figures make way for it."
ROOM = 20
"Pixels above and below the text: buttons of messages stand there."
MOST_MESSAGE = 640
"Pixels of a message for which figures make way; what is longer is shown in full by its button."


class StatusStrip(QWidget):
    """Setters only. Figures keep their places while they change; the least make way for lack of room."""

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
        # With a message or without, so that nothing moves when one comes.
        self.setFixedHeight(self.fontMetrics().height() + ROOM)
        self.setMessages(())

    def minimumSizeHint(self) -> QSize:
        """The state alone."""
        return QSize(self.stateLabel.sizeHint().width(), self.height())

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Show as many figures as there is room for."""
        super().resizeEvent(event)
        self._fit()

    def setState(self, text: str, tone: Tone) -> None:
        """How the source is doing."""
        self.stateLabel.setText(f"● {text}")
        restyle(self.stateLabel, "tone", tone.value)

    def setTitle(self, text: str) -> None:
        """The name of what is open; messages take its place."""
        self.titleLabel.setText(text)

    def setMessages(self, messages: Sequence[Message]) -> None:
        """Show the first of these in place of the title."""
        self.messages.setMessages(messages)
        self.messages.setVisible(bool(messages))
        self.titleLabel.setVisible(not messages)
        self._fit()

    def setFormat(self, text: str) -> None:
        """Resolution and pixel format."""
        self._show(self.formatLabel, text)

    def setRates(self, camera: float, painted: float) -> None:
        """Frames per second from the camera, and pictures painted."""
        self._show(
            self.rateLabel,
            localized(self.tr("{0:.1f} fps · {1:.0f} shown").format(camera, painted)),
        )

    def setBandwidth(self, bytes_per_second: float) -> None:
        """Payload per second."""
        self._show(self.bandwidthLabel, localized(f"{bytes_per_second / 1e6:.1f} MB/s"))

    def setLosses(self, text: str, tone: Tone, detail: str) -> None:
        """What was lost, how bad that is, and every counter for the tooltip."""
        self._show(self.lossLabel, text)
        self.lossLabel.setToolTip(detail)
        restyle(self.lossLabel, "tone", tone.value)

    def clearFigures(self) -> None:
        """Nothing streams."""
        for label in self._figures:
            label.clear()
            label.setMinimumWidth(0)

    def _show(self, label: QLabel, text: str) -> None:
        """Never narrower than before, so that one more digit does not push its neighbours to and fro."""
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


_WAY = (State.SEARCHING, State.CENTRING, State.WAITING, State.APPROACHING, State.REACHED)
"From one to the next when all goes well."
_APART = (State.STUCK, State.LOST, State.STOPPED)
"From anywhere."
_GAP, _ARROW, _PADDING = 6.0, 16.0, 11.0


class StateStrip(QWidget):
    """One setter."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self._state: State | None = None

    @property
    def state(self) -> State | None:
        """What is lit."""
        return self._state

    def setState(self, state: State) -> None:
        """Light one."""
        if state is not self._state:
            self._state = state
            self.setAccessibleName(state_text(state))
            self.update()

    def sizeHint(self) -> QSize:
        """All of them in a row."""
        return QSize(round(self._places()[-1][1].right()) + 2, self.fontMetrics().height() + 12)

    def minimumSizeHint(self) -> QSize:
        """None is ever left out."""
        return self.sizeHint()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Draw them."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        line = self.palette().color(QPalette.ColorRole.Mid)
        muted = self.palette().color(QPalette.ColorRole.PlaceholderText)
        places = self._places()
        for index, (state, place) in enumerate(places):
            lit = state is self._state
            colour = QColor(*colour_of(state))
            painter.setPen(QPen(colour if lit else line, 1.2))
            painter.setBrush(colour if lit else Qt.GlobalColor.transparent)
            radius = place.height() / 2
            painter.drawRoundedRect(place, radius, radius)
            painter.setPen(_text_on(colour) if lit else muted)
            painter.drawText(place, Qt.AlignmentFlag.AlignCenter, self._name(state))
            if index and state in _WAY:
                self._arrow(
                    painter, QPointF(places[index - 1][1].right(), place.center().y()), place.left(), muted
                )
        painter.end()

    def _name(self, state: State) -> str:
        """Short enough for a row of seven."""
        return self.tr("waiting") if state is State.WAITING else state_text(state)

    def _places(self) -> list[tuple[State, QRectF]]:
        metrics = QFontMetricsF(self.font())
        height, x = metrics.height() + 8, 1.0
        places = []
        for state in (*_WAY, *_APART):
            width = metrics.horizontalAdvance(self._name(state)) + 2 * _PADDING
            places.append((state, QRectF(x, 2.0, width, height)))
            x += width + (_ARROW if state in _WAY[:-1] else _GAP)
            x += 3 * _GAP if state is _WAY[-1] else 0.0
        return places

    @staticmethod
    def _arrow(painter: QPainter, start: QPointF, end: float, colour: QColor) -> None:
        painter.setPen(QPen(colour, 1.2))
        tip = QPointF(end - 3, start.y())
        painter.drawLine(QPointF(start.x() + 3, start.y()), tip)
        for side in (-3, 3):
            painter.drawLine(tip, QPointF(tip.x() - 3, tip.y() + side))


def _text_on(colour: QColor) -> QColor:
    """Black or white, whichever is read better on a colour."""
    luminance = 0.299 * colour.red() + 0.587 * colour.green() + 0.114 * colour.blue()
    return QColor("black") if luminance > 120 else QColor("white")
