"""Editors of numbers: a field, with or without a slider."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from PyQt5.QtCore import QSize, Qt, QTimer, pyqtSignal
from PyQt5.QtGui import QFocusEvent, QKeyEvent, QKeySequence, QResizeEvent, QShowEvent, QValidator
from PyQt5.QtWidgets import QAbstractSpinBox, QApplication, QWidget

from grabbergui.core.features import Feature
from grabbergui.models.features.feature_text import limit_text
from grabbergui.models.features.number_input import (
    can_become_number,
    parse_number,
    typed_unit,
    units_to_type,
    without_shown_unit,
)
from grabbergui.models.features.number_steps import StepSize, stepped
from grabbergui.models.features.number_text import DIGITS, quantity_text, shown_unit
from grabbergui.models.features.slider_scale import SliderScale, nearest_allowed
from grabbergui.ui.editors.feature_editor import FeatureEditor
from grabbergui.ui.editors.value_slider import EditedFeature, ValueSlider
from grabbergui.ui.keys import ShortcutGuard, WheelGuard
from grabbergui.ui.widgets.hints import show_hint

SHOWN_DIGITS = 5
"""Significant digits of a fraction that are shown without the focus; with it, all."""
LEAST_DIGITS = 4
"""Significant digits of a fraction that are shown in any width."""

FOLLOWING_MS = 25
"""Delay of the shown text behind the user's hand: laying out text first would delay the write."""

LINE_EDIT_PADDING = 6
"""Pixels that a line edit keeps free beside its text."""


class DelayedDisplay(QTimer):
    """Shows an edited number a little later: after its write has left, not between the two."""

    def __init__(self, parent: QWidget, show: Callable[[], None]) -> None:
        super().__init__(parent)
        self.setSingleShot(True)
        self.setInterval(FOLLOWING_MS)
        self.timeout.connect(show)

    def begin(self) -> None:
        """Show it within FOLLOWING_MS, also while edits go on."""
        if not self.isActive():
            self.start()


