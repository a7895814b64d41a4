"""Commands of guests: packages such as `servo`, which nothing else imports.

A guest registers each of its commands as an entry point in the group `grabbergui.commands`: the command's
name, and a function that adds its parser, as `add_commands` of the families here does.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

GROUP = "grabbergui.commands"


@cache
def guest_commands() -> dict[str, EntryPoint]:
    """Return the entry points of all guests' commands, by name; no guest is imported."""
    from importlib.metadata import entry_points  # a third of the time of `grabbergui --version`

    return {entry.name: entry for entry in entry_points(group=GROUP)}


def add_guest_commands(commands: Any, names: Iterable[str]) -> None:
    """Add the parsers of these commands. A guest that was deleted after its installation adds none."""
    for place in dict.fromkeys(guest_commands()[name].value for name in names):
        entry = next(each for each in guest_commands().values() if each.value == place)
        try:
            add_commands = entry.load()
        except ModuleNotFoundError as missing:
            if not f"{entry.module}.".startswith(f"{missing.name}."):
                raise
        else:
            add_commands(commands)
