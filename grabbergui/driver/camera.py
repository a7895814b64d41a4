"""Any device plus GenApi's node map: a frame grabber."""

from __future__ import annotations

import logging
import threading
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace

from grabbergui.core.errors import DeviceLostError, FeatureAccessError, GrabberError
from grabbergui.core.features import AccessMode, Category, Feature, FeatureKind, FeatureValue
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import Access, ConnectionState, FrameGrabber, StreamStatistics
from grabbergui.core.sfnc import AUTO_OFF, automatic_mode_of, enabler_of
from grabbergui.driver.device import Device, StreamRequest
from grabbergui.driver.event_delivery import EventDelivery
from grabbergui.driver.genapi import preparation
from grabbergui.driver.genapi.chunk_reader import ChunkReader
from grabbergui.driver.genapi.node_map import CameraNodeMap
from grabbergui.driver.poller import POLL_PERIOD, Poller
from grabbergui.driver.settings_memory import SettingsMemory

log = logging.getLogger(__name__)

RECONNECT_PERIOD = 0.5
"""Seconds between attempts to open a camera that was lost."""

_EVENT_SWITCH = "EventNotification"
"""Beginning of the names of features that switch events on: one with a selector, or one an event."""

_CHANGES_PAYLOAD = (
    "PixelFormat", "Width", "Height", "Binning", "Decimation", "ChunkModeActive", "ChunkEnable",
)  # fmt: skip
"""Beginnings of the names of features that change what a frame looks like: the stream is restarted."""


