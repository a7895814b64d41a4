"""The dialog of the camera's user sets."""

from __future__ import annotations

from collections.abc import Sequence

from PyQt5.QtCore import Qt, pyqtBoundSignal, pyqtSignal
from PyQt5.QtWidgets import (
    QDialog,
    QListWidget,
    QListWidgetItem,
    QMessageBox,
    QPushButton,
    QWidget,
)

from grabbergui.models.settings.user_sets import UserSet
from grabbergui.models.unavailable import Unavailable
from grabbergui.ui.actions import set_available
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.shown_text import question_box, set_tooltip

_SET_ROLE = Qt.ItemDataRole.UserRole


class UserSetsDialog(QDialog):
    """Setters for the sets; signals, with a set's name, for the requested actions."""

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
        self.loadButton.clicked.connect(lambda: self._emit_for_chosen(self.loadRequested))
        self.saveButton.clicked.connect(self._ask_save)
        self.question: QMessageBox | None = None
        """The question whether to overwrite a set, while it is open."""
        self.startButton.clicked.connect(lambda: self._emit_for_chosen(self.startRequested))
        self.closeButton.clicked.connect(self.reject)
        self._enable()

    @property
    def chosen(self) -> UserSet | None:
        """The set that is selected."""
        item = self.setList.currentItem()
        return item.data(_SET_ROLE) if item is not None else None

    def setSets(self, sets: Sequence[UserSet]) -> None:
        """Show these sets, and keep the selection."""
        before = self.chosen
        self.setList.clear()
        for user_set in sets:
            text = user_set.title
            if user_set.starts:
                text = self.tr("{0}  ·  the camera starts with it").format(text)
            item = QListWidgetItem(text, self.setList)
            item.setData(_SET_ROLE, user_set)
            set_tooltip(item, user_set.tooltip)
        names = [user_set.name for user_set in sets]
        self.setList.setCurrentRow(names.index(before.name) if before and before.name in names else 0)

    def _ask_save(self) -> None:
        if (chosen := self.chosen) is None:
            return
        self.question = box = question_box(
            self,
            self.tr("Save the current settings in {0}?").format(chosen.title),
            self.tr("This overwrites the set and cannot be undone."),
        )
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        save = box.addButton(self.tr("Overwrite"), QMessageBox.ButtonRole.DestructiveRole)
        box.setDefaultButton(box.addButton(QMessageBox.StandardButton.Cancel))
        box.finished.connect(lambda _: self._on_question_finished(box.clickedButton() is save, chosen.name))
        box.open()

    def _on_question_finished(self, agreed: bool, name: str) -> None:
        self.question = None
        if agreed:
            self.saveRequested.emit(name)

    def _emit_for_chosen(self, signal: pyqtBoundSignal) -> None:
        if (chosen := self.chosen) is not None:
            signal.emit(chosen.name)

    def _enable(self, _: int = 0) -> None:
        chosen = self.chosen
        load = Unavailable.USER_SET if chosen is None else None
        save = Unavailable.SAVABLE if chosen is not None and not chosen.savable else load
        fixed = chosen is not None and (chosen.starts or not chosen.startable)
        set_available(self.loadButton, load)
        set_available(self.saveButton, save)
        set_available(self.startButton, Unavailable.STARTABLE if fixed else load)
