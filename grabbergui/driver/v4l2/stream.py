"""The stream of a video device: a thread takes the kernel's filled buffers."""

from __future__ import annotations

import select
import sys
import threading
import time
from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core import pfnc
from grabbergui.core.errors import GrabberError, TransportError
from grabbergui.core.frame import BufferPool, Frame, FrameStatus, time_of_day
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.driver.device import FrameCounter, StreamRequest, deliver_or_log
from grabbergui.driver.v4l2.description import COMPRESSED, PFNC_NAMES
from grabbergui.driver.v4l2.video import CurrentFormat, Filled, VideoDevice

if sys.platform != "linux":
    raise ImportError("Video4Linux is a part of Linux")

BUFFERS = 8
"Number of mapped buffers. Frames are copied out of them, so that consumers may keep frames."
_STOP_PERIOD = 0.1
"Seconds after which the receiving thread checks whether it should end."


class V4l2Stream:
    """Takes filled buffers on its own thread, from construction until `close`."""

    def __init__(
        self,
        video: VideoDevice,
        request: StreamRequest,
        deliver: Callable[[Frame], None],
        on_gone: Callable[[str], None],
    ) -> None:
        """Start. Raises AccessDeniedError if another program streams from the device, TransportError."""
        self._video = video
        self._deliver = deliver
        self._on_gone = on_gone
        self._deliver_incomplete = request.deliver_incomplete
        self._format = video.format()
        if self._format.fourcc not in PFNC_NAMES:
            raise TransportError(
                f"{video.path} is set to {self._format.fourcc}, which cannot be shown; choose another"
                " PixelFormat"
            )
        self._pool = BufferPool(max(payload_bytes(self._format), 1))
        self._counter = FrameCounter()
        self._stopping = threading.Event()
        self._buffers = video.begin(BUFFERS)
        self._thread = threading.Thread(target=self._run, name="v4l2 receiver", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop. Nothing is delivered after return."""
        self._stopping.set()
        self._thread.join()
        self._video.end(self._buffers)

    def statistics(self) -> StreamStatistics:
        """Return a snapshot of the counters. Any thread."""
        return self._counter.statistics()

    def _run(self) -> None:
        poll = select.poll()
        poll.register(self._video.fileno(), select.POLLIN | select.POLLPRI)
        try:
            while not self._stopping.is_set():
                if not poll.poll(_STOP_PERIOD * 1000):
                    continue
                filled = self._video.take()
                if filled is None:
                    continue
                frame = self._frame(filled)
                self._video.queue(filled.index)
                if frame is not None:
                    deliver_or_log(self._deliver, frame)
                del frame
        except (GrabberError, OSError) as error:
            if not self._stopping.is_set():
                self._on_gone(str(error))

    def _frame(self, filled: Filled) -> Frame | None:
        self._counter.note_id(filled.sequence)
        buffer = self._pool.take()
        if buffer is None:
            self._counter.counts.underruns += 1
            return None
        payload = None if filled.damaged or not filled.size else self._payload(filled, buffer)
        if payload is None:
            self._counter.counts.incomplete += 1
            return None
        self._counter.note_complete(payload.nbytes)
        current = self._format
        compressed = current.fourcc in COMPRESSED
        pixel_format = pfnc.by_name("BGR8" if compressed else PFNC_NAMES[current.fourcc])
        line = pixel_format.line_bytes(current.width)
        stamp = filled.timestamp_ns
        frame = Frame(
            payload=payload,
            width=current.width,
            height=current.height,
            pixel_format=pixel_format,
            frame_id=filled.sequence,
            timestamp_ns=stamp,
            received_ns=time.time_ns(),
            status=FrameStatus.COMPLETE,
            padding_x=0 if compressed else max(0, current.line_bytes - line),
        )
        if stamp:
            frame.received_ns, frame.captured = time_of_day(stamp), stamp / 1e9
        return frame

    def _payload(self, filled: Filled, buffer: NDArray[np.uint8]) -> NDArray[np.uint8] | None:
        """Copy a frame into `buffer`, decoded if it is compressed; return None if it is damaged."""
        content = np.frombuffer(self._buffers[filled.index], np.uint8, filled.size)
        current = self._format
        if current.fourcc not in COMPRESSED:
            size = min(filled.size, buffer.size)
            buffer[:size] = content[:size]
            return buffer[:size] if size >= current.line_bytes * current.height else None
        try:
            image = cv2.imdecode(content, cv2.IMREAD_COLOR)
        except cv2.error:  # e.g. a header with an impossible size
            return None
        if image is None or image.shape != (current.height, current.width, 3):
            return None
        buffer[:] = image.reshape(-1)
        return buffer


def payload_bytes(current: CurrentFormat) -> int:
    """Return the size of the largest delivered frame; compressed frames are decoded to BGR8."""
    compressed = current.fourcc in COMPRESSED
    return current.width * current.height * 3 if compressed else current.image_bytes
