"""Dialogs about settings of a camera: loading report, comparison of files, user sets, look-up table."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from PyQt5.QtCore import QSignalBlocker, Qt, pyqtBoundSignal, pyqtSignal
from PyQt5.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDialog,
    QDoubleSpinBox,
    QHBoxLayout,
    QLabel,
    QListWidget,
    QListWidgetItem,
    QMessageBox,
    QPushButton,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from grabbergui.core.features import FeatureValue, format_value
from grabbergui.core.lookup_table import LEAST_GAMMA, MOST_GAMMA
from grabbergui.core.settings import SettingKey
from grabbergui.models.language import counted
from grabbergui.models.markup import markup
from grabbergui.models.open_source import Lack
from grabbergui.models.settings.feature_set import Difference
from grabbergui.models.settings.loading import PENDING, SETTLED, LoadReport, Outcome
from grabbergui.models.settings.user_sets import UserSet
from grabbergui.ui.shown_text import PlainLabel, question_box, set_cell_tooltip, set_rich, set_tooltip
from grabbergui.ui.widgets.plots import ChannelPlot
from grabbergui.ui.windows import fit_screen, load_form, set_available

# -- what was loaded, and what differs -----------------------------------------------------------
_TICK_WIDTH = 24
"Width of the check boxes, which the style sheet makes larger than Qt expects."
_KEY_ROLE = Qt.ItemDataRole.UserRole + 1
"Of a row that can be ticked: its `SettingKey`."


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
            texts = (format_value(setting.before), format_value(setting.wanted))
            row = QTreeWidgetItem([str(setting.key), *texts, self._outcome(setting.outcome), setting.reason])
            set_cell_tooltip(row, 4, setting.reason)
            row.setData(0, Qt.ItemDataRole.UserRole, setting.outcome is Outcome.EQUAL)
            if setting.outcome in PENDING:
                _make_checkable(row, setting.key)
            if setting.outcome not in SETTLED:
                font = row.font(3)
                font.setBold(True)
                row.setFont(3, font)
            self.table.addTopLevelItem(row)
        for line in report.lost_lines:
            row = QTreeWidgetItem(["", "", "", self.tr("not a setting"), line])
            set_cell_tooltip(row, 4, line)
            self.table.addTopLevelItem(row)
        self._show_equal(self.equalBox.isChecked())
        for column in range(4):
            self.table.resizeColumnToContents(column)
        self.table.setColumnWidth(0, self.table.columnWidth(0) + _TICK_WIDTH)

    def _summary(self, report: LoadReport) -> str:
        counts = [(report.count(outcome), self._outcome(outcome)) for outcome in Outcome]
        counts.append((len(report.lost_lines), self.tr("not a setting")))
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
            Outcome.NOT_WRITTEN: self.tr("not written"),
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


NAME_WIDTH = 160
"Pixels of a file's name on a button; the tooltip has the whole name."


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


# -- the camera's user sets ----------------------------------------------------------------------
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
        load = Lack.USER_SET if chosen is None else None
        save = Lack.SAVABLE if chosen is not None and not chosen.savable else load
        fixed = chosen is not None and (chosen.starts or not chosen.startable)
        set_available(self.loadButton, load)
        set_available(self.saveButton, save)
        set_available(self.startButton, Lack.STARTABLE if fixed else load)


# -- the look-up table ---------------------------------------------------------------------------
_MOST_POINTS = 2048
"Most points of a curve that are drawn; no screen shows more."
_EDITED = "#3e7bfa"
"Colour of the edited curve."


class LutDialog(QDialog):
    """Shows tables; signals for the requested actions. Setters never emit."""

    selectorChosen = pyqtSignal(str)
    enableToggled = pyqtSignal(bool)
    gammaChosen = pyqtSignal(float)
    linearRequested = pyqtSignal()
    loadRequested = pyqtSignal()
    saveRequested = pyqtSignal()
    writeRequested = pyqtSignal()
    undoRequested = pyqtSignal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.unsaved: Callable[[], bool] = lambda: False
        """Returns whether edits would be lost; the user is asked before that."""
        self.question: QMessageBox | None = None
        """The question whether to discard edits, while it is open."""
        self._selector = ""
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(self.tr("Look-up table"))
        self.resize(560, 480)
        self.selectorLabel = PlainLabel(self.tr("&Table"))
        self.selectorBox = QComboBox()
        self.selectorLabel.setBuddy(self.selectorBox)
        self.enableBox = QCheckBox(self.tr("The camera &uses it"))
        self.plot = ChannelPlot()
        self.plot.setAccessibleName(self.tr("Curve of the look-up table"))
        set_tooltip(
            self.plot, self.tr("Horizontal: value of the sensor; vertical: value that is sent instead")
        )
        self.plot.nameAxes(self.tr("Input (LUTIndex)"), self.tr("Output (LUTValue)"))
        present, edited = self.tr("in the camera"), self.tr("edited")
        self.legendLabel = PlainLabel()
        legend = markup('━ {0} &nbsp; <span style="color: {1}">━</span> {2}', present, _EDITED, edited)
        set_rich(self.legendLabel, legend)
        self.gammaBox = QDoubleSpinBox()
        self.gammaBox.setRange(0, MOST_GAMMA)
        self.gammaBox.setSpecialValueText("–")
        self.gammaBox.setSingleStep(0.05)
        self.gammaBox.setAccessibleName(self.tr("Gamma"))
        set_tooltip(self.gammaBox, self.tr("Below 1, dark parts become brighter; above 1, darker"))
        gamma_label = PlainLabel(self.tr("&Gamma"))
        gamma_label.setBuddy(self.gammaBox)
        self.linearButton = QPushButton(self.tr("Li&near"))
        self.loadButton = QPushButton(self.tr("L&oad…"))
        self.saveButton = QPushButton(self.tr("&Save…"))
        self.stateLabel = PlainLabel()
        self.stateLabel.setWordWrap(True)
        self.undoButton = QPushButton(self.tr("Un&do"))
        set_tooltip(self.undoButton, self.tr("Write back the camera's previous table"))
        self.writeButton = QPushButton(self.tr("&Write to the camera"))
        self.closeButton = QPushButton(self.tr("&Close"))
        self._lay_out(gamma_label)
        self._join()

    def setSelectors(self, names: tuple[str, ...]) -> None:
        """Offer these tables; the choice is hidden if there is only one."""
        with QSignalBlocker(self.selectorBox):
            self.selectorBox.clear()
            self.selectorBox.addItems(names)
        self._selector = self.selectorBox.currentText()
        self.selectorBox.setVisible(len(names) > 1)
        self.selectorLabel.setVisible(len(names) > 1)

    def setEnabledInCamera(self, used: bool | None) -> None:
        """Show whether the camera uses the table; None if it has no switch for that."""
        self.enableBox.setVisible(used is not None)
        with QSignalBlocker(self.enableBox):
            self.enableBox.setChecked(bool(used))

    def setTables(self, present: NDArray[np.int64], edited: NDArray[np.int64]) -> None:
        """Show the camera's table, and the edited one over it."""
        places = np.unique(np.linspace(0, len(present) - 1, _MOST_POINTS).astype(int))
        self.plot.setLine("present", places, present[places], "")
        self.plot.setLine("edited", places, edited[places], _EDITED)
        changed = not np.array_equal(present, edited)
        set_available(self.writeButton, None if changed else Lack.EDIT)
        size = self.tr("{0} entries").format(len(present))
        state = self.tr("not written yet") if changed else self.tr("as in the camera")
        self.stateLabel.setText(f"{size} · {state}")

    def showProblem(self, text: str) -> None:
        """Show why a file was not loaded, until the next table is shown."""
        self.stateLabel.setText(text)

    def setUndoable(self, undoable: bool) -> None:
        """Enable the undo of the last write."""
        set_available(self.undoButton, None if undoable else Lack.EDIT)

    def setGamma(self, gamma: float | None) -> None:
        """Show the exponent of a gamma curve; None for any other curve."""
        with QSignalBlocker(self.gammaBox):
            self.gammaBox.setValue(gamma or 0.0)

    def reject(self) -> None:
        """Close the window; called by Qt for Esc and the window's own button, too."""
        self._ask_to_discard(super().reject)

    def _lay_out(self, gamma_label: QLabel) -> None:
        def line(*widgets: QWidget | None) -> QHBoxLayout:
            row = QHBoxLayout()
            for widget in widgets:
                row.addStretch(1) if widget is None else row.addWidget(widget)
            return row

        column = QVBoxLayout(self)
        column.addLayout(line(self.selectorLabel, self.selectorBox, self.enableBox, None, self.legendLabel))
        column.addWidget(self.plot, 1)
        column.addWidget(self.stateLabel)
        column.addLayout(
            line(gamma_label, self.gammaBox, self.linearButton, None, self.loadButton, self.saveButton)
        )
        column.addLayout(line(self.undoButton, None, self.writeButton, self.closeButton))

    def _join(self) -> None:
        for button in self.findChildren(QPushButton):
            button.setAutoDefault(False)  # Enter in the field must not press one
        self.selectorBox.currentTextChanged.connect(self._on_selector_chosen)
        self.enableBox.toggled.connect(self.enableToggled)
        self.gammaBox.valueChanged.connect(self._on_gamma_changed)
        self.gammaBox.editingFinished.connect(self._on_gamma_entered)
        self.linearButton.clicked.connect(lambda: self.linearRequested.emit())
        self.loadButton.clicked.connect(lambda: self.loadRequested.emit())
        self.saveButton.clicked.connect(lambda: self.saveRequested.emit())
        self.writeButton.clicked.connect(lambda: self.writeRequested.emit())
        self.undoButton.clicked.connect(lambda: self.undoRequested.emit())
        self.closeButton.clicked.connect(self.reject)

    def _on_gamma_changed(self, gamma: float) -> None:
        if gamma >= LEAST_GAMMA:
            self.gammaChosen.emit(gamma)

    def _on_gamma_entered(self) -> None:
        if 0 < self.gammaBox.value() < LEAST_GAMMA:
            self.gammaBox.setValue(LEAST_GAMMA)

    def _on_selector_chosen(self, name: str) -> None:
        def discarded() -> None:
            self._selector = name
            self.selectorChosen.emit(name)

        def kept() -> None:
            with QSignalBlocker(self.selectorBox):
                self.selectorBox.setCurrentText(self._selector)

        self._ask_to_discard(discarded, kept)

    def _ask_to_discard(self, discarded: Callable[[], None], kept: Callable[[], None] = lambda: None) -> None:
        """Call `discarded` if no edits would be lost or the user agrees to that, otherwise `kept`."""
        if not self.unsaved():
            discarded()
            return
        if self.question is not None:
            return
        self.question = box = question_box(
            self,
            self.tr("Discard the edited table?"),
            self.tr("It is neither in the camera nor saved in a file."),
        )
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        discard = box.addButton(self.tr("&Discard"), QMessageBox.ButtonRole.DestructiveRole)
        box.setDefaultButton(box.addButton(QMessageBox.StandardButton.Cancel))

        def finished(_: int) -> None:
            self.question = None
            (discarded if box.clickedButton() is discard else kept)()

        box.finished.connect(finished)
        box.open()
