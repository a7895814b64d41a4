"""The one abstraction: a source of frames with features, local or remote."""

from __future__ import annotations

import difflib
from abc import ABC, abstractmethod
from dataclasses import asdict, dataclass
from enum import Enum
from typing import Any

from psygnal import Signal

from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import FeatureNotFoundError
from grabbergui.core.features import Category, Feature, FeatureValue
from grabbergui.core.frame_queue import FrameFanout, FrameQueue


@dataclass(frozen=True)
class DeviceInfo:
    """What is known of a source before it is opened."""

    uri: str
    "Opens exactly this source, e.g. `gige:GV01`."
    vendor: str = ""
    model: str = ""
    serial: str = ""
    bus: str = ""
    "`GigE Vision`, `USB3 Vision`, `YARP`, `ROS 2`, `Simulated`."
    address: str = ""
    "IP address, USB path, port or topic."
    user_name: str = ""
    "DeviceUserID, where set."
    version: str = ""
    interface: str = ""
    "The host's network interface or bus it was seen on."
    note: str = ""
    "What hinders opening it, for people; empty where nothing does."

    @property
    def title(self) -> str:
        """The name for people."""
        return self.user_name or " ".join(part for part in (self.vendor, self.model) if part) or self.uri

    def as_dict(self) -> dict[str, str]:
        """All fields, for JSON."""
        return asdict(self)


@dataclass(frozen=True)
class DeviceEvent:
    """Something that a camera told by itself, because its EventNotification is on."""

    name: str
    "As EventSelector has it, e.g. `ExposureEnd`; the id in hexadecimal where the description has no name."
    event_id: int
    values: dict[str, FeatureValue]
    "What came with it, by feature name, e.g. `EventExposureEndTimestamp`."

    def __str__(self) -> str:
        said = ", ".join(f"{name}={value}" for name, value in self.values.items())
        return f"{self.name}: {said}" if said else self.name


class Access(Enum):
    """What is asked of a device on opening."""

    CONTROL = "control"
    "Features can be written; others may read."
    TAKE_OVER = "take over"
    "Control, also from a program that offers it to whoever asks for it on purpose; granted as CONTROL."
    MONITOR = "monitor"
    "Only reading, beside whoever has control."


class ConnectionState(Enum):
    """Where a source stands."""

    CLOSED = "closed"
    OPENING = "opening"
    OPEN = "open"
    LOST = "lost"
    "Gone without being closed; a reconnection may be under way."


@dataclass
class StreamStatistics:
    """Counters since the stream was started; all only grow. Rates are of the last two seconds."""

    frames: int = 0
    "Complete frames delivered."
    incomplete: int = 0
    "Frames with packets missing."
    lost: int = 0
    "Frames of which nothing arrived: gaps between frame ids."
    underruns: int = 0
    "Frames dropped because consumers held every buffer."
    bytes: int = 0
    "Payload bytes of complete frames."
    packets: int = 0
    packets_missing: int = 0
    "Packets that never came, after all requests."
    packets_resent: int = 0
    "Packets that came because they were asked for again."
    packets_duplicate: int = 0
    packets_ignored: int = 0
    "Foreign, malformed or stale datagrams."
    frame_rate: float = 0.0
    "Frames per second."
    bandwidth: float = 0.0
    "Payload bytes per second."

    def as_dict(self) -> dict[str, Any]:
        """All fields, for JSON."""
        return asdict(self)


