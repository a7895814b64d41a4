"""A GenTL data stream: announced buffers, and the thread that takes the filled ones."""

from __future__ import annotations

import ctypes
import logging
import threading
import time
import weakref
from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np
from genicam import gentl
from numpy.typing import NDArray

from grabbergui.core import pfnc
from grabbergui.core.errors import LocalProtocolError, TransportError
from grabbergui.core.frame import POOL_MEMORY, Frame, FrameStatus
from grabbergui.core.frame_queue import RateMeter, StreamStatistics
from grabbergui.driver.device import StreamRequest
from grabbergui.driver.gentl.producer import answering, reason_of

log = logging.getLogger(__name__)

BUFFERS = 16
LOOK_PERIOD = 0.001
"""Seconds between checks for filled buffers: waiting inside the producer would keep the GIL."""
MAX_PAYLOAD_BYTES = 1 << 30
ERRORS_IN_A_ROW = 10
"Refusals by the producer, a tenth of a second apart, after which the camera counts as gone."


class GentlStream:
    """The first data stream of an open device, from construction until `close`."""

    def __init__(
        self,
        device: Any,
        request: StreamRequest,
        deliver: Callable[[Frame], None],
        on_gone: Callable[[str], None],
    ) -> None:
        """`device`: a gentl.Device. Both functions are called on the receiving thread and return at once.

        `on_gone` is called with the reason if the stream ends by itself. Raises TransportError,
        DeviceStatusError, DeviceLostError.
        """
        self._deliver = deliver
        self._on_gone = on_gone
        self._deliver_incomplete = request.deliver_incomplete
        self._statistics = StreamStatistics()
        self._rate = RateMeter()
        self._stopping = threading.Event()
        self._last_frame_id: int | None = None
        # Buffers without a view into them. Finalisers only add; the receiving thread queues them.
        self._free: deque[int] = deque()
        self._memory: list[bytes] = []
        self._buffers: list[Any] = []
        with answering("opening the stream"):
            self._stream = device.create_data_stream()
            names = device.data_stream_ids
            if not names:
                raise TransportError("the producer offers no data stream for this camera")
            self._stream.open(names[0])
        try:
            with answering("starting the stream"):
                self._begin(request)
        except BaseException:
            self._release()
            raise
        self._thread = threading.Thread(target=self._run, name="gentl-receiver", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop; nothing is delivered any more on return. Frames that consumers hold stay valid."""
        self._stopping.set()
        if self._thread is threading.current_thread():
            raise LocalProtocolError("a consumer of frames must not close their stream")
        self._thread.join()
        self._release()

    def statistics(self) -> StreamStatistics:
        """A snapshot. Any thread."""
        return self._statistics.snapshot(self._rate)

    # -- buffers ---------------------------------------------------------------------------------
    def _begin(self, request: StreamRequest) -> None:
        stream = self._stream
        size = stream.payload_size if stream.defines_payload_size() else request.payload_size
        if not 0 < size <= MAX_PAYLOAD_BYTES:
            raise TransportError(f"the camera announces pictures of {size} bytes; check PayloadSize")
        fewest = stream.buffer_announce_min + 1
        for index in range(max(fewest, min(BUFFERS, POOL_MEMORY // size))):
            memory = bytes(size)  # of all types the binding takes only this; the producer writes into it
            self._memory.append(memory)
            buffer = stream.announce_buffer(gentl.BufferToken(memory, index))
            self._buffers.append(buffer)
            stream.queue_buffer(buffer)
        token = stream.register_event(gentl.EVENT_TYPE_LIST.EVENT_NEW_BUFFER)
        self._events = gentl.EventManagerNewBuffer(token)
        stream.start_acquisition(gentl.ACQ_START_FLAGS_LIST.ACQ_START_FLAGS_DEFAULT, -1)

    def _release(self) -> None:
        stream, queue = self._stream, gentl.ACQ_QUEUE_TYPE_LIST.ACQ_QUEUE_ALL_DISCARD
        steps: list[Callable[[], Any]] = [
            lambda: stream.stop_acquisition(gentl.ACQ_STOP_FLAGS_LIST.ACQ_STOP_FLAGS_KILL),
            lambda: self._events.unregister_event(),
            lambda: stream.flush_buffer_queue(queue),
            *(lambda buffer=buffer: stream.revoke_buffer(buffer) for buffer in self._buffers),
            stream.close,
        ]
        for step in steps:
            try:
                step()
            except (gentl.GenericException, AttributeError) as error:
                log.debug("closing the stream: %s", error)

    def _lease(self, index: int, size: int) -> NDArray[np.uint8]:
        """The first `size` bytes of a buffer, which is free again once the last view of them is gone."""
        memory = self._memory[index]
        address = np.frombuffer(memory, np.uint8).ctypes.data
        # numpy collapses chains of array bases, but not this object: it lives as long as any view.
        lease: Any = (ctypes.c_ubyte * size).from_address(address)
        # The finaliser keeps the memory alive, also beyond the stream's end.
        weakref.finalize(lease, _give_back, self._free, index, memory).atexit = False
        array: NDArray[np.uint8] = np.frombuffer(lease, np.uint8)
        array.flags.writeable = False
        return array

    # -- receiving thread ------------------------------------------------------------------------
    def _run(self) -> None:
        errors = 0
        while not self._stopping.is_set():
            try:
                self._queue_free()
                self._events.update_event_data(0)
                frame = self._take(self._events.buffer)
                errors = 0
            except gentl.TimeoutException:
                errors = 0
                self._stopping.wait(LOOK_PERIOD)
                continue
            except gentl.GenericException as error:
                errors += 1
                log.log(logging.WARNING if errors == 1 else logging.DEBUG, "receiving: %s", error)
                if errors == ERRORS_IN_A_ROW:
                    self._on_gone(f"the producer gives no pictures any more: {reason_of(error)}")
                    return
                self._stopping.wait(0.1)
                continue
            if frame is not None:
                try:
                    self._deliver(frame)
                except Exception:
                    log.exception("a consumer of frames failed")
            del frame

    def _queue_free(self) -> None:
        while self._free:
            self._stream.queue_buffer(self._buffers[self._free.popleft()])

    def _take(self, buffer: Any) -> Frame | None:
        """A filled buffer as a frame, or back to the producer."""
        index: int = buffer.context
        frame = None
        try:
            frame = self._frame(buffer, index)
        finally:
            if frame is None:
                self._free.append(index)
        return frame

    def _frame(self, buffer: Any, index: int) -> Frame | None:
        statistics = self._statistics
        frame_id = _number(buffer, "frame_id")
        last, self._last_frame_id = self._last_frame_id, frame_id
        if last is not None and frame_id > last + 1:
            statistics.lost += frame_id - last - 1
        complete = _complete(buffer)
        size = min(_number(buffer, "size_filled"), len(self._memory[index]))
        if complete:
            statistics.frames += 1
            statistics.bytes += size
            self._rate.add(size)
        else:
            statistics.incomplete += 1
        if not size or not (complete or self._deliver_incomplete):
            return None
        offset = _number(buffer, "image_offset")
        return Frame(
            payload=self._lease(index, size)[min(offset, size) :],
            width=_number(buffer, "width"),
            height=_number(buffer, "height"),
            pixel_format=pfnc.by_code(_number(buffer, "pixel_format")),
            frame_id=frame_id,
            timestamp_ns=_number(buffer, "timestamp_ns"),
            received_ns=time.time_ns(),
            status=FrameStatus.COMPLETE if complete else FrameStatus.INCOMPLETE,
            offset_x=_number(buffer, "offset_x"),
            offset_y=_number(buffer, "offset_y"),
            padding_x=_number(buffer, "padding_x"),
            big_endian=_number(buffer, "pixel_endianness") == gentl.PIXELENDIANNESS_IDS.PIXELENDIANNESS_BIG,
        )


def _give_back(free: deque[int], index: int, memory: bytes) -> None:
    free.append(index)


def _complete(buffer: Any) -> bool:
    """Whether all of an image came, as far as the producer says."""
    try:
        return bool(buffer.is_complete())
    except gentl.GenericException:
        return True


def _number(buffer: Any, name: str) -> int:
    """A piece of information that a producer may leave out: then 0."""
    try:
        return int(getattr(buffer, name))
    except gentl.GenericException:
        return 0
