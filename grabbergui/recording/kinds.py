"""Kinds of recordings, and the kind that a path's suffix asks for."""

from __future__ import annotations

from enum import Enum
from pathlib import Path

from grabbergui.core.errors import UsageError

_NOT_WRITTEN = frozenset(
    [
        ".mkv",
        ".avi",
        ".mov",
        ".webm",
        ".bag",
        ".db3",
        ".npz",
        ".png",
        ".jpg",
        ".jpeg",
        ".bmp",
        ".gif",
        ".raw",
        ".h5",
        ".hdf5",
    ]
)
"Endings of files that are not written, and that a folder would be mistaken for."


class RecordingKind(Enum):
    """The kind of files of a recording."""

    PNG = "png"
    "A folder of PNG: lossless compression, on several threads."
    TIFF = "tiff"
    "A folder of TIFF: as fast as the disk."
    H264 = "h264"
    "A movie that every player opens: 8 bits, lossy."
    LOSSLESS = "lossless"
    "A movie (lossless H.264): 8 bits exactly, as fast as a camera of 8.8 MP."
    FFV1 = "ffv1"
    "A movie (FFV1): Mono of up to 16 bits and 8-bit colour exactly; smaller, and slower to write."
    STACK = "stack"
    "One TIFF with a page for each frame, uncompressed; up to 4 GiB."
    NUMPY = "npy"
    "One NumPy array of all frames."
    MCAP = "mcap"
    "Uncompressed ROS 2 messages, for Foxglove and `ros2 bag`."
    BAG = "bag"
    "The same in a folder with `metadata.yaml`, as `ros2 bag record` makes it."

    @property
    def suffix(self) -> str:
        """The suffix of its files; empty for a folder."""
        return _SUFFIXES.get(self, ".mp4" if self in MOVIE_KINDS else "")


_SUFFIXES = {RecordingKind.MCAP: ".mcap", RecordingKind.STACK: ".tiff", RecordingKind.NUMPY: ".npy"}
MOVIE_KINDS = (RecordingKind.H264, RecordingKind.LOSSLESS, RecordingKind.FFV1)
CODECS = {kind.value: kind for kind in (RecordingKind.H264, RecordingKind.FFV1)}
"""Codecs of a movie by their names; lossless H.264 has none of its own."""
_BY_SUFFIX = {
    ".mcap": RecordingKind.MCAP,
    ".tif": RecordingKind.STACK,
    ".tiff": RecordingKind.STACK,
    ".npy": RecordingKind.NUMPY,
}


def kind_of(
    path: Path,
    *,
    codec: str | None = None,
    lossless: bool = False,
    tiff: bool = False,
    bag: bool = False,
) -> RecordingKind:
    """Return the kind for a path's suffix: a movie, MCAP, one TIFF or NumPy array, or a folder of PNG.

    `codec` is one of CODECS, h264 by default; `codec` and `lossless` are for a movie, `tiff` and `bag` for a
    folder. A folder's name may end with digits after a dot, as in a date. Raises UsageError, also for other
    endings, which would be a file's.
    """
    suffix = path.suffix.lower()
    is_file = bool(suffix) and not suffix[1:].isdigit()
    if bag:
        if is_file:
            raise UsageError(
                f"a bag is a folder, which has no ending: name {path.with_suffix('')}, not {path}"
            )
        if tiff or lossless or codec is not None:
            raise UsageError("a bag has uncompressed images: leave out tiff, lossless and codec")
        return RecordingKind.BAG
    if is_file and suffix not in _BY_SUFFIX and suffix != ".mp4":
        raise UsageError(f"{path}: recordings are .mp4, .mcap, .tiff, .npy, or a folder (no ending)")
    if tiff and suffix in (".mp4", ".mcap", ".npy"):
        raise UsageError(f"tiff is for a folder of images, not for {path.name}")
    if suffix == ".mp4":
        return _movie_kind(codec or RecordingKind.H264.value, lossless=lossless)
    if codec is not None or lossless:
        given = f"codec {codec}" if codec is not None else "lossless"
        raise UsageError(f"{given} is for a movie (.mp4), not for {path.name}")
    if suffix in _BY_SUFFIX:
        return _BY_SUFFIX[suffix]
    return RecordingKind.TIFF if tiff else RecordingKind.PNG


def _movie_kind(codec: str, *, lossless: bool) -> RecordingKind:
    if codec not in CODECS:
        raise UsageError(f"'{codec}' is no codec of a movie; there are {', '.join(CODECS)}")
    kind = CODECS[codec]
    return RecordingKind.LOSSLESS if lossless and kind is RecordingKind.H264 else kind
