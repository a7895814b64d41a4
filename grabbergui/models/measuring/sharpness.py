"""How sharp a picture is, to focus a lens by."""

from __future__ import annotations

import time
from collections import deque

import cv2

from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family
from grabbergui.core.pixels import for_display
from grabbergui.core.region import Region

HISTORY_SECONDS = 60.0
HISTORY_MOST = 1200
"Scores kept at most."


def sharpness(frame: Frame, region: Region | None = None) -> float:
    """A score that is highest where the lens is in focus; for comparing pictures of one scene.

    The variance of the Laplacian, over the square of the mean, in percent: a brighter picture of the same
    scene has about the same score. Raises PixelFormatError.
    """
    region = (region or Region(0, 0, frame.width, frame.height)).clipped(frame.width, frame.height)
    # A mosaic's own pattern would pass for sharpness, so Bayer is taken in colour first.
    pixels = for_display(frame, region).pixels
    grey = cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY) if pixels.ndim == 3 else pixels
    if frame.pixel_format.family is Family.BAYER:
        grey = cv2.GaussianBlur(grey, (3, 3), 0)
    _, deviation = cv2.meanStdDev(cv2.Laplacian(grey, cv2.CV_16S))
    mean = float(grey.mean())
    return 100.0 * float(deviation[0][0]) ** 2 / mean**2 if mean >= 1 else 0.0


class FocusHistory:
    """Scores over the last minute, and the best one. Times are seconds of any one clock."""

    def __init__(self) -> None:
        self._scores: deque[tuple[float, float]] = deque(maxlen=HISTORY_MOST)
        self.best = 0.0
        "Highest score since `clear`."

    @property
    def scores(self) -> list[tuple[float, float]]:
        """Time and score, the oldest first."""
        return list(self._scores)

    def add(self, score: float, now: float | None = None) -> None:
        """Note a score."""
        now = time.monotonic() if now is None else now
        self._scores.append((now, score))
        while self._scores[0][0] < now - HISTORY_SECONDS:
            self._scores.popleft()
        self.best = max(self.best, score)

    def clear(self) -> None:
        """Begin anew."""
        self._scores.clear()
        self.best = 0.0
