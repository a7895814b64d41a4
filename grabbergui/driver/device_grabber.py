"""Combines any `Device` with GenApi's node map into a frame grabber."""

from __future__ import annotations

import logging
from collections.abc import Container, Iterable, Iterator, Mapping
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import replace

from psygnal import EmitLoopError
from typing_extensions import override

from grabbergui.core.errors import (
    DeviceLostError,
    FeatureAccessError,
    FeatureError,
    GrabberError,
    ResourceExhaustedError,
    TransportError,
)
from grabbergui.core.features import (
    TRANSPORT_LOCK,
    AccessCondition,
    Category,
    Feature,
    FeatureValue,
    format_value,
)
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.core.grabber import Access, ConnectionState
from grabbergui.core.settings import SettingKey, WriteResult
from grabbergui.driver import acquisition, description_files
from grabbergui.driver.acquisition import Acquisition
from grabbergui.driver.device import Device
from grabbergui.driver.event_delivery import EventDelivery
from grabbergui.driver.genapi.node_map import CameraNodeMap
from grabbergui.driver.poller import POLL_PERIOD, Poller
from grabbergui.driver.reconnection import ReconnectingGrabber
from grabbergui.driver.setting_writer import LOAD_SET, SettingsMemory, SettingWriter, validated

log = logging.getLogger(__name__)

_EVENT_SWITCH = "EventNotification"
"""Beginning of the names of features that switch events on: one with a selector, or one an event."""


