"""Dialogs about settings of a camera: loading report, comparison of files, user sets, look-up table."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import (
    QCheckBox,
    QDialog,
    QLabel,
    QPushButton,
    QTreeWidget,
    QTreeWidgetItem,
    QWidget,
)

from grabbergui.core.features import FeatureValue, format_value
from grabbergui.core.settings import SettingKey
from grabbergui.models.features.number_text import quantity_text
from grabbergui.models.language import counted
from grabbergui.models.settings.feature_set import Difference
from grabbergui.models.settings.loading import PENDING, SETTLED, LoadReport, SettingOutcome
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.screen import fit_screen
from grabbergui.ui.shown_text import set_cell_tooltip, set_tooltip

_TICK_WIDTH = 24
"Width of the check boxes, which the style sheet makes larger than Qt expects."
_KEY_ROLE = Qt.ItemDataRole.UserRole + 1
"Role of the `SettingKey` of a row that can be ticked."
NAME_WIDTH = 160
"Pixels of a file's name on a button; the tooltip has the whole name."


class SettingsReport(QDialog):
    """Lists settings; offers to apply those that were only compared, or to roll back those written."""

    applyRequested = pyqtSignal(list)
    """The settings (list[SettingKey]) that are ticked."""
    rollBackRequested = pyqtSignal()

    headline: QLabel
    table: QTreeWidget
    equalBox: QCheckBox
    applyButton: QPushButton
    rollBackButton: QPushButton
    closeButton: QPushButton

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("settings_report", self)
        fit_screen(self)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.equalBox.toggled.connect(self._show_equal)
        self.closeButton.clicked.connect(self.reject)
        self.applyButton.clicked.connect(self._on_apply_clicked)
        self.rollBackButton.clicked.connect(self._on_roll_back_clicked)

    def setReport(self, title: str, report: LoadReport) -> None:
        """Show a report; of a dry run, the values that would be written, with a button to do so."""
        self.setWindowTitle(title)
        again = self.tr("Settings already written are restored when the camera is back, the others are not")
        restored = again if report.interrupted and report.written else ""
        parts = (self._summary(report), report.problem, restored)
        self.headline.setText(". ".join(part[0].upper() + part[1:] for part in parts if part))
        set_tooltip(self.headline, report.problem)
        self.applyButton.setVisible(report.count(*PENDING) > 0)
        self.rollBackButton.setVisible(report.written > 0)
        self.table.clear()
        for setting in report.settings:
            values = (setting.before, setting.wanted, setting.after)
            texts = [_with_unit(value, setting.unit) for value in values]
            row = QTreeWidgetItem([str(setting.key), *texts, self._outcome(setting.outcome), setting.reason])
            set_cell_tooltip(row, 5, setting.reason)
            row.setData(0, Qt.ItemDataRole.UserRole, setting.outcome is SettingOutcome.EQUAL)
            if setting.outcome in PENDING:
                _make_checkable(row, setting.key)
            if setting.outcome not in SETTLED:
                font = row.font(4)
                font.setBold(True)
                row.setFont(4, font)
            self.table.addTopLevelItem(row)
        for line in report.lost_lines:
            row = QTreeWidgetItem(["", "", "", "", self.tr("not a setting"), line])
            set_cell_tooltip(row, 5, line)
            self.table.addTopLevelItem(row)
        self._show_equal(self.equalBox.isChecked())
        self.table.setColumnHidden(3, report.count(*PENDING) > 0 or not report.written)
        for column in range(5):
            self.table.resizeColumnToContents(column)
        self.table.setColumnWidth(0, self.table.columnWidth(0) + _TICK_WIDTH)

    def _summary(self, report: LoadReport) -> str:
        counts = [(report.count(outcome), self._outcome(outcome)) for outcome in SettingOutcome]
        counts.append((len(report.lost_lines), self.tr("not a setting")))
        # Other languages decline what follows a number.
        return ", ".join(f"{name}: {count}" for count, name in counts if count) or self.tr("Nothing to do")

    def _outcome(self, outcome: SettingOutcome) -> str:
        return {
            SettingOutcome.WRITTEN: self.tr("written"),
            SettingOutcome.EQUAL: self.tr("equal"),
            SettingOutcome.WOULD_WRITE: self.tr("would be written"),
            SettingOutcome.DEPENDS: self.tr("depends on the others"),
            SettingOutcome.REFUSED: self.tr("refused"),
            SettingOutcome.DIFFERENT: self.tr("came out different"),
            SettingOutcome.LEFT_ALONE: self.tr("left alone"),
            SettingOutcome.UNKNOWN: self.tr("unknown"),
            SettingOutcome.CANCELLED: self.tr("cancelled"),
            SettingOutcome.NOT_WRITTEN: self.tr("not written"),
        }.get(outcome, outcome.value)

    def _show_equal(self, shown: bool) -> None:
        for index in range(self.table.topLevelItemCount()):
            row = self.table.topLevelItem(index)
            if row is not None:
                row.setHidden(bool(row.data(0, Qt.ItemDataRole.UserRole)) and not shown)

    def _on_apply_clicked(self) -> None:
        self.applyRequested.emit(_checked_keys(self.table))
        self.close()

    def _on_roll_back_clicked(self) -> None:
        self.rollBackRequested.emit()
        self.close()


def _with_unit(value: FeatureValue | None, unit: str) -> str:
    """Return a value with the unit of its feature; empty without a value."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not unit:
        return format_value(value)
    return quantity_text(value, unit, shown_in=unit)


