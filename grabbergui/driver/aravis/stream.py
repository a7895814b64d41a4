"""The stream of a camera behind Aravis: its thread takes filled buffers from the library."""

from __future__ import annotations

import ctypes
import ctypes.util
import threading
from collections.abc import Callable
from ctypes import c_int, c_size_t, c_uint64
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grabbergui.core import pfnc
from grabbergui.core.errors import TransportError
from grabbergui.core.frame import BufferPool, Frame
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.driver.aravis.library import Failure
from grabbergui.driver.device import FrameCounter, StreamRequest, check_payload_size, deliver_or_log

QUEUED = 8
"Number of buffers that Aravis holds to fill."
WAIT_US = 100_000
"Microseconds after which the thread checks whether it should end."
SUCCESS = 0
"ArvBufferStatus of a complete frame."
PAYLOADS_WITH_IMAGE = (0x1, 0x5, 0xA)
"Image, extended chunk data, multi-part."
PARTS_WITH_IMAGE = range(1, 10)
"2D and 3D images, their planes, confidence maps."

_COUNTERS = {
    "n_received_packets": "packets",
    "n_missing_packets": "packets_missing",
    "n_resent_packets": "packets_resent",
    "n_duplicated_packets": "packets_duplicate",
    "n_ignored_packets": "packets_ignored",
}
"""Our counters by Aravis's counters of GigE Vision streams."""


class AravisStream:
    """A stream from construction until `close`. Aravis fills buffers of our pool; nothing is copied."""

    def __init__(
        self, library: Any, device: int, request: StreamRequest, deliver: Callable[[Frame], None]
    ) -> None:
        """`deliver` is called on the receiving thread and must not wait. Raises TransportError."""
        size = request.payload_size
        check_payload_size(size)
        self._library = library
        self._deliver = deliver
        self._pool = BufferPool(size)
        self._lent: dict[int, NDArray[np.uint8]] = {}
        "Arrays that Aravis fills, by the address of its buffer object."
        self._counter = FrameCounter()
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
        """Stop. Nothing is delivered after return. Frames that consumers hold stay valid."""
        self._stopping = True
        self._thread.join()
        with self._lock:
            self._count()
            stream, self._stream = self._stream, None
        # Ends Aravis's thread and releases the buffers it holds; only then may their memory be freed.
        self._library.g_object_unref(stream)
        self._lent.clear()

    def statistics(self) -> StreamStatistics:
        """Return a snapshot of the counters. Any thread."""
        with self._lock:
            self._count()
        return self._counter.statistics()

    def _count(self) -> None:
        """Copy Aravis's counters while the stream is open. The caller holds the lock."""
        if self._stream is None:
            return
        completed, failures, underruns = c_uint64(), c_uint64(), c_uint64()
        self._library.arv_stream_get_statistics(
            self._stream, ctypes.byref(completed), ctypes.byref(failures), ctypes.byref(underruns)
        )
        counts = self._counter.counts
        counts.incomplete, counts.underruns = failures.value, underruns.value
        for index in range(self._library.arv_stream_get_n_infos(self._stream)):
            field = _COUNTERS.get(self._library.arv_stream_get_info_name(self._stream, index).decode())
            if field:
                value = self._library.arv_stream_get_info_uint64(self._stream, index)
                setattr(counts, field, value)

    def _lend(self) -> bool:
        """Give Aravis one more buffer; return False if consumers hold all of them."""
        array = self._pool.take()
        if array is None:
            return False
        buffer = self._library.arv_buffer_new(len(array), array.ctypes.data)
        self._lent[buffer] = array
        # Takes ownership of our reference.
        self._library.arv_stream_push_buffer(self._stream, buffer)
        return True

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
            # The memory is ours; Aravis's object is no longer needed.
            library.g_object_unref(buffer)
            del array
            if frame is not None:
                deliver_or_log(self._deliver, frame)
            del frame

    def _frame(self, buffer: int, array: NDArray[np.uint8]) -> Frame | None:
        library = self._library
        complete = library.arv_buffer_get_status(buffer) == SUCCESS
        size = c_size_t()
        library.arv_buffer_get_data(buffer, ctypes.byref(size))
        used = min(size.value, len(array))
        frame_id = library.arv_buffer_get_frame_id(buffer)
        self._counter.note_id(frame_id)
        # Aravis reports neither size nor format of an incomplete frame; the counters contain it.
        if not complete:
            return None
        self._counter.note_complete(used)
        # A payload without an image (a file, GenDC) becomes one line of bytes in an unknown format.
        x, y, width, height, padding_x, pixel_format = 0, 0, used, 1, 0, 0
        if self._is_image(buffer):
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

    def _is_image(self, buffer: int) -> bool:
        library = self._library
        return (
            library.arv_buffer_get_n_parts(buffer) > 0
            and library.arv_buffer_get_payload_type(buffer) in PAYLOADS_WITH_IMAGE
            and library.arv_buffer_get_part_data_type(buffer, 0) in PARTS_WITH_IMAGE
        )

    @staticmethod
    def _numbers(function: Any, buffer: int, count: int) -> list[int]:
        numbers = [c_int() for _ in range(count)]
        function(buffer, *map(ctypes.byref, numbers))
        return [number.value for number in numbers]
