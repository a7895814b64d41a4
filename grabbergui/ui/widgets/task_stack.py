"""Rows of tasks in progress."""

from __future__ import annotations

from PyQt5.QtCore import QEvent, pyqtSignal
from PyQt5.QtWidgets import (
    QFrame,
    QLabel,
    QProgressBar,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from grabbergui.models.unavailable import Unavailable
from grabbergui.ui.actions import set_available
from grabbergui.ui.form_loader import load_form


class TaskRow(QFrame):
    """A task: its title, progress and *Cancel*."""

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
        self.bar.setRange(0, 0)  # busy, until the progress is known
        self.cancelButton.clicked.connect(self._on_cancel_clicked)

    def setShare(self, share: float) -> None:
        """Show the progress, 0 … 1."""
        self.bar.setRange(0, 1000)
        self.bar.setValue(round(1000 * min(max(share, 0.0), 1.0)))

    def setText(self, text: str) -> None:
        """Show the progress as text."""
        self.textLabel.setText(text)

    def _on_cancel_clicked(self) -> None:
        set_available(self.cancelButton, Unavailable.PATIENCE)
        self.cancelRequested.emit()


class TaskStack(QWidget):
    """All tasks in progress, the newest at the bottom."""

    changed = pyqtSignal()
    """The number of rows or their height changed."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._rows: list[TaskRow] = []
        self._layout = QVBoxLayout(self)
        self._layout.setContentsMargins(0, 0, 0, 0)
        self._layout.setSpacing(1)
        self.hide()

    def event(self, event: QEvent | None) -> bool:
        """Emit `changed` for another height of the rows, which the style sheet sets when they are shown."""
        done = super().event(event)
        if event is not None and event.type() == QEvent.Type.LayoutRequest:
            self.changed.emit()
        return done

    @property
    def rows(self) -> tuple[TaskRow, ...]:
        """The rows shown, from the top."""
        return tuple(self._rows)

    def begin(self, title: str) -> TaskRow:
        """Add and return a row; remove it with `end`."""
        row = TaskRow(title, self)
        self._rows.append(row)
        self._layout.addWidget(row)
        self.show()
        self.changed.emit()
        return row

    def end(self, row: TaskRow) -> None:
        """Remove a row; does nothing if it is gone already."""
        if row in self._rows:
            self._rows.remove(row)
            self._layout.removeWidget(row)
            row.hide()
            row.deleteLater()
        self.setVisible(bool(self._rows))
        self.changed.emit()
