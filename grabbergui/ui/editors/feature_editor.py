"""The base class of editors; those of switches, commands, texts and choices; an automatic mode's button."""

from __future__ import annotations

from abc import abstractmethod

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtGui import QCursor, QKeyEvent, QStandardItem, QStandardItemModel
from PyQt5.QtWidgets import (
    QAbstractItemView,
    QAction,
    QActionGroup,
    QCheckBox,
    QComboBox,
    QCompleter,
    QHBoxLayout,
    QLineEdit,
    QMenu,
    QPushButton,
    QToolButton,
    QWidget,
)

from grabbergui.core.features import (
    EnumEntry,
    Feature,
    FeatureKind,
    FeatureValue,
    Representation,
    parse_coded,
)
from grabbergui.core.sfnc import AUTO_CONTINUOUS, AUTO_OFF, AUTO_ONCE
from grabbergui.models.features.feature_text import access_text, limit_text, value_text
from grabbergui.models.features.slider_scale import nearest_allowed
from grabbergui.models.open_source import Lack
from grabbergui.ui.shown_text import PlainLabel, set_tooltip
from grabbergui.ui.widgets.labels import ElidedComboBox, show_hint
from grabbergui.ui.windows import ShortcutGuard, WheelGuard, set_available


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


# -- choices -------------------------------------------------------------------------------------
LONG_LIST = 12
"""Lists with more entries can be searched."""
_WIDEST_LIST = 480
"Pixels beyond which the names in an open list are elided."


class _Combo(ElidedComboBox):
    """A combo box with signals for its list opening and closing; typing searches a long list."""

    popupShown = pyqtSignal()
    popupHidden = pyqtSignal()

    def showPopup(self) -> None:
        self.popupShown.emit()
        self._widen(self.view())
        super().showPopup()

    def hidePopup(self) -> None:
        super().hidePopup()
        self.popupHidden.emit()

    def showEntries(self, model: QStandardItemModel) -> None:
        """Replace the entries."""
        self.setModel(model)
        searched = model.rowCount() > LONG_LIST
        if searched and not self.isEditable():
            self._become_searchable()
        elif not searched:
            self.setEditable(False)
        if (completer := self.completer()) is not None:
            completer.setModel(model)

    def showBeginning(self) -> None:
        """Show the beginning of a searchable entry that is too long, not its end, unless it is edited."""
        line = self.lineEdit()
        if line is not None and not line.hasFocus():
            line.setCursorPosition(0)

    def _widen(self, entries: QAbstractItemView | None) -> None:
        """Let an open list be as wide as its names."""
        if entries is None:
            return
        bar = entries.verticalScrollBar()
        beside = 2 * entries.frameWidth() + (bar.sizeHint().width() if bar is not None else 0)
        entries.setMinimumWidth(min(entries.sizeHintForColumn(0) + beside, max(_WIDEST_LIST, self.width())))

    def _become_searchable(self) -> None:
        self.setEditable(True)
        self.setInsertPolicy(QComboBox.InsertPolicy.NoInsert)
        completer = QCompleter(self)
        completer.setFilterMode(Qt.MatchFlag.MatchContains)
        completer.setCaseSensitivity(Qt.CaseSensitivity.CaseInsensitive)
        self.setCompleter(completer)
        line = self.lineEdit()
        assert line is not None
        ShortcutGuard(line, line.isModified)
        line.setAccessibleName(self.accessibleName())
        line.returnPressed.connect(self._take_only_match)
        line.editingFinished.connect(self._show_chosen)

    def _take_only_match(self) -> None:
        """Choose the entry whose name contains the typed text, if there is only one."""
        typed, model = self.currentText().casefold(), self.model()
        texts = [self.itemText(index).casefold() for index in range(self.count())]
        found = [index for index, text in enumerate(texts) if typed and typed in text]
        enabled = len(found) == 1 and model is not None and model.flags(model.index(found[0], 0))
        if enabled and enabled & Qt.ItemFlag.ItemIsEnabled and found[0] != self.currentIndex():
            self.setCurrentIndex(found[0])
            self.activated[int].emit(found[0])

    def _show_chosen(self) -> None:
        """Show the current entry again: the typed text is no entry."""
        self.setEditText(self.itemText(self.currentIndex()))
        self.showBeginning()


