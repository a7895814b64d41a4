"""A long recording in segments: a new file after some time, so that no file grows without end."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from typing_extensions import override

from grabbergui.core.frame import Frame
from grabbergui.recording.writer import RecordingWriter


def segment_path(path: Path, number: int) -> Path:
    """Return the file of a segment: `run.mcap` becomes `run.0001.mcap`."""
    return path.with_name(f"{path.stem}.{number:04d}{path.suffix}")


class SegmentedWriter(RecordingWriter):
    """Writes one file after the other. A frame is in one of them, never in two."""

    def __init__(self, path: Path, create: Callable[[Path], RecordingWriter], seconds: float) -> None:
        """`create` makes the writer of a segment; `seconds` is its length. Raises as `create`."""
        self._named = path
        self._create = create
        self._seconds = seconds
        self._number = 1
        self._finished_bytes = 0
        self._begun: float | None = None
        self.path = segment_path(path, 1)
        self._writer = create(self.path)
        self.keeps_components = self._writer.keeps_components

    @override
    def write(self, frame: Frame) -> None:
        if self._begun is None:
            self._begun = frame.captured
        if frame.captured - self._begun >= self._seconds:
            self._writer.close()
            self._finished_bytes += self._writer.size()
            self._number += 1
            self._writer = self._create(segment_path(self._named, self._number))
            self._begun = frame.captured
        self._writer.write(frame)

    @override
    def close(self) -> None:
        self._writer.close()

    @override
    def size(self) -> int:
        return self._finished_bytes + self._writer.size()
