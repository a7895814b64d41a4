"""Changes of the current camera: longer work on it, actions that only some cameras support, undo and redo."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from PyQt5.QtCore import QObject
from PyQt5.QtWidgets import QAction, QApplication

from grabbergui.core.environment import write_whole
from grabbergui.models.change_tracking import command_line, program, revert
from grabbergui.models.open_source import OpenSource
from grabbergui.models.unavailable import Unavailable
from grabbergui.models.undo_steps import Direction
from grabbergui.ui.actions import set_available
from grabbergui.ui.controllers.source_context import SourceContext
from grabbergui.ui.editors.feature_row import FeatureRows
from grabbergui.ui.gui_thread import Bridge
from grabbergui.ui.views.bases import UndoActions
from grabbergui.ui.views.changes_panel import ChangesPanel, CopyAs

MOST_SHOWN = 60
"Characters of a step's text in the menu."


class ChangesController(QObject):
    """Each source has its own changes; those of a closed source stay visible until another is opened."""

    def __init__(
        self,
        actions: UndoActions,
        panel: ChangesPanel,
        edited: Sequence[FeatureRows],
        context: SourceContext,
    ) -> None:
        super().__init__(context.window)
        self._panel = panel
        self._files = context.files
        self._messages = context.messages
        self._source: OpenSource | None = None
        self._open = False
        self._actions = {Direction.UNDO: actions.actionUndo, Direction.REDO: actions.actionRedo}
        self._bridge = bridge = Bridge(self)
        bridge.bind(context.open_sources.opened, self._on_source_opened)
        bridge.bind(context.open_sources.closing, self._on_source_closing)
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
            nothing = Unavailable.CHANGE if direction is Direction.UNDO else Unavailable.UNDONE
            set_available(action, None if text else nothing if self._open else Unavailable.SOURCE)

    def _name(self, direction: Direction) -> str:
        return self.tr("&Undo") if direction is Direction.UNDO else self.tr("&Redo")

    def _on_source_opened(self, source: OpenSource) -> None:
        self._source, self._open = source, True
        if self._journal_bridge is not None:
            self._journal_bridge.close()
        self._journal_bridge = Bridge(self)
        self._journal_bridge.bind(source.journal.noted, self._panel.noteChange)
        self._journal_bridge.bind(source.journal.steps_changed, self._show_steps)
        self._show_all()
        self._show_steps()

    def _on_source_closing(self, source: OpenSource) -> None:
        if source is self._source:
            self._open = False
            self._show_steps()

    def _show_all(self) -> None:
        self._panel.setChanges(self._source.journal.changes if self._source is not None else ())

    def _clear(self) -> None:
        if self._source is not None:
            self._source.journal.clear()
        self._show_all()

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
