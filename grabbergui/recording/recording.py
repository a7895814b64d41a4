"""What a recording is to those who play it, whatever files it is made of."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path

from grabbergui.core.frame import Frame

DEFAULT_RATE = 25.0
"Frames per second where nothing was noted."


class Recording(ABC):
    """Frames with times, in any order of access. One thread at a time."""

    path: Path
    title: str = ""
    "What it is a recording of, for people."
    times_ns: list[int]
    "Of each frame, never falling; only differences matter."

    def __len__(self) -> int:
        return len(self.times_ns)

    @abstractmethod
    def frame(self, index: int, received_ns: int) -> Frame:
        """A frame, as though it had arrived at `received_ns`. Raises RecordingError."""

    @abstractmethod
    def close(self) -> None:
        """Let go of files. May be called twice."""

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last."""
        return (self.times_ns[-1] - self.times_ns[0]) / 1e9 if self.times_ns else 0.0


def rising(times: list[int]) -> list[int]:
    """Times of frames with what fell back (a clock that was set) held at the highest so far."""
    highest = 0
    held = []
    for time in times:
        highest = max(highest, time)
        held.append(highest)
    return held