class FrameGrabber(ABC):
    """A source of images and features.

    Feature calls and start/stop may take as long as the device or the network does, so a window makes them
    on a thread of its own; each grabber serialises them. `open_queue` and `statistics` never wait. Signals
    are emitted from whatever thread noticed; a listener returns at once and calls no grabber.

    Errors are those of `core.errors`; nothing else leaves a grabber.
    """

    features_changed = Signal(frozenset)
    """Names (frozenset[str]) of features whose value, range or access may have changed."""
    connection_changed = Signal(ConnectionState, str)
    """The new state, and why, for people."""
    noticed = Signal(str)
    """While the connection holds: what hinders the pictures, or how the other end changed; a sentence."""
    event_received = Signal(DeviceEvent)
    """The camera told something by itself. At the end of every exposure, if that is what was switched on."""
    shared = False
    """Whether others may write its features meanwhile: it is remote, or served to a network."""

    def __init__(self, info: DeviceInfo) -> None:
        self.info = info
        self._fanout = FrameFanout()

    # -- connection ------------------------------------------------------------------------------
    @abstractmethod
    def open(self, access: Access = Access.CONTROL) -> None:
        """Connect. Writes nothing to the camera.

        Raises SourceNotFoundError, AccessDeniedError when another application has control (monitor access
        may still be had), TransportError.
        """

    @abstractmethod
    def close(self) -> None:
        """Stop, release control and let go. May be called twice; never raises."""

    @property
    @abstractmethod
    def access(self) -> Access:
        """What was granted on opening."""

    # -- features --------------------------------------------------------------------------------
    @abstractmethod
    def feature_tree(self) -> Category:
        """The root category. Costs nothing on the wire once open."""

    @abstractmethod
    def has_feature(self, name: str) -> bool:
        """Whether the camera's description has it and it is implemented."""

    @abstractmethod
    def feature(self, name: str) -> Feature:
        """The feature as it is now; read from the cache where GenApi's rules allow it.

        Raises FeatureNotFoundError. A feature that cannot be read is no error: see `Feature.access` and
        `Feature.problem`.
        """

    @abstractmethod
    def write_feature(self, name: str, value: FeatureValue) -> Feature:
        """Write a value (or its text) and return what the camera then reports.

        An automatic mode of the feature that is on is switched off first. Raises FeatureNotFoundError,
        FeatureAccessError, FeatureValueError, FeatureError for the camera's refusal, TransportError.
        """

    def pauses_for(self, name: str) -> bool:
        """Whether writing the feature stops a running stream, and starts it again."""
        return False

    @abstractmethod
    def execute(self, name: str) -> None:
        """Run a command feature and wait until the camera says it is done (at most five seconds)."""

    def features(self) -> list[Feature]:
        """Every feature as it is now, in the tree's order. May read hundreds of registers."""
        return [self.feature(description.name) for description in self.feature_tree().descriptions()]

    def _require(self, name: str) -> None:
        if not self.has_feature(name):
            raise self._not_found(name)

    def _not_found(self, name: str) -> FeatureNotFoundError:
        names = [description.name for description in self.feature_tree().descriptions()]
        by_lower = {known.lower(): known for known in names}
        near = difflib.get_close_matches(name.lower(), list(by_lower), n=3, cutoff=0.6)
        hint = f"; did you mean {' or '.join(by_lower[match] for match in near)}?" if near else ""
        return FeatureNotFoundError(f"{self.info.title} has no feature {name}{hint}", name)

    # -- acquisition -----------------------------------------------------------------------------
    @abstractmethod
    def start(self, *, keep_trigger: bool = False) -> None:
        """Start streaming; does nothing where it runs already.

        A local camera is set to AcquisitionMode Continuous and, unless `keep_trigger`, TriggerMode Off;
        nothing else is written.
        """

    @abstractmethod
    def stop(self) -> None:
        """Stop streaming; does nothing where it does not run. Queues stay open."""

    @property
    @abstractmethod
    def streaming(self) -> bool:
        """Whether the stream is on."""

    @abstractmethod
    def statistics(self) -> StreamStatistics:
        """A snapshot of the counters. Any thread; never waits."""

    def calibration(self) -> Calibration | None:
        """How directions become pixels in the pictures it sends just now; None where the source does not say.

        Any thread; never waits.
        """
        return None

    def open_queue(self, depth: int = 2) -> FrameQueue:
        """A new consumer of the stream. Any thread; also before `start` and across restarts."""
        return self._fanout.open_queue(depth)