class ChoiceEditor(FeatureEditor):
    """A combo box; entries that the camera does not accept now are grey."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._entries: tuple[EnumEntry, ...] = ()
        self.combo = _Combo()
        self.combo.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        self.combo.setMinimumContentsLength(6)
        self._guard = WheelGuard(self.combo)
        self.hold(self.combo)
        self.combo.activated[int].connect(self._on_combo_activated)
        self.combo.popupShown.connect(self.editingStarted)
        self.combo.popupHidden.connect(self.editingFinished)

    def setFeature(self, feature: Feature) -> None:
        """Show the current entry."""
        self.combo.setAccessibleName(feature.title)
        if feature.entries != self._entries:
            self._entries = feature.entries
            self.combo.showEntries(self._model())
        names = [entry.name for entry in self._entries]
        index = names.index(feature.value) if feature.value in names else -1
        self.combo.setCurrentIndex(index)
        self.combo.showBeginning()
        self.combo.setPlaceholderText(value_text(feature) if index < 0 else "")

    def _model(self) -> QStandardItemModel:
        model, not_offered = QStandardItemModel(self.combo), Lack.OFFER.text
        for entry in self._entries:
            item = QStandardItem(entry.title)
            reason = "" if entry.available else not_offered
            set_tooltip(item, f"{entry.tooltip}\n{reason}".strip())
            item.setEnabled(entry.available)
            model.appendRow(item)
        return model

    def _on_combo_activated(self, index: int) -> None:
        self.valueEdited.emit(self._entries[index].name)


# -- an automatic mode ---------------------------------------------------------------------------
class AutoButton(QToolButton):
    """Lit while the automatic mode is on. A click toggles it; its menu has every mode, Once included."""

    modeChosen = pyqtSignal(object)
    """The value for the automatic mode's feature."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._feature: Feature | None = None
        self._menu = QMenu(self)
        self._menu.setToolTipsVisible(True)
        self._group = QActionGroup(self)
        self._group.triggered.connect(lambda action: self.modeChosen.emit(action.data()))
        self.setCheckable(True)
        self.setText(self.tr("Auto"))
        self.clicked[bool].connect(self._on_clicked)
        self._menu.aboutToHide.connect(self._forget_mouse)

    def setFeature(self, feature: Feature) -> None:
        """Show the state of an automatic mode: an enumeration with Off, or a boolean."""
        entries_changed = self._feature is None or self._feature.entries != feature.entries
        self._feature = feature
        if entries_changed:
            self._fill_menu(feature)
        self.setChecked(feature.value not in (AUTO_OFF, False, None))
        self.setText(self.tr("Once") if feature.value == AUTO_ONCE else self.tr("Auto"))
        for action in self._group.actions():
            action.setChecked(action.data() == feature.value)
        self.setEnabled(feature.access.writable)
        self.setAccessibleName(feature.title)
        state = f"{feature.title}: {feature.value}"
        problem = self.tr("{0}\nIt {1}.").format(state, access_text(feature))
        set_tooltip(self, state if feature.access.writable else problem)

    def _fill_menu(self, feature: Feature) -> None:
        self._menu.clear()
        for action in self._group.actions():
            action.deleteLater()
            self._group.removeAction(action)
        for entry in feature.entries:
            action = QAction(entry.title, self._group)
            action.setData(entry.name)
            action.setCheckable(True)
            set_available(action, None if entry.available else Lack.OFFER)
        self._menu.addActions(self._group.actions())
        self.setMenu(self._menu if feature.entries else None)
        self.setPopupMode(
            QToolButton.ToolButtonPopupMode.MenuButtonPopup
            if feature.entries
            else QToolButton.ToolButtonPopupMode.DelayedPopup
        )

    def _forget_mouse(self) -> None:
        """End the hover state: Qt sends no leave event while the menu is open."""
        if not self.rect().contains(self.mapFromGlobal(QCursor.pos())):
            self.setAttribute(Qt.WidgetAttribute.WA_UnderMouse, False)
            self.update()

    def _on_clicked(self, checked: bool) -> None:
        feature = self._feature
        if feature is None:
            return
        # The camera's answer sets the state, not the click.
        self.setChecked(not checked)
        if feature.kind is FeatureKind.BOOLEAN:
            self.modeChosen.emit(checked)
        elif checked:
            names = [entry.name for entry in feature.entries if entry.available]
            modes = [
                name for name in (AUTO_CONTINUOUS, AUTO_ONCE, *names) if name in names and name != AUTO_OFF
            ]
            if modes:
                self.modeChosen.emit(modes[0])
        else:
            self.modeChosen.emit(AUTO_OFF)
