"""Arguments that many calls share, checked before anything is sent to a camera."""

from __future__ import annotations

import operator

from grabbergui.core.errors import UsageError


def checked_timeout(call: str, timeout: float | None) -> float | None:
    """Return a time-out in seconds, or None for the default. Raises UsageError."""
    if timeout is None:
        return None
    try:
        seconds = float(timeout)
    except (TypeError, ValueError):
        seconds = -1.0
    if isinstance(timeout, str) or not seconds >= 0:
        raise UsageError(f"{call}(timeout={timeout!r}): the time-out is in seconds, as in timeout=0.5")
    return seconds


def checked_count(call: str, count: int | None) -> int | None:
    """Return a number of frames or sets, or None for no end. Raises UsageError."""
    if count is None:
        return None
    number = _whole(count)
    if number is None or number < 0:
        raise UsageError(f"{call}({count!r}): the number of frames is 0 or more, or None for no end")
    return number


def checked_depth(call: str, depth: int) -> int:
    """Return how many frames may wait for a loop. Raises UsageError."""
    number = _whole(depth)
    if number is None or number < 1:
        raise UsageError(f"{call}(depth={depth!r}): at least one frame must be able to wait for the loop")
    return number


def _whole(value: object) -> int | None:
    try:
        return operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        return None
