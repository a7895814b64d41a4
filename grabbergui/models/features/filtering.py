"""Which features the window shows."""

from __future__ import annotations

from collections.abc import Collection

from grabbergui.core.features import (
    Category,
    FeatureDescription,
    Visibility,
)

HAS_BUTTONS = frozenset({"AcquisitionStart", "AcquisitionStop", "AcquisitionAbort"})
"""Commands with buttons in the window, which also start and stop reception."""


def visible_names(
    root: Category, visibility: Visibility, text: str = "", elsewhere: Collection[str] = ()
) -> list[str]:
    """Return the features up to a visibility that match the text, in the tree's order, each once.

    A category for experts hides everything below it, as GenApi defines. For beginners, unless they search,
    the list omits features with controls `elsewhere` in the window and commands with buttons.
    """
    words = tuple(text.lower().split())
    hidden = HAS_BUTTONS.union(elsewhere) if visibility < Visibility.EXPERT and not words else frozenset()
    found: dict[str, None] = {}
    _collect(root, visibility, words, hidden, found)
    return list(found)


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
        elif _matches(member, words):
            found[member.name] = None


def _matches(description: FeatureDescription, words: tuple[str, ...]) -> bool:
    """Return whether every word, in lower case, occurs in the name, the display name or the tooltip."""
    haystack = f"{description.name}\n{description.display_name}\n{description.tooltip}".lower()
    return all(word in haystack for word in words)
