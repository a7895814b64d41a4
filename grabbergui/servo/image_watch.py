"""Notices a camera that sends images again, or long after they were taken. No I/O, no clock.

A camera that hangs may send its last image for ever, with new stamps, and one whose ring of buffers is stuck
its last few in turn: a head that turned to a target in them would turn on and on, and a hand be guided blind.
So an image that equals one of the last `_REMEMBERED` does not count once the head has moved, nor ever from a
camera whose images have noise. The images of a simulator may have none.
"""

from __future__ import annotations

import math
import zlib
from collections import deque

import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration.geometry import Vector
from grabbergui.core.errors import UsageError
from grabbergui.core.frame import Frame

_REMEMBERED = 64
"Images: more than a driver has buffers at the rates of servoing."
_SPARSE = 16
"Every so many rows of an image with noise are enough to recognise it."
_PARTS = 16
"Parts of each of these rows in which noise is looked for."
_NOISE = 0.5
"Share of them that noise changes from image to image, at least; a moving person changes fewer."
_NOISY = 3
"So many images in a row with noise show that the camera has some."
_RESTING = math.radians(0.5)
"Largest motion of a joint of a head at rest: readings scatter."
REPEATS = "the camera repeats its image"
AGREE_S = 2.0
"Seconds between a sender's stamp and the arrival, up to which the stamp is of the same clock."


class ImageWatch:
    """Compares each image of a source with those before. Use from one thread."""

    def __init__(self) -> None:
        self._region: tuple[int, int, int, int] | None = None
        self._last: NDArray[np.uint8] | None = None
        "Some rows of the last new image."
        self._head: Vector | None = None
        "The head's joints at that image."
        self._seen: deque[tuple[int, Vector | None]] = deque(maxlen=_REMEMBERED)
        "The checksums of the last new images, and the head's joints."
        self._noisy = 0
        "Number of images in a row with noise, up to `_NOISY`, where it stays."

    def problem_of(self, frame: Frame, grey: NDArray[np.uint8], head: Vector | None) -> str:
        """Return why an image does not count, as display text; empty if it does.

        `grey` are its pixels, `head` the head's joints. Raises UsageError if size or region changed, as the
        calibration is of those before.
        """
        region = (frame.width, frame.height, frame.offset_x, frame.offset_y)
        before, self._region = self._region, region
        if before is not None and before != region:
            raise UsageError(
                f"the camera's region changed from {_region_text(before)} to {_region_text(region)}: set it "
                "back, or start again if the calibration is right for it"
            )
        rows = np.ascontiguousarray(grey[::_SPARSE])
        noisy = self._noisy == _NOISY
        checksum = zlib.crc32((rows if noisy else np.ascontiguousarray(grey)).data)
        for known, then in self._seen:
            if known == checksum:
                return "" if not noisy and _rests(then, head) else REPEATS
        self._look_for_noise(rows, head)
        self._seen.append((checksum, head))
        return ""

    def _look_for_noise(self, rows: NDArray[np.uint8], head: Vector | None) -> None:
        last, self._last = self._last, rows
        rested, self._head = _rests(self._head, head), head
        if last is None or not rested or self._noisy == _NOISY:
            return
        parts = np.array_split(last != rows, _PARTS, axis=1)
        share = float(np.mean([part.any(axis=1).mean() for part in parts if part.size]))
        self._noisy = self._noisy + 1 if share > _NOISE else 0
        if self._noisy == _NOISY:
            self._seen.clear()  # from now on, checksums are of fewer rows


def _rests(before: Vector | None, now: Vector | None) -> bool:
    """Return whether the head was in the same place; False while it is not known."""
    return before is not None and now is not None and bool(np.all(np.abs(now - before) < _RESTING))


def _region_text(region: tuple[int, int, int, int]) -> str:
    width, height, x, y = region
    return f"{width}×{height} at ({x}, {y})"


class SenderStamps:
    """Finds by the senders' stamps that images were long on their way: over YARP and ROS 2.

    Whether the sender's clock agrees with this computer's is known from any image: it agrees for good.
    """

    def __init__(self) -> None:
        self._agrees = False

    def seconds_late(self, frame: Frame) -> float:
        """Return how long before `Frame.captured` an image was stamped; 0 if that is not known."""
        late = 1e-9 * (frame.received_ns - frame.timestamp_ns) if frame.timestamp_ns else -1.0
        self._agrees |= 0 <= late < AGREE_S
        return max(late, 0.0) if self._agrees else 0.0
