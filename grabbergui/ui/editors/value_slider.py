"""A slider over a feature's range."""

from __future__ import annotations

from PyQt5.QtCore import QRect, QSignalBlocker, Qt, pyqtSignal
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtWidgets import QSlider, QStyle, QStyleOptionSlider, QWidget

from grabbergui.models.features.scale import SliderScale
from grabbergui.ui.editors.wheel_guard import WheelGuard


class ValueSlider(QSlider):
    """Positions that mean numbers, by a `SliderScale`. A click beside the handle takes it there."""

    valueEdited = pyqtSignal(object)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(Qt.Orientation.Horizontal, parent)
        self._scale: SliderScale | None = None
        self._guard = WheelGuard(self)
        self.valueChanged.connect(self._on_value_changed)

    def show_number(self, scale: SliderScale, number: int | float) -> None:
        """Move to a number without telling."""
        with QSignalBlocker(self):
            if scale != self._scale:
                self._scale = scale
                self.setRange(0, scale.steps)
                self.setSingleStep(max(1, scale.steps // 200))
                self.setPageStep(max(1, scale.steps // 10))
            self.setValue(scale.to_position(number))

    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        """Bring the handle under the mouse, then drag it."""
        if event is not None and event.button() == Qt.MouseButton.LeftButton:
            handle = self._handle()
            if not handle.contains(event.pos()):
                x = event.pos().x() - handle.width() // 2
                span = max(1, self.width() - handle.width())
                self.setSliderDown(True)
                self.setValue(QStyle.sliderValueFromPosition(self.minimum(), self.maximum(), x, span))
        super().mousePressEvent(event)

    def _handle(self) -> QRect:
        option = QStyleOptionSlider()
        self.initStyleOption(option)
        style = self.style()
        assert style is not None
        return style.subControlRect(
            QStyle.ComplexControl.CC_Slider, option, QStyle.SubControl.SC_SliderHandle, self
        )

    def _on_value_changed(self, position: int) -> None:
        if self._scale is not None:
            self.valueEdited.emit(self._scale.to_value(position))
