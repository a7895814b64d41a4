"""Editors for integers and fractions."""

from __future__ import annotations

from dataclasses import replace

from PyQt5.QtWidgets import QWidget

from grabbergui.core.features import Feature
from grabbergui.models.features.scale import SliderScale
from grabbergui.ui.editors.feature_editor import FeatureEditor
from grabbergui.ui.editors.number_field import NumberField
from grabbergui.ui.editors.value_slider import ValueSlider


class NumberEditor(FeatureEditor):
    """A spin box, for ranges too large for a slider."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.field = NumberField()
        self.hold(self.field)
        self.field.valueEdited.connect(self.valueEdited)
        self.field.typingStarted.connect(self.editingStarted)
        self.field.typingFinished.connect(self.editingFinished)

    def setFeature(self, feature: Feature) -> None:
        """Show the number."""
        self.field.setAccessibleName(feature.title)
        self.field.setFeature(feature)


class RangeEditor(NumberEditor):
    """A spin box with a slider over the real range; each follows the other while a person moves it.

    What pauses the stream is emitted once the slider is released, and not on the way there.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._feature: Feature | None = None
        self._waiting: int | float | None = None
        "A number on the slider that is not emitted yet."
        self._slider = ValueSlider(self)
        self._slider.sliderPressed.connect(self.editingStarted)
        self._slider.sliderReleased.connect(self._on_slider_released)
        self._slider.valueEdited.connect(self._on_slider_value_edited)
        self.field.valueEdited.connect(self._on_field_value_edited)

    def slider(self) -> ValueSlider:
        """The slider, for a line of its own."""
        return self._slider

    def setFeature(self, feature: Feature) -> None:
        """Show the number in both; a slider in somebody's hand stays."""
        self._feature = feature
        self._slider.setAccessibleName(feature.title)
        if self._slider.isSliderDown():
            return
        super().setFeature(feature)
        scale = SliderScale.of(feature)
        if scale is not None and isinstance(feature.value, int | float):
            self._slider.show_feature(scale, feature)

    def _on_slider_value_edited(self, number: int | float) -> None:
        assert self._feature is not None
        self._feature = replace(self._feature, value=number)
        if self._feature.pauses_stream and self._slider.isSliderDown():
            self._waiting = number
        else:
            self.valueEdited.emit(number)  # first, as the camera takes longer than the field
        self.field.setFeature(self._feature)

    def _on_slider_released(self) -> None:
        if (number := self._waiting) is not None:
            self._waiting = None
            self.valueEdited.emit(number)
        self.editingFinished.emit()

    def _on_field_value_edited(self, number: int | float) -> None:
        assert self._feature is not None
        self.setFeature(replace(self._feature, value=number))
