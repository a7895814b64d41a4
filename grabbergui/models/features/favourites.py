"""Features that somebody wants at hand: an order, and how it is changed. Pure functions."""

from __future__ import annotations

from collections.abc import Sequence

MOST = 12
"What is more is not at hand any more."


def placed(names: Sequence[str], name: str, index: int) -> tuple[str, ...]:
    """The names with one of them at the place before which it was dropped; it may be there already.

    A place beyond the end is the end. With `MOST` names, one that is not among them is not taken.
    """
    if name not in names and len(names) >= MOST:
        return tuple(names)
    index = min(max(index, 0), len(names))
    before = [other for other in names[:index] if other != name]
    after = [other for other in names[index:] if other != name]
    return (*before, name, *after)


def without(names: Sequence[str], name: str) -> tuple[str, ...]:
    """The names without one."""
    return tuple(other for other in names if other != name)


def moved(names: Sequence[str], name: str, steps: int) -> tuple[str, ...]:
    """The names with one of them so many places further on, or back."""
    if name not in names:
        return tuple(names)
    others = without(names, name)
    index = min(max(names.index(name) + steps, 0), len(others))
    return (*others[:index], name, *others[index:])
