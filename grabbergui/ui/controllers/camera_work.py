"""Work on the camera that takes a while: its own thread does it, the window shows how far it is."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import TypeVar

from PyQt5.QtCore import QObject, pyqtSignal

from grabbergui.core.errors import GrabberError
from grabbergui.models.changes.history import Step
from grabbergui.models.changes.tracking import ChangeTrackingGrabber
from grabbergui.models.connection import Connection
from grabbergui.models.error_text import error_text
from grabbergui.models.open_source import OpenSource
from grabbergui.models.settings.feature_set import Progress
from grabbergui.ui.bridge import Bridge
from grabbergui.ui.widgets.task_stack import TaskRow, TaskStack

T = TypeVar("T")

Work = Callable[[ChangeTrackingGrabber, Progress, threading.Event], T]
"""Does something with a camera, tells how far it is, and gives up once the event is set."""

TELL = 0.05
"""Seconds between two reports of how far it is: more often nobody sees."""


class CameraWork(QObject):
    """Runs work for whoever makes the calls, one after the other."""

    failed = pyqtSignal(str)
    """What did not work, for the window's error bar."""

    def __init__(self, tasks: TaskStack, connection: Connection) -> None:
        super().__init__(tasks)
        self._tasks = tasks
        self._connection = connection
        self._bridge = Bridge(self)
        self._under_way: dict[threading.Event, OpenSource] = {}
        # Not over the bridge: what is under way has to give up before the camera is closed.
        connection.ending.connect(self._on_connection_ending)

    def run(
        self, title: str, work: Work[T], done: Callable[[T], None], *, undoable: str = "", text: str = ""
    ) -> None:
        """Show `title` while it is done, then call `done` here with the result.

        What was changed before, by a slider let go just now, is written before.

        With `undoable`, all that is written is one step of that name to undo. A failure is told by `failed`.
        """
        source = self._connection.source
        if source is None or source.tracked_grabber is None or source.features is None:
            self.failed.emit(self.tr("there is no camera; connect to one first"))
            return
        grabber, cancelled = source.tracked_grabber, threading.Event()
        row = self._tasks.begin(title)
        row.setText(text)
        row.cancelRequested.connect(cancelled.set)
        self._under_way[cancelled] = source
        progress = self._progress(row)

        def job() -> T:
            if not undoable:
                return work(grabber, progress, cancelled)
            with grabber.journal.within(Step(undoable)):
                return work(grabber, progress, cancelled)

        def end(report: Callable[[], None]) -> None:
            self._under_way.pop(cancelled, None)
            self._tasks.end(row)
            report()

        def succeeded(result: T) -> None:
            self._bridge.call(lambda: end(lambda: done(result)))

        def gone_wrong(error: GrabberError) -> None:
            self._bridge.call(lambda: end(lambda: self.failed.emit(error_text(error))))

        if not source.features.run(job, done=succeeded, failed=gone_wrong):
            end(lambda: None)

    def _progress(self, row: TaskRow) -> Progress:
        told = 0.0

        def progress(done: int, of: int) -> None:
            nonlocal told
            now = time.monotonic()
            if now - told >= TELL or done >= of:
                told = now
                self._bridge.call(lambda: row.setShare(done / max(of, 1)))

        return progress

    def _on_connection_ending(self, ending: OpenSource) -> None:
        for cancelled, source in tuple(self._under_way.items()):
            if source is ending:
                cancelled.set()
