"""Undo and redo: what a step changed is written again."""

from __future__ import annotations

from collections.abc import Mapping

from grabbergui.core.features import FeatureValue
from grabbergui.core.selection import SettingKey
from grabbergui.core.settling import settle
from grabbergui.models.changes.noting import NotingGrabber
from grabbergui.models.changes.undo_history import Direction
from grabbergui.models.features.stream_pause import stream_paused

FEW = 4
"Settings; for more the stream is stopped once instead of once for each that changes the frames."


def revert(grabber: NotingGrabber, direction: Direction) -> list[str]:
    """Undo or redo the next step; return what could not be brought back, a sentence each.

    On the thread that makes the grabber's calls. What the camera refuses is tried again with the next step:
    an automatic mode may have moved what limits it, and that mode is undone later. Does nothing where there
    is no step. Raises TransportError when the camera is gone; the step can be tried again then.
    """
    journal = grabber.journal
    with journal.reverting(direction) as step:
        if step is None:
            return []
        values = dict(step.values(direction))
        wanted = {**journal.owed(direction), **values}
        problems = write_values(grabber, wanted)
        journal.owe(direction, {key: wanted[key] for key in problems})
    return [f"{direction.value} of {step}: {problem}" for key, problem in problems.items() if key in values]


def write_values(grabber: NotingGrabber, values: Mapping[SettingKey, FeatureValue]) -> dict[SettingKey, str]:
    """Write settings until all are there, as `settle` does; return what could not be set, a sentence each."""
    with stream_paused(grabber, len(values) > FEW):
        return settle(grabber, values)
