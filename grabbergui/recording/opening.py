"""Opens a recording: each kind of file has a reader of its own."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

from grabbergui.core.errors import GrabberError, MissingFileError, UsageError
from grabbergui.recording.errors import RecordingError
from grabbergui.recording.reader import RecordingReader

VIDEO_SUFFIXES = (".mp4", ".mkv", ".avi", ".mov", ".m4v", ".webm")
"Suffixes of movies that are played."


def open_recording(path: Path, *, topic: str = "") -> RecordingReader:
    """Open the recording in a folder or file. Raises MissingFileError, UsageError, RecordingError.

    `topic` chooses the images in a ROS recording; `all` are played at once, as components of a frame.
    """
    try:
        return _opened(path, topic)
    except GrabberError:
        raise  # a missing file is an OSError, too
    except OSError as error:
        raise RecordingError(f"{path} could not be read: {error.strerror or error}") from error


def _opened(path: Path, topic: str) -> RecordingReader:
    # Imported on demand, as each kind needs another library.
    if not path.exists():
        raise MissingFileError(f"there is no recording {path}; write file: and a folder, a movie or an .mcap")
    from grabbergui.recording import bag_folder

    files = bag_folder.bag_files(path) if path.is_dir() else [path]
    if files and files[0].suffix.lower() in (".mcap", ".db3"):
        from grabbergui.recording.ros_recording import RosRecording

        return RosRecording(path, bag_folder.opened(files), topic)
    if topic:
        raise UsageError(f"{path} has no topics; topic= is for .mcap, .db3 and folders of rosbag2")
    if path.suffix.lower() == ".npy":
        from grabbergui.recording.npy_file import NpyRecording

        return NpyRecording(path)
    if path.is_dir() or path.suffix.lower() in (".tif", ".tiff"):
        from grabbergui.recording.folder import FolderRecording

        return FolderRecording(path)
    if path.suffix.lower() in VIDEO_SUFFIXES:
        from grabbergui.recording.movie_file import MovieRecording

        return MovieRecording(path)
    raise UsageError(
        f"{path} is no recording; there are folders of images, .mcap, .db3, .tiff, .npy "
        f"and {', '.join(VIDEO_SUFFIXES)}"
    )


def playable_frames(path: Path) -> int:
    """Return how many frames of a recording that ended early can be played, up to the last readable one."""
    try:
        with closing(open_recording(path)) as recording:
            for index in reversed(range(len(recording))):
                try:
                    recording.frame(index, 0)
                except GrabberError:
                    continue
                return index + 1
    except GrabberError:
        pass
    return 0
