"""Longer work on the current camera, and actions that only some cameras support."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import TypeVar

from PyQt5.QtCore import QObject, pyqtSignal
from PyQt5.QtWidgets import QAction

from grabbergui.core.errors import GrabberError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.models.change_journal import Step
from grabbergui.models.change_tracking import ChangeTrackingGrabber
from grabbergui.models.connection import Connection
from grabbergui.models.error_text import error_text
from grabbergui.models.messages import CurrentMessages
from grabbergui.models.open_source import LinkState, OpenSource
from grabbergui.models.settings.feature_set import Progress
from grabbergui.ui.gui_thread import Bridge
from grabbergui.ui.widgets.labels import TaskRow, TaskStack

T = TypeVar("T")

Work = Callable[[ChangeTrackingGrabber, Progress, threading.Event], T]
"""Works with a camera, reports its progress, and stops once the event is set."""

REPORT_PERIOD = 0.05
"""Seconds between two reports of progress; nobody sees more."""


class CameraWork(QObject):
    """Runs work on the current camera, one task after another, and shows its progress."""

    def __init__(self, tasks: TaskStack, connection: Connection, messages: CurrentMessages) -> None:
        super().__init__(tasks)
        self._messages = messages
        self._tasks = tasks
        self._connection = connection
        self._bridge = Bridge(self)
        self._under_way: dict[threading.Event, OpenSource] = {}
        # Not over the bridge: work in progress has to stop before the camera is closed.
        connection.ending.connect(self._on_connection_ending)

    @property
    def source(self) -> OpenSource | None:
        """The source that `run` works on by default: the current one."""
        return self._connection.source

    def if_current(self, done: Callable[[T], None]) -> Callable[[T], None]:
        """Return a `done` for results that mean nothing once another source is current: it ignores them."""
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
        undoable: str = "",
        text: str = "",
        source: OpenSource | None = None,
    ) -> None:
        """Run `work` on the camera's thread, with `title` shown; then call `done` here with the result.

        `source` is the camera's, by default the current one; another may be current when `done` is called.
        Earlier changes, for instance of a slider that was just released, are written first. With `undoable`,
        all that is written is one step of that name to undo. A failure is posted as a message.
        """
        source = source or self.source
        if source is None or source.tracked_grabber is None or source.features is None:
            self._messages.error(self.tr("there is no camera; connect to one first"))
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
            self._bridge.call(lambda: end(lambda: self._connection.messages.error(error_text(error), source)))

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

    def _on_connection_ending(self, ending: OpenSource) -> None:
        for cancelled, source in tuple(self._under_way.items()):
            if source is ending:
                cancelled.set()


class CameraAbility(QObject):
    """Enables actions while the current camera supports them and may be changed."""

    ended = pyqtSignal()
    """The camera is gone, or another is being opened."""

    def __init__(
        self, owner: QObject, connection: Connection, ask: Callable[[FrameGrabber], bool], *actions: QAction
    ) -> None:
        """`ask` is called on the thread of the camera."""
        super().__init__(owner)
        self._connection = connection
        self._ask = ask
        self._actions = actions
        self._present = False
        self._bridge = bridge = Bridge(self)
        bridge.bind(connection.opened, self._on_connection_opened)
        bridge.bind(connection.state_changed, self._on_connection_state_changed)
        self._enable()

    def _on_connection_opened(self, source: OpenSource) -> None:
        grabber = source.grabber
        if grabber is None or source.read_only:
            return

        def on_answer(present: bool) -> None:
            self._bridge.call(lambda: self._allow(source, present))

        source.worker.submit(lambda: self._ask(grabber), done=on_answer)

    def _allow(self, source: OpenSource, present: bool) -> None:
        self._present = present and source is self._connection.source
        self._enable()

    def _on_connection_state_changed(self, state: LinkState, _: str) -> None:
        if state in (LinkState.CLOSED, LinkState.OPENING):
            self._present = False
            self.ended.emit()
        self._enable()

    def _enable(self) -> None:
        for action in self._actions:
            action.setEnabled(self._present and self._connection.state.connected)
