"""Every change of an open source: a log to show, and the steps that can be undone."""

from __future__ import annotations

import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace

from psygnal import Signal

from grabbergui.core.features import FeatureValue
from grabbergui.core.selection import SettingKey, ValueChange
from grabbergui.models.changes.history import Change, Direction, Origin, Step, UndoHistory, goes_on

MOST_CHANGES = 2000
"Most changes kept in the log."


class ChangeJournal:
    """Keeps what happened to one source's features. Any thread; signals come from the one that noted.

    A control that is moved on and on, or a value that the camera regulates, is one entry that grows.
    """

    noted = Signal(Change)
    """A change; one that continued is emitted again under its number."""
    steps_changed = Signal()
    """The next step to undo or redo has changed."""

    def __init__(
        self,
        most: int = MOST_CHANGES,
        *,
        clock: Callable[[], float] = time.monotonic,
        time_of_day: Callable[[], float] = time.time,
    ) -> None:
        self._log: OrderedDict[int, Change] = OrderedDict()
        self._most = most
        self._going_on: dict[SettingKey | Origin, tuple[int, float]] = {}
        "Number and moment of the last change of a setting by others, and of the operator's last."
        self._history = UndoHistory()
        self._clock = clock
        self._time_of_day = time_of_day
        self._count = 0
        self._held: dict[str, float] = {}
        "Controls that are dragged or typed into, and since when."
        self._step: Step | None = None
        self._reverting: Direction | None = None
        self._owed: tuple[Direction, dict[SettingKey, FeatureValue]] = (Direction.UNDO, {})
        "Values that the last undone or redone steps could not restore."
        self._lock = threading.RLock()

    # -- what is known ---------------------------------------------------------------------------
    @property
    def changes(self) -> tuple[Change, ...]:
        """The recorded changes, the oldest first."""
        with self._lock:
            return tuple(self._log.values())

    def next_text(self, direction: Direction) -> str:
        """Return the next step to undo or redo as display text; empty if there is none."""
        with self._lock:
            return str(self._history.next(direction) or "")

    @property
    def gathering(self) -> bool:
        """Whether current writes belong to a larger step."""
        return self._step is not None

    def clear(self) -> None:
        """Clear the log; steps can still be undone."""
        with self._lock:
            self._log.clear()
            self._going_on.clear()

    # -- what happens ----------------------------------------------------------------------------
    def wrote(
        self,
        written: Sequence[ValueChange],
        consequences: Sequence[ValueChange] = (),
        regulated: Mapping[SettingKey, FeatureValue] | None = None,
    ) -> None:
        """Note what one write of the operator changed: the setting that was meant comes last in `written`.

        `consequences` are what the camera changed because of it, `regulated` values that an automatic mode
        takes over with this write. All of them belong to the same step.
        """
        with self._lock:
            now, since = self._clock(), self._held.get(written[-1].key.name)
            changes = [self._enter(*change, Origin.OPERATOR, now, since) for change in written]
            followed = [self._enter(*change, Origin.CAMERA, now, None) for change in consequences]
            if self._reverting is None:
                self._owed = (Direction.UNDO, {})
                # The log joins by its own rule what goes on; a step counts from where it began.
                pairs = zip((*followed, *changes), (*consequences, *written), strict=True)
                begun = [replace(change, before=before) for change, (_, before, _) in pairs]
                step = self._history.note(begun, self._step, now, since)
                for key, value in (regulated or {}).items():
                    step.regulated.setdefault(key, value)
        for change in (*changes, *followed):
            self.noted.emit(change)
        self.steps_changed.emit()

    def ran(self, name: str) -> None:
        """Record a command of the operator, which cannot be undone."""
        with self._lock:
            self._history.interrupt()
            self._going_on.pop(Origin.OPERATOR, None)
            change = self._append(SettingKey(name), None, None, Origin.OPERATOR, command=True)
        self.noted.emit(change)

    def saw(self, key: SettingKey, before: FeatureValue, after: FeatureValue, origin: Origin) -> None:
        """Record a change by somebody else."""
        with self._lock:
            change = self._enter(key, before, after, origin, self._clock(), None)
        self.noted.emit(change)

    def hold(self, name: str) -> None:
        """Count a control's writes as one step until `release`, however slow: it is dragged or typed into."""
        with self._lock:
            self._held[name] = self._clock()

    def release(self, name: str) -> None:
        """End the step that `hold` began."""
        with self._lock:
            self._held.pop(name, None)

    @contextmanager
    def within(self, step: Step) -> Iterator[None]:
        """Join all writes in the block, on the source's own thread, into one step."""
        with self._lock:
            self._step, outer = step, self._step
        try:
            yield
        finally:
            with self._lock:
                self._step = outer

    # -- undoing ---------------------------------------------------------------------------------
    @contextmanager
    def reverting(self, direction: Direction) -> Iterator[Step | None]:
        """Yield the step to undo or redo, if any; writes within the block are no step of their own.

        After the block the step can be reversed; if the block raised, it can be tried again.
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
        """Return the values that the steps reverted in a row could not restore so far."""
        with self._lock:
            return self._owed[1] if self._owed[0] is direction else {}

    def owe(self, direction: Direction, values: dict[SettingKey, FeatureValue]) -> None:
        """Keep the values that could not be restored for the next step in this direction."""
        with self._lock:
            self._owed = (direction, values)

    # -- the log, under the lock -----------------------------------------------------------------
    def _enter(
        self,
        key: SettingKey,
        before: FeatureValue | None,
        after: FeatureValue | None,
        origin: Origin,
        now: float,
        since: float | None,
    ) -> Change:
        # The operator's changes come one after another; those of others may interleave.
        place: SettingKey | Origin = origin if origin is Origin.OPERATOR else key
        number, moment = self._going_on.get(place, (0, now))
        last = self._log.get(number)
        cause = self._cause if origin is Origin.OPERATOR else ""
        same = last is not None and (last.key, last.origin, last.cause) == (key, origin, cause)
        if last is not None and same and goes_on(moment, now, since):
            change = replace(last, after=after)
            self._log[number] = change
        else:
            change = self._append(key, before, after, origin)
        self._going_on[place] = (change.number, now)
        return change

    def _append(
        self,
        key: SettingKey,
        before: FeatureValue | None,
        after: FeatureValue | None,
        origin: Origin,
        *,
        command: bool = False,
    ) -> Change:
        self._count += 1
        cause = self._cause if origin is Origin.OPERATOR else ""
        change = Change(self._count, self._time_of_day(), key, before, after, origin, cause, command)
        self._log[change.number] = change
        while len(self._log) > self._most:
            self._log.popitem(last=False)
        return change

    @property
    def _cause(self) -> str:
        if self._reverting is not None:
            return self._reverting.value
        return self._step.cause if self._step is not None else ""
