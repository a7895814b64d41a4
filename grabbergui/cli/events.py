"""`events`: print a camera's event messages as they arrive, or list its events."""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from contextlib import contextmanager
from queue import Empty, Queue
from typing import Any

from grabbergui.cli.arguments import (
    add_source,
    count,
    opened,
    wait_time,
)
from grabbergui.cli.process import stop_on_signals
from grabbergui.core.errors import (
    FeatureError,
    FeatureValueError,
    UsageError,
)
from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.grabber import DeviceEvent
from grabbergui.core.json_text import to_json
from grabbergui.core.settings import SettingKey
from grabbergui.core.visible_text import print_line

_POLL = 0.1
"Seconds between checks whether a signal ended the command."
_SELECTOR, _SWITCH = "EventSelector", "EventNotification"
_MOST_WAITING = 1000
"Most events that wait for a slow reader; further ones are dropped."


def add_commands(commands: Any) -> None:
    """Add the parser."""
    parser = commands.add_parser(
        "events",
        help="print a camera's events as they arrive, or list its events",
        example="grabbergui events gige: ExposureEnd --start",
    )
    add_source(parser)
    parser.add_argument(
        "names",
        metavar="NAME",
        nargs="*",
        help="an event, such as ExposureEnd; without a name, list the events",
    )
    parser.add_argument("-n", "--count", type=count, help="end after this many events")
    parser.add_argument("--duration", type=wait_time, metavar="S", help="end after this many seconds")
    parser.add_argument("--start", action="store_true", help="stream while listening")
    parser.add_argument("--json", action="store_true", help="print one JSON object per line")
    parser.set_defaults(run=_events)


def _events(options: argparse.Namespace) -> int:
    if not options.names and (options.start or options.count or options.duration):
        raise UsageError(f"print which events? `grabbergui events {options.source}` lists them")
    with opened(options.source, reading=not options.names) as grabber:
        known = _known_events(grabber)
        if not options.names:
            for name in known:
                print_line(name)
            return 0
        for name in options.names:
            if name not in known:
                names = ", ".join(known)
                raise FeatureValueError(f"this camera has no event {name}; it has {names}", _SELECTOR)
        waiting: Queue[DeviceEvent] = Queue(_MOST_WAITING)
        grabber.event_received.connect(lambda event: _keep(waiting, event))
        with stop_on_signals() as stop, _switched_on(grabber, options.names):
            if options.start:
                grabber.start()
            deadline = time.monotonic() + options.duration if options.duration else float("inf")
            printed = 0
            while not stop.is_set() and time.monotonic() < deadline:
                try:
                    event = waiting.get(timeout=_POLL)
                except Empty:
                    continue
                print_line(_event_line(event, as_json=options.json), flush=True)
                printed += 1
                if printed == options.count:
                    break
            if options.start:
                grabber.stop()
    return 0


def _known_events(grabber: FeatureSource) -> list[str]:
    if not grabber.has_feature(_SELECTOR) or not grabber.has_feature(_SWITCH):
        raise FeatureError(f"{grabber.info.title} has no {_SELECTOR}, so it sends no events", _SELECTOR)
    return [entry.name for entry in grabber.feature(_SELECTOR).entries if entry.available]


def _keep(waiting: Queue[DeviceEvent], event: DeviceEvent) -> None:
    if not waiting.full():
        waiting.put_nowait(event)


@contextmanager
def _switched_on(grabber: FeatureSource, names: list[str]) -> Iterator[None]:
    """Switch the events on for the block; those that were off are switched off again."""
    switches = [SettingKey(_SWITCH, ((_SELECTOR, name),)) for name in names]
    before = [(key, grabber.read_setting(key).value) for key in switches]
    try:
        for key in switches:
            grabber.write_setting(key, "On")
        yield
    finally:
        for key, value in before:
            if value is not None:
                grabber.write_setting(key, value)


def _event_line(event: DeviceEvent, *, as_json: bool) -> str:
    if as_json:
        return to_json({"event": event.name, "id": event.event_id, "values": event.values})
    return str(event)
