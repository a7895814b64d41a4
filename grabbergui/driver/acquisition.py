"""Background activity of an open camera: its stream, its events, and the polling of values.

`Acquisition` prepares, starts, pauses and ends the stream. `EventDelivery` and `Poller` have a thread each.
"""

from __future__ import annotations

import logging
from collections.abc import Container, Iterator
from contextlib import contextmanager

from grabbergui.core import pfnc
from grabbergui.core.component import PayloadType
from grabbergui.core.errors import FeatureAccessError, GrabberError
from grabbergui.core.feature_instances import instances_of
from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.features import TRANSPORT_LOCK, Feature, FeatureValue
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameFanout
from grabbergui.core.settings import SettingKey
from grabbergui.driver.camera_formats import CameraFormats
from grabbergui.driver.chunk_image import GEOMETRY, take_image
from grabbergui.driver.device import Device, StreamRequest
from grabbergui.driver.genapi.chunk_reader import ChunkReader
from grabbergui.driver.genapi.node_map import CameraNodeMap

log = logging.getLogger(__name__)

MODE, TRIGGER = "AcquisitionMode", "TriggerMode"
"Features that can keep a camera from sending frames continuously."
MOST_BYTES_PER_PIXEL = 8
"Upper limit of all pixel formats."
_SET_BY_TRANSPORT = ("GevSCPSPacketSize", "GevSCPD", "GevSCDA", "GevSCPHostPort")
"Features whose registers a transport writes by itself when it opens a stream."
NOT_SETTINGS = frozenset({TRANSPORT_LOCK, *_SET_BY_TRANSPORT})
"Features that are written for each stream."
_CHANGES_PAYLOAD = (
    "PixelFormat", "Width", "Height", "Binning", "Decimation", "ChunkModeActive", "ChunkEnable",
    "ComponentEnable", "GenDCStreamingMode", "ImageCompression", "PayloadType",
)  # fmt: skip
"Beginnings of the names of features that change the size or layout of a frame: the stream is restarted."
PIXEL_ORDER = "DeviceStreamChannelEndianness"
"""SFNC's feature for the byte order of pixels: `Little` or `Big`."""


