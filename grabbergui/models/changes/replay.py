"""Changes as something that makes them again: a command line, or a program in Python.

Of what was changed several times the last value counts; what ended where it began is left out, and so is
what the camera did by itself. Commands stand where they were run.
"""

from __future__ import annotations

import shlex
import time
from collections.abc import Iterable, Iterator, Sequence

from grabbergui.core.features import FeatureValue, format_value
from grabbergui.core.selection import SettingKey
from grabbergui.models.changes.change import Change, Origin

Write = tuple[str, FeatureValue | None]
"A feature and its value; None runs a command."


def writes(changes: Iterable[Change]) -> list[Write]:
    """What is to be written, in order, selectors where they are needed."""
    found: list[Write] = []
    run: dict[SettingKey, Change] = {}
    standing: dict[str, str] = {}
    for change in changes:
        if change.origin is Origin.CAMERA:
            continue
        if not change.command:
            known = run.pop(change.key, change)  # at its end: it was set after what was set meanwhile
            run[change.key] = _joined(known, change)
            continue
        found += _settings(run.values(), standing)
        run.clear()
        found.append((change.key.name, None))
    return [*found, *_settings(run.values(), standing)]


def command_line(uri: str, changes: Iterable[Change]) -> str:
    """`grabbergui set URI NAME=VALUE …`, and `grabbergui run` for commands, a line each, for a shell."""
    lines: list[list[str]] = []
    for name, value in writes(changes):
        if value is None:
            lines.append(["run", uri, name])
        elif lines and lines[-1][0] == "set":
            lines[-1].append(f"{name}={format_value(value)}")
        else:
            lines.append(["set", uri, f"{name}={format_value(value)}"])
    return "".join(f"grabbergui {shlex.join(words)}\n" for words in lines)


def program(uri: str, changes: Sequence[Change]) -> str:
    """A program in Python that opens the source and makes the changes."""
    when = time.strftime("%Y-%m-%d %H:%M", time.localtime(changes[-1].time)) if changes else "no changes"
    calls = [
        f"    camera.execute({name!r})" if value is None else f"    camera.write_feature({name!r}, {value!r})"
        for name, value in writes(changes)
    ]
    return "\n".join(
        [
            f'"""Sets a camera as it was set with grabbergui ({when})."""',
            "",
            "from grabbergui import sources",
            "",
            f"camera = sources.create({uri!r})",
            "camera.open()",
            "try:",
            *(calls or ["    pass"]),
            "finally:",
            "    camera.close()",
            "",
        ]
    )


def _joined(first: Change, last: Change) -> Change:
    return Change(
        last.number, last.time, last.key, first.before, last.after, last.origin, last.cause, last.command
    )


def _settings(changes: Iterable[Change], standing: dict[str, str]) -> Iterator[Write]:
    for change in changes:
        if change.after is None or not change.effective:
            continue
        for selector, entry in change.key.selected:
            if standing.get(selector) != entry:
                standing[selector] = entry
                yield selector, entry
        yield change.key.name, change.after
        standing[change.key.name] = format_value(change.after)  # it may be a selector itself
