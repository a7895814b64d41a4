"""The interface of recordings that are read: frames with times, with random access."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path

from grabbergui.core.calibration import Calibration
from grabbergui.core.coord3d import Scan3d
from grabbergui.core.frame import Frame


class RecordingReader(ABC):
    """Frames with times, with random access. One thread at a time."""

    path: Path
    title: str = ""
    "The recorded source, as display text."
    scan: Scan3d | None = None
    "The meaning of its 3D data; None if that was not recorded."
    remark: str = ""
    "Remark for the user about it, such as further topics; empty if there is nothing."
    times_ns: list[int]
    "The time of each frame, never decreasing; only differences are meaningful."

    def __len__(self) -> int:
        return len(self.times_ns)

    @abstractmethod
    def frame(self, index: int, received_ns: int) -> Frame:
        """Return a frame with the time of receipt `received_ns`. Raises RecordingError."""

    def calibration(self, index: int) -> Calibration | None:
        """Return the calibration of a frame; None if it was not recorded."""
        return None

    @abstractmethod
    def close(self) -> None:
        """Close its files. May be called twice."""

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last."""
        return (self.times_ns[-1] - self.times_ns[0]) / 1e9 if self.times_ns else 0.0
