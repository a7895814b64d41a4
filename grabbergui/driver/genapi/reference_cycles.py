"""Cycles among the references of a description's nodes, which GenApi refuses."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Set
from contextlib import suppress
from graphlib import CycleError, TopologicalSorter


def cyclic_groups(references: Mapping[str, Set[str]]) -> Iterator[list[str]]:
    """Yield the groups of nodes of which each depends on each other one, and so on itself.

    `references` has for each node those that it refers to. In time linear in their number (Tarjan 1972).
    """
    number: dict[str, int] = {}
    lowest: dict[str, int] = {}
    stack: list[str] = []
    stacked: set[str] = set()
    for start in references:
        path = [] if start in number else [(start, iter(references[start]))]
        while path:
            name, targets = path[-1]
            if name not in number:
                number[name] = lowest[name] = len(number)
                stack.append(name)
                stacked.add(name)
            for target in targets:
                if target in stacked:
                    lowest[name] = min(lowest[name], number[target])
                elif target not in number and target in references:
                    path.append((target, iter(references[target])))
                    break
            else:
                path.pop()
                if path:
                    lowest[path[-1][0]] = min(lowest[path[-1][0]], lowest[name])
                if lowest[name] == number[name]:
                    group = [stack.pop()]
                    while group[-1] != name:
                        group.append(stack.pop())
                    stacked.difference_update(group)
                    if len(group) > 1 or name in references[name]:
                        yield group


def dependency_order(needs: Mapping[str, Set[str]]) -> list[str]:
    """Return the nodes, each after those that it needs; without those that need themselves."""
    sorter = TopologicalSorter(needs)
    with suppress(CycleError):
        sorter.prepare()
    order: list[str] = []
    while ready := sorter.get_ready():
        order += ready
        sorter.done(*ready)
    return order
