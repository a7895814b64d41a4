"""Durations as display text."""

from __future__ import annotations

_UNITS = ((999, 1, "s"), (3 * 3600, 60, "min"), (72 * 3600, 3600, "h"), (1000 * 86400, 86400, "days"))
"""Up to how many seconds a unit is used, its seconds, and its symbol."""
_YEAR = 365.25 * 86400


def duration_text(seconds: float) -> str:
    """Return a duration with at most three digits in a unit that suits it: `0.35 s`, `57 min`, `56 years`."""
    for most, unit, symbol in _UNITS:
        if abs(seconds) <= most:
            return f"{seconds / unit:.3g} {symbol}"
    return f"{seconds / _YEAR:.3g} years"
