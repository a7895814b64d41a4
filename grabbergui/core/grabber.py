"""The frame grabber: the interface of every source of frames with features, local or remote."""

from __future__ import annotations

import difflib
import logging
import threading
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from enum import Enum

from psygnal import Signal

from grabbergui.core.calibration import Calibration
from grabbergui.core.coord3d import Scan3d
from grabbergui.core.errors import FeatureAccessError, FeatureNotFoundError, GrabberError
from grabbergui.core.features import (
    AccessMode,
    Category,
    Feature,
    FeatureKind,
    FeatureValue,
    format_value,
)
from grabbergui.core.frame_queue import FrameFanout, FrameQueue, StreamStatistics
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.settings import Selected, Selectors, SettingKey, ValueChange, WriteResult, same_value
from grabbergui.core.sfnc import Companions, Role

log = logging.getLogger(__name__)


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


class FrameGrabber(ABC):
    """A source of frames and features.

    Feature calls, `start` and `stop` take as long as the device or the network does, so a window calls them
    on another thread; each grabber serialises them. `open_queue` and `statistics` never wait. Signals are
    emitted on any thread; a listener must return immediately and call no grabber.

    All errors are those of `core.errors`.
    """

    features_changed = Signal(frozenset)
    """Names (frozenset[str]) of features whose value, range or access may have changed."""
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
    shared = False
    """Whether others may write its features too, because it is remote or served to a network."""

    def __init__(self, info: DeviceInfo) -> None:
        self.info = info
        self._fanout = FrameFanout()
        self._lock = threading.RLock()
        "Serialises feature calls; held over several that belong together."
        self._restored: frozenset[str] = frozenset()
        "Selectors that the current `exclusive` blocks restore at their end. Protected by the lock."
        self._selectors: Selectors | None = None

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

    @abstractmethod
    def feature_tree(self) -> Category:
        """Return the root category, without a request to the camera once it is open."""

    @abstractmethod
    def has_feature(self, name: str) -> bool:
        """Return whether the camera's description contains the feature, and the camera implements it."""

    @abstractmethod
    def feature(self, name: str) -> Feature:
        """Return the current feature; from the cache if GenApi's rules allow it.

        Raises FeatureNotFoundError. A feature that cannot be read is no error: see `Feature.access` and
        `Feature.problem`.
        """

    @property
    def reads_at_once(self) -> int:
        """Number of features that `read_features` reads with one request to the camera."""
        return 1

    def read_features(self, names: Sequence[str]) -> list[Feature]:
        """Return features in the order of `names`. Raises as `feature` if one of them does."""
        return [self.feature(name) for name in names]

    @abstractmethod
    def write_feature(self, name: str, value: FeatureValue) -> Feature:
        """Write a value (or its text) and return what the camera then reports.

        Switches off an automatic mode of the feature first. Raises FeatureNotFoundError, FeatureAccessError,
        FeatureValueError, FeatureError if the camera refuses, TransportError.
        """

    def pauses_for(self, name: str) -> bool:
        """Return whether writing the feature stops a running stream and starts it again."""
        return False

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

    @abstractmethod
    def execute(self, name: str) -> None:
        """Run a command feature and wait until the camera reports it done (at most five seconds)."""

    def register_length(self, name: str) -> int:
        """Return the size in bytes of a register that is not a feature, such as FileAccessBuffer.

        Raises FeatureAccessError if there is none; remote sources have no such registers.
        """
        raise self._has_no_register(name)

    def read_register(self, name: str, length: int) -> bytes:
        """Read the first `length` bytes of a register from the camera. Raises as `register_length`."""
        raise self._has_no_register(name)

    def write_register(self, name: str, content: bytes) -> None:
        """Write bytes to the beginning of a register. Raises as `register_length`."""
        raise self._has_no_register(name)

    def _has_no_register(self, name: str) -> FeatureAccessError:
        return FeatureAccessError(
            f"{self.info.title} gives no access to the register {name}; only a camera that is attached"
            " to this computer does",
            name,
        )

    @property
    def selectors(self) -> Selectors:
        """The selectors of each feature, without a request to the camera."""
        tree = self.feature_tree()
        selectors = self._selectors
        if selectors is None or selectors.tree is not tree:
            self._selectors = selectors = Selectors(tree)
        return selectors

    def role(self, role: Role) -> str | None:
        """Return the feature that has a role on this camera, without a request to it; None if none has."""
        return self.selectors.roles.get(role)

    def setting(self, name: str) -> SettingKey:
        """Return the setting that a feature currently shows. May read its selectors."""
        selected = [(selector, self.feature(selector).value) for selector in self.selectors.of(name)]
        return SettingKey(name, tuple((s, format_value(value)) for s, value in selected if value is not None))

    def read_setting(self, key: SettingKey) -> Feature:
        """Select and read a feature, and restore its selectors, in one step.

        No other caller reads or writes a feature of this grabber in between. Raises what `feature` and, for
        the selectors, `write_feature` raise.
        """
        with self._selecting(key.selected):
            return self.feature(key.name)

    def write_setting(self, key: SettingKey, value: FeatureValue) -> WriteResult:
        """Select and write a feature, and restore its selectors, in one step.

        Returns everything that changed. A key without selectors means the currently selected instance. Raises
        what `write_feature` raises.
        """
        with self._lock, self._selecting(key.selected):
            companions = Companions.of(key.name, self.has_feature)
            setting = self.setting(key.name)
            before = self.feature(key.name).value
            # Modes that are off and enablers that are on do not change, so they are not read again: each read
            # is a request to a remote camera.
            switchable = [
                companion
                for companion in map(self.feature, companions.names)
                if companions.impedes(companion.name, companion.value)
            ]
            keys = [self.setting(companion.name) for companion in switchable]
            feature = self.write_feature(key.name, value)
            companions_after = [self.feature(companion.name) for companion in switchable]
            switched = [
                ValueChange(key, old.value, new.value)
                for key, old, new in zip(keys, switchable, companions_after, strict=True)
                if old.value != new.value
            ]
            after = feature.value if feature.value is not None else value
            return WriteResult(
                feature,
                (*switched, ValueChange(setting, before, after)),
                also_changed=tuple(companions_after),
            )

    def execute_setting(self, key: SettingKey) -> None:
        """Select and run a command (`UserSetLoad[UserSetSelector=UserSet1]`) in one step."""
        with self._selecting(key.selected):
            self.execute(key.name)

    @contextmanager
    def exclusive(self, selectors: Iterable[str] = ()) -> Iterator[None]:
        """Let no other caller use features during the block, and restore these selectors after it.

        For several settings that belong together. Other callers wait, so keep it short. A nested block does
        not restore the selectors that the outer one restores.
        """
        with self._lock:
            names = [name for name in selectors if name not in self._restored and self.has_feature(name)]
            before = {name: value for name in names if (value := self.feature(name).value) is not None}
            outer, self._restored = self._restored, self._restored | before.keys()
            try:
                yield
            finally:
                self._restored = outer
                for name, value in before.items():
                    try:
                        self._select(name, format_value(value))
                    except GrabberError as error:
                        log.info("%s could not be restored: %s", name, error)

    @contextmanager
    def _selecting(self, selected: Selected) -> Iterator[None]:
        if not selected:
            yield
            return
        with self.exclusive(selector for selector, _ in selected):
            for selector, entry in selected:
                self._select(selector, entry)
            yield

    def _select(self, selector: str, entry: str) -> None:
        value = self.feature(selector).value
        if value is None or not same_value(value, entry):
            self.write_feature(selector, entry)

    def features(self) -> list[Feature]:
        """Return every feature, in the tree's order. May read hundreds of registers."""
        return [self.feature(description.name) for description in self.feature_tree().descriptions()]

    def _require(self, name: str) -> None:
        if not self.has_feature(name):
            raise self._not_found(name)

    def _not_found(self, name: str) -> FeatureNotFoundError:
        names = [description.name for description in self.feature_tree().descriptions()]
        by_lower = {known.lower(): known for known in names}
        near = difflib.get_close_matches(name.lower(), list(by_lower), n=3, cutoff=0.6)
        hint = f"; did you mean {' or '.join(by_lower[match] for match in near)}?" if near else ""
        return FeatureNotFoundError(f"{self.info.title} has no feature {name[:60]}{hint}", name)

    @abstractmethod
    def start(self, *, keep_trigger: bool = False) -> None:
        """Start the stream; do nothing if it is on.

        A local camera is set to AcquisitionMode Continuous and, unless `keep_trigger`, TriggerMode Off;
        nothing else is written.
        """

    @abstractmethod
    def stop(self) -> None:
        """Stop the stream; do nothing if it is off. Queues stay open."""

    @property
    @abstractmethod
    def streaming(self) -> bool:
        """Whether the stream is on."""

    @abstractmethod
    def statistics(self) -> StreamStatistics:
        """Return a snapshot of the counters. Any thread; never waits."""

    def calibration(self) -> Calibration | None:
        """Return the calibration of the current images; None if the source does not report it.

        Any thread; never waits.
        """
        return None

    def silence(self) -> str:
        """Return, while no images arrive, from where they should, as display text; empty if unknown.

        Any thread; never waits.
        """
        return ""

    def recorded_coordinates(self) -> Scan3d | None:
        """Return the meaning of 3D data as it was recorded with them; None if the features report it.

        Any thread; never waits. `read_scan3d` prefers it to the features.
        """
        return None

    def open_queue(self, depth: int = 2) -> FrameQueue:
        """Return a queue for a new consumer of the stream.

        Any thread; also before `start`, and it stays open across restarts.
        """
        return self._fanout.open_queue(depth)
