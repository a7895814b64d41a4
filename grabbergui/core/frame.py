"""One frame: a payload, what it is, and the two views robots use (raw and RGB)."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grabbergui.core import pixels
from grabbergui.core.pfnc import PixelFormat

MOST_AGE = 60.0
"Seconds that a frame may have been on its way."


def time_of_day(monotonic_ns: int) -> int:
    """The time of day (`time.time_ns`) at a moment of the monotonic clock (`time.monotonic_ns`)."""
    return time.time_ns() - (time.monotonic_ns() - monotonic_ns)


class FrameStatus(Enum):
    """Whether all of the payload arrived."""

    COMPLETE = "complete"
    INCOMPLETE = "incomplete"


@dataclass(eq=False)
class Frame:
    """An image as the sensor sent it, with its metadata. Treat as immutable; may be read from any thread."""

    payload: NDArray[np.uint8]
    "1-D, the bytes on the wire; perhaps longer than the image (padding, chunks)."
    width: int
    height: int
    pixel_format: PixelFormat
    frame_id: int = 0
    "The device's block id, or a counter; starts again with each acquisition."
    timestamp_ns: int = 0
    "Device clock, nanoseconds; 0 where the device has none."
    received_ns: int = 0
    """Time of day of this computer (`time.time_ns`) when the frame was exposed, as far as the device's clock
    could be mapped to it, or else when it arrived. For stamps and names of files. The time of day may jump:
    durations are differences of `captured`."""
    captured: float = 0.0
    "The same moment on the monotonic clock (`time.monotonic`, seconds); by default made from `received_ns`."
    status: FrameStatus = FrameStatus.COMPLETE
    missing_bytes: int = 0
    offset_x: int = 0
    offset_y: int = 0
    padding_x: int = 0
    "Bytes at the end of each line that are not pixels."
    big_endian: bool = False
    "Of unpacked pixels deeper than 8 bits; GigE Vision devices may choose."
    chunks: dict[str, Any] = field(default_factory=dict)
    "Chunk values by feature name, e.g. `ChunkExposureTime`."
    _converted: dict[str, NDArray[Any]] = field(default_factory=dict, repr=False)
    _lock: threading.Lock = field(default_factory=threading.Lock, repr=False)

    def __post_init__(self) -> None:
        if not self.captured:
            now = time.monotonic()
            age = (time.time_ns() - self.received_ns) / 1e9
            # A stamp from the future, or older than a minute, is another clock's.
            self.captured = now - age if 0 <= age < MOST_AGE else now

    @property
    def complete(self) -> bool:
        """Whether every byte arrived."""
        return self.status is FrameStatus.COMPLETE

    def raw(self) -> NDArray[Any]:
        """Return the sensor's data, read-only.

        Shape (height, width) uint8 or uint16 (native byte order, value in the low bits) for mono and
        Bayer, (height, width, n) uint8 for interleaved colour. A view of the payload without a copy unless
        the format is packed. Raises PixelFormatError for a format we cannot lay out.
        """
        return self._cached("raw", pixels.to_raw)

    def rgb(self) -> NDArray[np.uint8]:
        """Return the image for display: (height, width, 3) uint8, R G B, read-only; computed once.

        Deeper formats keep their eight highest bits. A view without a copy for RGB8. Raises
        PixelFormatError for a format we cannot convert.
        """
        return self._cached("rgb", pixels.to_rgb)

    def mono(self) -> NDArray[np.uint8]:
        """Return the image in grey: (height, width) uint8, read-only; a view without a copy for Mono8."""
        return self._cached("mono", pixels.to_mono)

    def _cached(self, key: str, convert: Callable[[Frame], NDArray[Any]]) -> NDArray[Any]:
        with self._lock:
            array: NDArray[Any] | None = self._converted.get(key)
            if array is None:
                array = convert(self)
                array = array.view()
                array.flags.writeable = False
                self._converted[key] = array
            return array
