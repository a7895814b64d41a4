"""Changes of the current camera: longer work on it, actions that only some cameras support, undo and redo."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TypeVar

from PyQt5.QtCore import QObject, pyqtSignal
from PyQt5.QtWidgets import QAction, QApplication

from grabbergui.core.environment import write_whole
from grabbergui.core.errors import GrabberError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.models.change_tracking import ChangeTrackingGrabber, command_line, program, revert
from grabbergui.models.connection import Connection
from grabbergui.models.error_text import error_text
from grabbergui.models.open_source import Lack, LinkState, OpenSource, lack_of
from grabbergui.models.settings.feature_set import Progress
from grabbergui.models.source_messages import CurrentMessages
from grabbergui.models.undo_steps import Direction, Step
from grabbergui.ui.editors.feature_row import FeatureRows
from grabbergui.ui.gui_thread import Bridge
from grabbergui.ui.views.bases import FileQuestions, UndoActions
from grabbergui.ui.views.changes_panel import ChangesPanel, CopyAs
from grabbergui.ui.widgets.labels import TaskRow, TaskStack
from grabbergui.ui.windows import set_available

# -- longer work ---------------------------------------------------------------------------------
T = TypeVar("T")

Work = Callable[[ChangeTrackingGrabber, Progress, threading.Event], T]
"""Works with a camera, reports its progress, and stops once the event is set."""

REPORT_PERIOD = 0.05
"""Seconds between two reports of progress."""


class CameraWork(QObject):
    """Runs work on the current camera, one task after another, and shows its progress."""

    def __init__(self, tasks: TaskStack, connection: Connection, messages: CurrentMessages) -> None:
        super().__init__(tasks)
        self._messages = messages
        self._tasks = tasks
        self._connection = connection
        self._bridge = Bridge(self)
        self._in_progress: dict[threading.Event, OpenSource] = {}
        # Not over the bridge: work in progress has to stop before the camera is closed.
        connection.ending.connect(self._on_connection_ending)

    @property
    def source(self) -> OpenSource | None:
        """The source that `run` works on by default: the current one."""
        return self._connection.source

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
            with grabber.journal.within(Step(undoable)):
                return work(grabber, progress, cancelled)

        def end(report: Callable[[], None]) -> None:
            self._in_progress.pop(cancelled, None)
            self._tasks.end(row)
            report()

        def succeeded(result: T) -> None:
            self._bridge.call(lambda: end(lambda: done(result)))

        def gone_wrong(error: GrabberError) -> None:
            def report() -> None:
                self._connection.messages.error(error_text(error), source)
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

    def _on_connection_ending(self, ending: OpenSource) -> None:
        for cancelled, source in tuple(self._in_progress.items()):
            if source is ending:
                cancelled.set()


# -- actions that only some cameras support ------------------------------------------------------
class CameraAbility(QObject):
    """Enables actions while the current camera supports them and may be changed."""

    changed = pyqtSignal()
    """`lack` may have changed."""
    ended = pyqtSignal()
    """The camera is gone, or another is being opened."""

    def __init__(
        self,
        owner: QObject,
        connection: Connection,
        ask: Callable[[FrameGrabber], bool],
        lack: Lack,
        *actions: QAction,
    ) -> None:
        """`ask` is called on the thread of the camera; `lack` is the reason if it returns False."""
        super().__init__(owner)
        self._connection = connection
        self._ask = ask
        self._lack = lack
        self._actions = actions
        self._present = False
        self._bridge = bridge = Bridge(self)
        bridge.bind(connection.opened, self._on_connection_opened)
        bridge.bind(connection.state_changed, self._on_connection_state_changed)
        self._enable()

    def lack(self, *, stream: bool = False) -> Lack | None:
        """Return why the actions are not available: the source, control of it, its stream, or the ability."""
        missing = lack_of(self._connection.source, stream=stream, control=True)
        return missing if missing is not None or self._present else self._lack

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
            set_available(action, self.lack())
        self.changed.emit()


# -- changes -------------------------------------------------------------------------------------
MOST_SHOWN = 60
"Characters of a step's text in the menu."


class ChangesController(QObject):
    """Each source has its own changes; those of a closed source stay visible until another is opened."""

    def __init__(
        self,
        actions: UndoActions,
        panel: ChangesPanel,
        edited: Sequence[FeatureRows],
        files: FileQuestions,
        connection: Connection,
        messages: CurrentMessages,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._panel = panel
        self._files = files
        self._messages = messages
        self._source: OpenSource | None = None
        self._open = False
        self._actions = {Direction.UNDO: actions.actionUndo, Direction.REDO: actions.actionRedo}
        self._bridge = bridge = Bridge(self)
        bridge.bind(connection.opened, self._on_connection_opened)
        bridge.bind(connection.closing, self._on_connection_closing)
        self._journal_bridge: Bridge | None = None
        for direction, action in self._actions.items():
            action.triggered.connect(partial(self._revert, direction))
        for rows in edited:
            rows.held.connect(self._on_rows_held)
            rows.released.connect(self._on_rows_released)
        self._panel.whoseChanged.connect(self._show_all)
        self._panel.clearRequested.connect(self._clear)
        self._panel.copyRequested.connect(self._copy)
        self._panel.saveRequested.connect(self._ask_save)
        self._show_steps()

    # -- undo and redo ---------------------------------------------------------------------------
    def _revert(self, direction: Direction, _: bool = False) -> None:
        source = self._source
        if source is None or source.features is None or source.tracked_grabber is None:
            return
        job = partial(revert, source.tracked_grabber, direction)
        source.features.run(job, done=lambda problems: self._bridge.call(partial(self._say, problems)))

    def _on_rows_held(self, name: str) -> None:
        if self._source is not None:
            self._source.journal.hold(name)

    def _on_rows_released(self, name: str) -> None:
        if self._source is not None:
            self._source.journal.release(name)

    def _say(self, problems: list[str]) -> None:
        for problem in problems:
            self._messages.error(problem)

    def _show_steps(self) -> None:
        for direction, action in self._actions.items():
            text = self._source.journal.next_text(direction) if self._source and self._open else ""
            _describe(action, self._name(direction), text)
            nothing = Lack.CHANGE if direction is Direction.UNDO else Lack.UNDONE
            set_available(action, None if text else nothing if self._open else Lack.SOURCE)

    def _name(self, direction: Direction) -> str:
        return self.tr("&Undo") if direction is Direction.UNDO else self.tr("&Redo")

    # -- the list --------------------------------------------------------------------------------
    def _on_connection_opened(self, source: OpenSource) -> None:
        self._source, self._open = source, True
        if self._journal_bridge is not None:
            self._journal_bridge.close()
        self._journal_bridge = Bridge(self)
        self._journal_bridge.bind(source.journal.noted, self._panel.noteChange)
        self._journal_bridge.bind(source.journal.steps_changed, self._show_steps)
        self._show_all()
        self._show_steps()

    def _on_connection_closing(self, source: OpenSource) -> None:
        if source is self._source:
            self._open = False
            self._show_steps()

    def _show_all(self) -> None:
        self._panel.setChanges(self._source.journal.changes if self._source is not None else ())

    def _clear(self) -> None:
        if self._source is not None:
            self._source.journal.clear()
        self._show_all()

    # -- doing it again --------------------------------------------------------------------------
    def _copy(self, kind: CopyAs) -> None:
        if (clipboard := QApplication.clipboard()) is not None:
            clipboard.setText(self._text(kind))

    def _ask_save(self) -> None:
        kinds = self.tr("Python program (*.py);;Shell script (*.sh);;Table (*.tsv)")
        if path := self._files.to_save(self.tr("Save changes"), "changes.py", kinds):
            self.save(path)

    def save(self, path: Path) -> None:
        """Save the selected changes in the format of the file's suffix."""
        kind = {".py": CopyAs.PROGRAM, ".sh": CopyAs.COMMAND}.get(path.suffix, CopyAs.TABLE)
        text = self._text(kind)
        with self._messages.saving(path, self.tr("Saved the changes to {0}")):
            write_whole(path, f"#!/bin/sh -e\n{text}" if kind is CopyAs.COMMAND else text)

    def _text(self, kind: CopyAs) -> str:
        changes = self._panel.chosen
        uri = str(self._source.uri) if self._source is not None else ""
        if kind is CopyAs.COMMAND:
            return command_line(uri, changes)
        return program(uri, changes) if kind is CopyAs.PROGRAM else self._panel.tableText(changes)


def _describe(action: QAction, name: str, what: str) -> None:
    """Name the step in the menu's entry."""
    shown = what if len(what) <= MOST_SHOWN else what[: MOST_SHOWN - 1] + "…"
    action.setText(f"{name} {shown.replace('&', '&&')}".rstrip())
    action.setIconText(name.replace("&", ""))
