"""Every change of an open source: a log to show, and the steps that can be undone or redone.

A step is one action to the user: a slider dragged from here to there, a settings file loaded.
"""

from __future__ import annotations

import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace

from psygnal import Signal

from grabbergui.core.features import FeatureValue
from grabbergui.core.settings import SettingKey, ValueChange
from grabbergui.models.change import Change, Origin
from grabbergui.models.undo_steps import Direction, UndoHistory, UndoStep, continues

MOST_CHANGES = 2000
"Most changes kept in the log."


class ChangeJournal:
    """Records the changes of one source's features. Any thread; signals come from the recording thread.

    Repeated changes by one control, or of a value that the camera regulates, extend a single entry, which is
    removed if they lead back to the first value.
    """

    noted = Signal(Change)
    """A change; one that continues is emitted again under its number. One that is back at its first value
    is no longer `effective` and has left the log.
    """
    steps_changed = Signal()
    """The next step to undo or redo has changed."""

    def __init__(
        self,
        *,
        clock: Callable[[], float] = time.monotonic,
        time_of_day: Callable[[], float] = time.time,
    ) -> None:
        self._log: OrderedDict[int, Change] = OrderedDict()
        self._latest: dict[SettingKey | Origin, tuple[int, float]] = {}
        "Number and time of the operator's last change, and of the last change of each setting by others."
        self._history = UndoHistory()
        self._clock = clock
        self._time_of_day = time_of_day
        self._count = 0
        self._held: dict[str, float] = {}
        "Start of each interaction: controls that the user drags or types into."
        self._step: UndoStep | None = None
        self._reverting: Direction | None = None
        self._owed: tuple[Direction, dict[SettingKey, FeatureValue]] = (Direction.UNDO, {})
        "Values that the last undone or redone steps could not restore."
        self._lock = threading.RLock()

    @property
    def changes(self) -> tuple[Change, ...]:
        """The recorded changes, the oldest first."""
        with self._lock:
            return tuple(self._log.values())

    def next_text(self, direction: Direction) -> str:
        """Return the next step to undo or redo as display text; empty if there is none."""
        with self._lock:
            return str(self._history.next(direction) or "")

    def clear(self) -> None:
        """Clear the log; steps can still be undone."""
        with self._lock:
            self._log.clear()
            self._latest.clear()

    def wrote(
        self,
        written: Sequence[ValueChange],
        consequences: Sequence[ValueChange] = (),
        regulated: Mapping[SettingKey, FeatureValue] | None = None,
    ) -> None:
        """Record a write of the operator: its companions and, last in `written`, the intended setting.

        `consequences` are settings that the camera changed because of it, `regulated` the values that an
        automatic mode takes over. All of them belong to the same step.
        """
        with self._lock:
            now, since = self._clock(), self._held.get(written[-1].key.name)
            intended = written[-1].key
            written = [change for change in written if change.before != change.after]
            changes = [self._enter(*change, Origin.OPERATOR, now, since) for change in written]
            consequent = [self._enter(*change, Origin.CAMERA, now, None) for change in consequences]
            if self._reverting is None:
                self._owed = (Direction.UNDO, {})
                # An entry of the log may span several steps; a step needs the value before this write.
                pairs = zip((*consequent, *changes), (*consequences, *written), strict=True)
                own = [replace(change, before=before) for change, (_, before, _) in pairs]
                step = self._history.note(own, intended, self._step, now, since)
                for key, value in (regulated or {}).items():
                    step.regulated.setdefault(key, value)
        for change in (*changes, *consequent):
            self.noted.emit(change)
        self.steps_changed.emit()

    def ran(self, key: SettingKey, origin: Origin = Origin.OPERATOR, author: str = "") -> None:
        """Record a command, which cannot be undone; `author` is the program on the network that ran it."""
        with self._lock:
            if origin is Origin.OPERATOR:
                self._history.interrupt()
                self._latest.pop(Origin.OPERATOR, None)
            change = self._append(key, None, None, origin, author, command=True)
        self.noted.emit(change)

    def saw(
        self,
        key: SettingKey,
        before: FeatureValue,
        after: FeatureValue,
        origin: Origin,
        author: str = "",
    ) -> None:
        """Record a change by somebody else; `author` is the program on the network that made it."""
        with self._lock:
            change = self._enter(key, before, after, origin, self._clock(), None, author)
        self.noted.emit(change)

    def hold(self, name: str) -> None:
        """Join a control's writes into one step until `release`: the user drags it or types into it."""
        with self._lock:
            self._held[name] = self._clock()

    def release(self, name: str) -> None:
        """End the step that `hold` began."""
        with self._lock:
            self._held.pop(name, None)

    @contextmanager
    def within(self, step: UndoStep) -> Iterator[None]:
        """Join all writes in the block into one step. On the source's own thread."""
        with self._lock:
            self._step, outer = step, self._step
        try:
            yield
        finally:
            with self._lock:
                self._step = outer

    @contextmanager
    def reverting(self, direction: Direction) -> Iterator[UndoStep | None]:
        """Yield the step to undo or redo, if any; writes within the block form no step of their own.

        After the block the step can be reverted the other way; if the block raised, it can be tried again.
        """
        with self._lock:
            step = self._history.take(direction)
            self._reverting = direction
        reverted = False
        try:
            yield step
            reverted = True
        finally:
            with self._lock:
                self._reverting = None
                if step is not None:
                    self._history.put(direction.back if reverted else direction, step)
            self.steps_changed.emit()

    def owed(self, direction: Direction) -> dict[SettingKey, FeatureValue]:
        """Return the values that the latest steps in this direction could not restore."""
        with self._lock:
            return self._owed[1] if self._owed[0] is direction else {}

    def owe(self, direction: Direction, values: dict[SettingKey, FeatureValue]) -> None:
        """Remember values that could not be restored, for the next step in this direction."""
        with self._lock:
            self._owed = (direction, values)

    def _enter(
        self,
        key: SettingKey,
        before: FeatureValue | None,
        after: FeatureValue | None,
        origin: Origin,
        now: float,
        since: float | None,
        others: str = "",
    ) -> Change:
        # The operator's changes are sequential; those of others may interleave.
        author: SettingKey | Origin = origin if origin is Origin.OPERATOR else key
        number, moment = self._latest.get(author, (0, now))
        last = self._log.get(number)
        cause = self._cause if origin is Origin.OPERATOR else others
        same = last is not None and (last.key, last.origin, last.cause) == (key, origin, cause)
        if last is not None and same and continues(moment, now, since):
            change = replace(last, after=after)
            if not change.effective:
                del self._log[number], self._latest[author]
                return change
            self._log[number] = change
        else:
            change = self._append(key, before, after, origin, others)
        self._latest[author] = (change.number, now)
        return change

    def _append(
        self,
        key: SettingKey,
        before: FeatureValue | None,
        after: FeatureValue | None,
        origin: Origin,
        others: str = "",
        *,
        command: bool = False,
    ) -> Change:
        self._count += 1
        cause = self._cause if origin is Origin.OPERATOR else others
        change = Change(self._count, self._time_of_day(), key, before, after, origin, cause, command)
        self._log[change.number] = change
        while len(self._log) > MOST_CHANGES:
            self._log.popitem(last=False)
        return change

    @property
    def _cause(self) -> str:
        if self._reverting is not None:
            return self._reverting.title
        return self._step.cause if self._step is not None else ""
