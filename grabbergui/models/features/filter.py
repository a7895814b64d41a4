"""Which features somebody wants to see."""

from __future__ import annotations

from grabbergui.core.features import Category, FeatureDescription, Visibility

HAS_BUTTONS = frozenset({"AcquisitionStart", "AcquisitionStop", "AcquisitionAbort"})
"""Commands that beginners have buttons for, which also start and stop receiving."""


def matches(description: FeatureDescription, words: tuple[str, ...]) -> bool:
    """Whether every word, in lower case, occurs in the name, the display name or the tooltip."""
    haystack = f"{description.name}\n{description.display_name}\n{description.tooltip}".lower()
    return all(word in haystack for word in words)


def visible_names(root: Category, visibility: Visibility, text: str = "") -> list[str]:
    """Names of the features up to a visibility that match the text, in the tree's order, each once.

    A category that is meant for experts hides what is below it, as GenApi has it. Commands that have buttons
    in the window are for experts, too.
    """
    words = tuple(text.lower().split())
    found: dict[str, None] = {}
    _collect(root, visibility, words, found)
    return list(found)


def _collect(
    category: Category, visibility: Visibility, words: tuple[str, ...], found: dict[str, None]
) -> None:
    for member in category.members:
        expert = member.name in HAS_BUTTONS and not words
        if member.visibility > visibility or (expert and visibility < Visibility.EXPERT):
            continue
        if isinstance(member, Category):
            _collect(member, visibility, words, found)
        elif matches(member, words):
            found[member.name] = None
