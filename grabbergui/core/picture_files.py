"""Pictures as files have them (JPEG, PNG, BMP, TIFF), decoded by OpenCV once their size is found reasonable.

A file may announce any size in a few bytes, and a decoder takes the memory for it before it looks at
the first pixel. So the headers that are easily read (JPEG: ITU T.81, B.2.2; PNG: ISO 15948, 11.2.2; BMP) are
read first. Of other kinds OpenCV's own limit of 2^30 pixels holds. Its PNG decoder takes up to 4 GiB for a
chunk by its announced length alone, so these are held against the file's, too.
"""

from __future__ import annotations

import struct
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core.errors import RemoteProtocolError

MOST_PIXELS = 1 << 28
"Of a picture that is decoded; the largest sensors have some 250 million."

_PNG = b"\x89PNG\r\n\x1a\n"
_JPEG, _BMP = b"\xff\xd8", b"BM"
_FRAME_MARKERS = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
"SOF0 to SOF15 without DHT, JPG and DAC: the segments that contain the size."
_STANDALONE = frozenset((0x01, *range(0xD0, 0xD9)))
"Markers that no length follows: TEM, RST0 to RST7, SOI."


def decode(file: NDArray[np.uint8]) -> NDArray[Any]:
    """The picture in a file's bytes (1-D), as OpenCV has it: (height, width[, 3 or 4]), colours as B G R A.

    uint8 or uint16, or what else a TIFF holds. Raises RemoteProtocolError for what is no picture, is cut
    short, or has more than `MOST_PIXELS`.
    """
    size = announced_size(file.data)
    if size is not None and size[0] * size[1] > MOST_PIXELS:
        raise RemoteProtocolError(
            f"a picture that announces {size[0]}×{size[1]} pixels; at most {MOST_PIXELS} are decoded"
        )
    if not _png_is_whole(file.data):
        raise RemoteProtocolError(f"{file.size} bytes of a PNG picture that was cut short")
    try:
        picture = cv2.imdecode(file, cv2.IMREAD_UNCHANGED) if file.size else None
    except cv2.error:
        picture = None
    if picture is None:
        raise RemoteProtocolError(f"{file.size} bytes that are no picture, or one that was cut short")
    return picture


def announced_size(file: bytes | memoryview) -> tuple[int, int] | None:
    """Width and height by a file's header; None where it is of another kind or cut short before them."""
    if file[:2] == _JPEG:
        return _jpeg_size(file)
    if file[:8] == _PNG and file[12:16] == b"IHDR" and len(file) >= 24:
        width, height = struct.unpack_from(">II", file, 16)
        return width, height
    if file[:2] == _BMP and len(file) >= 26 and struct.unpack_from("<I", file, 14)[0] >= 40:
        width, height = struct.unpack_from("<ii", file, 18)
        return abs(width), abs(height)  # negative: the first line on top
    return None


def _png_is_whole(file: memoryview) -> bool:
    """Whether every chunk up to the last lies within the file; true of anything but a PNG."""
    if file[:8] != _PNG:
        return True
    at = len(_PNG)
    while at + 8 <= len(file):
        if bytes(file[at + 4 : at + 8]) == b"IEND":
            return True
        at += 12 + int(struct.unpack_from(">I", file, at)[0])
    return False


def _jpeg_size(file: bytes | memoryview) -> tuple[int, int] | None:
    """Of the first frame header: the segments before it are stepped over by their lengths."""
    at = 2
    while at + 9 <= len(file):
        if file[at] != 0xFF:
            return None
        marker = file[at + 1]
        if marker == 0xFF:  # filling
            at += 1
        elif marker in _STANDALONE:
            at += 2
        elif marker in _FRAME_MARKERS:
            height, width = struct.unpack_from(">HH", file, at + 5)
            return width, height
        else:
            at += 2 + struct.unpack_from(">H", file, at + 2)[0]
    return None