class Acquisition:
    """Starts, pauses and stops the stream of one camera. The caller holds the camera's lock.

    `running` is also cleared by the thread that notices the loss of the camera; `wanted` stays.
    """

    def __init__(self, device: Device, fanout: FrameFanout, *, deliver_incomplete: bool) -> None:
        self.running = False
        self.wanted = False
        "Whether the stream should run; also true while it is paused or the camera is lost."
        self.left_on = False
        "Whether the camera refused to stop, or to unlock the layout of frames, when the stream was closed."
        self._device = device
        self._fanout = fanout
        self._deliver_incomplete = deliver_incomplete
        self._nodes: CameraNodeMap | None = None
        self._xml = b""
        self._in_control = False
        self._chunks: ChunkReader | None = None
        "Reads the chunk data of the current stream; None while ChunkModeActive is off."
        self._chunk_reader: ChunkReader | None = None
        "Reused by later streams, because making it parses the whole description."
        self._formats: CameraFormats | None = None
        self._geometry: dict[str, FeatureValue] = {}
        "The image that the camera was set to send, for payloads of chunks that do not describe theirs."
        self._stream_locks: dict[str, bool] = {}
        "Cache for `pauses_for` during a stream: whether only the stream locks a feature."

    def attach(self, nodes: CameraNodeMap, xml: bytes, *, in_control: bool) -> None:
        """Use the node map of a camera that was opened or reopened."""
        self._nodes, self._xml, self._in_control = nodes, xml, in_control
        self._chunk_reader = None
        self.left_on = False

    def start(self) -> None:
        """Open the stream and, in control, start the acquisition. Raises GrabberError and stops again."""
        nodes = self._attached()
        order = _value_of(nodes, PIXEL_ORDER)
        request = StreamRequest(
            payload_size(nodes),
            self._deliver_incomplete,
            None if order is None else str(order).lower().startswith("big"),
        )
        self._fanout.clear()
        self._chunks = self._reader_of_chunks(nodes)
        self._formats = CameraFormats(nodes, self._device.info.vendor)
        self._geometry = nodes.values([name for name in GEOMETRY if nodes.has(name)])
        self._device.open_stream(request, self._deliver)
        _invalidate_transport_features(nodes)
        try:
            if self._in_control:
                self.lock_transport(locked=True)
                nodes.execute("AcquisitionStart")
        except BaseException:
            self._device.close_stream()
            self.lock_transport(locked=False)
            raise
        self._stream_locks.clear()
        self.running = self.wanted = True
        self.left_on = False

    def stop(self) -> None:
        """Stop the acquisition and close the stream, also if the camera refuses to stop; then try again."""
        self.wanted = False
        if self.running or self.left_on:
            self._halt()

    def _halt(self) -> None:
        self.running, self.left_on = False, True
        try:
            if self._in_control:
                self._attached().execute("AcquisitionStop")
        finally:
            self._device.close_stream()
            unlocked = not self._in_control or self.lock_transport(locked=False)
        self.left_on = not unlocked

    @contextmanager
    def paused(self) -> Iterator[None]:
        """Stop the stream for the block and restart it afterwards, also if the camera refuses to stop."""
        try:
            self._halt()
            yield
        finally:
            self.start()

    def pauses_for(self, name: str) -> bool:
        """Whether a write of the feature `name` needs the stream to pause.

        It does if it changes the size or layout of a frame, or if only the running stream locks the feature.
        """
        if name.startswith(_CHANGES_PAYLOAD) and not name.endswith(("Max", "Selector")):
            return True
        if not self.running:
            return False
        if name not in self._stream_locks:
            nodes = self._attached()
            self._stream_locks[name] = nodes.has_node(TRANSPORT_LOCK) and nodes.is_locked_by(
                name, TRANSPORT_LOCK
            )
        return self._stream_locks[name]

    def lock_transport(self, *, locked: bool) -> bool:
        """Forbid or allow changes of the layout of frames (TLParamsLocked); return False if refused."""
        nodes = self._attached()
        if not nodes.has_node(TRANSPORT_LOCK):
            return True
        try:
            if nodes.feature(TRANSPORT_LOCK).access.writable:
                nodes.write(TRANSPORT_LOCK, int(locked))
        except GrabberError as error:
            log.info("%s=%d: %s", TRANSPORT_LOCK, locked, error)
            return False
        return True

    def _attached(self) -> CameraNodeMap:
        assert self._nodes is not None
        return self._nodes

    def _reader_of_chunks(self, nodes: CameraNodeMap) -> ChunkReader | None:
        layout = self._device.chunk_layout
        if layout is None or not nodes.has("ChunkModeActive") or not nodes.feature("ChunkModeActive").value:
            return None
        if self._chunk_reader is None:
            self._chunk_reader = ChunkReader(self._xml, nodes.root, layout)
        return self._chunk_reader

    def _deliver(self, frame: Frame) -> None:
        """Pass a frame to the consumers. Called on the transport's receiver thread."""
        if self._formats is not None:
            self._formats.correct(frame)
        if self._chunks is not None and frame.complete:
            payload = frame.payload if frame.chunk_payload is None else frame.chunk_payload
            frame.chunks.update(self._chunks.read(payload))
        if frame.payload_type is PayloadType.CHUNK and self._device.chunk_layout is not None:
            take_image(frame, self._device.chunk_layout, self._geometry)
        self._fanout.put(frame)


def run_free(grabber: FeatureSource, kept: Container[str] = ()) -> None:
    """Write AcquisitionMode Continuous and every TriggerMode Off, except those that are `kept`."""
    modes = [SettingKey(MODE)] if grabber.has_feature(MODE) else []
    for wanted, keys in (("Continuous", modes), ("Off", instances_of(grabber, TRIGGER))):
        for key in keys:
            if key.name in kept:
                continue
            feature = grabber.read_setting(key)
            if feature.value != wanted and feature.access.writable and _offers(feature, wanted):
                grabber.write_setting(key, wanted)


def payload_size(nodes: CameraNodeMap) -> int:
    """Return the size of the largest frame in bytes.

    Raises FeatureAccessError if the camera has neither PayloadSize nor Width and Height.
    """
    size = _value_of(nodes, "PayloadSize")
    if isinstance(size, int) and size > 0:
        return size
    width, height = _value_of(nodes, "Width"), _value_of(nodes, "Height")
    if not isinstance(width, int) or not isinstance(height, int):
        raise FeatureAccessError("the camera has neither PayloadSize nor Width and Height", "PayloadSize")
    try:
        return pfnc.by_name(str(_value_of(nodes, "PixelFormat"))).image_bytes(width, height)
    except KeyError:
        return width * height * MOST_BYTES_PER_PIXEL


def _value_of(nodes: CameraNodeMap, name: str) -> FeatureValue | None:
    """Read a node's value from the camera, not from the cache; None without such a node."""
    if not nodes.has_node(name):
        return None
    nodes.invalidate(frozenset({name}))
    return nodes.feature(name).value


def _invalidate_transport_features(nodes: CameraNodeMap) -> None:
    """Invalidate cached values that the transport changed without GenApi when it opened the stream."""
    nodes.invalidate(frozenset(name for name in _SET_BY_TRANSPORT if nodes.has(name)))


def _offers(feature: Feature, name: str) -> bool:
    """Whether an enumeration has this entry and it is available."""
    return any(entry.name == name and entry.available for entry in feature.entries)
