"""An editor for enumerations."""

from __future__ import annotations

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtGui import QStandardItem, QStandardItemModel
from PyQt5.QtWidgets import QComboBox, QWidget

from grabbergui.core.features import EnumEntry, Feature
from grabbergui.models.features.wording import value_text
from grabbergui.ui.editors.feature_editor import FeatureEditor
from grabbergui.ui.editors.wheel_guard import WheelGuard


class _Combo(QComboBox):
    """A combo box that tells when its list opens and closes."""

    popupShown = pyqtSignal()
    popupHidden = pyqtSignal()

    def showPopup(self) -> None:
        self.popupShown.emit()
        super().showPopup()

    def hidePopup(self) -> None:
        super().hidePopup()
        self.popupHidden.emit()


class ChoiceEditor(FeatureEditor):
    """A combo box; entries that the camera does not take just now are grey."""

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
            self.combo.setModel(self._model())
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
