"""What a recording is to those who play it, whatever files it is made of."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path

from grabbergui.core.errors import SourceNotFoundError, UsageError
from grabbergui.core.frame import Frame

VIDEO_SUFFIXES = (".mp4", ".mkv", ".avi", ".mov", ".m4v", ".webm")
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


def open_recording(path: Path) -> Recording:
    """The recording in a folder or file. Raises SourceNotFoundError, UsageError, RecordingError."""
    # On demand: each kind needs another library.
    if not path.exists():
        raise SourceNotFoundError(
            f"there is no recording {path}; write file: and a folder, a movie or an .mcap"
        )
    if path.is_dir():
        from grabbergui.driver.playback.folder import FolderRecording

        return FolderRecording(path)
    if path.suffix.lower() == ".mcap":
        from grabbergui.driver.playback.mcap_file import McapRecording

        return McapRecording(path)
    if path.suffix.lower() in VIDEO_SUFFIXES:
        from grabbergui.driver.playback.video import VideoRecording

        return VideoRecording(path)
    raise UsageError(
        f"{path} is no recording; there are folders of pictures, .mcap and {', '.join(VIDEO_SUFFIXES)}"
    )


def rising(times: list[int]) -> list[int]:
    """Times of frames with what fell back (a clock that was set) held at the highest so far."""
    highest = 0
    held = []
    for time in times:
        highest = max(highest, time)
        held.append(highest)
    return held
