"""`grabbergui events`: prints the event messages of a camera as they arrive."""

from __future__ import annotations

import argparse
import json
import queue
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from grabbergui.cli.opening import add_source, opened
from grabbergui.cli.parsing import count, positive
from grabbergui.cli.process import stop_on_signals
from grabbergui.core.errors import FeatureError, FeatureValueError, UsageError
from grabbergui.core.grabber import DeviceEvent, FrameGrabber
from grabbergui.core.settings import SettingKey

SELECTOR, SWITCH = "EventSelector", "EventNotification"
LOOK_PERIOD = 0.1
"""Seconds between checks whether the user wants to end."""
MOST_WAITING = 1000
"""Most events that wait for a slow reader; further ones are dropped."""


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    parser = commands.add_parser(
        "events",
        help="print the events of a camera as they come, or which ones it has",
        example="grabbergui events gige: ExposureEnd --start",
    )
    add_source(parser)
    parser.add_argument("names", metavar="NAME", nargs="*", help="as ExposureEnd; without any: list them")
    parser.add_argument("-n", "--count", type=count, help="end after so many events")
    parser.add_argument("--duration", type=positive, metavar="S", help="end after so many seconds")
    parser.add_argument("--start", action="store_true", help="let the camera take pictures meanwhile")
    parser.add_argument("--json", action="store_true", help="print one JSON object a line")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    if not options.names and (options.start or options.count or options.duration):
        raise UsageError(f"print which events? `grabbergui events {options.source}` lists them")
    with opened(options.source, reading=not options.names) as grabber:
        known = _known(grabber)
        if not options.names:
            for name in known:
                print(name)
            return 0
        for name in options.names:
            if name not in known:
                names = ", ".join(known)
                raise FeatureValueError(f"{name} is no event of this camera; it has {names}", SELECTOR)
        waiting: queue.Queue[DeviceEvent] = queue.Queue(MOST_WAITING)
        grabber.event_received.connect(lambda event: _keep(waiting, event))
        with stop_on_signals() as stop, _switched_on(grabber, options.names):
            if options.start:
                grabber.start()
            deadline = time.monotonic() + options.duration if options.duration else float("inf")
            printed = 0
            while not stop.is_set() and time.monotonic() < deadline:
                try:
                    event = waiting.get(timeout=LOOK_PERIOD)
                except queue.Empty:
                    continue
                print(_line(event, as_json=options.json), flush=True)
                printed += 1
                if printed == options.count:
                    break
            if options.start:
                grabber.stop()
    return 0


def _known(grabber: FrameGrabber) -> list[str]:
    if not grabber.has_feature(SELECTOR) or not grabber.has_feature(SWITCH):
        raise FeatureError(f"{grabber.info.title} has no {SELECTOR}, so it sends no events", SELECTOR)
    return [entry.name for entry in grabber.feature(SELECTOR).entries if entry.available]


def _keep(waiting: queue.Queue[DeviceEvent], event: DeviceEvent) -> None:
    if not waiting.full():
        waiting.put_nowait(event)


@contextmanager
def _switched_on(grabber: FrameGrabber, names: list[str]) -> Iterator[None]:
    """Switch the events on for the block; those that were off are switched off again."""
    switches = [SettingKey(SWITCH, ((SELECTOR, name),)) for name in names]
    before = [(key, grabber.read_setting(key).value) for key in switches]
    try:
        for key in switches:
            grabber.write_setting(key, "On")
        yield
    finally:
        for key, value in before:
            if value is not None:
                grabber.write_setting(key, value)


def _line(event: DeviceEvent, *, as_json: bool) -> str:
    if as_json:
        return json.dumps({"event": event.name, "id": event.event_id, "values": event.values})
    return str(event)
