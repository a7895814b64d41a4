"""Editors that are typed into: strings and coded integers."""

from __future__ import annotations

from PyQt5.QtCore import Qt
from PyQt5.QtGui import QKeyEvent
from PyQt5.QtWidgets import QLineEdit, QWidget

from grabbergui.core.features import Feature, FeatureValue
from grabbergui.models.features.scale import nearest_allowed
from grabbergui.models.features.text import coded_text, parse_coded
from grabbergui.ui.editors.feature_editor import FeatureEditor
from grabbergui.ui.editors.shortcut_guard import ShortcutGuard


class TextEditor(FeatureEditor):
    """A line edit for a string; Enter or leaving takes what was typed, Escape gives it up."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._feature: Feature | None = None
        self._typing = False
        self.line = QLineEdit()
        self._guard = ShortcutGuard(self.line, lambda: self._typing)
        self.hold(self.line)
        self.line.textEdited.connect(self._on_line_text_edited)
        self.line.editingFinished.connect(self._on_line_editing_finished)

    def setFeature(self, feature: Feature) -> None:
        """Show the value; what is being typed stays."""
        self._feature = feature
        self.line.setAccessibleName(feature.title)
        if feature.maximum_length:
            self.line.setMaxLength(feature.maximum_length)
        if not self._typing:
            self._show()

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Escape gives up what was typed."""
        if event is not None and event.key() == Qt.Key.Key_Escape and self._typing:
            self._stop_typing()
            return
        super().keyPressEvent(event)

    def text_of(self, feature: Feature) -> str:
        """What the line shows."""
        return "" if feature.value is None else str(feature.value)

    def value_of(self, feature: Feature, text: str) -> FeatureValue:
        """What was typed, as a value. Raises ValueError."""
        return text

    def _show(self) -> None:
        assert self._feature is not None
        text = self.text_of(self._feature)
        if text != self.line.text():
            self.line.setText(text)
            self.line.setCursorPosition(0)

    def _on_line_text_edited(self, text: str) -> None:
        if not self._typing:
            self._typing = True
            self.editingStarted.emit()

    def _on_line_editing_finished(self) -> None:
        if not self._typing or self._feature is None:
            return
        try:
            value = self.value_of(self._feature, self.line.text())
        except ValueError:
            pass
        else:
            if value != self._feature.value:
                self.valueEdited.emit(value)
        self._stop_typing()

    def _stop_typing(self) -> None:
        self._typing = False
        self._show()
        self.editingFinished.emit()


class CodedNumberEditor(TextEditor):
    """A line edit for an integer that is a hexadecimal number, an IPv4 or a MAC address."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.line.setAlignment(Qt.AlignmentFlag.AlignRight)

    def text_of(self, feature: Feature) -> str:
        """The number in its representation."""
        return coded_text(feature.value, feature.representation) if isinstance(feature.value, int) else ""

    def value_of(self, feature: Feature, text: str) -> FeatureValue:
        """The nearest integer allowed."""
        return nearest_allowed(feature, parse_coded(text, feature.representation))
