"""What two sets of settings differ in."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import QDialog, QLabel, QPushButton, QTreeWidget, QTreeWidgetItem, QWidget

from grabbergui.core.features import FeatureValue, format_value
from grabbergui.core.selection import SettingKey
from grabbergui.models.settings.feature_set import Difference
from grabbergui.ui.loader import load_form
from grabbergui.ui.widgets.checked_rows import TICK_WIDTH, checked_keys, make_checkable


class SettingsDifference(QDialog):
    """Lists differences; offers to set the camera as one or the other set says, where that is ticked."""

    firstRequested = pyqtSignal(list)
    """The settings (list[SettingKey]) that the camera is to have as in the first set."""
    secondRequested = pyqtSignal(list)

    headline: QLabel
    table: QTreeWidget
    firstButton: QPushButton
    secondButton: QPushButton
    closeButton: QPushButton

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("settings_difference", self)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.closeButton.clicked.connect(self.reject)
        self.firstButton.clicked.connect(lambda: self._apply(self.firstRequested.emit))
        self.secondButton.clicked.connect(lambda: self._apply(self.secondRequested.emit))

    def setDifferences(
        self, names: tuple[str, str], differences: Sequence[Difference], applicable: bool
    ) -> None:
        """Show what the sets of these names differ in; `applicable` where there is a camera to set."""
        first, second = names
        self.headline.setText(
            self.tr("{0} settings differ. What is ticked can be set on the camera.").format(len(differences))
            if differences
            else self.tr("There is no difference.")
        )
        self.table.setHeaderLabels([self.tr("Setting"), first, second])
        for button, name in ((self.firstButton, first), (self.secondButton, second)):
            button.setText(self.tr("Set as in {0}").format(name.replace("&", "&&")))
            button.setVisible(applicable and bool(differences))
        self.table.clear()
        for difference in differences:
            values = (self._shown(value) for value in (difference.first, difference.second))
            row = QTreeWidgetItem([str(difference.key), *values])
            make_checkable(row, difference.key)
            self.table.addTopLevelItem(row)
        for column in range(3):
            self.table.resizeColumnToContents(column)
        self.table.setColumnWidth(0, self.table.columnWidth(0) + TICK_WIDTH)

    def checked(self) -> list[SettingKey]:
        """What is ticked."""
        return checked_keys(self.table)

    def _shown(self, value: FeatureValue | None) -> str:
        return self.tr("(not in it)") if value is None else format_value(value)

    def _apply(self, request: Callable[[list[SettingKey]], None]) -> None:
        request(self.checked())
        self.close()
