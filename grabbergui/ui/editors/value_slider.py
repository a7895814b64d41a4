"""A slider over the part of a feature's range around its value."""

from __future__ import annotations

from dataclasses import replace

from PyQt5.QtCore import QPointF, QRect, QSignalBlocker, Qt, QTimer, pyqtSignal
from PyQt5.QtGui import (
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QPolygonF,
    QResizeEvent,
    QWheelEvent,
)
from PyQt5.QtWidgets import QSlider, QStyle, QStyleOptionSlider, QWidget

from grabbergui.core.features import Feature
from grabbergui.models.features.number_steps import StepSize, stepped
from grabbergui.models.features.number_text import quantity_text
from grabbergui.models.features.slider_scale import SliderScale
from grabbergui.ui.keys import WheelGuard
from grabbergui.ui.shown_text import set_tooltip

SCROLL_MS = 40
"Between two steps of the range under a handle that is held beyond the end of the track."
SCROLL_STEPS = 2
"Steps of an arrow key that it moves by then."
NOTCH = 120
"`QWheelEvent.angleDelta` of one click of a mouse wheel."

_STEPS_OF_KEYS = {
    Qt.Key.Key_Left: -1,
    Qt.Key.Key_Down: -1,
    Qt.Key.Key_Right: 1,
    Qt.Key.Key_Up: 1,
    Qt.Key.Key_PageDown: -10,
    Qt.Key.Key_PageUp: 10,
}


class EditedFeature:
    """A number feature with the number that the user gave it last.

    The two are joined only when asked for: until the write has left, every call delays it.
    """

    def __init__(self) -> None:
        self.number: int | float | None = None
        "The user's number, or else the camera's; None without either."
        self._feature: Feature | None = None

    def show(self, feature: Feature) -> None:
        """Forget the user's number: this is what the camera has."""
        self._feature = feature
        self.number = feature.value if isinstance(feature.value, int | float) else None

    @property
    def feature(self) -> Feature | None:
        """The feature with that number; None before `show`."""
        feature, number = self._feature, self.number
        if feature is not None and number is not None and number != feature.value:
            feature = self._feature = replace(feature, value=number)
        return feature


