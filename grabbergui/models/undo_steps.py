"""The steps of a source's history that can be undone or redone."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from enum import Enum

from grabbergui.core.features import FeatureValue
from grabbergui.core.settings import SettingKey
from grabbergui.models.change import Change, Origin
from grabbergui.models.language import translate

MOST_STEPS = 200
"Most steps that can be undone."
_MOST_SETTINGS = 5000
"Most changes within one step; the first ones are kept."
STEP_PAUSE = 1.0
"Seconds without a write of a feature after which the next one is another step."

Values = list[tuple[SettingKey, FeatureValue]]
"Settings and what to write to them, in order."


class Direction(Enum):
    """Direction through the steps."""

    UNDO = "Undo"
    REDO = "Redo"

    @property
    def back(self) -> Direction:
        """The opposite direction."""
        return Direction.REDO if self is Direction.UNDO else Direction.UNDO

    @property
    def title(self) -> str:
        """The direction as display text."""
        return translate("Changes", "Undo") if self is Direction.UNDO else translate("Changes", "Redo")


@dataclass(eq=False)
class UndoStep:
    """Changes that are undone together. Pass it to `ChangeJournal.within` to group several writes."""

    cause: str = ""
    "Display text: `Loaded settings.yaml`; empty for a single control."
    changes: dict[SettingKey, Change] = field(default_factory=dict)
    "By setting, in the order of their first write."
    regulated: dict[SettingKey, FeatureValue] = field(default_factory=dict)
    "Manual values displaced by an automatic mode; undoing the mode restores them."
    last: float = 0.0
    "Time of the last write in seconds of the journal's clock."
    intended: SettingKey | None = None
    "The setting that was written last; the others changed with it."

    def add(self, change: Change, now: float) -> None:
        """Add a change; merge it with an earlier change of the same setting."""
        known = self.changes.get(change.key)
        if known is not None:
            change = replace(change, before=known.before)
        elif len(self.changes) >= _MOST_SETTINGS:
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
        written = [change for change in changes if change.origin is not Origin.CAMERA]
        return ", ".join(str(change) for change in written or changes)


class UndoHistory:
    """Steps done and steps undone, the newest last; the oldest are dropped. One thread at a time."""

    def __init__(self) -> None:
        self._steps: dict[Direction, deque[UndoStep]] = {way: deque(maxlen=MOST_STEPS) for way in Direction}
        self._interrupted = False

    def next(self, direction: Direction) -> UndoStep | None:
        """Return the step that would be undone or redone next."""
        steps = self._steps[direction]
        return steps[-1] if steps else None

    def note(
        self,
        changes: Iterable[Change],
        intended: SettingKey,
        step: UndoStep | None,
        now: float,
        since: float | None = None,
    ) -> UndoStep:
        """Add changes to `step`, or else to the previous step if they continue it. Return their step.

        A step of a single control continues while the user holds the control (`since` this moment), or writes
        it again within `STEP_PAUSE`, unless something else changes in between.
        """
        step = step or self._continued(intended, now, since) or UndoStep()
        for change in changes:
            step.add(change, now)
        step.intended = intended
        done = self._steps[Direction.UNDO]
        if step not in done:
            done.append(step)
        if not step.effective:
            done.remove(step)  # all values are as before
        self._steps[Direction.REDO].clear()
        self._interrupted = False
        return step

    def interrupt(self) -> None:
        """Let the next change start a step of its own, after something that cannot be undone."""
        self._interrupted = True

    def take(self, direction: Direction) -> UndoStep | None:
        """Remove and return the next step. The caller must `put` it on one of the two stacks afterwards."""
        self._interrupted = True
        steps = self._steps[direction]
        return steps.pop() if steps else None

    def put(self, direction: Direction, step: UndoStep) -> None:
        """Put a step on the stack of the direction in which it can be reverted next."""
        self._steps[direction].append(step)

    def _continued(self, key: SettingKey, now: float, since: float | None) -> UndoStep | None:
        """Return the previous step if a write of this setting continues it."""
        step = self.next(Direction.UNDO)
        if step is None or step.cause or self._interrupted:
            return None
        return step if step.intended == key and continues(step.last, now, since) else None


def continues(last: float, now: float, since: float | None) -> bool:
    """Return whether a write continues the previous one: soon after it, or within one interaction."""
    return now - last < STEP_PAUSE or (since is not None and last >= since)
