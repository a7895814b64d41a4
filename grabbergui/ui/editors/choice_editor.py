"""The editor of choices: a list, which for many entries is searched by typing."""

from __future__ import annotations

from PyQt5.QtCore import QEvent, QObject, Qt, pyqtSignal
from PyQt5.QtGui import QKeyEvent, QMouseEvent, QStandardItem, QStandardItemModel
from PyQt5.QtWidgets import (
    QAbstractItemView,
    QComboBox,
    QCompleter,
    QWidget,
)

from grabbergui.core.features import (
    EnumEntry,
    Feature,
)
from grabbergui.models.features.feature_text import value_text
from grabbergui.models.unavailable import Unavailable
from grabbergui.ui.editors.feature_editor import FeatureEditor
from grabbergui.ui.keys import ShortcutGuard, WheelGuard
from grabbergui.ui.shown_text import set_tooltip
from grabbergui.ui.widgets.labels import ElidedComboBox

LONG_LIST = 12
"""Lists with more entries can be searched."""
_WIDEST_LIST = 480
"Pixels beyond which the names in an open list are elided."


MOST_VISIBLE = 15
"Entries of an open searchable list that are seen at once."
_CHOOSING = (Qt.Key.Key_Up, Qt.Key.Key_Down, Qt.Key.Key_PageUp, Qt.Key.Key_PageDown)


class _Combo(ElidedComboBox):
    """A combo box with signals for its list opening and closing; typing filters a long list.

    A long list writes nothing that was not chosen in it: a click or key opens it, with the text selected, so
    that typing replaces the text.
    """

    popupShown = pyqtSignal()
    popupHidden = pyqtSignal()

    def showPopup(self) -> None:
        if self.isEditable():
            self._show_all()
            return
        self.popupShown.emit()
        self._widen(self.view())
        super().showPopup()

    def hidePopup(self) -> None:
        completer = self.completer()
        if self.isEditable() and completer is not None and (popup := completer.popup()) is not None:
            popup.hide()
            return
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
        completer.setMaxVisibleItems(MOST_VISIBLE)
        self.setCompleter(completer)
        line, popup = self.lineEdit(), completer.popup()
        assert line is not None and popup is not None
        ShortcutGuard(line, line.isModified)
        line.setAccessibleName(self.accessibleName())
        line.returnPressed.connect(self._take_only_match)
        line.editingFinished.connect(self._show_chosen)
        line.installEventFilter(self)
        popup.installEventFilter(self)

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Open the list by a click on the text, and report that it opens and closes."""
        kind = event.type() if event is not None else None
        completer = self.completer()
        if watched is self.lineEdit() and isinstance(event, QMouseEvent) and self.isEnabled():
            if kind == QEvent.Type.MouseButtonPress and event.button() == Qt.MouseButton.LeftButton:
                self.showPopup()
                return True
        elif completer is not None and watched is completer.popup():
            if kind == QEvent.Type.Show:
                self.popupShown.emit()
            elif kind == QEvent.Type.Hide:
                self.popupHidden.emit()
        return super().eventFilter(watched, event)

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Open a long list by the keys that would choose the entry beside the present one."""
        if event is not None and event.key() in _CHOOSING and self.isEditable():
            self.showPopup()
            return
        super().keyPressEvent(event)

    def _show_all(self) -> None:
        """Open the searchable list with all entries, the present one marked; typing replaces its text."""
        line, completer = self.lineEdit(), self.completer()
        assert line is not None and completer is not None
        line.setFocus(Qt.FocusReason.MouseFocusReason)
        completer.setCompletionPrefix("")
        popup = completer.popup()
        assert popup is not None
        self._widen(popup)
        completer.complete()
        if (found := completer.completionModel()) is not None:
            popup.setCurrentIndex(found.index(self.currentIndex(), 0))
        line.selectAll()  # last, as the completer writes the marked entry there

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
        self._chosen: object = None
        "The entry that the camera has, or was asked to take."
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
        self._chosen = feature.value
        if feature.entries != self._entries:
            self._entries = feature.entries
            self.combo.showEntries(self._model())
        names = [entry.name for entry in self._entries]
        index = names.index(feature.value) if feature.value in names else -1
        self.combo.setCurrentIndex(index)
        self.combo.showBeginning()
        self.combo.setPlaceholderText(value_text(feature) if index < 0 else "")

    def _model(self) -> QStandardItemModel:
        model, not_offered = QStandardItemModel(self.combo), Unavailable.OFFER.text
        for entry in self._entries:
            item = QStandardItem(entry.title)
            reason = "" if entry.available else not_offered
            set_tooltip(item, f"{entry.tooltip}\n{reason}".strip())
            item.setEnabled(entry.available)
            model.appendRow(item)
        return model

    def _on_combo_activated(self, index: int) -> None:
        name = self._entries[index].name
        if name != self._chosen:  # Enter reaches list and text
            self._chosen = name
            self.valueEdited.emit(name)