class Camera(FrameGrabber):
    """A local camera on whatever transport. Thread-safe; feature calls are serialised.

    A camera that is lost is opened again as soon as it answers; what was written to it since it was opened
    is written again, and the stream goes on.
    """

    def __init__(self, device: Device, *, deliver_incomplete: bool = False) -> None:
        super().__init__(device.info)
        self.device = device
        "The transport, for what only it knows (its address, its stream's port)."
        self._deliver_incomplete = deliver_incomplete
        self._nodes: CameraNodeMap | None = None
        self._xml = b""
        self._chunks: ChunkReader | None = None
        self._chunk_reader: ChunkReader | None = None
        "Kept from stream to stream, as it parses the whole description; `_chunks` while they are on."
        self._access = Access.MONITOR
        self._streaming = False
        self._keep_trigger = False
        # Held for whole operations (start, stop, write with its restart), not while frames arrive.
        self._lock = threading.RLock()
        self._poller: Poller | None = None
        self._events: EventDelivery | None = None
        self._hears_events = False
        self._automatic: dict[str, list[str]] = {}
        self._settings = SettingsMemory()
        self._closed = threading.Event()
        self._closed.set()
        self._reconnecting: threading.Thread | None = None
        self._losses = threading.Lock()
        "Never held while anything waits: a loss is told of by threads that closing the device joins."
        self._lost_meanwhile = False

    # -- connection ------------------------------------------------------------------------------
    def open(self, access: Access = Access.CONTROL) -> None:
        """See FrameGrabber."""
        with self._lock:
            if self._nodes is not None:
                return
            self.connection_changed.emit(ConnectionState.OPENING, "")
            self.device.on_lost = self._on_lost
            self._events = EventDelivery(self._on_event, f"events {self.info.uri}")
            self.device.on_event = self._events.put
            self._hears_events = self._lost_meanwhile = False
            self.device.take_over = access is Access.TAKE_OVER
            self._settings = SettingsMemory()
            try:
                self._connect(Access.CONTROL if self.device.take_over else access)
                with self._losses:
                    if self._lost_meanwhile:
                        raise DeviceLostError(f"{self.info.title} was lost while it was opened")
                    self._closed.clear()
            except BaseException:
                if self._nodes is not None:
                    self._nodes.close()
                self._nodes = None
                self.device.close()
                self._events.close()
                self.connection_changed.emit(ConnectionState.CLOSED, "")
                raise
            # Once taken away again, control is not fought for.
            self.device.take_over = False
            self._poller = Poller(self._poll)
        self.connection_changed.emit(ConnectionState.OPEN, "")

    def _connect(self, access: Access) -> None:
        self._access = self.device.open(access)
        self._xml = self.device.description()
        self._nodes = CameraNodeMap(self.device, self._xml, self._on_features_changed)
        self.info = self.device.info
        self._automatic = self._automatic_modes(self._nodes)
        self._chunk_reader = None

    def close(self) -> None:
        """See FrameGrabber."""
        self._closed.set()
        with self._lock:
            if self._nodes is None:
                return
            try:
                self.stop()
            except GrabberError as error:
                log.info("stopping %s on closing: %s", self.info.uri, error)
            poller, self._poller = self._poller, None
            nodes, self._nodes = self._nodes, None
            nodes.close()
            self.device.close()
            reconnecting, self._reconnecting = self._reconnecting, None
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
    def access(self) -> Access:
        """See FrameGrabber."""
        return self._access

    # -- features --------------------------------------------------------------------------------
    def feature_tree(self) -> Category:
        """See FrameGrabber."""
        return self._opened().root

    def has_feature(self, name: str) -> bool:
        """See FrameGrabber."""
        return self._opened().has(name)

    def feature(self, name: str) -> Feature:
        """See FrameGrabber."""
        nodes = self._opened()
        self._require(name)
        feature = nodes.feature(name)
        ours = self._access is Access.CONTROL and name != preparation.TRANSPORT_LOCK
        if feature.access.writable and not ours:
            readable = feature.access.readable
            feature = replace(
                feature, access=AccessMode.READ_ONLY if readable else AccessMode.NOT_AVAILABLE
            )
        return feature

    def write_feature(self, name: str, value: FeatureValue) -> Feature:
        """See FrameGrabber.

        A value that changes the size of a frame while streaming stops the stream, is written, and starts it
        again. A switch that makes the feature act (AcquisitionFrameRateEnable) is turned on.
        """
        with self._lock:
            feature = self.feature(name)
            if self._access is Access.MONITOR:
                raise FeatureAccessError(
                    f"{name}: this camera is open for reading only, another application controls it", name
                )
            if name == preparation.TRANSPORT_LOCK:
                raise FeatureAccessError(f"{name} is set by the stream alone: 1 while it runs", name)
            restart = self._streaming and self.pauses_for(name)
            # Refuse a wrong value before anything is switched or stopped for its sake.
            if feature.value is not None:
                replace(feature, access=AccessMode.READ_WRITE).validated(value)
            if name.startswith(_EVENT_SWITCH):
                self._hear_events()
            with self._paused() if restart else nullcontext():
                self._prepare_write(feature)
                feature = self._opened().feature(name)
                accepted = feature.validated(value)
                self._opened().write(name, accepted)
                self._settings.note(feature, accepted, self._opened().feature)
            return self.feature(name)

    def pauses_for(self, name: str) -> bool:
        """See FrameGrabber."""
        return name.startswith(_CHANGES_PAYLOAD) and not name.endswith("Max")

    def execute(self, name: str) -> None:
        """See FrameGrabber."""
        self._require(name)
        if self._access is Access.MONITOR:
            raise FeatureAccessError(f"{name}: this camera is open for reading only", name)
        self._opened().execute(name)

    def _prepare_write(self, feature: Feature) -> None:
        nodes = self._opened()
        if feature.auto is not None:
            mode = nodes.feature(feature.auto)
            if mode.value != AUTO_OFF and mode.access.writable and preparation.has_entry(mode, AUTO_OFF):
                nodes.write(mode.name, AUTO_OFF)
        enabler = enabler_of(feature.name, nodes.has)
        if enabler is not None:
            switch = nodes.feature(enabler)
            if switch.kind is FeatureKind.BOOLEAN and switch.value is False and switch.access.writable:
                nodes.write(enabler, True)

    # -- acquisition -----------------------------------------------------------------------------
    def start(self, *, keep_trigger: bool = False) -> None:
        """See FrameGrabber."""
        with self._lock:
            if self._streaming:
                return
            self._opened()
            self._keep_trigger = keep_trigger
            if self._access is Access.CONTROL:
                preparation.run_free(self._opened(), keep_trigger=keep_trigger)
                if self._event_left_on():
                    self._hear_events()
            self._start_stream()

    def stop(self) -> None:
        """See FrameGrabber."""
        with self._lock:
            if self._streaming:
                self._stop_stream()

    @property
    def streaming(self) -> bool:
        """See FrameGrabber."""
        return self._streaming

    def statistics(self) -> StreamStatistics:
        """See FrameGrabber."""
        return self.device.stream_statistics()

    def _start_stream(self) -> None:
        request = StreamRequest(preparation.payload_size(self._opened()), self._deliver_incomplete)
        self._fanout.clear()
        self._chunks = self._reader_of_chunks()
        self.device.open_stream(request, self._deliver)
        preparation.forget_what_transport_set(self._opened())
        try:
            if self._access is Access.CONTROL:
                self._lock_transport(locked=True)
                self._opened().execute("AcquisitionStart")
        except BaseException:
            self.device.close_stream()
            self._lock_transport(locked=False)
            raise
        self._streaming = True

    def _stop_stream(self) -> None:
        self._streaming = False
        try:
            if self._access is Access.CONTROL:
                self._opened().execute("AcquisitionStop")
        finally:
            self.device.close_stream()
            self._lock_transport(locked=False)

    @contextmanager
    def _paused(self) -> Iterator[None]:
        self._stop_stream()
        try:
            yield
        finally:
            self._start_stream()

    def _lock_transport(self, *, locked: bool) -> None:
        if self._nodes is not None:
            preparation.lock_transport(self._nodes, locked=locked)

    def _reader_of_chunks(self) -> ChunkReader | None:
        nodes, layout = self._opened(), self.device.chunk_layout
        if layout is None or not nodes.has("ChunkModeActive") or not nodes.feature("ChunkModeActive").value:
            return None
        if self._chunk_reader is None:
            self._chunk_reader = ChunkReader(self._xml, nodes.root, layout)
        return self._chunk_reader

    def _deliver(self, frame: Frame) -> None:
        if self._chunks is not None and frame.complete:
            frame.chunks.update(self._chunks.read(frame.payload))
        self._fanout.put(frame)

    # -- changes ---------------------------------------------------------------------------------
    def _on_features_changed(self, names: frozenset[str]) -> None:
        self.features_changed.emit(names)

    def _event_left_on(self) -> bool:
        """Whether a user set, or who had the camera before, left the selected event switched on."""
        nodes = self._opened()
        return nodes.has(_EVENT_SWITCH) and nodes.feature(_EVENT_SWITCH).value not in ("Off", None)

    def _hear_events(self) -> None:
        self.device.open_events()
        self._hears_events = True

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
        """Let values that move by themselves be noticed, while anybody listens."""
        nodes = self._nodes
        if nodes is None or not len(self.features_changed):
            return
        nodes.poll(int(POLL_PERIOD * 1000))
        moving = frozenset(self._regulated(nodes))
        if moving:
            nodes.invalidate(moving)

    @staticmethod
    def _automatic_modes(nodes: CameraNodeMap) -> dict[str, list[str]]:
        """Each automatic mode and the features it regulates."""
        modes: dict[str, list[str]] = {}
        for description in nodes.root.descriptions():
            auto = automatic_mode_of(description.name, nodes.has)
            if auto is not None:
                modes.setdefault(auto, []).append(description.name)
        return modes

    def _regulated(self, nodes: CameraNodeMap) -> Iterator[str]:
        """Features whose automatic mode is on: cameras seldom give these a PollingTime."""
        for auto, names in self._automatic.items():
            if nodes.feature(auto).value not in (AUTO_OFF, None):
                yield auto  # Once falls back to Off by itself
                yield from names

    # -- loss and return -------------------------------------------------------------------------
    def _on_lost(self, reason: str) -> None:
        log.warning("%s: %s", self.info.uri, reason)
        was_streaming, self._streaming = self._streaming, False
        self.connection_changed.emit(ConnectionState.LOST, reason)
        with self._losses:
            if self._closed.is_set() or self._reconnecting is not None:
                self._lost_meanwhile = True
                return
            name = f"reconnect {self.info.uri}"
            thread = threading.Thread(target=self._reconnect, args=(was_streaming,), name=name, daemon=True)
            self._reconnecting = thread
        thread.start()

    def _reconnect(self, was_streaming: bool) -> None:
        """Try until it is back or closed."""
        while not self._closed.wait(RECONNECT_PERIOD):
            with self._lock:
                if self._closed.is_set():
                    return
                try:
                    self._restore(was_streaming)
                except GrabberError as error:
                    log.info("%s is not back yet: %s", self.info.uri, error)
                    continue
                with self._losses:
                    if self._lost_meanwhile:
                        continue
                    self._reconnecting = None
            self.connection_changed.emit(ConnectionState.OPEN, "it is back, and set as before")
            names = frozenset(description.name for description in self.feature_tree().descriptions())
            self.features_changed.emit(names)
            return

    def _restore(self, streaming: bool) -> None:
        self.device.close_stream()
        self.device.close()
        self._lost_meanwhile = self._streaming = False  # what was told until here is about what is closed
        if self._nodes is not None:
            self._nodes.close()
        self._connect(self._access)
        nodes = self._opened()
        if self._hears_events:
            self.device.open_events()
        for refusal in self._settings.replay(nodes.write):
            log.warning("%s, set again: %s", self.info.uri, refusal)
        if streaming:
            self.start(keep_trigger=self._keep_trigger)

    def _opened(self) -> CameraNodeMap:
        nodes = self._nodes
        if nodes is None:
            raise DeviceLostError(f"{self.info.title} is not open")
        return nodes
