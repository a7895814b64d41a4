"""Finished blocks to frames, and device time to host time."""

from __future__ import annotations

from collections import deque
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from grabbergui.core import pfnc
from grabbergui.core.component import Component, ComponentKind, PayloadType
from grabbergui.core.frame import Frame, FrameStatus, time_of_day
from grabbergui.driver.gige.gvsp import Leader, PartType, PayloadKind, PayloadPart
from grabbergui.driver.gige.stream.block import Block
from grabbergui.driver.gige.stream.block_history import distance
from grabbergui.driver.h264 import H264Stream
from grabbergui.driver.payload_contents import Contents, PayloadReader, kind_of

_PLAIN = {
    PayloadKind.RAW: PayloadType.RAW_DATA,
    PayloadKind.FILE: PayloadType.FILE,
    PayloadKind.CHUNK: PayloadType.CHUNK,
}
_COMPRESSED: dict[int, PayloadType] = {
    PayloadKind.JPEG: PayloadType.JPEG,
    PayloadKind.JPEG2000: PayloadType.JPEG2000,
    PartType.JPEG: PayloadType.JPEG,
    PartType.JPEG2000: PayloadType.JPEG2000,
}
MOST_DELAY_NS = 1_000_000_000
"A frame that seems to have waited in the camera for longer shows that the clock is slow, not the network."
MOST_DRIFT = 0.05
"Delay by time since the fastest packet, up to which also longer delays are believed."


class FrameBuilder:
    """Makes the frames of one stream. One thread."""

    def __init__(self, tick_frequency: int, *, big_endian: bool = False, channel: int = 0) -> None:
        """`tick_frequency` in Hz, 0 if the device has no clock; `big_endian`: byte order of pixels.

        `channel` is the stream channel that the blocks are from.
        """
        self._channel = channel
        self._tick_frequency = tick_frequency
        self._big_endian = big_endian
        self._clock = ClockMapper()
        self._formats: dict[int, pfnc.PixelFormat] = {}
        self._reader = PayloadReader(big_endian=big_endian)
        self._video = H264Stream()
        self._number = 0
        "Number of the last H.264 image; continues where block ids of 16 bits begin again."

    def build(self, block: Block) -> Frame:
        """Return a frame whose payload is a view of the block's buffer."""
        leader = block.leader
        assert leader is not None, "every finished block has one"
        arrival_ns = int(block.first_packet_at * 1e9)
        timestamp_ns = ticks_to_ns(leader.timestamp or block.timestamp, self._tick_frequency)
        captured_ns = self._clock.map(timestamp_ns, arrival_ns) if timestamp_ns else arrival_ns
        frame = Frame(
            payload=block.payload,
            width=leader.width,
            height=block.height,
            pixel_format=self._format(leader.pixel_format),
            frame_id=block.block_id,
            timestamp_ns=timestamp_ns,
            received_ns=time_of_day(captured_ns),
            captured=captured_ns / 1e9,
            status=FrameStatus.COMPLETE if block.complete else FrameStatus.INCOMPLETE,
            missing_bytes=block.missing_bytes,
            offset_x=leader.offset_x,
            offset_y=leader.offset_y,
            padding_x=leader.padding_x,
            big_endian=self._big_endian,
            stream_channel=self._channel,
        )
        return frame if leader.is_image and not leader.parts else self._contents(leader, block).frame(frame)

    def _contents(self, leader: Leader, block: Block) -> Contents:
        """Read a payload that is not one image."""
        payload, kind = block.payload, PayloadKind(leader.kind)
        if kind is PayloadKind.MULTI_PART:
            return self._multi_part(leader, payload)
        if kind is PayloadKind.GENDC:
            return self._reader.container(payload)
        if kind in (PayloadKind.JPEG, PayloadKind.JPEG2000):
            return self._reader.compressed(_COMPRESSED[kind], payload)
        if kind is PayloadKind.H264:
            self._number += distance(self._number, block.block_id, block.extended)
            image = self._video.add(self._number, payload, complete=block.complete)
            return Contents(PayloadType.H264, payload, () if image is None else (image,))
        return self._reader.plain(_PLAIN[kind], payload, leader.file_name)

    def _multi_part(self, leader: Leader, payload: NDArray[np.uint8]) -> Contents:
        images: list[Component] = []
        chunks, begin = None, 0
        for part in leader.parts:
            data = payload[begin : begin + part.length]
            begin += part.length
            if part.data_type == PartType.CHUNK:
                chunks = data
            elif (image := self._image_part(part, data)) is not None:
                images.append(image)
        return Contents(PayloadType.MULTI_PART, payload, tuple(images), chunks)

    def _image_part(self, part: PayloadPart, data: NDArray[np.uint8]) -> Component | None:
        width, height, offset_x, offset_y, padding_x, _ = part.geometry
        pixel_format = self._format(part.pixel_format)
        kind = kind_of(pixel_format, part.purpose)
        if part.data_type == PartType.CONFIDENCE:
            kind = ComponentKind.CONFIDENCE
        image: Component | None = None
        if part.data_type in (PartType.JPEG, PartType.JPEG2000):
            image = self._reader.compressed_part(_COMPRESSED[part.data_type], data, kind)
        elif width and height:
            image = Component(
                data,
                width,
                height,
                pixel_format,
                kind,
                offset_x=offset_x,
                offset_y=offset_y,
                padding_x=padding_x,
                big_endian=self._big_endian,
            )
        if image is None:
            return None
        return replace(image, region=part.region, source=part.source, purpose=part.purpose)

    def _format(self, code: int) -> pfnc.PixelFormat:
        if code not in self._formats:
            if len(self._formats) > 64:
                self._formats.clear()
            self._formats[code] = pfnc.by_code(code)
        return self._formats[code]


