"""Which kind of recording a path holds."""

from __future__ import annotations

from pathlib import Path

from grabbergui.core.errors import MissingFileError, UsageError
from grabbergui.recording.recording import Recording
from grabbergui.recording.stored import RecordingError

VIDEO_SUFFIXES = (".mp4", ".mkv", ".avi", ".mov", ".m4v", ".webm")


def open_recording(path: Path) -> Recording:
    """The recording in a folder or file. Raises MissingFileError, UsageError, RecordingError."""
    try:
        return _opened(path)
    except OSError as error:
        raise RecordingError(f"{path} could not be read: {error.strerror or error}") from error


def _opened(path: Path) -> Recording:
    # On demand: each kind needs another library.
    if not path.exists():
        raise MissingFileError(f"there is no recording {path}; write file: and a folder, a movie or an .mcap")
    if path.is_dir():
        from grabbergui.recording.folder import FolderRecording

        return FolderRecording(path)
    if path.suffix.lower() == ".mcap":
        from grabbergui.recording.mcap_file import McapRecording

        return McapRecording(path)
    if path.suffix.lower() in VIDEO_SUFFIXES:
        from grabbergui.recording.movie import VideoRecording

        return VideoRecording(path)
    raise UsageError(
        f"{path} is no recording; there are folders of pictures, .mcap and {', '.join(VIDEO_SUFFIXES)}"
    )