class NumberField(QAbstractSpinBox):
    """Shows a number feature with its unit; arrows and wheel step it, Enter or leaving takes the number.

    A step is a tenth with Shift and ten times as far with Ctrl. QSpinBox ends at 32 bits and QDoubleSpinBox
    rounds what it holds to what it shows; here the number stays Python's. Only what a number can be may be
    typed; it is moved to the nearest number allowed. Escape and nonsense change nothing.
    """

    valueEdited = pyqtSignal(object)
    typingStarted = pyqtSignal()
    typingFinished = pyqtSignal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._edited = EditedFeature()
        self._typing = False
        self._shown_in = ""
        "The unit of the shown value, which may be larger than the feature's own."
        self._following = DelayedDisplay(self, self._show)
        self.setAlignment(Qt.AlignmentFlag.AlignRight)
        self.setAccelerated(True)
        self._wheel_guard = WheelGuard(self)
        line = self.lineEdit()
        assert line is not None
        self._line = line
        self._shortcut_guard = ShortcutGuard(self, lambda: self._typing)
        self._line.textEdited.connect(self._on_line_edit_text_edited)
        self.editingFinished.connect(self._take_typed)

    def setFeature(self, feature: Feature) -> None:
        """Show a number feature. A text that is being typed stays."""
        before = self._edited.feature
        if before is None or feature.name != before.name:
            self._shown_in = ""
        self._edited.show(feature)
        self._following.stop()
        self._show()

    def stepBy(self, steps: int) -> None:
        """Change the value by some steps immediately. With Ctrl, Qt passes ten times as many."""
        self._take_typed()
        feature = self._edited.feature
        if feature is not None and feature.access.writable:
            fine = QApplication.keyboardModifiers() & Qt.KeyboardModifier.ShiftModifier
            self._edit(stepped(feature, steps, StepSize.FINE if fine else StepSize.USUAL))
            self.selectAll()

    def stepEnabled(self) -> QAbstractSpinBox.StepEnabled:
        """Return the arrows that have an effect."""
        enabled = QAbstractSpinBox.StepEnabled(QAbstractSpinBox.StepEnabledFlag.StepNone)
        feature = self._edited.feature
        if feature is None or not isinstance(feature.value, int | float) or not feature.access.writable:
            return enabled
        if feature.maximum is None or feature.value < feature.maximum:
            enabled |= QAbstractSpinBox.StepEnabledFlag.StepUpEnabled
        if feature.minimum is None or feature.value > feature.minimum:
            enabled |= QAbstractSpinBox.StepEnabledFlag.StepDownEnabled
        return enabled

    def validate(self, text: str | None, position: int) -> tuple[QValidator.State, str, int]:
        """Accept a first key only if a number can begin so: other keys are the window's.

        Then every key is accepted, and the whole refused if it is no number: without its stroke 1/60 is 160.
        """
        feature, text = self._edited.feature, text or ""
        possible = self._typing or (
            feature is not None and can_become_number(text, feature.unit, self._shown_in)
        )
        return QValidator.State.Acceptable if possible else QValidator.State.Invalid, text, position

    def sizeHint(self) -> QSize:
        """Return room for twelve characters."""
        hint = super().sizeHint()
        return QSize(hint.width() + self.fontMetrics().horizontalAdvance("0" * 12), hint.height())

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Let Escape discard the typed text; only the number can be selected."""
        if event is not None and event.key() == Qt.Key.Key_Escape and self._typing:
            self._stop_typing()
            return
        if event is not None and event.matches(QKeySequence.StandardKey.SelectAll):
            self.selectAll()
            return
        super().keyPressEvent(event)

    def focusInEvent(self, event: QFocusEvent | None) -> None:
        """Show every digit, and select the number, so that typing replaces it."""
        super().focusInEvent(event)
        self._show()
        self.selectAll()

    def focusOutEvent(self, event: QFocusEvent | None) -> None:
        """Take what was typed, and show as many digits as one reads at a glance."""
        super().focusOutEvent(event)
        self._show()

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Show as many digits as there is room for."""
        super().resizeEvent(event)
        self._show()

    def showEvent(self, event: QShowEvent | None) -> None:
        """Show as many digits as there is room for."""
        super().showEvent(event)
        self._show()

    def selectAll(self) -> None:
        """Select the number without its unit."""
        self._line.setSelection(0, len(self.text().split(" ")[0]))

    def _show(self) -> None:
        if self._typing:
            return
        feature = self._edited.feature
        if feature is None or not isinstance(feature.value, int | float):
            text = ""
        else:
            self._shown_in = shown_unit(feature.value, feature.unit, self._shown_in)
            text = self._fitting(feature.value, feature.unit)
        if text != self._line.text():
            selected = self._line.hasSelectedText()
            self._line.setText(text)
            if selected:
                self.selectAll()
            # Twenty digits need the room of the arrows more than they need the arrows.
            symbols = QAbstractSpinBox.ButtonSymbols
            self.setButtonSymbols(symbols.UpDownArrows if len(text) < 14 else symbols.NoButtons)

    def _fitting(self, number: int | float, unit: str) -> str:
        """Return the number with its unit, and as many digits as there is room for."""
        room = self._line.width() - LINE_EDIT_PADDING
        text = ""
        for digits in range(DIGITS if self.hasFocus() else SHOWN_DIGITS, LEAST_DIGITS - 1, -1):
            text = quantity_text(number, unit, digits, self._shown_in)
            if not self.isVisible() or self.fontMetrics().horizontalAdvance(text) <= room:
                break
        return text

    def _edit(self, number: int | float) -> None:
        if number != self._edited.number:
            self._edited.number = number  # the next step begins there
            self.valueEdited.emit(number)
        self._following.begin()

    def _on_line_edit_text_edited(self, text: str) -> None:
        if not self._typing:
            self._typing = True
            self.typingStarted.emit()
        # "25m ms": the typed unit replaces the one that was shown.
        if (typed := without_shown_unit(text, self._shown_in)) != text:
            cursor = self._line.cursorPosition()
            self._line.setText(typed)
            self._line.setCursorPosition(cursor)

    def _take_typed(self) -> None:
        feature = self._edited.feature
        if not self._typing or feature is None:
            return
        try:
            typed = self._typed_number(feature)
            number = nearest_allowed(feature, typed)
        except (ValueError, OverflowError):
            units = ", ".join(units_to_type(feature.unit))
            hint = self.tr("“{0}” is not a number in {1}") if units else self.tr("“{0}” is not a number")
            show_hint(self, hint.format(self._line.text(), units))
            self._stop_typing()
        else:
            self._typing = False
            self._shown_in = typed_unit(self._line.text(), feature.unit) or self._shown_in
            why = limit_text(feature, typed, number)
            self._edit(number)
            self.typingFinished.emit()
            if why:
                show_hint(self, why)

    def _typed_number(self, feature: Feature) -> int | float:
        return parse_number(self._line.text(), feature, self._shown_in)

    def _stop_typing(self) -> None:
        self._typing = False
        self._show()
        self.typingFinished.emit()


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
    """A spin box with a slider over the feature's range; each follows the other while the user moves it.

    For a feature that pauses the stream only the value on release is emitted.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._feature: Feature | None = None
        self._waiting: int | float | None = None
        "A number on the slider that is not emitted yet."
        self._number: int | float = 0
        "The number that either was moved to last."
        self._following = DelayedDisplay(self, self._follow)
        self._slider = ValueSlider(self)
        self._slider.sliderPressed.connect(self.editingStarted)
        self._slider.sliderReleased.connect(self._on_slider_released)
        self._slider.valueEdited.connect(self._on_slider_value_edited)
        self.field.valueEdited.connect(self._follow_to)

    def slider(self) -> ValueSlider:
        """Return the slider, which needs a line of its own."""
        return self._slider

    def setFeature(self, feature: Feature) -> None:
        """Show the number in both; a slider that is being dragged stays."""
        self._feature = feature
        self._slider.setAccessibleName(feature.title)
        if self._slider.isSliderDown():
            return
        self._following.stop()
        super().setFeature(feature)
        self._show_on_slider(feature)

    def _show_on_slider(self, feature: Feature) -> None:
        scale = SliderScale.of(feature)
        if scale is not None and isinstance(feature.value, int | float):
            self._slider.show_feature(scale, feature)

    def _on_slider_value_edited(self, number: int | float) -> None:
        assert self._feature is not None
        if self._feature.pauses_stream and self._slider.isSliderDown():
            self._waiting = number
        else:
            self.valueEdited.emit(number)
        self._follow_to(number)

    def _on_slider_released(self) -> None:
        if (number := self._waiting) is not None:
            self._waiting = None
            self.valueEdited.emit(number)
        if self._following.isActive():
            self._following.stop()
            self._follow()
        self.editingFinished.emit()

    def _follow_to(self, number: int | float) -> None:
        self._number = number
        self._following.begin()

    def _follow(self) -> None:
        assert self._feature is not None
        shown = replace(self._feature, value=self._number)
        self.field.setFeature(shown)
        if not self._slider.isSliderDown():
            self._show_on_slider(shown)
