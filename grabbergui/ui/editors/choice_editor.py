"""Editors of a choice among entries: a list that can be searched, and the button of an automatic mode."""

from __future__ import annotations

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtGui import QCursor, QStandardItem, QStandardItemModel
from PyQt5.QtWidgets import QAction, QActionGroup, QComboBox, QCompleter, QMenu, QToolButton, QWidget

from grabbergui.core.features import EnumEntry, Feature, FeatureKind
from grabbergui.core.sfnc import AUTO_CONTINUOUS, AUTO_OFF, AUTO_ONCE
from grabbergui.models.features.text import access_text, value_text
from grabbergui.ui.editors.feature_editor import FeatureEditor, ShortcutGuard, WheelGuard
from grabbergui.ui.widgets.labels import ElidedComboBox

LONG = 12
"""Lists with more entries can be searched."""


class _Combo(ElidedComboBox):
    """A combo box with signals for its list opening and closing; typing searches a long list."""

    popupShown = pyqtSignal()
    popupHidden = pyqtSignal()

    def showPopup(self) -> None:
        self.popupShown.emit()
        super().showPopup()

    def hidePopup(self) -> None:
        super().hidePopup()
        self.popupHidden.emit()

    def showEntries(self, model: QStandardItemModel) -> None:
        """Replace the entries."""
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


class AutoButton(QToolButton):
    """Lit while the automatic mode is on. A click toggles it; its menu has every mode, Once included."""

    modeChosen = pyqtSignal(object)
    """The value for the automatic mode's feature."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._feature: Feature | None = None
        self._menu = QMenu(self)
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
        self.setToolTip(state if feature.access.writable else problem)

    def _fill_menu(self, feature: Feature) -> None:
        self._menu.clear()
        for action in self._group.actions():
            action.deleteLater()
            self._group.removeAction(action)
        for entry in feature.entries:
            action = QAction(entry.display_name or entry.name, self._group)
            action.setData(entry.name)
            action.setCheckable(True)
            action.setEnabled(entry.available)
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
