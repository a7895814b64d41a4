"""The frame grabber: the interface of every source of frames with features, local or remote."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, replace
from enum import Enum

from psygnal import Signal

from grabbergui.core.features import (
    AccessMode,
    Feature,
    FeatureKind,
    FeatureValue,
)
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.register_source import RegisterSource
from grabbergui.core.stream_source import StreamSource


@dataclass(frozen=True)
class DeviceEvent:
    """An event message of a camera, sent because its EventNotification is on."""

    name: str
    "Its entry of EventSelector, e.g. `ExposureEnd`; the id in hexadecimal if the description has none."
    event_id: int
    values: dict[str, FeatureValue]
    "The values in the message by feature name, e.g. `EventExposureEndTimestamp`."

    def __str__(self) -> str:
        values = ", ".join(f"{name}={value}" for name, value in self.values.items())
        return f"{self.name}: {values}" if values else self.name


class Access(Enum):
    """The access that is requested on opening a device."""

    CONTROL = "control"
    "Features can be written; others may read."
    TAKE_OVER = "take over"
    "Control, even if another program has it but permits switchover; granted as CONTROL."
    MONITOR = "monitor"
    "Reading only, while another program may have control."


class ConnectionState(Enum):
    """The state of a connection."""

    CLOSED = "closed"
    OPENING = "opening"
    OPEN = "open"
    LOST = "lost"
    "Disconnected without being closed; a reconnection may be in progress."


class FrameGrabber(RegisterSource, StreamSource):
    """A source of frames and features.

    Feature calls, `start` and `stop` take as long as the device or the network does, so a window calls them
    on another thread; each grabber serialises them. `open_queue` and `statistics` never wait. Signals are
    emitted on any thread; a listener must return immediately and call no grabber.

    All errors are those of `core.errors`.
    """

    connection_changed = Signal(ConnectionState, str)
    """The new state, and the reason as display text."""
    noticed = Signal(str)
    """A sentence, during a connection: why no images arrive, or what changed at the other end."""
    held_changed = Signal(bool)
    """Whether another application has control, while this one may only read: at first, and on a change.
    Only of cameras that report it."""
    event_received = Signal(DeviceEvent)
    """The camera sent an event, such as the end of an exposure, which must be switched on."""
    unlike_before: tuple[str, ...] = ()
    """After a loss and return: the settings that differ from before and why, a sentence each."""
    changed_meanwhile: tuple[str, ...] = ()
    """After a loss and return: other settings that changed, a sentence each. They are not restored."""

    def __init__(self, info: DeviceInfo) -> None:
        RegisterSource.__init__(self)
        StreamSource.__init__(self)
        self.info = info

    @abstractmethod
    def open(self, access: Access = Access.CONTROL) -> None:
        """Connect. Writes nothing to the camera.

        Raises SourceNotFoundError, AccessDeniedError if another application has control (monitor access may
        still be possible), TransportError.
        """

    @abstractmethod
    def close(self) -> None:
        """Stop, release control and close. May be called twice; never raises."""

    @property
    @abstractmethod
    def access(self) -> Access:
        """The access that was granted on opening."""

    @property
    def lost(self) -> str:
        """Why the camera is lost, as display text; empty if it is not. Any thread; never waits."""
        return ""

    def offered(self, feature: Feature) -> Feature:
        """Return the feature with the access that a control for this grabber offers.

        A feature that only the stream locks is writable, as a write pauses the stream. Without control no
        feature is writable and no command available.
        """
        if self.access is Access.CONTROL:
            locked = feature.access is AccessMode.READ_ONLY and feature.kind is not FeatureKind.COMMAND
            if locked and self.streaming and self.pauses_for(feature.name):
                return replace(feature, access=AccessMode.READ_WRITE, pauses_stream=True)
            return feature
        return replace(feature, access=feature.access.without_writing, pauses_stream=False)
