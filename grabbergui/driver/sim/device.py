"""The simulated camera in this process, without a transport: `sim:`."""

from __future__ import annotations

import logging
import struct
import threading
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.component import Component, PayloadType
from grabbergui.core.errors import DeviceLostError, DeviceStatusError, LocalProtocolError
from grabbergui.core.frame import BufferPool, Frame
from grabbergui.core.frame_queue import RateMeter, StreamStatistics
from grabbergui.core.grabber import Access
from grabbergui.core.identity import DeviceInfo
from grabbergui.driver.device import DataLayout, Device, StreamRequest
from grabbergui.driver.gige.gvcp_messages import Event as Message
from grabbergui.driver.h264 import H264Stream
from grabbergui.driver.payload_contents import Contents, PayloadReader
from grabbergui.driver.sim.contents import CHUNK_FEATURE, FILE_NAME, pieces
from grabbergui.driver.sim.description import camera_xml
from grabbergui.driver.sim.memory import Refusal, RegisterRefusedError
from grabbergui.driver.sim.model import CameraModel, FramePlan
from grabbergui.driver.sim.registers import EVENT_ID_BASE, Event

log = logging.getLogger(__name__)

_STATUS = {
    Refusal.INVALID_ADDRESS: 0x8003,
    Refusal.WRITE_PROTECT: 0x8004,
    Refusal.BAD_ALIGNMENT: 0x8005,
    Refusal.INVALID_PARAMETER: 0x8002,
    Refusal.ACCESS_DENIED: 0x8006,
}
"GVCP's codes, for want of any of our own."

_POLL_S = 0.1
_EVENT_DATA = struct.Struct(">qq")
"Frame id, timestamp."


class SimulatedDevice(Device):
    """A `CameraModel` as a device. Its frames are rendered straight into the pool's buffers."""

    event_layout = DataLayout.GIGE_VISION

    def __init__(self, info: DeviceInfo, model: CameraModel) -> None:
        self.info = info
        self.model = model
        self._open = False
        self._granted = Access.MONITOR
        self._running = threading.Event()
        self._thread: threading.Thread | None = None
        self._statistics = StreamStatistics()
        self._rate = RateMeter()
        self._reader = PayloadReader()
        self._decoder = H264Stream()

    def open(self, access: Access) -> Access:
        """Connect. Every access is granted, as no other program can hold this camera."""
        self._open = True
        self._granted = access
        self.model.on_event = self._send_event
        return access

    def close(self) -> None:
        """Stop the acquisition and disconnect."""
        self.close_stream()
        if self._granted is Access.CONTROL:
            self.model.stop()
        self.model.on_event = None
        self._open = False

    def read(self, address: int, length: int) -> bytes:
        """Register bytes."""
        self._require_open()
        try:
            return self.model.read(address, length)
        except RegisterRefusedError as error:
            raise DeviceStatusError(f"the camera refused to read: {error}", _STATUS[error.reason]) from error

    def write(self, address: int, data: bytes) -> None:
        """Write registers."""
        self._require_open()
        try:
            self.model.write(address, data)
        except RegisterRefusedError as error:
            raise DeviceStatusError(f"the camera refused to write: {error}", _STATUS[error.reason]) from error

    def description(self) -> bytes:
        """Return the GenICam XML."""
        return camera_xml()

    def open_stream(self, request: StreamRequest, deliver: Callable[[Frame], None]) -> None:
        """Start the thread that renders and delivers."""
        if self._thread is not None:
            raise LocalProtocolError("the simulated camera's stream is open already")
        self._statistics = StreamStatistics()
        self._rate.clear()
        # The first look draws the scene, which must not make the first frames late.
        self.model.sensor.scene.view(0)
        self._running.set()
        pool = BufferPool(max(request.payload_size, 1))
        self._thread = threading.Thread(
            target=self._stream, args=(pool, deliver), name="simulated camera", daemon=True
        )
        self._thread.start()

    def close_stream(self) -> None:
        """Stop the thread and wait for its end."""
        self._running.clear()
        if self._thread is not None:
            self._thread.join()
            self._thread = None

    def stream_statistics(self) -> StreamStatistics:
        """Return a snapshot of the counters."""
        return self._statistics.snapshot(self._rate)

    def _require_open(self) -> None:
        if not self._open:
            raise DeviceLostError("the simulated camera is closed")

    def _stream(self, pool: BufferPool, deliver: Callable[[Frame], None]) -> None:
        while self._running.is_set():
            plan = self.model.next_frame(_POLL_S)
            if plan is None:
                continue
            if plan.payload_bytes > pool.size:
                # The stream was opened for smaller frames, as if packets beyond the buffer were dropped.
                self._statistics.incomplete += 1
                continue
            buffer = pool.take()
            if buffer is None:
                self._statistics.underruns += 1
                continue
            used = self.model.render(plan, buffer)
            self._statistics.frames += 1
            self._statistics.bytes += used
            self._rate.add(used)
            frame = self._frame(plan, buffer[:used])
            del buffer
            try:
                deliver(frame)
            except Exception:
                log.exception("a consumer of frames failed")
            del frame  # else its buffer would be in use until the next one is made

    def _frame(self, plan: FramePlan, payload: NDArray[np.uint8]) -> Frame:
        settings = plan.settings
        frame = Frame(
            payload=payload,
            width=settings.width,
            height=settings.height,
            pixel_format=settings.pixel_format,
            frame_id=plan.frame_id,
            timestamp_ns=plan.timestamp_ns,
            received_ns=time.time_ns() - (self.model.timestamp() - plan.timestamp_ns),
            offset_x=settings.offset_x,
            offset_y=settings.offset_y,
            chunks={CHUNK_FEATURE[chunk]: value for chunk, value in plan.chunk_values.items()},
        )
        if settings.payload_type is PayloadType.IMAGE:
            return frame
        return self._contents(plan, payload).frame(frame)

    def _contents(self, plan: FramePlan, payload: NDArray[np.uint8]) -> Contents:
        settings, kind = plan.settings, plan.settings.payload_type
        if kind is PayloadType.GENDC:
            return self._reader.container(payload)
        if kind in (PayloadType.JPEG, PayloadType.JPEG2000):
            return self._reader.compressed(kind, payload)
        if kind is PayloadType.H264:
            if plan.frame_id == 1:
                self._decoder = H264Stream()
            image = self._decoder.add(plan.frame_id, payload)
            return Contents(kind, payload, () if image is None else (image,))
        if kind is not PayloadType.MULTI_PART:
            return self._reader.plain(kind, payload, FILE_NAME if kind is PayloadType.FILE else "")
        parts = tuple(
            Component(
                payload[piece.begin : piece.begin + piece.length],
                settings.width,
                settings.height,
                piece.pixel_format,
                piece.kind,
                offset_x=settings.offset_x,
                offset_y=settings.offset_y,
            )
            for piece in pieces(settings, ())
        )
        return Contents(kind, payload, parts)

    def _send_event(self, event: Event, frame_id: int, timestamp: int) -> None:
        if self.on_event:
            event_id = EVENT_ID_BASE + event
            message = Message(event_id, frame_id, timestamp, data=_EVENT_DATA.pack(frame_id, timestamp))
            self.on_event(event_id, message.encode(1, ack_required=False))
