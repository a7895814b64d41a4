"""What the program has logged."""

from __future__ import annotations

import logging
import time
from collections.abc import Sequence

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QApplication, QComboBox, QPlainTextEdit, QPushButton, QWidget

from grabbergui.models.log_book import MOST_LINES, LogLine
from grabbergui.ui.loader import load_form

_LEVELS = (logging.NOTSET, logging.WARNING, logging.ERROR)


class LogPanel(QWidget):
    """Shows entries, the newest last, and follows them unless somebody scrolled up."""

    levelChanged = pyqtSignal()
    """Other entries are to be shown: `setLines` is to follow."""
    clearRequested = pyqtSignal()

    levelBox: QComboBox
    copyButton: QPushButton
    clearButton: QPushButton
    text: QPlainTextEdit

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("log_panel", self)
        self.text.setMaximumBlockCount(MOST_LINES)
        self.levelBox.currentIndexChanged[int].connect(lambda _: self.levelChanged.emit())
        self.clearButton.clicked.connect(self.clearRequested)
        self.copyButton.clicked.connect(self._on_copy_clicked)

    def setLines(self, lines: Sequence[LogLine]) -> None:
        """Show these entries, as far as they are serious enough."""
        self.text.setPlainText("\n".join(_text(line) for line in lines if self._shown(line)))
        if (bar := self.text.verticalScrollBar()) is not None:
            bar.setValue(bar.maximum())

    def addLine(self, line: LogLine) -> None:
        """Show one more."""
        if self._shown(line):
            self.text.appendPlainText(_text(line))

    def _shown(self, line: LogLine) -> bool:
        return line.level >= _LEVELS[self.levelBox.currentIndex()]

    def _on_copy_clicked(self) -> None:
        if (clipboard := QApplication.clipboard()) is not None:
            clipboard.setText(self.text.toPlainText())


def _text(line: LogLine) -> str:
    moment = time.strftime("%H:%M:%S", time.localtime(line.time))
    milliseconds = int(line.time * 1000) % 1000
    return f"{moment}.{milliseconds:03d}  {logging.getLevelName(line.level):<8} {line.origin}: {line.text}"
