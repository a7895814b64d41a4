"""Undo and redo, and changes as a command line or a program that makes them again."""

from __future__ import annotations

import shlex
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence

from grabbergui.core.features import FeatureValue, format_value
from grabbergui.core.selection import SettingKey
from grabbergui.core.settling import settle
from grabbergui.models.changes.history import Change, Direction, Origin
from grabbergui.models.changes.tracking import ChangeTrackingGrabber
from grabbergui.models.features.sensor_region import stream_paused

FEW = 4
"Number of settings above which the stream is stopped once instead of for each that changes the frames."


def revert(grabber: ChangeTrackingGrabber, direction: Direction) -> list[str]:
    """Undo or redo the next step; return a sentence for each value that could not be restored.

    Call it on the thread that makes the grabber's calls. A refused value is tried again with the next step:
    an automatic mode may have moved its limits, and that mode is undone later. Does nothing if there is no
    step. Raises TransportError if the camera is lost; the step can then be tried again.
    """
    journal = grabber.journal
    with journal.reverting(direction) as step:
        if step is None:
            return []
        values = dict(step.values(direction))
        wanted = {**journal.owed(direction), **values}
        problems = write_values(grabber, wanted)
        journal.owe(direction, {key: wanted[key] for key in problems})
    return [f"{direction.value} of {step}: {problem}" for key, problem in problems.items() if key in values]


def write_values(
    grabber: ChangeTrackingGrabber, values: Mapping[SettingKey, FeatureValue]
) -> dict[SettingKey, str]:
    """Write settings until all are there, as `settle` does; return what could not be set, a sentence each."""
    with stream_paused(grabber, len(values) > FEW):
        return settle(grabber, values)


Write = tuple[str, FeatureValue | None]
"A feature and its value; None runs a command."


def writes(changes: Iterable[Change]) -> list[Write]:
    """Return the values to write, in order, with selectors where they are needed."""
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
    """Return a program in Python that opens the source and makes the changes."""
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
