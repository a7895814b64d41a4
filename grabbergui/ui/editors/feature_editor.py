"""The base class of editors; those of switches, commands, texts and choices; an automatic mode's button."""

from __future__ import annotations

from abc import abstractmethod

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtGui import QKeyEvent
from PyQt5.QtWidgets import (
    QCheckBox,
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QWidget,
)

from grabbergui.core.features import (
    Feature,
    FeatureKind,
    FeatureValue,
    Representation,
    parse_coded,
)
from grabbergui.models.features.feature_text import limit_text, value_text
from grabbergui.models.features.slider_scale import nearest_allowed
from grabbergui.ui.keys import ShortcutGuard
from grabbergui.ui.shown_text import PlainLabel
from grabbergui.ui.widgets.hints import show_hint


class FeatureEditor(QWidget):
    """Shows a feature and lets it be edited. One subclass a kind of control.

    `setFeature` shows and never emits. The signals report what the user does, and nothing else.
    """

    valueEdited = pyqtSignal(object)
    """The value that the user chose (int, float, bool or str); None to run a command."""
    editingStarted = pyqtSignal()
    """The user began to drag the control or to type into it."""
    editingFinished = pyqtSignal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._layout = QHBoxLayout(self)
        self._layout.setContentsMargins(0, 0, 0, 0)
        self._layout.setSpacing(4)

    @abstractmethod
    def setFeature(self, feature: Feature) -> None:
        """Show a feature of this editor's kind."""

    def slider(self) -> QWidget | None:
        """Return a part that needs a whole line for itself; the row places it."""
        return None

    def hold(self, control: QWidget) -> None:
        """Make a control the editor's only one, which gets the focus."""
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
        """Show the state of the switch."""
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
    """Text that can be selected and copied, for a value that cannot be written."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.label = PlainLabel()
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
    """A line edit for a string; Enter or leaving takes the typed text, Escape discards it."""

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
        """Let Escape discard the typed text."""
        if event is not None and event.key() == Qt.Key.Key_Escape and self._typing:
            self._stop_typing()
            return
        super().keyPressEvent(event)

    def text_of(self, feature: Feature) -> str:
        """Return the text of the line."""
        return "" if feature.value is None else str(feature.value)

    def value_of(self, feature: Feature, text: str) -> FeatureValue:
        """Return the typed text as a value. Raises ValueError with the reason as display text."""
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
        except ValueError as error:
            show_hint(self.line, str(error))
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
        """Return the number in its representation."""
        return feature.text

    def value_of(self, feature: Feature, text: str) -> FeatureValue:
        """Return the nearest allowed integer."""
        try:
            number = parse_coded(text, feature.representation)
        except ValueError:
            if feature.representation is Representation.IPV4_ADDRESS:
                hint = self.tr("“{0}” is not an IPv4 address")
            elif feature.representation is Representation.MAC_ADDRESS:
                hint = self.tr("“{0}” is not a MAC address")
            else:
                hint = self.tr("“{0}” is not a number")
            raise ValueError(hint.format(text)) from None
        taken = nearest_allowed(feature, number)
        if why := limit_text(feature, number, taken):
            show_hint(self.line, why)
        return taken
