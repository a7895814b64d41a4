"""Folders of yarpdatadumper: images, and `data.log` with a line for each.

A line has the number of the envelope, one or two times in seconds (of the sender, of receipt), and the file's
name, which newer versions follow by the pixel code: `17 1700000000.123456 00000000.ppm [rgb]`. Images are
PPM, PGM, PNG, JPEG, or `.float` and `.floatzip`: height and width as 64-bit numbers, then 32-bit floats, the
latter compressed by zlib.
"""

from __future__ import annotations

import math
import re
import struct
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.encoded_image import MOST_PIXELS
from grabbergui.core.errors import RemoteProtocolError
from grabbergui.core.regular_files import read_bounded

LOG_NAME = "data.log"
FLOAT_SUFFIXES = (".float", ".floatzip")
MAX_LOG_BYTES = 1 << 26
_LINE = re.compile(
    r"(-?\d{1,10})((?: +-?\d{1,12}\.?\d{0,12}){1,2}) +([\w-]+\.\w{1,10})(?: +\[.*\])?", re.ASCII
)


@dataclass(frozen=True)
class Dumped:
    """A line of the log."""

    file: str
    number: int
    "Number in the envelope."
    time_ns: int
    "Time of the sender, or else of receipt."


def read_log(folder: Path) -> list[Dumped]:
    """Return the images of a folder's log; none without such a log, or for other data.

    Raises UsageError, OSError.
    """
    path = folder / LOG_NAME
    if not path.exists():
        return []
    found = []
    for line in (
        read_bounded(path, MAX_LOG_BYTES, "log of yarpdatadumper").decode("utf-8", "replace").splitlines()
    ):
        if match := _LINE.fullmatch(line.strip()):
            seconds = float(match[2].split()[0])
            time_ns = round(seconds * 1e9) if math.isfinite(seconds) else 0
            found.append(Dumped(match[3], max(0, int(match[1])), max(0, time_ns)))
    return found


def read_float(content: bytes, *, compressed: bool) -> NDArray[Any]:
    """Return the image of a `.float` or `.floatzip` file: (height, width) float32.

    Raises RemoteProtocolError.
    """
    if len(content) < 16:
        raise RemoteProtocolError(f"only {len(content)} bytes")
    height, width = struct.unpack_from("<QQ", content)
    if not 0 < height * width <= MOST_PIXELS:
        raise RemoteProtocolError(f"an image of {width}×{height} pixels is impossible")
    size, values = 4 * height * width, content[16:]
    if compressed:
        try:
            values = zlib.decompressobj().decompress(values, size)
        except zlib.error as error:
            raise RemoteProtocolError(f"its compressed values are damaged: {error}") from None
    if len(values) < size:
        raise RemoteProtocolError(f"{width}×{height} values, but only {len(values)} bytes of them")
    return np.frombuffer(values[:size], "<f4").reshape(height, width)
