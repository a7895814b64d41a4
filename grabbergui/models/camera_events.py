"""The event messages of the current camera: which are switched on, and those that arrived."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from psygnal import Signal

from grabbergui.core.errors import GrabberError
from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.features import format_value
from grabbergui.core.grabber import DeviceEvent, FrameGrabber
from grabbergui.core.settings import SettingKey
from grabbergui.core.visible_text import shortened
from grabbergui.models.open_source import OpenSource

MOST_EVENTS = 1000
"Events that are kept; the oldest are dropped."
MOST_TEXT = 300
"Characters of an event's values."
_SELECTOR, _SWITCH = "EventSelector", "EventNotification"


@dataclass(frozen=True)
class ReceivedEvent:
    """An event that arrived."""

    moment: float
    "Seconds since the epoch, on this computer's clock."
    name: str
    values: str
    "As display text, without the event's name in front of each."

    @property
    def time_text(self) -> str:
        """Time of day with milliseconds."""
        whole = int(self.moment)
        return f"{time.strftime('%H:%M:%S', time.localtime(whole))}.{int((self.moment - whole) * 1000):03d}"

    @property
    def row(self) -> tuple[str, str, str]:
        """Time, name and values."""
        return self.time_text, self.name, self.values


class CameraEvents:
    """The events of one source. `attach` and `detach` on one thread; all else on any. No call waits."""

    switches_changed = Signal(dict)
    """By name of each event that the camera has, whether it is on (dict[str, bool]). From the worker."""
    failed = Signal(GrabberError)
    """An event could not be switched. From the worker."""

    def __init__(self, clock: Callable[[], float] = time.time) -> None:
        self._clock = clock
        self._source: OpenSource | None = None
        self._grabber: FrameGrabber | None = None
        self._events: deque[ReceivedEvent] = deque(maxlen=MOST_EVENTS)
        self._lock = threading.Lock()
        self.count = 0
        "Events that ever arrived, also those that are no longer kept."

    @property
    def events(self) -> tuple[ReceivedEvent, ...]:
        """Those that arrived, oldest first."""
        with self._lock:
            return tuple(self._events)

    def since(self, moment: float) -> list[tuple[float, str]]:
        """Return time and name of the events since a moment, oldest first."""
        return [(event.moment, event.name) for event in self.events if event.moment >= moment]

    def attach(self, source: OpenSource) -> None:
        """Listen to a source that is open."""
        self.detach()
        self._source, self._grabber = source, source.grabber
        self.clear()
        if self._grabber is not None:
            self._grabber.event_received.connect(self._on_event)

    def detach(self) -> None:
        """Listen no more; what arrived stays."""
        if self._grabber is not None:
            self._grabber.event_received.disconnect(self._on_event, missing_ok=True)
        self._source = self._grabber = None

    def clear(self) -> None:
        """Forget what arrived."""
        with self._lock:
            self._events.clear()
            self.count += 1

    def request_switches(self) -> None:
        """Read which events there are; `switches_changed` follows."""
        source, grabber = self._source, self._grabber
        if source is not None and grabber is not None:
            source.worker.submit(lambda: _switches(grabber), key="events", done=self.switches_changed.emit)

    def switch(self, name: str, *, on: bool) -> None:
        """Switch an event on or off."""
        source = self._source
        if source is None or source.tracked_grabber is None or source.features is None:
            return
        grabber, key = source.tracked_grabber, SettingKey(_SWITCH, ((_SELECTOR, name),))

        def fail(error: GrabberError) -> None:
            self.failed.emit(error)
            self.request_switches()

        source.features.run(
            lambda: grabber.write_setting(key, "On" if on else "Off"),
            done=lambda _: self.request_switches(),
            failed=fail,
        )

    def _on_event(self, event: DeviceEvent) -> None:
        prefix = f"Event{event.name.rpartition('.')[2]}"  # those of a rig begin with the camera's name
        values = ", ".join(
            f"{name.removeprefix(prefix) or name} {format_value(value)}"
            for name, value in event.values.items()
        )
        with self._lock:
            self._events.append(ReceivedEvent(self._clock(), event.name, shortened(values, MOST_TEXT)))
            self.count += 1


def _switches(grabber: FeatureSource) -> dict[str, bool]:
    """Return the camera's events, and whether each is on; events whose switch cannot be read count as off."""
    if not grabber.has_feature(_SELECTOR) or not grabber.has_feature(_SWITCH):
        return {}
    found = {}
    for entry in grabber.feature(_SELECTOR).entries:
        if entry.available:
            try:
                value = grabber.read_setting(SettingKey(_SWITCH, ((_SELECTOR, entry.name),))).value
            except GrabberError:
                value = "Off"
            found[entry.name] = value not in ("Off", None, False)
    return found
