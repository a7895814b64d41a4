"""The data stream of a GenTL camera: it announces buffers; a thread takes the filled ones."""

from __future__ import annotations

import ctypes
import logging
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np
from genicam import gentl
from numpy.typing import NDArray

from grabbergui.core import pfnc
from grabbergui.core.errors import LocalProtocolError, TransportError
from grabbergui.core.frame import POOL_MEMORY, Frame, FrameStatus
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.core.leases import Leases
from grabbergui.driver.device import FrameCounter, StreamRequest, check_payload_size, deliver_or_log
from grabbergui.driver.gentl.errors import answering, reason_of

log = logging.getLogger(__name__)

BUFFERS = 16
LOOK_PERIOD = 0.001
"""Seconds between checks for filled buffers: waiting inside the producer would hold the GIL."""
ERRORS_IN_A_ROW = 10
"Consecutive errors, a tenth of a second apart, after which the camera counts as lost."


class GentlStream:
    """The first data stream of an open device, from construction until `close`."""

    def __init__(
        self,
        device: Any,
        request: StreamRequest,
        deliver: Callable[[Frame], None],
        on_gone: Callable[[str], None],
        tick_frequency: int,
    ) -> None:
        """`device`: a gentl.Device. Both functions are called on the receiving thread and must not wait.

        `tick_frequency`: ticks per second of the camera's clock, for producers that deliver its ticks but no
        nanoseconds; 0 if unknown. `on_gone` is called with the reason if the camera is lost. Raises
        TransportError, DeviceStatusError, DeviceLostError.
        """
        self._deliver = deliver
        self._on_gone = on_gone
        self._tick_frequency = tick_frequency
        self._deliver_incomplete = request.deliver_incomplete
        self._counter = FrameCounter()
        self._stopping = threading.Event()
        # Buffers that no frame uses, which the receiving thread queues.
        self._free: deque[int] = deque()
        self._leases: Leases[int] = Leases()
        "Indices of buffers with views."
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
        """Stop. Nothing is delivered after return. Frames that consumers hold stay valid."""
        self._stopping.set()
        if self._thread is threading.current_thread():
            raise LocalProtocolError("a consumer of frames must not close their stream")
        self._thread.join()
        self._release()

    def statistics(self) -> StreamStatistics:
        """Return a snapshot of the counters. Any thread."""
        return self._counter.statistics()

    def _begin(self, request: StreamRequest) -> None:
        stream = self._stream
        size = stream.payload_size if stream.defines_payload_size() else request.payload_size
        check_payload_size(size)
        fewest = stream.buffer_announce_min + 1
        for index in range(max(fewest, min(BUFFERS, POOL_MEMORY // size))):
            memory = bytes(size)  # the only type that the binding accepts; the producer writes into it
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
        """Return the first `size` bytes of a buffer, which is free again once their last view is gone."""
        memory = self._memory[index]
        address = np.frombuffer(memory, np.uint8).ctypes.data
        # numpy collapses chains of array bases, but not this object: it lives as long as any view.
        keeper: Any = (ctypes.c_ubyte * size).from_address(address)
        keeper.memory = memory  # as long as there are views, also after the stream's end
        self._leases.lend(keeper, index)
        array: NDArray[np.uint8] = np.frombuffer(keeper, np.uint8)
        array.flags.writeable = False
        return array

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
                    self._on_gone(f"the producer delivers no more frames: {reason_of(error)}")
                    return
                self._stopping.wait(0.1)
                continue
            if frame is not None:
                deliver_or_log(self._deliver, frame)
            del frame

    def _queue_free(self) -> None:
        self._free.extend(self._leases.returned())
        while self._free:
            self._stream.queue_buffer(self._buffers[self._free[0]])
            self._free.popleft()  # not before: the producer may refuse it for the moment

    def _take(self, buffer: Any) -> Frame | None:
        """Return a filled buffer as a frame; None, and free the buffer, if it makes none."""
        index: int = buffer.context
        frame = None
        try:
            frame = self._frame(buffer, index)
        finally:
            if frame is None:
                self._free.append(index)
        return frame

    def _frame(self, buffer: Any, index: int) -> Frame | None:
        frame_id = _number(buffer, "frame_id")
        self._counter.note_id(frame_id)
        complete = _complete(buffer)
        size = min(_number(buffer, "size_filled"), len(self._memory[index]))
        if complete:
            self._counter.note_complete(size)
        else:
            self._counter.counts.incomplete += 1
        if not size or not (complete or self._deliver_incomplete):
            return None
        offset = _number(buffer, "image_offset")
        return Frame(
            payload=self._lease(index, size)[min(offset, size) :],
            width=_number(buffer, "width"),
            height=_number(buffer, "height"),
            pixel_format=pfnc.by_code(_number(buffer, "pixel_format")),
            frame_id=frame_id,
            timestamp_ns=self._timestamp_ns(buffer),
            received_ns=time.time_ns(),
            status=FrameStatus.COMPLETE if complete else FrameStatus.INCOMPLETE,
            offset_x=_number(buffer, "offset_x"),
            offset_y=_number(buffer, "offset_y"),
            padding_x=_number(buffer, "padding_x"),
            big_endian=_number(buffer, "pixel_endianness") == gentl.PIXELENDIANNESS_IDS.PIXELENDIANNESS_BIG,
        )

    def _timestamp_ns(self, buffer: Any) -> int:
        """Return a buffer's time in nanoseconds, which GenTL has since 1.4; 0 if it is unknown."""
        if nanoseconds := _number(buffer, "timestamp_ns"):
            return nanoseconds
        hz = self._tick_frequency
        return _number(buffer, "timestamp") * 1_000_000_000 // hz if hz else 0


def _complete(buffer: Any) -> bool:
    """Whether an image is complete; True if the producer does not report it."""
    try:
        return bool(buffer.is_complete())
    except gentl.GenericException:
        return True


def _number(buffer: Any, name: str) -> int:
    """Return a numeric property, or 0 if the producer does not provide it."""
    try:
        return int(getattr(buffer, name))
    except gentl.GenericException:
        return 0
