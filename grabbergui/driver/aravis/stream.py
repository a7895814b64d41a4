"""A stream of Aravis: our buffers in, frames out."""

from __future__ import annotations

import ctypes
import logging
import threading
from collections.abc import Callable
from ctypes import c_int, c_size_t, c_uint64
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grabbergui.core import pfnc
from grabbergui.core.errors import TransportError
from grabbergui.core.frame import BufferPool, Frame
from grabbergui.core.frame_queue import RateMeter, StreamStatistics
from grabbergui.driver.aravis.library import Failure
from grabbergui.driver.device import StreamRequest

log = logging.getLogger(__name__)

MAX_PAYLOAD_BYTES = 1 << 30
QUEUED = 8
"Buffers that Aravis holds, being filled or to be filled."
WAIT_US = 100_000
"Microseconds after which the thread checks whether it should end."
SUCCESS = 0
"ArvBufferStatus of a complete frame."
PAYLOADS_WITH_PICTURE = (0x1, 0x5, 0xA)
"Image, extended chunk data, multi-part."
PARTS_WITH_PICTURE = range(1, 10)
"2D and 3D images, their planes, confidence maps."

_COUNTERS = {
    "n_received_packets": "packets",
    "n_missing_packets": "packets_missing",
    "n_resent_packets": "packets_resent",
    "n_duplicated_packets": "packets_duplicate",
    "n_ignored_packets": "packets_ignored",
}
"""Aravis's counters of GigE Vision streams, and ours."""


class AravisStream:
    """One stream from construction until `close`. Frames lie in our own pool's buffers; nothing is copied."""

    def __init__(
        self, library: Any, device: int, request: StreamRequest, deliver: Callable[[Frame], None]
    ) -> None:
        """`deliver` is called on the receiving thread and returns at once. Raises TransportError."""
        size = request.payload_size
        if not 0 < size <= MAX_PAYLOAD_BYTES:
            raise TransportError(f"the camera announces pictures of {size} bytes; check PayloadSize")
        self._library = library
        self._deliver = deliver
        self._pool = BufferPool(size)
        self._lent: dict[int, NDArray[np.uint8]] = {}
        "Arrays that Aravis fills, by the address of its buffer object."
        self._statistics = StreamStatistics()
        self._rate = RateMeter()
        self._last_id: int | None = None
        self._lock = threading.Lock()
        self._stopping = False
        failure = Failure("opening the stream")
        self._stream: int | None = library.arv_device_create_stream(device, None, None, failure.place)
        failure.check()
        if not self._stream:
            raise TransportError("Aravis offers no stream for this camera")
        for _ in range(QUEUED):
            self._lend()
        self._thread = threading.Thread(target=self._run, name="aravis-receiver", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop; nothing is delivered any more on return. Frames that consumers hold stay valid."""
        self._stopping = True
        self._thread.join()
        with self._lock:
            self._count()
            stream, self._stream = self._stream, None
        # Ends Aravis's thread and releases the buffers it holds; only then may their memory be freed.
        self._library.g_object_unref(stream)
        self._lent.clear()

    def statistics(self) -> StreamStatistics:
        """A snapshot. Any thread."""
        with self._lock:
            self._count()
        return self._statistics.snapshot(self._rate)

    def _count(self) -> None:
        """Aravis's own counters, while the stream is there. With the lock."""
        if self._stream is None:
            return
        completed, failures, underruns = c_uint64(), c_uint64(), c_uint64()
        self._library.arv_stream_get_statistics(
            self._stream, ctypes.byref(completed), ctypes.byref(failures), ctypes.byref(underruns)
        )
        self._statistics.incomplete = failures.value
        self._statistics.underruns = underruns.value
        for index in range(self._library.arv_stream_get_n_infos(self._stream)):
            field = _COUNTERS.get(self._library.arv_stream_get_info_name(self._stream, index).decode())
            if field:
                value = self._library.arv_stream_get_info_uint64(self._stream, index)
                setattr(self._statistics, field, value)

    def _lend(self) -> bool:
        """Give Aravis one more buffer; False where consumers hold them all."""
        array = self._pool.take()
        if array is None:
            return False
        buffer = self._library.arv_buffer_new(len(array), array.ctypes.data)
        self._lent[buffer] = array
        # Takes the reference over.
        self._library.arv_stream_push_buffer(self._stream, buffer)
        return True

    # -- receiving thread ------------------------------------------------------------------------
    def _run(self) -> None:
        library = self._library
        while not self._stopping:
            while len(self._lent) < QUEUED and self._lend():
                pass
            buffer = library.arv_stream_timeout_pop_buffer(self._stream, WAIT_US)
            if not buffer:
                continue
            array = self._lent.pop(buffer)
            frame = self._frame(buffer, array)
            # Its memory is ours; the object is not needed any more.
            library.g_object_unref(buffer)
            del array
            if frame is not None:
                try:
                    self._deliver(frame)
                except Exception:
                    log.exception("a consumer of frames failed")
            del frame

    def _frame(self, buffer: int, array: NDArray[np.uint8]) -> Frame | None:
        library = self._library
        complete = library.arv_buffer_get_status(buffer) == SUCCESS
        size = c_size_t()
        library.arv_buffer_get_data(buffer, ctypes.byref(size))
        used = min(size.value, len(array))
        frame_id = library.arv_buffer_get_frame_id(buffer)
        statistics = self._statistics
        if self._last_id is not None and frame_id > self._last_id + 1:
            statistics.lost += frame_id - self._last_id - 1
        self._last_id = frame_id
        # Aravis reports neither size nor format of an incomplete frame; the counters contain it.
        if not complete:
            return None
        statistics.frames += 1
        statistics.bytes += used
        self._rate.add(used)
        # A payload without an image (a file, GenDC) goes on as one line of bytes of no known format.
        x, y, width, height, padding_x, pixel_format = 0, 0, used, 1, 0, 0
        if self._is_picture(buffer):
            x, y, width, height = self._numbers(library.arv_buffer_get_image_region, buffer, 4)
            padding_x, _ = self._numbers(library.arv_buffer_get_image_padding, buffer, 2)
            pixel_format = library.arv_buffer_get_image_pixel_format(buffer)
        return Frame(
            payload=array[:used],
            width=width,
            height=height,
            pixel_format=pfnc.by_code(pixel_format),
            frame_id=frame_id,
            timestamp_ns=library.arv_buffer_get_timestamp(buffer),
            received_ns=library.arv_buffer_get_system_timestamp(buffer),
            offset_x=x,
            offset_y=y,
            padding_x=padding_x,
        )

    def _is_picture(self, buffer: int) -> bool:
        library = self._library
        return (
            library.arv_buffer_get_n_parts(buffer) > 0
            and library.arv_buffer_get_payload_type(buffer) in PAYLOADS_WITH_PICTURE
            and library.arv_buffer_get_part_data_type(buffer, 0) in PARTS_WITH_PICTURE
        )

    @staticmethod
    def _numbers(function: Any, buffer: int, count: int) -> list[int]:
        numbers = [c_int() for _ in range(count)]
        function(buffer, *map(ctypes.byref, numbers))
        return [number.value for number in numbers]
