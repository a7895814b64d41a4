"""*Help → Report this camera…*."""

from __future__ import annotations

import threading
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from PyQt5.QtCore import QObject
from PyQt5.QtWidgets import QAction

from grabbergui.core.environment import write_whole
from grabbergui.core.grabber import FrameGrabber
from grabbergui.models.log_book import LogBook
from grabbergui.ui.controllers.source_context import SourceContext
from grabbergui.ui.gui_thread import Bridge
from grabbergui.ui.views.report_dialog import ReportDialog

if TYPE_CHECKING:  # it imports the drivers, which the window does without at its start
    from grabbergui.driver.twin.report_file import CameraReport

FRAMES = 200
"Frames that are recorded."


class ReportController(QObject):
    """Makes the report of the current camera on a thread of its own, and saves it on request."""

    def __init__(self, action: QAction, context: SourceContext, book: LogBook) -> None:
        super().__init__(context.window)
        self._window = context.window
        self._files = context.files
        self._open_sources = context.open_sources
        self._book = book
        self._messages = context.messages
        self._bridge = Bridge(self)
        self._report: CameraReport | None = None
        "With all names and pixels."
        self.dialog: ReportDialog | None = None
        "While it is shown."
        action.triggered.connect(self.show)

    def show(self) -> None:
        """Ask the camera, and show what a report of it contains."""
        if self.dialog is not None:
            self.dialog.raise_()
            return
        self._report = None
        self.dialog = dialog = ReportDialog(self._window)
        dialog.optionsChanged.connect(self._show_contents)
        dialog.saveRequested.connect(self._ask_save)
        dialog.finished.connect(self._on_dialog_finished)
        dialog.show()
        source = self._open_sources.current
        grabber = source.grabber if source is not None else None
        threading.Thread(target=self._ask, args=(grabber, dialog), name="report", daemon=True).start()

    def _ask(self, grabber: FrameGrabber | None, dialog: ReportDialog) -> None:
        from grabbergui.report.collect import ReportOptions, report_of_open

        report = report_of_open(grabber, self._book, ReportOptions(FRAMES, pixels=True), lambda step: None)
        self._bridge.call(partial(self._take, report, dialog))

    def _take(self, report: CameraReport, dialog: ReportDialog) -> None:
        if self.dialog is dialog:
            self._report = report
            self._show_contents()

    def _chosen(self) -> CameraReport:
        """Return the report as the boxes say."""
        from grabbergui.report.stand_ins import without_names
        from grabbergui.report.summary import with_readme

        assert self._report is not None and self.dialog is not None
        kept = self.dialog.namesBox.isChecked()
        report = self._report if kept else without_names(self._report)
        if not self.dialog.pixelsBox.isChecked():
            report = replace(report, pixels=())
        return with_readme(report, names_kept=kept)

    def _show_contents(self) -> None:
        from grabbergui.report.summary import contents

        if self.dialog is not None and self._report is not None:
            self.dialog.setContents(contents(self._chosen(), names_kept=self.dialog.namesBox.isChecked()))

    def _ask_save(self) -> None:
        from grabbergui.driver.twin import report_file
        from grabbergui.report.summary import file_name

        report = self._chosen()
        name = file_name(report)
        path = self._files.to_save(self.tr("Save the report"), name, self.tr("Reports (*.zip)"))
        if path is None:
            return
        try:
            write_whole(path, report_file.encode(report))
        except OSError as error:
            self._messages.error(self.tr("{0} cannot be written: {1}").format(path, error.strerror or error))
            return
        self._messages.notice(self.tr("Saved the report to {0}").format(path))
        if self.dialog is not None:
            self.dialog.accept()

    def _on_dialog_finished(self, _: int) -> None:
        dialog, self.dialog, self._report = self.dialog, None, None
        if dialog is not None:
            dialog.deleteLater()