class SettingsDifference(QDialog):
    """Lists differences; offers to write the ticked values of either set."""

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
        self,
        names: tuple[str, str],
        differences: Sequence[Difference],
        applicable: bool,
        lost_lines: Sequence[str] = (),
    ) -> None:
        """Show the differences of two named sets; `applicable` if there is a camera to write them to.

        `lost_lines` are the invalid lines of their files, a sentence each.
        """
        first, second = names
        self.headline.setText(
            counted(
                len(differences),
                self.tr("1 setting differs. If it is ticked, it can be set on the camera."),
                self.tr("{0} settings differ. Those that are ticked can be set on the camera."),
            )
            if differences
            else self.tr("There is no difference.")
        )
        self.table.setHeaderLabels([self.tr("Setting"), first, second])
        for button, name in ((self.firstButton, first), (self.secondButton, second)):
            text = self.tr("Set as in {0}")
            short = button.fontMetrics().elidedText(name, Qt.TextElideMode.ElideMiddle, NAME_WIDTH)
            button.setText(text.format(short.replace("&", "&&")))
            set_tooltip(button, text.format(name))
            button.setVisible(applicable and bool(differences))
        self.table.clear()
        for difference in differences:
            values = (self._shown(value) for value in (difference.first, difference.second))
            row = QTreeWidgetItem([str(difference.key), *values])
            _make_checkable(row, difference.key)
            self.table.addTopLevelItem(row)
        for column in range(3):
            self.table.resizeColumnToContents(column)
        self.table.setColumnWidth(0, self.table.columnWidth(0) + _TICK_WIDTH)
        for line in lost_lines:
            row = QTreeWidgetItem([line])
            set_cell_tooltip(row, 0, line)
            self.table.addTopLevelItem(row)
            row.setFirstColumnSpanned(True)

    def checked(self) -> list[SettingKey]:
        """The ticked settings."""
        return _checked_keys(self.table)

    def _shown(self, value: FeatureValue | None) -> str:
        return self.tr("(not in this file)") if value is None else format_value(value)

    def _apply(self, request: Callable[[list[SettingKey]], None]) -> None:
        request(self.checked())
        self.close()


def _make_checkable(row: QTreeWidgetItem, key: SettingKey) -> None:
    """Give a row a check box, ticked at first."""
    row.setFlags(row.flags() | Qt.ItemFlag.ItemIsUserCheckable)
    row.setCheckState(0, Qt.CheckState.Checked)
    row.setData(0, _KEY_ROLE, key)


def _checked_keys(table: QTreeWidget) -> list[SettingKey]:
    """Return the settings of the ticked rows."""
    rows = (table.topLevelItem(index) for index in range(table.topLevelItemCount()))
    return [
        row.data(0, _KEY_ROLE)
        for row in rows
        if row is not None
        and row.data(0, _KEY_ROLE) is not None
        and row.checkState(0) == Qt.CheckState.Checked
    ]
