"""Selection of the features shown: by visibility, by filter, and pinned ones. Pure functions."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

from grabbergui.core.features import Category, FeatureDescription, Visibility
from grabbergui.core.sfnc import automatic_mode_of

HAS_BUTTONS = frozenset({"AcquisitionStart", "AcquisitionStop", "AcquisitionAbort"})
"""Commands that beginners have buttons for, which also start and stop receiving."""


def matches(description: FeatureDescription, words: tuple[str, ...]) -> bool:
    """Return whether every word, in lower case, occurs in the name, the display name or the tooltip."""
    haystack = f"{description.name}\n{description.display_name}\n{description.tooltip}".lower()
    return all(word in haystack for word in words)


def visible_names(
    root: Category, visibility: Visibility, text: str = "", elsewhere: Collection[str] = ()
) -> list[str]:
    """Return the features up to a visibility that match the text, in the tree's order, each once.

    A category for experts hides everything below it, as GenApi defines it. Beginners see a feature once:
    unless they search for it, the list omits features with controls `elsewhere` in the window and commands
    that have buttons.
    """
    words = tuple(text.lower().split())
    hidden = HAS_BUTTONS.union(elsewhere) if visibility < Visibility.EXPERT and not words else frozenset()
    found: dict[str, None] = {}
    _collect(root, visibility, words, hidden, found)
    return list(found)


def controlled_by(pinned: Collection[str], has: Callable[[str], bool]) -> frozenset[str]:
    """Return the features that pinned controls set: those that are pinned, and their automatic modes."""
    modes = (automatic_mode_of(name, has) for name in pinned)
    return frozenset(pinned).union(mode for mode in modes if mode is not None)


def _collect(
    category: Category,
    visibility: Visibility,
    words: tuple[str, ...],
    hidden: frozenset[str],
    found: dict[str, None],
) -> None:
    for member in category.members:
        if member.visibility > visibility or member.name in hidden:
            continue
        if isinstance(member, Category):
            _collect(member, visibility, words, hidden, found)
        elif matches(member, words):
            found[member.name] = None


MOST = 12
"Most features that can be pinned."


def placed(names: Sequence[str], name: str, index: int) -> tuple[str, ...]:
    """Return the names with one of them at the place before which it was dropped; it may be there already.

    A place beyond the end is the end. With `MOST` names, one that is not among them is not taken.
    """
    if name not in names and len(names) >= MOST:
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
