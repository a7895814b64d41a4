"""Work under way, above the picture: how far it is, and a way out."""

from __future__ import annotations

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QFrame, QLabel, QProgressBar, QPushButton, QVBoxLayout, QWidget

from grabbergui.ui.loader import load_form


class TaskRow(QFrame):
    """One piece of work."""

    cancelRequested = pyqtSignal()

    titleLabel: QLabel
    textLabel: QLabel
    bar: QProgressBar
    cancelButton: QPushButton

    def __init__(self, title: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("task_row", self)
        self.titleLabel.setText(title)
        self.setAccessibleName(title)
        self.bar.setRange(0, 0)  # busy, until it is known how far it is
        self.cancelButton.clicked.connect(self._on_cancel_clicked)

    def setShare(self, share: float) -> None:
        """How far it is, 0 … 1."""
        self.bar.setRange(0, 1000)
        self.bar.setValue(round(1000 * min(max(share, 0.0), 1.0)))

    def setText(self, text: str) -> None:
        """Where it stands."""
        self.textLabel.setText(text)

    def _on_cancel_clicked(self) -> None:
        self.cancelButton.setEnabled(False)
        self.cancelRequested.emit()


class TaskStack(QWidget):
    """All work under way, the newest below."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._rows: list[TaskRow] = []
        self._layout = QVBoxLayout(self)
        self._layout.setContentsMargins(0, 0, 0, 0)
        self._layout.setSpacing(1)
        self.hide()

    @property
    def rows(self) -> tuple[TaskRow, ...]:
        """What is shown."""
        return tuple(self._rows)

    def begin(self, title: str) -> TaskRow:
        """Show one more; `end` it."""
        row = TaskRow(title, self)
        self._rows.append(row)
        self._layout.addWidget(row)
        self.show()
        return row

    def end(self, row: TaskRow) -> None:
        """It is done, or given up; does nothing where it is gone already."""
        if row in self._rows:
            self._rows.remove(row)
            self._layout.removeWidget(row)
            row.hide()
            row.deleteLater()
        self.setVisible(bool(self._rows))
