"""The stream of the simulated camera in this process."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.component import Component, PayloadType
from grabbergui.core.frame import BufferPool, Frame
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.driver.device import FrameCounter, StreamRequest, deliver_or_log
from grabbergui.driver.h264 import H264Stream
from grabbergui.driver.payload_contents import Contents, PayloadReader
from grabbergui.driver.sim.chunks import CHUNK_FEATURE
from grabbergui.driver.sim.contents import FILE_NAME, pieces
from grabbergui.driver.sim.model import CameraModel, FramePlan

_POLL_S = 0.1


class SimulatedStream:
    """Renders frames straight into the pool's buffers on its own thread, from construction until `close`."""

    def __init__(self, model: CameraModel, request: StreamRequest, deliver: Callable[[Frame], None]) -> None:
        self._model = model
        self._deliver = deliver
        self._pool = BufferPool(max(request.payload_size, 1))
        self._counter = FrameCounter()
        self._reader = PayloadReader()
        self._decoder = H264Stream()
        self._stopping = False
        model.prepare()
        self._thread = threading.Thread(target=self._run, name="simulated camera", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop. Nothing is delivered after return."""
        self._stopping = True
        self._model.wake()
        self._thread.join()

    def statistics(self) -> StreamStatistics:
        """Return a snapshot of the counters. Any thread."""
        return self._counter.statistics()

    def _run(self) -> None:
        while not self._stopping:
            plan = self._model.next_frame(_POLL_S)
            if plan is None:
                continue
            if plan.payload_bytes > self._pool.size:
                # The stream was opened for smaller frames, as if packets beyond the buffer were dropped.
                self._counter.counts.incomplete += 1
                continue
            buffer = self._pool.take()
            if buffer is None:
                self._counter.counts.underruns += 1
                continue
            used = self._model.render(plan, buffer)
            self._counter.note_complete(used)
            frame = self._frame(plan, buffer[:used])
            del buffer
            deliver_or_log(self._deliver, frame)
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
            received_ns=time.time_ns() - (self._model.timestamp() - plan.timestamp_ns),
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
