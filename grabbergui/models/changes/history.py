"""Changes of features, and which of them can be undone or redone: bookkeeping only.

A step is one action to the user: a slider dragged from here to there, a settings file loaded.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from enum import Enum

from grabbergui.core.features import FeatureValue, format_value
from grabbergui.core.selection import SettingKey


class Origin(Enum):
    """Author of a change."""

    OPERATOR = "operator"
    "A person at this window, or what they started here."
    CAMERA = "camera"
    "The camera by itself: an automatic mode, or the consequence of another change."
    NETWORK = "network"
    "Another user of the same camera over a network."


@dataclass(frozen=True)
class Change:
    """The values of a feature before and after a change; a command that was run has neither."""

    number: int
    "Counts up from 1. A change that continues, as while a slider is dragged, keeps its number."
    time: float
    "Seconds since the epoch when it began."
    key: SettingKey
    before: FeatureValue | None
    after: FeatureValue | None
    origin: Origin
    cause: str = ""
    "The operation it was part of, as display text: `Loaded settings.yaml`; empty for a single control."
    command: bool = False

    @property
    def effective(self) -> bool:
        """Whether anything differs from before."""
        return self.command or self.before != self.after

    def __str__(self) -> str:
        """`Gain 0 → 6`, `TriggerSoftware run`."""
        if self.command:
            return f"{self.key} run"
        return f"{self.key} {format_value(self.before)} → {format_value(self.after)}"


MOST_STEPS = 200
MOST_SETTINGS = 5000
"Most changes within one step; the first ones are kept."
PAUSE = 1.0
"Seconds without a write of a feature after which the next one is another step."

Values = list[tuple[SettingKey, FeatureValue]]


class Direction(Enum):
    """Direction through the steps."""

    UNDO = "Undo"
    REDO = "Redo"

    @property
    def back(self) -> Direction:
        """The opposite direction."""
        return Direction.REDO if self is Direction.UNDO else Direction.UNDO


@dataclass(eq=False)
class Step:
    """Changes that are undone together. Pass it to `ChangeJournal.within` to group several writes."""

    cause: str = ""
    "Display text: `Loaded settings.yaml`; empty for a single control."
    changes: dict[SettingKey, Change] = field(default_factory=dict)
    "By setting, in the order of their first write."
    regulated: dict[SettingKey, FeatureValue] = field(default_factory=dict)
    "Manual values displaced by an automatic mode; undoing the mode restores them."
    last: float = 0.0
    "Time of the last write in seconds of the journal's clock."
    meant: SettingKey | None = None
    "The setting that was written last; the others changed with it."

    def add(self, change: Change, now: float) -> None:
        """Add a change; merge it with an earlier change of the same setting."""
        known = self.changes.get(change.key)
        if known is not None:
            change = replace(change, before=known.before)
        elif len(self.changes) >= MOST_SETTINGS:
            return
        self.changes[change.key] = change
        self.last = now

    @property
    def effective(self) -> bool:
        """Whether anything differs from before."""
        return any(change.effective for change in self.changes.values())

    def values(self, direction: Direction) -> Values:
        """Return the writes that undo or redo the step, in order."""
        changes = [change for change in self.changes.values() if change.effective]
        if direction is Direction.REDO:
            return [(change.key, change.after) for change in changes if change.after is not None]
        before = [(change.key, change.before) for change in reversed(changes)]
        return [(key, value) for key, value in (*before, *self.regulated.items()) if value is not None]

    def __str__(self) -> str:
        if self.cause:
            return self.cause
        changes = [change for change in self.changes.values() if change.effective]
        meant = [change for change in changes if change.origin is not Origin.CAMERA]
        return ", ".join(str(change) for change in meant or changes)


class UndoHistory:
    """Steps done and steps undone, the newest last; the oldest are dropped. One thread at a time."""

    def __init__(self, most: int = MOST_STEPS) -> None:
        self._steps: dict[Direction, deque[Step]] = {way: deque(maxlen=most) for way in Direction}
        self._interrupted = False

    def next(self, direction: Direction) -> Step | None:
        """Return the step that would be undone or redone next."""
        steps = self._steps[direction]
        return steps[-1] if steps else None

    def note(
        self, changes: Iterable[Change], step: Step | None, now: float, since: float | None = None
    ) -> Step:
        """Record a change as part of `step`, or of the previous step that it continues.

        A single control goes on while it is held, which it is `since` then, or for a moment longer, as long
        as nothing else is changed in between. Returns the step it became part of.
        """
        changes = list(changes)
        step = step or self._going_on(changes[-1].key, now, since) or Step()
        for change in changes:
            step.add(change, now)
        step.meant = changes[-1].key
        done = self._steps[Direction.UNDO]
        if step not in done:
            done.append(step)
        if not step.effective:
            done.remove(step)  # all values are as before
        self._steps[Direction.REDO].clear()
        self._interrupted = False
        return step

    def interrupt(self) -> None:
        """Note a change that cannot be undone: the next change starts a step of its own."""
        self._interrupted = True

    def take(self, direction: Direction) -> Step | None:
        """Remove and return the next step. The caller must `put` it on one of the two stacks afterwards."""
        self._interrupted = True
        steps = self._steps[direction]
        return steps.pop() if steps else None

    def put(self, direction: Direction, step: Step) -> None:
        """Put a step on the stack of those that can be undone, or redone."""
        self._steps[direction].append(step)

    def _going_on(self, key: SettingKey, now: float, since: float | None) -> Step | None:
        step = self.next(Direction.UNDO)
        if step is None or step.cause or self._interrupted:
            return None
        return step if step.meant == key and goes_on(step.last, now, since) else None


def goes_on(last: float, now: float, since: float | None) -> bool:
    """Return whether a write continues the previous one: soon after it, or within one interaction."""
    return now - last < PAUSE or (since is not None and last >= since)
