"""`sensor_msgs/Image` as frames, and what changed from one to the next that people should know."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from grabbergui.core.errors import PixelFormatError
from grabbergui.core.frame import Frame
from grabbergui.net.ros2.encodings import format_of

SAME_CLOCK = 5.0
"""Seconds by which a stamp may differ from our clock and still count as of it: pictures may come late."""


def frame_of(message: Any, frame_id: int) -> Frame:
    """A message as a frame that looks into its bytes. Raises PixelFormatError for what cannot be shown.

    `timestamp_ns` is the stamp; `received_ns` too, unless the publisher's clock is not ours.
    """
    pixel_format = format_of(message.encoding)
    payload = np.frombuffer(message.data, np.uint8)
    padding = message.step - pixel_format.line_bytes(message.width)
    if padding < 0 or message.step * message.height > payload.size or not message.width * message.height:
        raise PixelFormatError(
            f"an image of {message.width}×{message.height} {message.encoding} with lines of "
            f"{message.step} bytes and {payload.size} bytes in all contradicts itself"
        )
    stamp = message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec
    now = time.time_ns()
    return Frame(
        payload=payload,
        width=message.width,
        height=message.height,
        pixel_format=pixel_format,
        frame_id=frame_id,
        timestamp_ns=max(stamp, 0),
        received_ns=stamp if abs(now - stamp) < SAME_CLOCK * 1e9 else now,
        padding_x=padding,
        big_endian=bool(message.is_bigendian),
    )


class Continuity:
    """Compares each frame with the one before. One thread."""

    def __init__(self) -> None:
        self._last: Frame | None = None
        self._foreign_clock = False

    def remarks(self, frame: Frame) -> dict[str, str]:
        """What people should know of how it differs, by kind: size or format, and the publisher's clock."""
        last, self._last = self._last, frame
        found = {}
        if last is not None and _layout(last) != _layout(frame):
            found["layout"] = f"pictures are {_layout(frame)} now, they were {_layout(last)}"
        back = (last.timestamp_ns - frame.timestamp_ns) / 1e9 if last is not None else 0
        if back > 0 and frame.timestamp_ns:
            found["jump"] = (
                f"stamps went back by {back:.3g} s: the publisher's clock was set, or a recording began anew"
            )
        foreign = bool(frame.timestamp_ns) and frame.received_ns != frame.timestamp_ns
        if foreign and not self._foreign_clock:
            off = (frame.timestamp_ns - frame.received_ns) / 1e9
            found["clock"] = (
                f"stamps are {abs(off):.4g} s {'ahead of' if off > 0 else 'behind'} this machine's clock; "
                "times of arrival are used"
            )
        self._foreign_clock = foreign
        return found


def _layout(frame: Frame) -> str:
    return f"{frame.width}×{frame.height} {frame.pixel_format}"
