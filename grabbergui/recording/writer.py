"""The interface of the writers of recordings."""

from __future__ import annotations

import shutil
from abc import ABC, abstractmethod
from collections.abc import Callable
from pathlib import Path

from grabbergui.core.calibration import FrameCalibration
from grabbergui.core.frame import Frame

CalibrationOf = Callable[[Frame], FrameCalibration | None]
"""Returns the calibration of a frame, if it is known."""


class RecordingWriter(ABC):
    """Writes frames to files. Overwrites no file."""

    path: Path
    keeps_components = False
    "Whether it writes every component of a frame, and not only the frame's own image."

    @abstractmethod
    def write(self, frame: Frame) -> None:
        """Add a frame; wait if too many earlier ones are in progress.

        Raises RecordingError, PixelFormatError, OSError if the disk is full, also for earlier frames.
        """

    @abstractmethod
    def close(self) -> None:
        """Finish the files. May be called twice. Raises OSError if the disk is too full for that."""

    def kept(self, given: int) -> int:
        """Return how many of `given` frames are in the files, once these are closed."""
        return given

    def discard(self) -> None:
        """Remove the files of a writer that was closed without a frame. Raises OSError."""
        self.path.unlink(missing_ok=True)

    @abstractmethod
    def size(self) -> int:
        """Return the bytes written so far."""

    def free(self) -> int:
        """Return the free bytes on its disk."""
        folder = self.path if self.path.is_dir() else self.path.parent
        return shutil.disk_usage(folder).free
