"""Undo and redo: what a step changed is written again."""

from __future__ import annotations

from grabbergui.core.errors import FeatureError
from grabbergui.core.features import FeatureValue
from grabbergui.models.changes.noting import NotingGrabber
from grabbergui.models.changes.undo_history import Direction, Values
from grabbergui.models.features.stream_pause import stream_paused
from grabbergui.models.settings.feature_set import Selectors, SettingKey, same_value

MAX_PASSES = 6
"As when settings are loaded: one may hide, lock or limit another."
FEW = 4
"Settings; for more the stream is stopped once instead of once for each that changes the frames."


def revert(grabber: NotingGrabber, direction: Direction) -> list[str]:
    """Undo or redo the next step; what did not work, a sentence each. Does nothing where there is no step.

    On the thread that makes the grabber's calls. What the camera refuses is left as it is, and the step
    counts as undone. Raises TransportError when the camera is gone; the step can be tried again then.
    """
    with grabber.journal.reverting(direction) as step:
        if step is None:
            return []
        problems = write_values(grabber, step.values(direction))
    return [f"{direction.value} of {step}: {problem}" for problem in problems]


def write_values(grabber: NotingGrabber, values: Values) -> list[str]:
    """Write settings, each with its selectors where they belong; what was refused and why.

    What is refused is tried again after the others, as long as any of them is taken. Selectors end where
    they stood.
    """
    # Selectors are moved behind the journal's back: where they stand for a moment is nobody's change.
    selectors = Selectors(grabber.plain)
    moved = dict.fromkeys(selector for key, _ in values for selector, _ in key.selected)
    for name in {key.name for key, _ in values}:
        moved.pop(name, None)
    with stream_paused(grabber, len(values) > FEW), selectors.kept(list(moved)):
        for _ in range(MAX_PASSES):
            problems = {key: _write(grabber, selectors, key, value) for key, value in values}
            left = [(key, value) for key, value in values if problems[key]]
            if not left or len(left) == len(values):
                break
            values = left
    return [problem for problem in problems.values() if problem]


def _write(grabber: NotingGrabber, selectors: Selectors, key: SettingKey, value: FeatureValue) -> str:
    if not selectors.select(key.selected):
        return f"{key} cannot be selected just now"
    try:
        present = grabber.feature(key.name).value
        if present is None or not same_value(present, value):
            grabber.write_feature(key.name, value)
    except FeatureError as error:
        return str(error)
    return ""
