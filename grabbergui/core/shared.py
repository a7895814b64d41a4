"""Further handles on an open grabber, by which the window and the network servers of a process share it.

A `ReadOnlyGrabber` is a handle for networks with untrusted peers.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, TypeVar, cast

from typing_extensions import override

from grabbergui.core.errors import AccessDeniedError, FeatureAccessError
from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.features import AccessMode, Feature, FeatureValue
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.core.grabber import Access, ConnectionState, DeviceEvent, FrameGrabber
from grabbergui.core.register_source import RegisterSource
from grabbergui.core.settings import Selectors, SettingKey, WriteResult
from grabbergui.core.stream_source import StreamSource

_Method = TypeVar("_Method", bound=Callable[..., Any])
_REASON = "the camera is served read-only"


def _passed_on(method: _Method) -> _Method:
    """Return a method for `SharedGrabber` that calls the same one of the grabber behind it."""
    name = method.__name__

    def call(handle: SharedGrabber, *arguments: Any, **options: Any) -> Any:
        return getattr(handle._grabber, name)(*arguments, **options)

    call.__name__, call.__doc__ = name, method.__doc__
    return cast(_Method, call)


class SharedGrabber(FrameGrabber):
    """Another handle on an open grabber, which it neither opens nor closes.

    It passes all calls on to the grabber and all signals back. Closing the handle closes the queues opened
    through it, but not the grabber. Stopping the stream stops it for every handle.
    """

    shared = True

    feature_tree = _passed_on(FeatureSource.feature_tree)
    has_feature = _passed_on(FeatureSource.has_feature)
    feature = _passed_on(FeatureSource.feature)
    read_features = _passed_on(FeatureSource.read_features)
    conditions = _passed_on(FeatureSource.conditions)
    write_feature = _passed_on(FeatureSource.write_feature)
    execute = _passed_on(FeatureSource.execute)
    pauses_for = _passed_on(FeatureSource.pauses_for)
    setting = _passed_on(FeatureSource.setting)
    read_setting = _passed_on(FeatureSource.read_setting)
    write_setting = _passed_on(FeatureSource.write_setting)
    execute_setting = _passed_on(FeatureSource.execute_setting)
    exclusive = _passed_on(FeatureSource.exclusive)

    offered = _passed_on(FrameGrabber.offered)

    register_length = _passed_on(RegisterSource.register_length)
    read_register = _passed_on(RegisterSource.read_register)
    write_register = _passed_on(RegisterSource.write_register)

    start = _passed_on(StreamSource.start)
    stop = _passed_on(StreamSource.stop)
    statistics = _passed_on(StreamSource.statistics)
    calibration = _passed_on(StreamSource.calibration)
    silence = _passed_on(StreamSource.silence)
    recorded_coordinates = _passed_on(StreamSource.recorded_coordinates)

    def __init__(self, grabber: FrameGrabber) -> None:
        super().__init__(grabber.info)
        self._grabber = grabber
        self._queues: list[FrameQueue] = []
        self._queues_lock = threading.Lock()
        "Protects the list of queues, as any thread may open one."

    def open(self, access: Access = Access.CONTROL) -> None:
        """Listen to the grabber, which is already open."""
        # Not connected to `emit` itself, which psygnal would call with too many arguments first.
        self._grabber.features_changed.connect(self._on_features_changed)
        self._grabber.connection_changed.connect(self._on_connection_changed)
        self._grabber.noticed.connect(self._on_noticed)
        self._grabber.event_received.connect(self._on_event)
        self.connection_changed.emit(ConnectionState.OPEN, "")

    @override
    def close(self) -> None:
        self._grabber.features_changed.disconnect(self._on_features_changed, missing_ok=True)
        self._grabber.connection_changed.disconnect(self._on_connection_changed, missing_ok=True)
        self._grabber.noticed.disconnect(self._on_noticed, missing_ok=True)
        self._grabber.event_received.disconnect(self._on_event, missing_ok=True)
        with self._queues_lock:
            queues, self._queues = self._queues, []
        for queue in queues:
            queue.close()

    @property
    @override
    def access(self) -> Access:
        return self._grabber.access

    @property
    @override
    def lost(self) -> str:
        return self._grabber.lost

    @property
    @override
    def reads_at_once(self) -> int:
        return self._grabber.reads_at_once

    @property
    @override
    def selectors(self) -> Selectors:
        return self._grabber.selectors

    @property
    @override
    def streaming(self) -> bool:
        return self._grabber.streaming

    @override
    def open_queue(self, depth: int = 2) -> FrameQueue:
        queue = self._grabber.open_queue(depth)
        with self._queues_lock:
            self._queues = [*(q for q in self._queues if not q.closed), queue]
        return queue

    def _on_features_changed(self, names: frozenset[str]) -> None:
        self.features_changed.emit(names)

    def _on_noticed(self, message: str) -> None:
        self.noticed.emit(message)

    def _on_event(self, event: DeviceEvent) -> None:
        self.event_received.emit(event)

    def _on_connection_changed(self, state: ConnectionState, reason: str) -> None:
        self.info, self.unlike_before = self._grabber.info, self._grabber.unlike_before
        self.changed_meanwhile = self._grabber.changed_meanwhile
        self.connection_changed.emit(state, reason)


class ReadOnlyGrabber(SharedGrabber):
    """A handle on an open grabber that delivers frames and values, and refuses every write."""

    @property
    def access(self) -> Access:
        """Monitor, whatever access this process has."""
        return Access.MONITOR

    def feature(self, name: str) -> Feature:
        """Return the current feature without write access. Raises FeatureNotFoundError."""
        return self._unwritable(super().feature(name))

    def read_features(self, names: Sequence[str]) -> list[Feature]:
        """Return features as `feature` does."""
        return [self._unwritable(feature) for feature in super().read_features(names)]

    def write_feature(self, name: str, value: FeatureValue) -> Feature:
        """Raise FeatureAccessError, or FeatureNotFoundError."""
        raise FeatureAccessError(f"{super().feature(name).name} cannot be written: {_REASON}", name)

    def read_setting(self, key: SettingKey) -> Feature:
        """Read a feature. Raises FeatureAccessError unless its selectors already have the key's values."""
        return FrameGrabber.read_setting(self, key)  # selects by this class's `write_feature`

    def write_setting(self, key: SettingKey, value: FeatureValue) -> WriteResult:
        """Raise FeatureAccessError, or FeatureNotFoundError."""
        return WriteResult(self.write_feature(key.name, value), ())

    def pauses_for(self, name: str) -> bool:
        """Return False, as every write is refused."""
        return False

    def offered(self, feature: Feature) -> Feature:
        """Return the feature without write access."""
        return FrameGrabber.offered(self, feature)  # depends on this class's `access`

    def execute(self, name: str) -> None:
        """Raise FeatureAccessError, or FeatureNotFoundError."""
        raise FeatureAccessError(f"{super().feature(name).name} cannot be run: {_REASON}", name)

    def execute_setting(self, key: SettingKey) -> None:
        """Raise FeatureAccessError, or FeatureNotFoundError."""
        self.execute(key.name)

    def write_register(self, name: str, content: bytes) -> None:
        """Raise FeatureAccessError."""
        raise FeatureAccessError(f"{name} cannot be written: {_REASON}", name)

    def start(self, *, keep_trigger: bool = False) -> None:
        """Do nothing if the stream is on. Raises AccessDeniedError if it is off."""
        if not self.streaming:
            raise AccessDeniedError(f"the stream cannot be started: {_REASON}")

    def stop(self) -> None:
        """Raise AccessDeniedError, as other consumers need the stream."""
        raise AccessDeniedError(f"the stream cannot be stopped: {_REASON}")

    def _unwritable(self, feature: Feature) -> Feature:
        if not feature.access.writable:
            return feature
        if feature.access.readable:
            return replace(feature, access=AccessMode.READ_ONLY)
        return replace(feature, access=AccessMode.NOT_AVAILABLE, problem=_REASON)
