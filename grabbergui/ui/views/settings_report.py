"""What became of settings that were loaded, or what would change."""

from __future__ import annotations

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

from grabbergui.core.features import format_value
from grabbergui.models.settings.loading import PENDING, SETTLED, LoadReport, Outcome
from grabbergui.ui.loader import load_form
from grabbergui.ui.widgets.checked_rows import TICK_WIDTH, checked_keys, make_checkable


class SettingsReport(QDialog):
    """Lists settings; offers to apply what was only compared, or to roll back what was written."""

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
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.equalBox.toggled.connect(self._show_equal)
        self.closeButton.clicked.connect(self.reject)
        self.applyButton.clicked.connect(self._on_apply_clicked)
        self.rollBackButton.clicked.connect(self._on_roll_back_clicked)

    def setReport(self, title: str, report: LoadReport) -> None:
        """Show a report; of a dry run, what would be written, with a button to do so."""
        self.setWindowTitle(title)
        self.headline.setText(". ".join(part for part in (self._summary(report), report.problem) if part))
        self.applyButton.setVisible(report.count(*PENDING) > 0)
        self.rollBackButton.setVisible(report.count(Outcome.WRITTEN, Outcome.DIFFERENT) > 0)
        self.table.clear()
        for setting in report.settings:
            texts = (format_value(setting.before), format_value(setting.wanted))
            row = QTreeWidgetItem([str(setting.key), *texts, self._outcome(setting.outcome), setting.reason])
            row.setToolTip(4, setting.reason)
            row.setData(0, Qt.ItemDataRole.UserRole, setting.outcome is Outcome.EQUAL)
            if setting.outcome in PENDING:
                make_checkable(row, setting.key)
            if setting.outcome not in SETTLED:
                font = row.font(3)
                font.setBold(True)
                row.setFont(3, font)
            self.table.addTopLevelItem(row)
        for line in report.lost_lines:
            row = QTreeWidgetItem(["", "", "", self.tr("not a setting"), line])
            row.setToolTip(4, line)
            self.table.addTopLevelItem(row)
        self._show_equal(self.equalBox.isChecked())
        for column in range(4):
            self.table.resizeColumnToContents(column)
        self.table.setColumnWidth(0, self.table.columnWidth(0) + TICK_WIDTH)

    def _summary(self, report: LoadReport) -> str:
        counts = ((report.count(outcome), self._outcome(outcome)) for outcome in Outcome)
        return ", ".join(f"{count} {name}" for count, name in counts if count) or self.tr("Nothing to do")

    def _outcome(self, outcome: Outcome) -> str:
        return {
            Outcome.WRITTEN: self.tr("written"),
            Outcome.EQUAL: self.tr("equal"),
            Outcome.WOULD_WRITE: self.tr("would be written"),
            Outcome.DEPENDS: self.tr("depends on the others"),
            Outcome.REFUSED: self.tr("refused"),
            Outcome.DIFFERENT: self.tr("came out different"),
            Outcome.LEFT_ALONE: self.tr("left alone"),
            Outcome.UNKNOWN: self.tr("unknown"),
            Outcome.CANCELLED: self.tr("cancelled"),
        }.get(outcome, outcome.value)

    def _show_equal(self, shown: bool) -> None:
        for index in range(self.table.topLevelItemCount()):
            row = self.table.topLevelItem(index)
            if row is not None:
                row.setHidden(bool(row.data(0, Qt.ItemDataRole.UserRole)) and not shown)

    def _on_apply_clicked(self) -> None:
        self.applyRequested.emit(checked_keys(self.table))
        self.close()

    def _on_roll_back_clicked(self) -> None:
        self.rollBackRequested.emit()
        self.close()
