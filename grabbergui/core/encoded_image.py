"""Compressed images: their size from the first bytes, and their pixels when somebody asks for them.

JPEG (ITU-T T.81) and JPEG 2000 (T.800) images stand alone; OpenCV decodes them.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Any, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core import pfnc
from grabbergui.core.errors import PixelFormatError
from grabbergui.core.pfnc import PixelFormat


class Encoding(Protocol):
    """A way of compression."""

    @property
    def name(self) -> str:
        """Display text."""
        ...

    def decode(self, data: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return the image's bytes, 1-D, without padding. Raises PixelFormatError."""
        ...


@dataclass(frozen=True)
class ImageHeader:
    """Size and format of a compressed image, as it is once decoded."""

    width: int
    height: int
    pixel_format: PixelFormat


@dataclass(frozen=True)
class StillImage:
    """JPEG or JPEG 2000, decoded by OpenCV bit for bit as `cv2.imdecode` does."""

    name: str
    header: ImageHeader

    def decode(self, data: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Decode a whole image. Raises PixelFormatError where it is damaged."""
        try:
            image: NDArray[Any] | None = cv2.imdecode(np.ascontiguousarray(data), cv2.IMREAD_UNCHANGED)
        except cv2.error as error:
            raise PixelFormatError(f"the {self.name} image cannot be decoded: {error.err}") from error
        if image is None:
            raise PixelFormatError(f"the {self.name} image of {data.nbytes} bytes is damaged")
        if image.shape[:2] != (self.header.height, self.header.width):
            raise PixelFormatError(
                f"the {self.name} image has {image.shape[1]}×{image.shape[0]} pixels, its header says"
                f" {self.header.width}×{self.header.height}"
            )
        return np.ascontiguousarray(image).reshape(-1).view(np.uint8)


_START_OF_FRAME = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
_WITHOUT_LENGTH = frozenset((0x01, *range(0xD0, 0xD8)))
"Markers of JPEG that no segment follows."
LARGEST_SIDE = 1 << 16


def jpeg_header(data: bytes) -> ImageHeader:
    """Read the frame header (SOF) of a JPEG image. Raises PixelFormatError."""
    at = 2
    while data[:2] == b"\xff\xd8" and at + 9 < len(data) and data[at] == 0xFF:
        marker = data[at + 1]
        if marker == 0xFF:  # fill byte
            at += 1
        elif marker in _WITHOUT_LENGTH:
            at += 2
        elif marker in _START_OF_FRAME:
            depth, height, width, components = struct.unpack_from(">BHHB", data, at + 4)
            return _header("JPEG", width, height, depth, components)
        else:
            at += 2 + int.from_bytes(data[at + 2 : at + 4], "big")
    raise PixelFormatError("the camera sends a JPEG image without a frame header (SOF)")


_CODESTREAM = b"\xff\x4f\xff\x51"
"Start of codestream and of the SIZ segment, in a JP2 file or alone."


def jpeg2000_header(data: bytes) -> ImageHeader:
    """Read the SIZ segment of a JPEG 2000 image. Raises PixelFormatError."""
    at = data.find(_CODESTREAM)
    if at < 0 or len(data) < at + 45:
        raise PixelFormatError("the camera sends a JPEG 2000 image without a codestream header (SIZ)")
    right, bottom, left, top = struct.unpack_from(">IIII", data, at + 8)
    components, depth = struct.unpack_from(">HB", data, at + 40)
    return _header("JPEG 2000", right - left, bottom - top, (depth & 0x7F) + 1, components)


def _header(name: str, width: int, height: int, depth: int, components: int) -> ImageHeader:
    names = {(1, 8): "Mono8", (3, 8): "BGR8", (4, 8): "BGRa8"}
    if components == 1 and 8 < depth <= 16:
        pixel_format = pfnc.by_name("Mono16" if depth not in (10, 12, 14) else f"Mono{depth}")
    elif components == 3 and 8 < depth <= 16:
        pixel_format = pfnc.by_code(0x0230004B)  # BGR16
    elif (components, depth) in names:
        pixel_format = pfnc.by_name(names[components, depth])
    else:
        raise PixelFormatError(f"a {name} image of {components} components with {depth} bits is unknown")
    if not (0 < width <= LARGEST_SIDE and 0 < height <= LARGEST_SIDE):
        raise PixelFormatError(f"a {name} image of {width}×{height} pixels makes no sense")
    return ImageHeader(width, height, pixel_format)
