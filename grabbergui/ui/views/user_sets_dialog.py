"""The sets of settings that a camera keeps itself."""

from __future__ import annotations

from collections.abc import Sequence

from PyQt5.QtCore import Qt, pyqtBoundSignal, pyqtSignal
from PyQt5.QtWidgets import QDialog, QListWidget, QListWidgetItem, QMessageBox, QPushButton, QWidget

from grabbergui.models.settings.user_sets import UserSet
from grabbergui.ui.loader import load_form

_SET_ROLE = Qt.ItemDataRole.UserRole


class UserSetsDialog(QDialog):
    """Setters for the sets; signals, with a set's name, for what is to be done with it."""

    loadRequested = pyqtSignal(str)
    saveRequested = pyqtSignal(str)
    startRequested = pyqtSignal(str)

    setList: QListWidget
    loadButton: QPushButton
    saveButton: QPushButton
    startButton: QPushButton
    closeButton: QPushButton

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("user_sets_dialog", self)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setList.currentRowChanged.connect(self._enable)
        self.setList.itemDoubleClicked.connect(lambda _: self.loadButton.click())
        self.loadButton.clicked.connect(lambda: self._tell(self.loadRequested))
        self.saveButton.clicked.connect(self._ask_save)
        self.question: QMessageBox | None = None
        """Whether to overwrite a set, while it is asked."""
        self.startButton.clicked.connect(lambda: self._tell(self.startRequested))
        self.closeButton.clicked.connect(self.reject)
        self._enable()

    @property
    def chosen(self) -> UserSet | None:
        """The set that is selected."""
        item = self.setList.currentItem()
        return item.data(_SET_ROLE) if item is not None else None

    def setSets(self, sets: Sequence[UserSet]) -> None:
        """Show these; the one that was selected stays selected."""
        before = self.chosen
        self.setList.clear()
        for user_set in sets:
            text = user_set.title
            if user_set.starts:
                text = self.tr("{0}  ·  the camera starts with it").format(text)
            item = QListWidgetItem(text, self.setList)
            item.setData(_SET_ROLE, user_set)
            item.setToolTip(user_set.tooltip)
        names = [user_set.name for user_set in sets]
        self.setList.setCurrentRow(names.index(before.name) if before and before.name in names else 0)

    def _ask_save(self) -> None:
        if (chosen := self.chosen) is None:
            return
        self.question = box = QMessageBox(self)
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.setIcon(QMessageBox.Icon.Question)
        box.setText(self.tr("Save the present settings in {0}?").format(chosen.title))
        box.setInformativeText(self.tr("What it held is lost; that cannot be undone."))
        save = box.addButton(self.tr("Overwrite"), QMessageBox.ButtonRole.DestructiveRole)
        box.setDefaultButton(box.addButton(QMessageBox.StandardButton.Cancel))
        box.finished.connect(lambda _: self._on_question_finished(box.clickedButton() is save, chosen.name))
        box.open()

    def _on_question_finished(self, agreed: bool, name: str) -> None:
        self.question = None
        if agreed:
            self.saveRequested.emit(name)

    def _tell(self, signal: pyqtBoundSignal) -> None:
        if (chosen := self.chosen) is not None:
            signal.emit(chosen.name)

    def _enable(self, _: int = 0) -> None:
        chosen = self.chosen
        self.loadButton.setEnabled(chosen is not None)
        self.saveButton.setEnabled(chosen is not None and chosen.savable)
        self.startButton.setEnabled(chosen is not None and chosen.startable and not chosen.starts)