class ValueSlider(QSlider):
    """Moves a number by mouse, wheel and arrow keys: with Shift by a tenth, with Ctrl ten times as far.

    Of a range of many decades the track shows the part around the number in which every pixel is a useful
    step; holding the handle beyond the end of the track moves that part. A click beside the handle moves it
    there.
    """

    valueEdited = pyqtSignal(object)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(Qt.Orientation.Horizontal, parent)
        self._edited = EditedFeature()
        self._whole: SliderScale | None = None
        self._scale: SliderScale | None = None
        "The part of `_whole` that the track shows."
        self._grip = QPointF()
        "Last position of the mouse."
        self._place = 0.0
        "Position of the dragged handle; beyond the track while the mouse is."
        self._notches = 0.0
        "Movement of a fine wheel that does not make a step yet."
        self._guard = WheelGuard(self)
        self._scrolling = QTimer(self)
        self._scrolling.setInterval(SCROLL_MS)
        self._scrolling.timeout.connect(self._scroll)
        self.sliderReleased.connect(self._on_slider_released)
        self.valueChanged.connect(self._on_value_changed)

    def show_feature(self, scale: SliderScale, feature: Feature) -> None:
        """Move to a feature's number without emitting; `scale` is of its whole range."""
        known = self._whole == scale
        self._edited.show(feature)
        self._whole = scale
        if not self.isSliderDown():
            self._show_part(keep=known)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Show as much of the range as there are pixels for."""
        super().resizeEvent(event)
        if not self.isSliderDown():
            self._show_part(keep=False)

    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        """Bring the handle under the mouse, then drag it."""
        if event is None or event.button() != Qt.MouseButton.LeftButton:
            return
        handle = self._handle()
        self.setSliderDown(True)
        if not handle.contains(event.pos()):
            x = event.pos().x() - handle.width() // 2
            self.setValue(QStyle.sliderValueFromPosition(self.minimum(), self.maximum(), x, self._pixels()))
        self._grip, self._place = event.localPos(), float(self.value())
        super().mousePressEvent(event)

    def mouseMoveEvent(self, event: QMouseEvent | None) -> None:
        """Move the handle as far as the mouse, a tenth as far with Shift, ten times with Ctrl."""
        if event is None or not self.isSliderDown():
            return
        moved = event.localPos().x() - self._grip.x()
        self._grip = event.localPos()
        self._place += moved * self.maximum() / self._pixels() * _pace(event.modifiers()).value
        self.setValue(round(min(max(self._place, self.minimum()), self.maximum())))
        beyond = not self.minimum() <= self._place <= self.maximum()
        if beyond and self._scale != self._whole:
            self._scrolling.start()
        else:
            self._scrolling.stop()

    def mouseReleaseEvent(self, event: QMouseEvent | None) -> None:
        """Release the handle where it is."""
        if event is not None and event.button() == Qt.MouseButton.LeftButton:
            self.setSliderDown(False)
            super().mouseReleaseEvent(event)

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        """Step the number."""
        if event is None:
            return
        delta = event.angleDelta()
        # With Alt, and with Shift on some systems, a wheel turns sideways.
        self._notches += (delta.y() or delta.x()) / NOTCH
        steps = int(self._notches)
        self._notches -= steps
        self._step(steps, _pace(event.modifiers()))
        event.accept()

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Step the number; Home and End are the ends of the whole range."""
        if event is None or self._whole is None:
            return
        if event.key() in _STEPS_OF_KEYS:
            self._step(_STEPS_OF_KEYS[Qt.Key(event.key())], _pace(event.modifiers()))
        elif event.key() == Qt.Key.Key_Home:
            self._edit(self._whole.minimum)
        elif event.key() == Qt.Key.Key_End:
            self._edit(self._whole.maximum)
        else:
            event.ignore()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Draw an arrow at each end of the track beyond which the range continues."""
        super().paintEvent(event)
        if self._scale is None or self._whole is None or self._scale == self._whole:
            return
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(self.palette().mid().color(), 1.5))
        middle = self.height() / 2
        if self._scale.minimum > self._whole.minimum:
            painter.drawPolyline(_arrow(1.0, middle, 3.0))
        if self._scale.maximum < self._whole.maximum:
            painter.drawPolyline(_arrow(self.width() - 1.0, middle, -3.0))
        painter.end()

    def _show_part(self, keep: bool) -> None:
        """Show the number; with `keep`, in the same part of the range as long as that contains it."""
        number, part = self._edited.number, self._scale
        if self._whole is None or number is None:
            return
        if part is None or not keep or not part.minimum < number < part.maximum:
            part = self._whole.around(number, self._pixels())
        with QSignalBlocker(self):
            if part != self._scale:
                self._scale = part
                self.setRange(0, part.steps)
                set_tooltip(self, self._reach(part))
                self.update()
            self.setValue(part.to_position(number))

    def _reach(self, part: SliderScale) -> str:
        """Describe the range of the track and how to leave it; empty if it shows the whole range."""
        feature = self._edited.feature
        if part == self._whole or feature is None:
            return ""
        unit = feature.unit
        text = self.tr("{0} … {1}; hold the handle beyond an end to move the range.")
        return text.format(quantity_text(part.minimum, unit, 3), quantity_text(part.maximum, unit, 3))

    def _scroll(self) -> None:
        """Move the range along under a handle that is held beyond the end of the track."""
        feature = self._edited.feature
        if feature is None or self._whole is None or self._scale is None:
            return
        up = self._place > 0
        number = stepped(feature, SCROLL_STEPS if up else -SCROLL_STEPS)
        self._scale = self._whole.around(number, self._pixels(), 1.0 if up else 0.0)
        self._take(number)
        self.update()

    def _on_slider_released(self) -> None:
        self._scrolling.stop()
        self._show_part(keep=True)

    def _step(self, steps: int, pace: StepSize) -> None:
        feature = self._edited.feature
        if steps and feature is not None and self.isEnabled():
            self._edit(stepped(feature, steps, pace))

    def _edit(self, number: int | float) -> None:
        if number != self._edited.number:
            self._take(number)
            self._show_part(keep=True)

    def _take(self, number: int | float) -> None:
        if self._whole is not None and number != self._edited.number:
            self._edited.number = number
            self.valueEdited.emit(number)

    def _on_value_changed(self, position: int) -> None:
        if self._scale is not None:
            self._take(self._scale.to_value(position))

    def _pixels(self) -> int:
        """Return the number of positions of the handle."""
        return max(1, self.width() - self._handle().width())

    def _handle(self) -> QRect:
        option = QStyleOptionSlider()
        self.initStyleOption(option)
        style = self.style()
        assert style is not None
        return style.subControlRect(
            QStyle.ComplexControl.CC_Slider, option, QStyle.SubControl.SC_SliderHandle, self
        )


def _pace(modifiers: Qt.KeyboardModifiers | Qt.KeyboardModifier) -> StepSize:
    if modifiers & Qt.KeyboardModifier.ShiftModifier:
        return StepSize.FINE
    return StepSize.COARSE if modifiers & Qt.KeyboardModifier.ControlModifier else StepSize.USUAL


def _arrow(x: float, y: float, width: float) -> QPolygonF:
    """Return an arrow head with its tip at `x`, `width` pixels long."""
    return QPolygonF([QPointF(x + width, y - abs(width)), QPointF(x, y), QPointF(x + width, y + abs(width))])
