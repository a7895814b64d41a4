"""Controls of the menu *Help*: manual, check of the computer, shortcuts, log and report."""

from __future__ import annotations

from grabbergui.models.log_book import LogBook
from grabbergui.ui.controllers.help import HelpController, LogController
from grabbergui.ui.controllers.report import ReportController
from grabbergui.ui.controllers.source_context import SourceContext
from grabbergui.ui.views.bases import HelpActions
from grabbergui.ui.views.main_window import MainWindow


class HelpControls:
    """The log of the program, and the controllers of what helps its user."""

    def __init__(self, window: MainWindow, context: SourceContext) -> None:
        self.log_book = LogBook()
        self.log_book.open()
        actions = HelpActions(
            window.actionManual, window.actionDoctor, window.actionShortcuts, window.actionWhatsThis
        )
        self.help = HelpController(actions, window.menubar, window)
        self.log = LogController(window.log, self.log_book)
        self.report = ReportController(window.actionReport, context, self.log_book)
