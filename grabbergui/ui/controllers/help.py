"""The *Help* menu, and the panel of the log."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial

from PyQt5.QtCore import QEvent, QObject, Qt
from PyQt5.QtGui import QHelpEvent
from PyQt5.QtWidgets import QApplication, QMenuBar, QWhatsThis, QWidget

from grabbergui import doctor
from grabbergui.core.environment import MANUAL
from grabbergui.core.errors import GrabberError
from grabbergui.doctor.findings import Finding
from grabbergui.models.error_text import error_text
from grabbergui.models.log_book import LogBook, LogLine
from grabbergui.ui.gui_thread import Bridge
from grabbergui.ui.shown_text import show_explanation
from grabbergui.ui.views.bases import HelpActions
from grabbergui.ui.views.doctor_dialog import DoctorDialog
from grabbergui.ui.views.help_views import LogPanel, ManualDialog, ShortcutsDialog


class HelpController(QObject):
    """Opens the manual, the doctor and the list of keys. The doctor runs on a thread of its own."""

    def __init__(self, actions: HelpActions, menubar: QMenuBar, window: QWidget) -> None:
        super().__init__(window)
        self._window = window
        self._menubar = menubar
        self.manual: ManualDialog | None = None
        self.doctor: DoctorDialog | None = None
        "While it is shown."
        self._bridge = Bridge(self)
        actions.actionManual.triggered.connect(self.show_manual)
        actions.actionDoctor.triggered.connect(self.show_doctor)
        actions.actionShortcuts.triggered.connect(self.show_shortcuts)
        actions.actionWhatsThis.triggered.connect(QWhatsThis.enterWhatsThisMode)
        window.installEventFilter(self)

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Answer *What's this?* with the tooltip of the widget clicked, or of the one around it.

        The events of all widgets come by only while Qt is in that mode, of which it notifies the window:
        thousands a second while an image runs are a seventh of the GUI thread.
        """
        if event is None:
            return False
        app = QApplication.instance()
        if app is not None and event.type() == QEvent.Type.EnterWhatsThisMode:
            app.installEventFilter(self)
        elif app is not None and event.type() == QEvent.Type.LeaveWhatsThisMode:
            app.removeEventFilter(self)
        if event.type() not in (QEvent.Type.QueryWhatsThis, QEvent.Type.WhatsThis):
            return False
        if not isinstance(watched, QWidget) or not isinstance(event, QHelpEvent):
            return False
        text = _explanation(watched)
        if text and event.type() == QEvent.Type.WhatsThis:
            show_explanation(event.globalPos(), text, watched)
        event.setAccepted(bool(text))
        return bool(text)

    def show_manual(self) -> None:
        """Open the manual."""
        self.manual = dialog = ManualDialog(MANUAL, self._window)
        dialog.show()

    def show_doctor(self) -> None:
        """Check this computer, and show each finding as it comes."""
        if self.doctor is not None:
            self.doctor.raise_()
            return
        self.doctor = dialog = DoctorDialog(self._window)
        dialog.againRequested.connect(self._examine_again)
        dialog.mendRequested.connect(self._mend)
        dialog.copyRequested.connect(self._copy)
        dialog.finished.connect(self._on_doctor_finished)
        dialog.show()
        self._run(partial(self._examine, dialog))

    def show_shortcuts(self) -> None:
        """List all keys."""
        dialog = ShortcutsDialog(self._menubar, self._window)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.open()

    def _run(self, job: Callable[[], None]) -> None:
        threading.Thread(target=job, name="doctor", daemon=True).start()

    def _examine_again(self) -> None:
        if (dialog := self.doctor) is not None:
            dialog.begin()
            self._run(partial(self._examine, dialog))

    def _mend(self, finding: Finding) -> None:
        """Apply a remedy, and check everything again."""
        dialog, mend = self.doctor, finding.mend
        if dialog is None or mend is None:
            return

        def run() -> None:
            try:
                mend()
            except GrabberError as error:
                self._bridge.call(
                    partial(self._report, dialog, partial(dialog.setProblem, error_text(error)))
                )
            else:
                self._bridge.call(partial(self._report, dialog, self._examine_again))

        dialog.setMending(finding)
        self._run(run)

    def _copy(self) -> None:
        clipboard = QApplication.clipboard()
        if self.doctor is not None and clipboard is not None:
            clipboard.setText(self.doctor.text)

    def _examine(self, dialog: DoctorDialog) -> None:
        for finding in doctor.check():
            if self.doctor is not dialog:
                return
            self._bridge.call(partial(self._report, dialog, partial(dialog.addFinding, finding)))
        self._bridge.call(partial(self._report, dialog, dialog.finish))

    def _report(self, dialog: DoctorDialog, report: Callable[[], None]) -> None:
        if self.doctor is dialog:
            report()

    def _on_doctor_finished(self, _: int) -> None:
        self.doctor = None


def _explanation(widget: QWidget | None) -> str:
    while widget is not None:
        if text := widget.whatsThis() or widget.toolTip():
            return text
        widget = widget.parentWidget()
    return ""


class LogController(QObject):
    """Shows the log of the whole program."""

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
