"""An editor for enumerations."""

from __future__ import annotations

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtGui import QStandardItem, QStandardItemModel
from PyQt5.QtWidgets import QComboBox, QCompleter, QWidget

from grabbergui.core.features import EnumEntry, Feature
from grabbergui.models.features.text import value_text
from grabbergui.ui.editors.feature_editor import FeatureEditor
from grabbergui.ui.editors.shortcut_guard import ShortcutGuard
from grabbergui.ui.editors.wheel_guard import WheelGuard

LONG = 12
"""Lists with more entries can be searched."""


class _Combo(QComboBox):
    """A combo box that says when its list opens and closes; a long list is searched by typing into it."""

    popupShown = pyqtSignal()
    popupHidden = pyqtSignal()

    def showPopup(self) -> None:
        self.popupShown.emit()
        super().showPopup()

    def hidePopup(self) -> None:
        super().hidePopup()
        self.popupHidden.emit()

    def showEntries(self, model: QStandardItemModel) -> None:
        """Offer other entries."""
        self.setModel(model)
        searched = model.rowCount() > LONG
        if searched and not self.isEditable():
            self._become_searchable()
        elif not searched:
            self.setEditable(False)
        if (completer := self.completer()) is not None:
            completer.setModel(model)

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
        """Enter takes the entry that is meant, where no other one has what was typed in its name."""
        typed, model = self.currentText().casefold(), self.model()
        texts = [self.itemText(index).casefold() for index in range(self.count())]
        found = [index for index, text in enumerate(texts) if typed and typed in text]
        enabled = len(found) == 1 and model is not None and model.flags(model.index(found[0], 0))
        if enabled and enabled & Qt.ItemFlag.ItemIsEnabled and found[0] != self.currentIndex():
            self.setCurrentIndex(found[0])
            self.activated[int].emit(found[0])

    def _show_chosen(self) -> None:
        """What was typed is no entry: show the one that is set."""
        self.setEditText(self.itemText(self.currentIndex()))


class ChoiceEditor(FeatureEditor):
    """A combo box; entries that the camera does not take at the moment are grey."""

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
        """Show the entry that is set."""
        self.combo.setAccessibleName(feature.title)
        if feature.entries != self._entries:
            self._entries = feature.entries
            self.combo.showEntries(self._model())
        names = [entry.name for entry in self._entries]
        index = names.index(feature.value) if feature.value in names else -1
        self.combo.setCurrentIndex(index)
        self.combo.setPlaceholderText(value_text(feature) if index < 0 else "")

    def _model(self) -> QStandardItemModel:
        model = QStandardItemModel(self.combo)
        for entry in self._entries:
            item = QStandardItem(entry.display_name or entry.name)
            item.setToolTip(entry.tooltip)
            item.setEnabled(entry.available)
            model.appendRow(item)
        return model

    def _on_combo_activated(self, index: int) -> None:
        self.valueEdited.emit(self._entries[index].name)
