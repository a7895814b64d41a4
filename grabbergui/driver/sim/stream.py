"""The stream of the simulated camera in this process."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from grabbergui.core.component import Component, PayloadType
from grabbergui.core.frame import Frame
from grabbergui.driver.device import StreamRequest
from grabbergui.driver.h264 import H264Stream
from grabbergui.driver.payload_contents import Contents, PayloadReader
from grabbergui.driver.sim.chunks import CHUNK_FEATURE
from grabbergui.driver.sim.contents import FILE_NAME, pieces
from grabbergui.driver.sim.model import CameraModel, FramePlan
from grabbergui.driver.sim.planned_stream import PlannedStream


class SimulatedStream(PlannedStream):
    """Makes frames of any payload type."""

    def __init__(self, model: CameraModel, request: StreamRequest, deliver: Callable[[Frame], None]) -> None:
        self._model = model
        self._reader = PayloadReader()
        self._decoder = H264Stream()
        model.prepare()
        super().__init__(model, request.payload_size, deliver)

    @override
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
