"""The doctor's findings, each with its state, its remedy, and a button if the program can apply that."""

from __future__ import annotations

from collections.abc import Mapping

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import QDialog, QLabel, QPushButton, QScrollArea, QVBoxLayout, QWidget

from grabbergui.core.visible_text import visible
from grabbergui.doctor.findings import Finding, Level
from grabbergui.models.language import counted
from grabbergui.models.unavailable import Unavailable
from grabbergui.ui.actions import set_available
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.screen import fit_screen
from grabbergui.ui.shown_text import set_tooltip
from grabbergui.ui.widgets.labels import restyle

_TONES = {Level.GOOD: "good", Level.NOTE: "busy", Level.PROBLEM: "bad"}


class DoctorRow(QWidget):
    """One finding."""

    mendRequested = pyqtSignal()

    levelLabel: QLabel
    textLabel: QLabel
    remedyLabel: QLabel
    mendButton: QPushButton

    def __init__(self, finding: Finding, level: str, width: int, parent: QWidget) -> None:
        """`level` is the word for the finding's level, and `width` that of the longest one in pixels."""
        super().__init__(parent)
        load_form("doctor_row", self)
        self.levelLabel.setText(level)
        self.levelLabel.setMinimumWidth(width)
        restyle(self.levelLabel, "tone", _TONES[finding.level])
        self.textLabel.setText(_sentence(finding.text))
        self.remedyLabel.setText(f"→ {visible(finding.remedy)}")
        self.remedyLabel.setVisible(bool(finding.remedy))
        self.mendButton.setVisible(finding.mend is not None)
        set_tooltip(self.mendButton, finding.remedy)
        self.mendButton.clicked.connect(self.mendRequested)


class DoctorDialog(QDialog):
    """Shows findings as they come; deleted when it is closed."""

    mendRequested = pyqtSignal(object)
    """The `Finding` whose remedy is to be applied."""
    againRequested = pyqtSignal()
    copyRequested = pyqtSignal()

    stateLabel: QLabel
    scrollArea: QScrollArea
    content: QWidget
    rowsLayout: QVBoxLayout
    againButton: QPushButton
    copyButton: QPushButton
    closeButton: QPushButton

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("doctor_dialog", self)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._findings: list[Finding] = []
        self.rows: list[DoctorRow] = []
        self.againButton.clicked.connect(self.againRequested)
        self.copyButton.clicked.connect(self.copyRequested)
        self.closeButton.clicked.connect(self.accept)
        self.begin()
        fit_screen(self)

    @property
    def words(self) -> Mapping[Level, str]:
        """The words for the levels."""
        return {
            Level.GOOD: self.tr("OK"),
            Level.NOTE: self.tr("Warning"),
            Level.PROBLEM: self.tr("Fault"),
        }

    @property
    def text(self) -> str:
        """All findings and remedies as lines."""
        lines = []
        for finding in self._findings:
            lines.append(f"{self.words[finding.level]}: {finding.text}")
            if finding.remedy:
                lines.append(f"  → {finding.remedy}")
        return "\n".join(lines)

    def begin(self) -> None:
        """Remove all findings and show that the check is in progress."""
        for row in self.rows:
            row.hide()
            row.deleteLater()
        self.rows, self._findings = [], []
        set_available(self.againButton, Unavailable.PATIENCE)
        self.stateLabel.setText(self.tr("Checking this computer…"))

    def addFinding(self, finding: Finding) -> None:
        """Add a finding."""
        metrics = self.fontMetrics()
        width = max(metrics.horizontalAdvance(word) for word in self.words.values()) + 28
        row = DoctorRow(finding, self.words[finding.level], width, self.content)
        row.mendRequested.connect(lambda: self.mendRequested.emit(finding))
        self.rowsLayout.insertWidget(len(self.rows), row)
        self.rows.append(row)
        self._findings.append(finding)

    def setMending(self, finding: Finding) -> None:
        """Show that a remedy is being applied."""
        for row in self.rows:
            set_available(row.mendButton, Unavailable.PATIENCE)
        self.stateLabel.setText(self.tr("Applying the remedy: {0}").format(visible(finding.remedy)))

    def setProblem(self, text: str) -> None:
        """Show why a remedy could not be applied."""
        for row in self.rows:
            set_available(row.mendButton, None)
        self.stateLabel.setText(_sentence(text))

    def finish(self) -> None:
        """Show that the check is complete."""
        set_available(self.againButton, None)
        levels = [finding.level for finding in self._findings]
        faults, warnings = levels.count(Level.PROBLEM), levels.count(Level.NOTE)
        parts = [
            counted(faults, self.tr("1 fault"), self.tr("{0} faults")) if faults else "",
            counted(warnings, self.tr("1 warning"), self.tr("{0} warnings")) if warnings else "",
        ]
        self.stateLabel.setText(", ".join(filter(None, parts)) or self.tr("Nothing is wrong"))


def _sentence(text: str) -> str:
    """Begin with a capital letter, unless with a name such as `eth0`."""
    first, _, _ = text.partition(" ")
    return visible(text[:1].upper() + text[1:] if first.isalpha() and first.islower() else text)
