"""The pinned controls: their order, and what controls them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

from grabbergui.core.sfnc import automatic_mode_of

MOST_PINNED = 12
"Most features that can be pinned."


def controlled_by(pinned: Collection[str], has: Callable[[str], bool]) -> frozenset[str]:
    """Return the features that pinned controls set: the pinned features and their automatic modes."""
    modes = (automatic_mode_of(name, has) for name in pinned)
    return frozenset(pinned).union(mode for mode in modes if mode is not None)


def placed(names: Sequence[str], name: str, index: int) -> tuple[str, ...]:
    """Return the names with one of them, new or known, moved before the name at `index`.

    An index beyond the end means the end. With `MOST_PINNED` names, no new name is added.
    """
    if name not in names and len(names) >= MOST_PINNED:
        return tuple(names)
    index = min(max(index, 0), len(names))
    before = [other for other in names[:index] if other != name]
    after = [other for other in names[index:] if other != name]
    return (*before, name, *after)


def without(names: Sequence[str], name: str) -> tuple[str, ...]:
    """Return the names without one."""
    return tuple(other for other in names if other != name)


def moved(names: Sequence[str], name: str, steps: int) -> tuple[str, ...]:
    """Return the names with one of them moved by a number of places."""
    if name not in names:
        return tuple(names)
    others = without(names, name)
    index = min(max(names.index(name) + steps, 0), len(others))
    return (*others[:index], name, *others[index:])
