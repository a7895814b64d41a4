"""The base class of editors, and the editors of switches, commands, texts and coded numbers.

Event filters keep the mouse wheel and the window's shortcuts from editors.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable

from PyQt5.QtCore import QEvent, QObject, Qt, pyqtSignal
from PyQt5.QtGui import QKeyEvent, QKeySequence
from PyQt5.QtWidgets import QCheckBox, QHBoxLayout, QLabel, QLineEdit, QPushButton, QWidget

from grabbergui.core.features import Feature, FeatureKind, FeatureValue
from grabbergui.models.features.scale import nearest_allowed
from grabbergui.models.features.text import coded_text, parse_coded, value_text


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


class WheelGuard(QObject):
    """Lets the wheel reach its widget only while that has the focus; otherwise the panel scrolls."""

    def __init__(self, widget: QWidget) -> None:
        super().__init__(widget)
        widget.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        widget.installEventFilter(self)

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Ignore a wheel event without focus, so that the parent gets it."""
        if (
            event is not None
            and event.type() == QEvent.Type.Wheel
            and isinstance(watched, QWidget)
            and not watched.hasFocus()
        ):
            event.ignore()
            return True
        return False


_UNDO = (QKeySequence.StandardKey.Undo, QKeySequence.StandardKey.Redo)
_EDITING = (
    QKeySequence.StandardKey.Copy,
    QKeySequence.StandardKey.Cut,
    QKeySequence.StandardKey.Paste,
    QKeySequence.StandardKey.SelectAll,
)
_MOVING = (Qt.Key.Key_Left, Qt.Key.Key_Right, Qt.Key.Key_Home, Qt.Key.Key_End, Qt.Key.Key_Up, Qt.Key.Key_Down,
           Qt.Key.Key_Backspace, Qt.Key.Key_Delete)  # fmt: skip


class ShortcutGuard(QObject):
    """Keeps a line edit or spin box from taking the window's keys with Ctrl for itself.

    On X11 such a field clears itself on Ctrl+U and moves its cursor on Ctrl+E, and it takes Ctrl+Z even where
    nothing was typed. Here it keeps what belongs to editing text; undo and redo only while `typing`.
    """

    def __init__(self, field: QWidget, typing: Callable[[], bool]) -> None:
        super().__init__(field)
        self._typing = typing
        field.installEventFilter(self)

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Keep the window's keys from the field: the question whether it wants them, and the press itself."""
        if not isinstance(event, QKeyEvent) or not self._belongs_to_window(event):
            return False
        if event.type() not in (QEvent.Type.ShortcutOverride, QEvent.Type.KeyPress):
            return False
        event.ignore()
        return True

    def _belongs_to_window(self, event: QKeyEvent) -> bool:
        if any(event.matches(key) for key in _UNDO):
            return not self._typing()
        if not event.modifiers() & Qt.KeyboardModifier.ControlModifier:
            return False
        return event.key() not in _MOVING and not any(event.matches(key) for key in _EDITING)
