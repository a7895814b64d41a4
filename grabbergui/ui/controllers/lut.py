"""The camera's look-up tables: read, edited, saved in files, written."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from PyQt5.QtCore import QObject
from PyQt5.QtWidgets import QAction

from grabbergui.core.errors import UsageError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.lookup_table import (
    LutShape,
    Table,
    gamma_of,
    gamma_table,
    has_lut,
    load_table,
    read_table,
    save_table,
    selectors_of,
    shape_of,
    write_table,
)
from grabbergui.models.change_tracking import ChangeTrackingGrabber
from grabbergui.models.error_text import error_text
from grabbergui.models.settings.feature_set import Progress
from grabbergui.models.unavailable import Unavailable
from grabbergui.ui.controllers.camera_ability import CameraAbility
from grabbergui.ui.controllers.camera_work import CameraWork
from grabbergui.ui.controllers.source_context import SourceContext
from grabbergui.ui.views.lut_dialog import LutDialog


@dataclass(frozen=True, eq=False)
class _Present:
    """The table in the camera."""

    selectors: tuple[str, ...]
    selector: str
    shape: LutShape
    table: Table
    used: bool | None


class LutController(QObject):
    """Edits a copy of a table, which the user writes to the camera. One write can be undone."""

    def __init__(self, action: QAction, context: SourceContext, work: CameraWork) -> None:
        super().__init__(context.window)
        self._window = context.window
        self._files = context.files
        self._work = work
        self._messages = context.messages
        self.dialog: LutDialog | None = None
        "While it is shown."
        self._present: _Present | None = None
        self._edited: Table = np.zeros(0, np.int64)
        self._before: Table | None = None
        self._kept: Table | None = None
        "The edited table that was last saved in a file, or is being written."
        action.triggered.connect(self.show)
        CameraAbility(self, context.open_sources, has_lut, Unavailable.TABLE, action).ended.connect(
            self._on_camera_ended
        )

    @property
    def edited(self) -> Table:
        """The edited table."""
        return self._edited

    def show(self) -> None:
        """Read the camera's first table and open the window; raise the window if it is open already."""
        if self.dialog is None:
            self._read("", self._open)
        else:
            self.dialog.raise_()

    def _read(self, selector: str, done: Callable[[_Present], None]) -> None:
        def work(grabber: ChangeTrackingGrabber, progress: Progress, cancelled: threading.Event) -> _Present:
            return _read_table(grabber.plain, selector, progress, cancelled)

        self._work.run(self.tr("Reading the look-up table"), work, self._work.if_current(done))

    def _open(self, present: _Present) -> None:
        if self.dialog is not None:
            return  # requested twice before the first answer: what is edited since stays
        self.dialog = dialog = LutDialog(self._window)
        dialog.unsaved = self._unsaved
        dialog.selectorChosen.connect(lambda selector: self._read(selector, self._show_other))
        dialog.enableToggled.connect(self._on_enable_toggled)
        dialog.gammaChosen.connect(self._on_gamma_chosen)
        dialog.linearRequested.connect(self._on_linear_requested)
        dialog.loadRequested.connect(self._on_load_requested)
        dialog.saveRequested.connect(self._on_save_requested)
        dialog.writeRequested.connect(lambda: self._write(self._edited))
        dialog.undoRequested.connect(self._on_undo_requested)
        dialog.finished.connect(self._on_dialog_finished)
        dialog.setSelectors(present.selectors)
        dialog.show()
        self._show(present)

    def _show_other(self, present: _Present) -> None:
        self._before = None  # a write can only be undone in its own table
        self._show(present)

    def _show(self, present: _Present) -> None:
        if self.dialog is None:
            return
        self._present, self._edited = present, present.table.copy()
        self.dialog.setEnabledInCamera(present.used)
        self.dialog.setUndoable(self._before is not None)
        self.dialog.setTables(present.table, self._edited)
        self._show_gamma()

    def _show_gamma(self) -> None:
        if self.dialog is not None and self._present is not None:
            self.dialog.setGamma(gamma_of(self._present.shape, self._edited))

    def _unsaved(self) -> bool:
        """Return whether edits would be lost."""
        if self._present is None or self._edited is self._kept:
            return False
        return not np.array_equal(self._edited, self._present.table)

    def _edit(self, table: Table) -> None:
        self._edited = table
        if self.dialog is not None and self._present is not None:
            self.dialog.setTables(self._present.table, table)

    def _on_gamma_chosen(self, gamma: float) -> None:
        if self._present is not None:
            self._edit(gamma_table(self._present.shape, gamma))

    def _on_linear_requested(self) -> None:
        self._on_gamma_chosen(1.0)
        self._show_gamma()

    def _on_load_requested(self) -> None:
        kinds = self.tr("Tables (*.csv *.txt *.bin *.raw);;All files (*)")
        path = self._files.to_open(self.tr("Load a look-up table"), kinds)
        if path is None or self._present is None or self.dialog is None:
            return
        try:
            self._edit(load_table(path, self._present.shape))
            self._show_gamma()
        except UsageError as error:
            self._messages.error(error_text(error))
            self.dialog.showProblem(error_text(error))

    def _on_save_requested(self) -> None:
        kinds = self.tr("Comma-separated values (*.csv);;16-bit values (*.bin)")
        path = self._files.to_save(self.tr("Save the look-up table"), "lut.csv", kinds)
        if path is not None:
            with self._messages.saving(path, self.tr("Saved {0}")):
                save_table(path, self._edited)
                self._kept = self._edited

    def _on_undo_requested(self) -> None:
        if self._before is not None:
            self._write(self._before)

    def _write(self, table: Table) -> None:
        present, edited = self._present, self._edited
        if present is None:
            return

        def work(grabber: ChangeTrackingGrabber, progress: Progress, cancelled: threading.Event) -> _Present:
            write_table(grabber.plain, table, present.selector, progress=progress, cancelled=cancelled)
            return _read_table(grabber.plain, present.selector, lambda done, of: None, cancelled)

        def done(after: _Present) -> None:
            self._messages.notice(self.tr("The camera has the new look-up table"))
            if self.dialog is None:
                return
            edited_since = self._edited if self._edited is not edited else None
            self._before = present.table
            self._show(after)
            if edited_since is not None:
                self._edit(edited_since)
                self._show_gamma()

        def failed() -> None:
            self._kept = None

        self._kept = table
        done_if_current = self._work.if_current(done)
        self._work.run(self.tr("Writing the look-up table"), work, done_if_current, failed=failed)

    def _on_enable_toggled(self, used: bool) -> None:
        present = self._present
        if present is None:
            return

        def work(grabber: ChangeTrackingGrabber, _: Progress, __: threading.Event) -> None:
            if present.selector and grabber.plain.feature("LUTSelector").value != present.selector:
                grabber.write_feature("LUTSelector", present.selector)
            grabber.write_feature("LUTEnable", used)

        title = self.tr("Switching the look-up table")
        self._work.run(title, work, lambda _: None, undoable="LUTEnable")

    def _on_dialog_finished(self, _: int) -> None:
        self.dialog = self._present = self._before = self._kept = None

    def _on_camera_ended(self) -> None:
        if self.dialog is not None:
            self.dialog.done(0)  # its edits are of no use to another camera


def _read_table(
    grabber: FrameGrabber, selector: str, progress: Progress, cancelled: threading.Event
) -> _Present:
    selectors = selectors_of(grabber)
    chosen = selector or selectors[0]
    table = read_table(grabber, chosen, progress=progress, cancelled=cancelled)
    used = grabber.feature("LUTEnable").value if grabber.has_feature("LUTEnable") else None
    return _Present(selectors, chosen, shape_of(grabber), table, None if used is None else bool(used))
