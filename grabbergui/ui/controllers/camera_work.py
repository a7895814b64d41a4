"""Longer work on the current camera, with progress and a way to cancel."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import TypeVar

from PyQt5.QtCore import QObject

from grabbergui.core.errors import GrabberError
from grabbergui.models.change_tracking import ChangeTrackingGrabber
from grabbergui.models.error_text import error_text
from grabbergui.models.open_source import OpenSource
from grabbergui.models.settings.feature_set import Progress
from grabbergui.models.undo_steps import UndoStep
from grabbergui.ui.controllers.source_context import SourceContext
from grabbergui.ui.gui_thread import Bridge
from grabbergui.ui.widgets.task_stack import TaskRow, TaskStack

T = TypeVar("T")

Work = Callable[[ChangeTrackingGrabber, Progress, threading.Event], T]
"""Works with a camera, reports its progress, and stops once the event is set."""

REPORT_PERIOD = 0.05
"""Seconds between two reports of progress."""


class CameraWork(QObject):
    """Runs work on the current camera, one task after another, and shows its progress."""

    def __init__(self, tasks: TaskStack, context: SourceContext) -> None:
        super().__init__(tasks)
        self._messages = context.messages
        self._tasks = tasks
        self._open_sources = context.open_sources
        self._bridge = Bridge(self)
        self._in_progress: dict[threading.Event, OpenSource] = {}
        # Not over the bridge: work in progress has to stop before the camera is closed.
        context.open_sources.ending.connect(self._on_source_ending)

    @property
    def source(self) -> OpenSource | None:
        """The source that `run` works on by default: the current one."""
        return self._open_sources.current

    def if_current(self, done: Callable[[T], None]) -> Callable[[T], None]:
        """Return a `done` that ignores the result once another source is current."""
        source = self.source

        def checked(result: T) -> None:
            if source is self.source:
                done(result)

        return checked

    def run(
        self,
        title: str,
        work: Work[T],
        done: Callable[[T], None],
        *,
        failed: Callable[[], None] = lambda: None,
        undoable: str = "",
        text: str = "",
        source: OpenSource | None = None,
    ) -> None:
        """Run `work` on the camera's thread, with `title` shown; then call `done` here with the result.

        `source` is the camera's, by default the current one; another may be current when `done` is called.
        Earlier changes, for instance of a slider that was just released, are written first. With `undoable`,
        all that is written is one step of that name to undo. A failure is posted as a message; then `failed`
        is called.
        """
        source = source or self.source
        if source is None or source.tracked_grabber is None or source.features is None:
            self._messages.error(self.tr("there is no camera; connect to one first"))
            return
        grabber, cancelled = source.tracked_grabber, threading.Event()
        row = self._tasks.begin(title)
        row.setText(text)
        row.cancelRequested.connect(cancelled.set)
        self._in_progress[cancelled] = source
        progress = self._progress(row)

        def job() -> T:
            if not undoable:
                return work(grabber, progress, cancelled)
            with grabber.journal.within(UndoStep(undoable)):
                return work(grabber, progress, cancelled)

        def end(report: Callable[[], None]) -> None:
            self._in_progress.pop(cancelled, None)
            self._tasks.end(row)
            report()

        def succeeded(result: T) -> None:
            self._bridge.call(lambda: end(lambda: done(result)))

        def gone_wrong(error: GrabberError) -> None:
            def report() -> None:
                self._messages.error(error_text(error), source)
                failed()

            self._bridge.call(lambda: end(report))

        if not source.features.run(job, done=succeeded, failed=gone_wrong):
            end(lambda: None)

    def _progress(self, row: TaskRow) -> Progress:
        reported = 0.0

        def progress(done: int, of: int) -> None:
            nonlocal reported
            now = time.monotonic()
            if now - reported >= REPORT_PERIOD or done >= of:
                reported = now
                self._bridge.call(lambda: row.setShare(done / max(of, 1)))

        return progress

    def _on_source_ending(self, ending: OpenSource) -> None:
        for cancelled, source in tuple(self._in_progress.items()):
            if source is ending:
                cancelled.set()
