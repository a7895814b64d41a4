"""*Camera → Rig…*: the sets of a rig, their skew, its cameras' clocks, the budget of its link."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QDialog, QLabel, QPushButton, QTreeWidget, QWidget

from grabbergui.models.language import driver_text, localized
from grabbergui.rig.overview import BudgetOverview, RigOverview
from grabbergui.rig.ui.clock_text import clock_text
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.screen import fit_screen
from grabbergui.ui.widgets.columns import size_columns
from grabbergui.ui.widgets.labels import ElidedComboBox, ElidedLabel, restyle
from grabbergui.ui.widgets.plots import ChannelPlot, PlotPlace
from grabbergui.ui.widgets.table_rows import fill_rows

FORM = Path(__file__).with_name("forms") / "rig_dialog.ui"


class RigDialog(QDialog):
    """Setters for what is known of the rig; signals for its budget."""

    leaderChosen = pyqtSignal(str)
    """The name of the camera that the others follow; empty for none."""
    planRequested = pyqtSignal()
    applyRequested = pyqtSignal()
    removeRequested = pyqtSignal()

    setsLabel: ElidedLabel
    skewLabel: ElidedLabel
    skewPlace: PlotPlace
    cameraTable: QTreeWidget
    leaderBox: ElidedComboBox
    eventTable: QTreeWidget
    planButton: QPushButton
    applyButton: QPushButton
    removeButton: QPushButton
    budgetTable: QTreeWidget
    outcomeLabel: QLabel
    closeButton: QPushButton

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form(FORM, self)
        self.skewPlace.furnish = self._furnish
        size_columns(self.eventTable, ("00:00:00.000", "right.FrameTriggerMissed "))
        self.leaderBox.activated[int].connect(self._on_leader_activated)
        self.planButton.clicked.connect(self.planRequested)
        self.applyButton.clicked.connect(self.applyRequested)
        self.removeButton.clicked.connect(self.removeRequested)
        self.closeButton.clicked.connect(self.reject)
        self.setOutcome("")
        fit_screen(self)

    def setTitle(self, name: str) -> None:
        """Show which rig it is."""
        self.setWindowTitle(self.tr("Rig {0}").format(name))

    def setOverview(self, seen: RigOverview) -> None:
        """Show how the rig is doing."""
        counts = seen.counts
        text = self.tr("Complete sets: {0} · late: {1} · incomplete: {2}")
        self.setsLabel.setText(text.format(counts.complete, counts.late, counts.incomplete))
        skews = (counts.skew_median_ns, counts.skew_p99_ns, counts.skew_worst_ns)
        text = self.tr("Skew {0:.1f} µs (median) · {1:.1f} µs (p99) · {2:.1f} µs (worst)")
        self.skewLabel.setText(localized(text.format(*(skew / 1000 for skew in skews))))
        values = np.array(seen.skews_us)
        self.skewPlace.plot.setChannels(np.arange(1 - len(values), 1), {"skew": values})
        rows = [
            (each.name, str(each.frames), str(each.missing), clock_text(each.clock)) for each in seen.cameras
        ]
        _fill_and_size(self.cameraTable, rows)
        self._show_leader([each.name for each in seen.cameras], seen.leader)

    def setEvents(self, rows: Sequence[Sequence[str]]) -> None:
        """Show events of the cameras: time, name, values."""
        fill_rows(self.eventTable, rows)

    def _show_leader(self, cameras: Sequence[str], leader: str) -> None:
        if self.leaderBox.count() != len(cameras) + 1:
            self.leaderBox.clear()
            self.leaderBox.addItem(self.tr("none: each has its own settings"), "")
            for name in cameras:
                self.leaderBox.addItem(name, name)
        if (popup := self.leaderBox.view()) is None or not popup.isVisible():
            self.leaderBox.setCurrentIndex(max(0, self.leaderBox.findData(leader)))

    def _on_leader_activated(self, index: int) -> None:
        self.leaderChosen.emit(self.leaderBox.itemData(index))

    def setBudget(self, planned: BudgetOverview) -> None:
        """Show the budget of the link."""
        for widget in (self.budgetTable, self.applyButton):
            widget.setVisible(bool(planned.rows))
        if not planned.rows:
            self.setOutcome(self.tr("These cameras are on no link that they share."))
            return
        header, *rows = planned.rows
        self.budgetTable.setHeaderLabels(self._header(header))
        self.budgetTable.setColumnCount(len(header))
        _fill_and_size(self.budgetTable, rows)
        self.setOutcome(
            "\n".join(driver_text(problem) for problem in planned.problems)
            or self.tr("All frames fit into the link."),
            good=not planned.problems,
        )

    def setOutcome(self, text: str, *, good: bool = True) -> None:
        """Show what came of the last action."""
        self.outcomeLabel.setText(text)
        restyle(self.outcomeLabel, "problem", not good)

    def _header(self, columns: Sequence[str]) -> list[str]:
        words = {
            "camera": self.tr("Camera"),
            "frame": self.tr("Frame"),
            "rate": self.tr("Rate"),
            "packet": self.tr("Packet"),
            "needs": self.tr("Needs"),
            "share": self.tr("Share"),
            "frame takes": self.tr("Frame takes"),
            "set": self.tr("Set"),
        }
        return [words.get(column, column) for column in columns]

    def _furnish(self, plot: ChannelPlot) -> None:
        plot.nameAxes(self.tr("sets before the newest"), self.tr("µs"))


def _fill_and_size(table: QTreeWidget, rows: Sequence[Sequence[str]]) -> None:
    if fill_rows(table, rows):
        for column in range(table.columnCount()):
            table.resizeColumnToContents(column)
