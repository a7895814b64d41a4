"""Finished blocks to frames: the words of `core` for what a leader says."""

from __future__ import annotations

from grabbergui.core import pfnc
from grabbergui.core.frame import Frame, FrameStatus, time_of_day
from grabbergui.driver.gige.clock import ClockMapper, ticks_to_ns
from grabbergui.driver.gige.finished_block import FinishedBlock


class FrameBuilder:
    """Makes the frames of one stream. One thread."""

    def __init__(self, tick_frequency: int, *, big_endian: bool = False) -> None:
        """`tick_frequency` in Hz, 0 where the device has no clock; `big_endian` pixels as SCPS says."""
        self._tick_frequency = tick_frequency
        self._big_endian = big_endian
        self._clock = ClockMapper()
        self._formats: dict[int, pfnc.PixelFormat] = {}

    def build(self, block: FinishedBlock) -> Frame:
        """A frame that looks into the block's buffer."""
        leader = block.leader
        arrival_ns = int(block.began * 1e9)
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
