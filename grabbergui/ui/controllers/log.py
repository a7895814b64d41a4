"""Joins the log's panel to what is logged."""

from __future__ import annotations

from PyQt5.QtCore import QObject

from grabbergui.models.log_book import LogBook, LogLine
from grabbergui.ui.bridge import Bridge
from grabbergui.ui.views.log_panel import LogPanel


class LogController(QObject):
    """Shows what is logged from wherever."""

    def __init__(self, panel: LogPanel, book: LogBook) -> None:
        super().__init__(panel)
        self._panel = panel
        self._book = book
        Bridge(self).bind(book.added, self._on_book_added)
        panel.levelChanged.connect(self._show_all)
        panel.clearRequested.connect(self._clear)
        self._show_all()

    def _on_book_added(self, line: LogLine) -> None:
        self._panel.addLine(line)

    def _show_all(self) -> None:
        self._panel.setLines(self._book.lines)

    def _clear(self) -> None:
        self._book.clear()
        self._show_all()
