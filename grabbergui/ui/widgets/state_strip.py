"""The states of the servo loop in the order in which they are gone through, the present one lit."""

from __future__ import annotations

from PyQt5.QtCore import QPointF, QRectF, QSize, Qt
from PyQt5.QtGui import QColor, QFontMetricsF, QPainter, QPaintEvent, QPalette, QPen
from PyQt5.QtWidgets import QSizePolicy, QWidget

from grabbergui.models.servoing import state_text
from grabbergui.servo.overlay import colour_of
from grabbergui.servo.state_machine import State

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