class DeviceGrabber(ReconnectingGrabber):
    """A local camera on any transport. Thread-safe; feature calls are serialised.

    A lost camera is opened again as soon as it answers. All settings made since it was first opened are
    restored and compared, and the stream resumes.
    """

    def __init__(self, device: Device, *, deliver_incomplete: bool = False) -> None:
        super().__init__(device.info)
        self.device = device
        "The transport, for properties that only it has (address, stream port)."
        self._acquisition = Acquisition(device, self._fanout, deliver_incomplete=deliver_incomplete)
        self._nodes: CameraNodeMap | None = None
        self._access = Access.MONITOR
        self._poller: Poller | None = None
        self._events: EventDelivery | None = None
        self._events_open = False
        self._writer: SettingWriter | None = None

    @override
    def open(self, access: Access = Access.CONTROL) -> None:
        with self._lock:
            if self._nodes is not None:
                return
            self.connection_changed.emit(ConnectionState.OPENING, "")
            self.device.on_lost = self._on_lost
            self.device.on_held = self.held_changed.emit
            self._events = EventDelivery(self._on_event, f"events {self.info.uri}")
            self.device.on_event = self._events.put
            self._events_open = False
            self._begin_opening()
            self.device.take_over, self.device.interrupted = access is Access.TAKE_OVER, False
            self._writer = None  # settings from before `close` are not restored
            try:
                self._connect(Access.CONTROL if self.device.take_over else access)
                self._finish_opening()
            except BaseException:
                if self._nodes is not None:
                    self._nodes.close()
                self._nodes = None
                self.device.close()
                self._end_connection()
                self._events.close()
                self.connection_changed.emit(ConnectionState.CLOSED, "")
                raise
            # If control is taken away later, reconnecting must not take it back.
            self.device.take_over = False
            self._poller = Poller(self._poll)
        self.connection_changed.emit(ConnectionState.OPEN, "")

    def _connect(self, access: Access) -> None:
        try:
            self._access = self.device.open(access)
            file = self.device.description_file
            xml, nodes = description_files.used(self.device, file, self._node_map)
            self._nodes = nodes
        except GrabberError:
            raise
        except OSError as error:  # this computer has no more file descriptors, or its disk is full
            raise ResourceExhaustedError.of(error) or TransportError(
                f"{self.info.title} cannot be opened: {error.strerror or error}"
            ) from error
        self._acquisition.attach(nodes, xml, in_control=self._access is Access.CONTROL)
        self.info = self.device.info
        memory = self._writer.memory if self._writer is not None else SettingsMemory()
        self._writer = SettingWriter(self, nodes, memory)

    def _node_map(self, xml: bytes) -> CameraNodeMap:
        return CameraNodeMap(self.device, xml, self._on_features_changed)

    @override
    def close(self) -> None:
        if self._stop_reconnecting():
            self.device.interrupt()  # an attempt holds the lock while it waits for a camera that is gone
        with self._lock:
            if self._nodes is None:
                return
            self._stop_reconnecting()  # again: another thread may just have opened it
            try:
                self.stop()
            except GrabberError as error:
                log.info("stopping %s on closing: %s", self.info.uri, error)
            poller, self._poller = self._poller, None
            nodes, self._nodes = self._nodes, None
            try:
                nodes.close()
            finally:
                self.device.close()
            reconnecting = self._end_connection()
            events, self._events = self._events, None
        if events is not None:
            events.close()
        if poller is not None:
            poller.stop()
        if reconnecting is not None:
            reconnecting.join()
        self._fanout.close()
        self.connection_changed.emit(ConnectionState.CLOSED, "")

    @property
    @override
    def access(self) -> Access:
        return self._access

    @override
    def feature_tree(self) -> Category:
        return self._opened().root

    @override
    def has_feature(self, name: str) -> bool:
        return self._opened().has(name)

    @override
    def feature(self, name: str) -> Feature:
        nodes = self._opened()
        self._require(name)
        with self._explaining_loss:
            feature = nodes.feature(name)
        ours = self._access is Access.CONTROL and name != TRANSPORT_LOCK
        return feature if ours else replace(feature, access=feature.access.without_writing)

    @override
    def conditions(self, name: str) -> tuple[AccessCondition, ...]:
        nodes = self._opened()
        self._require(name)
        with self._explaining_loss:
            return nodes.conditions(name)

    @override
    def write_feature(self, name: str, value: FeatureValue) -> Feature:
        """Write a value. One that changes the size of a frame stops a running stream and starts it again.

        A switch that makes the feature act (AcquisitionFrameRateEnable) is turned on.
        """
        with self._explaining_loss:
            return self._write(name, value).feature

    @override
    def read_setting(self, key: SettingKey) -> Feature:
        """Report no change of selectors, which are only switched for the moment."""
        if not key.selected:
            return self.feature(key.name)
        with self._explaining_loss, self._lock, self._opened().unreported():
            return super().read_setting(key)

    @override
    def write_setting(self, key: SettingKey, value: FeatureValue) -> WriteResult:
        """Consequences are found by the description's invalidation rules."""
        with self._explaining_loss, self._selecting(key.selected) if key.selected else nullcontext():
            return self._write(key.name, value)

    @override
    def setting(self, name: str) -> SettingKey:
        path = self.selectors.of(name)
        values = self._opened().values(path)
        return SettingKey(name, tuple((s, format_value(values[s])) for s in path if s in values))

    @contextmanager
    @override
    def exclusive(self, selectors: Iterable[str] = ()) -> Iterator[None]:
        """Block readers too: they must not see selectors that are switched for the moment."""
        with self._lock, self._opened().exclusive(), super().exclusive(selectors):
            yield

    def _write(self, name: str, value: FeatureValue) -> WriteResult:
        with self._lock:
            nodes, writer = self._opened(), self._writes()
            self._require(name)
            self._require_control(name)
            if name == TRANSPORT_LOCK:
                raise FeatureAccessError(f"{name} is set by the stream alone: 1 while it runs", name)
            if self._acquisition.left_on and self._acquisition.pauses_for(name):
                self._acquisition.stop()  # otherwise it is locked until the next stream ends
            restart = self._acquisition.running and self._acquisition.pauses_for(name)
            taking = None if restart else nodes.taking(name, value)
            feature, value = taking or validated(nodes.feature(name), value)
            if name.startswith(_EVENT_SWITCH):
                self._open_events()
            if not restart:
                with nodes.exclusive():  # one lock for all its steps
                    return writer.write(feature, value)
            with self._acquisition.paused():
                result = writer.write(feature, value)
            # A stream that runs again locks features.
            others = tuple(self.feature(other.name) for other in result.also_changed)
            return replace(result, feature=self.feature(name), also_changed=others)

    @override
    def pauses_for(self, name: str) -> bool:
        """Include features that the description locks only during streaming."""
        return self._acquisition.pauses_for(name)

    @override
    def execute(self, name: str) -> None:
        self._require(name)
        self._require_control(name)
        with self._explaining_loss, self._lock if name == LOAD_SET else nullcontext():
            self._opened().execute(name)
            if name == LOAD_SET:
                self._writes().memory.note_loaded_set(self.setting(name))

    @override
    def register_length(self, name: str) -> int:
        with self._explaining_loss:
            return self._opened().register_length(name)

    @override
    def read_register(self, name: str, length: int) -> bytes:
        with self._explaining_loss:
            return self._opened().read_register(name, length)

    @override
    def write_register(self, name: str, content: bytes) -> None:
        self._require_control(name)
        with self._explaining_loss, self._lock:
            self._opened().write_register(name, content)

    def _require_control(self, name: str) -> None:
        if self._access is Access.MONITOR:
            raise FeatureAccessError(
                f"{name}: this camera is open for reading only; another application may control it", name
            )

    @override
    def start(self, *, keep_trigger: bool = False) -> None:
        """A camera that is lost during the start streams once it is reconnected."""
        self._start({acquisition.TRIGGER} if keep_trigger else ())

    def _start(self, kept: Container[str]) -> None:
        with self._lock:
            if self.streaming:
                return
            self._opened()
            try:
                if self._access is Access.CONTROL:
                    acquisition.run_free(self, kept)
                    if self._event_already_on():
                        self._open_events()
                self._acquisition.start()
            except DeviceLostError:
                self._acquisition.wanted = True  # once it is back
                raise

    @override
    def stop(self) -> None:
        with self._lock:
            self._acquisition.stop()

    @property
    @override
    def streaming(self) -> bool:
        return self._acquisition.running

    @override
    def statistics(self) -> StreamStatistics:
        return self.device.stream_statistics()

    @override
    def silence(self) -> str:
        return self.device.silence() if self.streaming else ""

    def _on_features_changed(self, names: frozenset[str]) -> None:
        if not len(self.features_changed):
            return
        try:
            self.features_changed.emit(names)
        except EmitLoopError as error:
            if not isinstance(error.__cause__, ReferenceError):
                raise
            # Another thread removed a listener during the call; notify the rest once more.
            self.features_changed.emit(names)

    def _event_already_on(self) -> bool:
        """Whether a user set or a previous application left the selected event switched on."""
        nodes = self._opened()
        return nodes.has(_EVENT_SWITCH) and nodes.feature(_EVENT_SWITCH).value not in ("Off", None)

    def _open_events(self) -> None:
        self.device.open_events()
        self._events_open = True

    def _on_event(self, event_id: int, message: bytes) -> None:
        nodes = self._nodes
        if nodes is None:
            return
        try:
            event = nodes.take_event(event_id, message)
        except GrabberError as error:
            log.info("%s: %s", self.info.uri, error)
            return
        if event is not None:
            log.info("%s: event %s", self.info.uri, event)
            self.event_received.emit(event)

    def _poll(self) -> None:
        """Report values that change by themselves, if `features_changed` has listeners."""
        nodes = self._nodes
        if nodes is None or self._reconnecting is not None:
            return
        if self._lock.acquire(blocking=False):
            try:
                self._writes().notice_regulated_once()
            except GrabberError as error:
                log.info("%s: %s", self.info.uri, error)
            finally:
                self._lock.release()
        if not len(self.features_changed):
            return
        nodes.poll(int(POLL_PERIOD * 1000))
        moving = frozenset(self._writes().regulated_now())
        if moving:
            nodes.invalidate(moving)

    def _on_lost(self, reason: str) -> None:
        self._acquisition.running = False
        self._lose(reason)

    @override
    def _known_settings(self) -> dict[SettingKey, FeatureValue]:
        return self._writer.known_settings() if self._nodes is not None and self._writer else {}

    @override
    def _disconnect(self) -> None:
        self.device.close_stream()
        self.device.close()
        self._acquisition.running = False

    @override
    def _restore(self, known: Mapping[SettingKey, FeatureValue]) -> tuple[list[str], list[str]]:
        streaming = self._acquisition.wanted
        if self._nodes is not None:
            self._nodes.close()
        self._connect(self._access)
        if self._events_open:
            self.device.open_events()
        in_control = self._access is Access.CONTROL
        problems, changed = self._set_as_before(streaming, known) if in_control else ([], [])
        if streaming:
            # Keep the restored triggers, and the mode if the user chose one.
            remembered = {key.name for key in self._writes().memory.settings}
            self._start({acquisition.TRIGGER, *remembered & {acquisition.MODE}})
        return problems, changed

    def _set_as_before(
        self, was_streaming: bool, known: Mapping[SettingKey, FeatureValue]
    ) -> tuple[list[str], list[str]]:
        if was_streaming:
            # A camera that kept its power may still stream and lock the layout of its frames.
            with suppress(FeatureError):
                self._opened().execute("AcquisitionStop")
            self._acquisition.lock_transport(locked=False)
        # Restoring must not change the remembered settings.
        writer = self._writes()
        remembered, writer.memory = writer.memory, SettingsMemory()
        try:
            problems = remembered.restore(self)
            # The mode changes when the stream starts.
            others = {k: v for k, v in known.items() if not (was_streaming and k.name == acquisition.MODE)}
            return problems, writer.changed_since(others)
        finally:
            writer.memory = remembered

    def _writes(self) -> SettingWriter:
        self._opened()
        assert self._writer is not None
        return self._writer

    def _opened(self) -> CameraNodeMap:
        nodes = self._nodes  # another thread may close it
        if nodes is None:
            raise DeviceLostError(f"{self.info.title} is not open")
        return nodes
