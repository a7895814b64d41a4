"""Errors of recordings: why one could not be written or read, or ended."""

from __future__ import annotations

from pathlib import Path

from grabbergui.core.errors import GrabberError


class RecordingError(GrabberError):
    """A recording could not be written or read."""


class DiskFullError(RecordingError):
    """A recording ended because the disk is full. The frames written before are kept."""

    def __init__(self, path: Path, free: int) -> None:
        free = max(free, 0)  # frames that wait to be written may need more than there is
        super().__init__(f"the disk of {path} is full ({free >> 20} MiB left)")
        self.path = path
        self.free = free
        "Free bytes, too few for another frame and the end of the file."


class SourceClosedError(RecordingError):
    """A recording ended because its source was closed."""

    def __init__(self) -> None:
        super().__init__("the source was closed")


class UnfinishedFileError(RecordingError):
    """The end of a recording could not be written."""

    def __init__(self, path: Path, cause: Exception) -> None:
        super().__init__(f"{path} could not be finished: {cause}")
        self.path = path
        self.cause = cause
