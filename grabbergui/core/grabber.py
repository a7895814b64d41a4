"""The one abstraction: a source of frames with features, local or remote."""

from __future__ import annotations

import difflib
import logging
import threading
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from enum import Enum
from typing import TYPE_CHECKING

from psygnal import Signal

from grabbergui.core.calibration import Calibration
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
from grabbergui.core.sfnc import Companions, is_on

if TYPE_CHECKING:
    from grabbergui.core.scan3d import Scan3d

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class DeviceEvent:
    """An event message of a camera, sent because its EventNotification is on."""

    name: str
    "As EventSelector has it, e.g. `ExposureEnd`; the id in hexadecimal where the description has no name."
    event_id: int
    values: dict[str, FeatureValue]
    "The values that the message carried, by feature name, e.g. `EventExposureEndTimestamp`."

    def __str__(self) -> str:
        said = ", ".join(f"{name}={value}" for name, value in self.values.items())
        return f"{self.name}: {said}" if said else self.name


class Access(Enum):
    """The access that is requested on opening a device."""

    CONTROL = "control"
    "Features can be written; others may read."
    TAKE_OVER = "take over"
    "Control, also from a program that offers it to whoever asks for it on purpose; granted as CONTROL."
    MONITOR = "monitor"
    "Only reading, beside whoever has control."


class ConnectionState(Enum):
    """The state of a connection."""

    CLOSED = "closed"
    OPENING = "opening"
    OPEN = "open"
    LOST = "lost"
    "Gone without being closed; a reconnection may be in progress."


MOST_CHANGED = 5
"Most settings that others changed which one line names: a user set that somebody loads changes them all."


