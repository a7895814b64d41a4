"""The feature tree of a node map."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

from genicam import genapi

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.core.features import (
    AccessMode,
    Category,
    FeatureDescription,
)
from grabbergui.core.sfnc import features_by_role, role_of
from grabbergui.driver.genapi.node_features import access_of, describe, is_category, visibility_of


class FeatureTree:
    """The features that a camera implements, by category."""

    def __init__(self, node_map: Any) -> None:
        """Read the access mode of every feature. Raises RemoteProtocolError without a category Root."""
        self.descriptions: dict[str, FeatureDescription] = {}
        "Every feature by name."
        self._map = node_map
        self._categories: set[str] = set()
        root = node_map.get_node("Root") if node_map.has_node("Root") else None
        if root is None or not is_category(root):
            raise RemoteProtocolError("the camera's description cannot be used: it has no category Root")
        self.root = self._complete(self._category(root, frozenset()))
        "The category of all others."

    def _complete(self, root: Category) -> Category:
        """Add what the description has and does not list below Root."""
        # Some cameras have categories without a parent, which contain the gain, for example.
        orphans: list[Category] = []
        others: list[Any] = []
        for value in self._map.nodes:
            if is_category(value):
                if value.node.name not in self._categories and not value.node.parents:
                    orphans.append(self._category(value, frozenset()))
            elif role_of(value.node.name) is not None:
                others.append(value)
        branches = (*root.members, *(branch for branch in orphans if branch.members))
        if unlisted := tuple(self._unlisted(others)):
            branches += (Category("Unlisted", "Not in a category", members=unlisted),)
        return replace(root, members=branches)

    def _unlisted(self, nodes: Iterable[Any]) -> Iterator[FeatureDescription]:
        """Yield features that operators need and no category lists, such as a frame rate.

        `nodes`: those whose names have a role.
        """
        listed = features_by_role(self.descriptions.values())
        described = ((value, describe(value.node, "Unlisted")) for value in nodes)
        known = {description.name: (value, description) for value, description in described if description}
        for role, name in features_by_role(description for _, description in known.values()).items():
            value, description = known[name]
            if role not in listed and _implemented(value):
                self.descriptions[name] = description
                yield description

    def _category(self, category: Any, above: frozenset[str]) -> Category:
        node = category.node
        name = node.name
        self._categories.add(name)
        members: list[Category | FeatureDescription] = []
        for value in category.features:
            if not _implemented(value):
                continue
            if is_category(value):
                if value.node.name not in above | {name}:
                    branch = self._category(value, above | {name})
                    if branch.members:
                        members.append(branch)
            elif (description := describe(value.node, name)) is not None:
                self.descriptions.setdefault(description.name, description)
                members.append(description)
        return Category(name, node.display_name, node.tooltip, visibility_of(node), tuple(members))


def _implemented(value: Any) -> bool:
    try:
        return access_of(value) is not AccessMode.NOT_IMPLEMENTED
    except (genapi.GenericException, RuntimeError):
        # A failed access does not say that the feature is missing. Its row in the panel shows the error.
        return True
