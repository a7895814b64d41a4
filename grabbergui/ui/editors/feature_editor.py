"""The base class of editors, and the editors of switches, commands, texts and coded numbers."""

from __future__ import annotations

from abc import abstractmethod

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtGui import QKeyEvent
from PyQt5.QtWidgets import QCheckBox, QHBoxLayout, QLabel, QLineEdit, QPushButton, QWidget

from grabbergui.core.features import Feature, FeatureKind, FeatureValue
from grabbergui.models.features.scale import nearest_allowed
from grabbergui.models.features.text import coded_text, parse_coded, value_text
from grabbergui.ui.editors.guards import ShortcutGuard


class FeatureEditor(QWidget):
    """Shows a feature and lets it be edited. One subclass a kind of control.

    `setFeature` shows and never emits. The signals report what the user does, and nothing else.
    """

    valueEdited = pyqtSignal(object)
    """The value a person wants (int, float, bool or str); None to run a command."""
    editingStarted = pyqtSignal()
    """A person has the control in hand: it is dragged or typed into."""
    editingFinished = pyqtSignal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._layout = QHBoxLayout(self)
        self._layout.setContentsMargins(0, 0, 0, 0)
        self._layout.setSpacing(4)

    @abstractmethod
    def setFeature(self, feature: Feature) -> None:
        """Show a feature of the kind this editor is for."""

    def slider(self) -> QWidget | None:
        """A part that wants a line of its own, as wide as it gets; the row places it."""
        return None

    def hold(self, control: QWidget) -> None:
        """Make a control the editor's, with the focus going to it."""
        self._layout.addWidget(control)
        self.setFocusProxy(control)


class SwitchEditor(FeatureEditor):
    """A check box, for booleans and for integers that are one."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._integer = False
        self.box = QCheckBox()
        self.hold(self.box)
        self._layout.addStretch()
        self.box.clicked[bool].connect(self._on_box_clicked)

    def setFeature(self, feature: Feature) -> None:
        """Show whether it is on."""
        self._integer = feature.kind is FeatureKind.INTEGER
        self.box.setAccessibleName(feature.title)
        self.box.setChecked(bool(feature.value))

    def _on_box_clicked(self, checked: bool) -> None:
        self.valueEdited.emit(int(checked) if self._integer else checked)


class CommandEditor(FeatureEditor):
    """A button that runs a command."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.button = QPushButton(self.tr("Run"))
        self.hold(self.button)
        self.button.clicked.connect(lambda: self.valueEdited.emit(None))

    def setFeature(self, feature: Feature) -> None:
        """Name the button."""
        self.button.setAccessibleName(feature.title)


class ReadingLabel(FeatureEditor):
    """Text that can be selected and copied, for what cannot be written."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.label = QLabel()
        self.label.setTextFormat(Qt.TextFormat.PlainText)
        self.label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.label.setMargin(3)
        self.hold(self.label)

    def setFeature(self, feature: Feature) -> None:
        """Show the value and its unit."""
        self.label.setAccessibleName(feature.title)
        text = feature.kind in (FeatureKind.STRING, FeatureKind.ENUMERATION) or feature.value is None
        side = Qt.AlignmentFlag.AlignLeft if text else Qt.AlignmentFlag.AlignRight
        self.label.setWordWrap(text)  # a number and its unit stay together
        self.label.setAlignment(Qt.Alignment(side) | Qt.AlignmentFlag.AlignVCenter)
        self.label.setText(value_text(feature))


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
        """Show the value. A text that is being typed stays."""
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
        """The text of the line."""
        return "" if feature.value is None else str(feature.value)

    def value_of(self, feature: Feature, text: str) -> FeatureValue:
        """The typed text as a value. Raises ValueError."""
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