def return_text(problems: Sequence[str], changed: Sequence[str] = ()) -> str:
    """Describe how a source came back after it was lost: set as before, or which settings differ and why.

    `changed` are settings that had never been set here, and have another value now.
    """
    text = f"but not as before: {'; '.join(problems)}" if problems else "set as before"
    if not changed:
        return text
    more = f"; and {len(changed) - MOST_CHANGED} more" if len(changed) > MOST_CHANGED else ""
    return f"{text}; changed meanwhile, not by us: {'; '.join(changed[:MOST_CHANGED])}{more}"


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
    """The new state, and the reason as display text."""
    noticed = Signal(str)
    """While the connection holds: why no images arrive, or how the other end changed; a sentence."""
    event_received = Signal(DeviceEvent)
    """The camera sent an event: at the end of every exposure, for instance, if that event is switched on."""
    unlike_before: tuple[str, ...] = ()
    """After a loss and return: the settings that differ from before, and why, a sentence each."""
    changed_meanwhile: tuple[str, ...] = ()
    """After a loss and return: other settings that changed meanwhile, a sentence each; they are left so."""
    shared = False
    """Whether others may write its features meanwhile: it is remote, or served to a network."""

    def __init__(self, info: DeviceInfo) -> None:
        self.info = info
        self._fanout = FrameFanout()
        self._lock = threading.RLock()
        "Of feature calls: held wherever several belong together."
        self._put_back: frozenset[str] = frozenset()
        "Selectors that an `exclusive` block of the thread that holds the lock is going to put back."
        self._selectors: Selectors | None = None

    # -- connection ------------------------------------------------------------------------------
    @abstractmethod
    def open(self, access: Access = Access.CONTROL) -> None:
        """Connect. Writes nothing to the camera.

        Raises SourceNotFoundError, AccessDeniedError when another application has control (monitor access
        may still be had), TransportError.
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
        """Why the camera is lost, as display text; empty while it is not. Any thread; never waits."""
        return ""

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

    @property
    def reads_at_once(self) -> int:
        """How many features `read_features` reads in one request to the camera."""
        return 1

    def read_features(self, names: Sequence[str]) -> list[Feature]:
        """Return features in the order of their names. Raises as `feature` if one of them does."""
        return [self.feature(name) for name in names]

    @abstractmethod
    def write_feature(self, name: str, value: FeatureValue) -> Feature:
        """Write a value (or its text) and return what the camera then reports.

        An automatic mode of the feature that is on is switched off first. Raises FeatureNotFoundError,
        FeatureAccessError, FeatureValueError, FeatureError for the camera's refusal, TransportError.
        """

    def pauses_for(self, name: str) -> bool:
        """Whether writing the feature stops a running stream, and starts it again."""
        return False

    def offered(self, feature: Feature) -> Feature:
        """Return the feature as a control of this grabber may offer it.

        What only the stream locks can be written, as a write pauses the stream. Without control nothing can
        be written, and no command be run.
        """
        if self.access is Access.CONTROL:
            locked = feature.access is AccessMode.READ_ONLY and feature.kind is not FeatureKind.COMMAND
            if locked and self.streaming and self.pauses_for(feature.name):
                return replace(feature, access=AccessMode.READ_WRITE, pauses_stream=True)
            return feature
        if not feature.access.writable:
            return feature
        readable = feature.access.readable
        access = AccessMode.READ_ONLY if readable else AccessMode.NOT_AVAILABLE
        return replace(feature, access=access, pauses_stream=False)

    @abstractmethod
    def execute(self, name: str) -> None:
        """Run a command feature and wait until the camera says it is done (at most five seconds)."""

    # -- registers of plain bytes ----------------------------------------------------------------
    def register_length(self, name: str) -> int:
        """Return the bytes of a register that is no feature, as FileAccessBuffer.

        Raises FeatureAccessError, also where the source is remote: such registers do not travel.
        """
        raise self._has_no_register(name)

    def read_register(self, name: str, length: int) -> bytes:
        """Return the first `length` bytes of a register, from the camera. Raises as `register_length`."""
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

    # -- settings: features with their selectors -------------------------------------------------
    @property
    def selectors(self) -> Selectors:
        """The selectors of each feature. Asks no camera."""
        tree = self.feature_tree()
        selectors = self._selectors
        if selectors is None or selectors.tree is not tree:
            self._selectors = selectors = Selectors(tree)
        return selectors

    def setting(self, name: str) -> SettingKey:
        """Return the setting that a feature shows at the moment. May read its selectors."""
        standing = [(selector, self.feature(selector).value) for selector in self.selectors.of(name)]
        return SettingKey(name, tuple((s, format_value(value)) for s, value in standing if value is not None))

    def read_setting(self, key: SettingKey) -> Feature:
        """Read a feature under its selectors, which then stand where they stood, in one step.

        No other caller reads or writes a feature of this grabber in between. Raises what `feature` and, for
        the selectors, `write_feature` raise.
        """
        with self._selecting(key.selected):
            return self.feature(key.name)

    def write_setting(self, key: SettingKey, value: FeatureValue) -> WriteResult:
        """Write a feature under its selectors, which then stand where they stood, in one step.

        Returns everything that changed. A key without selectors means the instance that is selected at the
        moment. Raises what `write_feature` raises.
        """
        with self._lock, self._selecting(key.selected):
            companions = Companions.of(key.name, self.has_feature)
            own = self.setting(key.name)
            before = self.feature(key.name).value
            # A mode that is off and a switch that is on stay so: each read is a request on a remote camera.
            may_switch = [
                stood
                for stood in map(self.feature, companions.names)
                if is_on(stood.value) == (stood.name == companions.mode)
            ]
            keys = [self.setting(stood.name) for stood in may_switch]
            feature = self.write_feature(key.name, value)
            switched = [self.feature(stood.name) for stood in may_switch]
            changes = [
                ValueChange(setting, stood.value, now.value)
                for setting, stood, now in zip(keys, may_switch, switched, strict=True)
                if stood.value != now.value
            ]
            after = feature.value if feature.value is not None else value
            return WriteResult(
                feature, (*changes, ValueChange(own, before, after)), also_changed=tuple(switched)
            )

    def execute_setting(self, key: SettingKey) -> None:
        """Run a command under its selectors (`UserSetLoad[UserSetSelector=UserSet1]`) in one step."""
        with self._selecting(key.selected):
            self.execute(key.name)

    @contextmanager
    def exclusive(self, selectors: Iterable[str] = ()) -> Iterator[None]:
        """Let no other caller use features within the block, and put these selectors back behind it.

        For several settings that belong together; keep it short, as everybody else waits. Nested blocks leave
        the selectors that the outer one puts back where they are.
        """
        with self._lock:
            names = [name for name in selectors if name not in self._put_back and self.has_feature(name)]
            stood = {name: value for name in names if (value := self.feature(name).value) is not None}
            outer, self._put_back = self._put_back, self._put_back | stood.keys()
            try:
                yield
            finally:
                self._put_back = outer
                for name, value in stood.items():
                    try:
                        self._select(name, format_value(value))
                    except GrabberError as error:
                        log.info("%s could not be put back: %s", name, error)

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
        """Return how directions become pixels in its current images; None if the source does not report it.

        Any thread; never waits.
        """
        return None

    def recorded_coordinates(self) -> Scan3d | None:
        """Return what its 3D data mean, as it was recorded with them; None if the features report it.

        Any thread; never waits. `Scan3d.read` asks for this first.
        """
        return None

    def open_queue(self, depth: int = 2) -> FrameQueue:
        """A new consumer of the stream. Any thread; also before `start` and across restarts."""
        return self._fanout.open_queue(depth)