def ticks_to_ns(ticks: int, frequency: int) -> int:
    """Convert device ticks to nanoseconds without rounding errors; 0 if the device has no clock."""
    if frequency <= 0:
        return 0
    seconds, rest = divmod(ticks, frequency)
    return seconds * 1_000_000_000 + rest * 1_000_000_000 // frequency


class ClockMapper:
    """Maps device time to host time by the packets that travelled fastest.

    Every arrival is its device time plus the clocks' offset plus a delay that is never negative, so the
    smallest recent difference is the best estimate of the offset. Nothing is written to the device.

    To a clock that is slower than the device states, every frame seems to be later than the one before. Such
    a clock is not used, because its smallest difference would be that of the oldest frame.
    """

    def __init__(self, window_ns: int = 10_000_000_000) -> None:
        """`window_ns`: how far back arrivals count; clocks drift apart beyond it."""
        self._window_ns = window_ns
        self._best: deque[tuple[int, int]] = deque()
        self._fastest: tuple[int, int] | None = None
        "Arrival and offset of the fastest packet of all."
        self._newest = 0

    def map(self, device_ns: int, arrival_ns: int) -> int:
        """Return the host time of a device time whose message arrived at `arrival_ns`; never later."""
        if device_ns < self._newest:  # the device's clock was set back
            self._best.clear()
            self._fastest = None
        self._newest = device_ns
        offset = arrival_ns - device_ns
        if self._fastest is None or offset <= self._fastest[1]:
            self._fastest = (arrival_ns, offset)
        # Offsets grow from left to right: the leftmost is the smallest of the window.
        while self._best and self._best[-1][1] >= offset:
            self._best.pop()
        self._best.append((arrival_ns, offset))
        while self._best[0][0] < arrival_ns - self._window_ns:
            self._best.popleft()
        begun, least = self._fastest
        if offset - least > max(MOST_DELAY_NS, MOST_DRIFT * (arrival_ns - begun)):
            return arrival_ns
        return device_ns + self._best[0][1]
