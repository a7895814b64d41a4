"""Finished blocks to frames, and device time to host time."""

from __future__ import annotations

from collections import deque

from grabbergui.core import pfnc
from grabbergui.core.frame import Frame, FrameStatus, time_of_day
from grabbergui.driver.gige.stream.block import Block


class FrameBuilder:
    """Makes the frames of one stream. One thread."""

    def __init__(self, tick_frequency: int, *, big_endian: bool = False) -> None:
        """`tick_frequency` in Hz, 0 if the device has no clock; `big_endian`: byte order of pixels."""
        self._tick_frequency = tick_frequency
        self._big_endian = big_endian
        self._clock = ClockMapper()
        self._formats: dict[int, pfnc.PixelFormat] = {}

    def build(self, block: Block) -> Frame:
        """Return a frame whose payload is a view of the block's buffer."""
        leader = block.leader
        assert leader is not None, "every finished block has one"
        arrival_ns = int(block.first_packet_at * 1e9)
        timestamp_ns = ticks_to_ns(leader.timestamp, self._tick_frequency)
        captured_ns = self._clock.map(timestamp_ns, arrival_ns) if timestamp_ns else arrival_ns
        return Frame(
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
        )

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
    """

    def __init__(self, window_ns: int = 10_000_000_000) -> None:
        """`window_ns`: how far back arrivals count; clocks drift apart beyond it."""
        self._window_ns = window_ns
        self._best: deque[tuple[int, int]] = deque()
        self._newest = 0

    def map(self, device_ns: int, arrival_ns: int) -> int:
        """Return the host time of a device time whose message arrived at `arrival_ns`; never later."""
        if device_ns < self._newest:
            self._best.clear()  # the device's clock was set back
        self._newest = device_ns
        offset = arrival_ns - device_ns
        # Offsets grow from left to right: the leftmost is the smallest of the window.
        while self._best and self._best[-1][1] >= offset:
            self._best.pop()
        self._best.append((arrival_ns, offset))
        while self._best[0][0] < arrival_ns - self._window_ns:
            self._best.popleft()
        return device_ns + self._best[0][1]
