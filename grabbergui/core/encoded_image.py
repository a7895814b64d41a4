"""Compressed images: reads their size from the header, and decodes their pixels on demand.

Cameras send JPEG (ITU-T T.81) and JPEG 2000 (T.800) images, each of which can be decoded alone; OpenCV does
it. Image files from elsewhere (JPEG, PNG, BMP, TIFF, PPM) are decoded only if their size is reasonable.

A file can announce any size in a few bytes, and a decoder allocates the memory before it reads the first
pixel. Therefore the headers of JPEG (T.81, B.2.2), PNG (ISO 15948, 11.2.2), BMP, TIFF and PPM are checked
first, and other kinds are refused. OpenCV's PNG decoder allocates up to 4 GiB for the announced length of a
chunk, so chunks are also compared with the length of the file.
"""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass
from typing import Any, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core import pfnc
from grabbergui.core.errors import PixelFormatError, RemoteProtocolError
from grabbergui.core.pfnc import PixelFormat

_JPEG, _PNG, _BMP = b"\xff\xd8", b"\x89PNG\r\n\x1a\n", b"BM"
"The first bytes of such files."
_START_OF_FRAME = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
"Markers SOF0 to SOF15 without DHT, JPG and DAC: the segments that contain the size."
_WITHOUT_LENGTH = frozenset((0x01, *range(0xD0, 0xD9)))
"Markers that no length follows: TEM, RST0 to RST7, SOI."
LARGEST_SIDE = 1 << 16
"Pixels."
MOST_PIXELS = 1 << 28
"Pixels of an image that is decoded; the largest sensors have some 250 million."
_CODESTREAM = b"\xff\x4f\xff\x51"
"Start of codestream and of the SIZ segment, in a JP2 file or alone."
_MOST_TAGS = 500
_TIFF_NUMBERS = {3: "H", 4: "I", 16: "Q"}
_NETPBM = re.compile(rb"P[1-6]\s(?:\s*#[^\n]*\n)*\s*(\d{1,10})\s+(\d{1,10})\s")
"The beginning of PBM, PGM and PPM: width and height as text, after comments."
SHOWN_WIDTH = 960
"Largest width of an image in a notebook, in pixels. Wider ones are scaled down for the way to the browser."
SHOWN_HEIGHT = 65_500
"Largest height of a JPEG that OpenCV writes."


class Encoding(Protocol):
    """A kind of compression."""

    @property
    def name(self) -> str:
        """Display text."""
        ...

    def decode(self, data: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return the image's bytes, 1-D, without padding. Raises PixelFormatError."""
        ...


@dataclass(frozen=True)
class StillImageHeader:
    """Size and format of a compressed image after decoding."""

    width: int
    height: int
    pixel_format: PixelFormat


@dataclass(frozen=True)
class StillImage:
    """JPEG or JPEG 2000; decodes to exactly the bytes of `cv2.imdecode`."""

    name: str
    header: StillImageHeader

    def decode(self, data: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Decode the image. Raises PixelFormatError if it is damaged."""
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


def jpeg_header(data: bytes) -> StillImageHeader:
    """Read the frame header (SOF) of a JPEG image. Raises PixelFormatError."""
    at = _frame_header_at(data)
    if at is None:
        raise PixelFormatError("the camera sends a JPEG image without a frame header (SOF)")
    depth, height, width, components = struct.unpack_from(">BHHB", data, at + 4)
    return _header("JPEG", width, height, depth, components)


def _frame_header_at(file: bytes | memoryview) -> int | None:
    """Return where the first frame header of a JPEG image begins; None if it has none, or is cut short."""
    at = 2
    while file[:2] == _JPEG and at + 10 <= len(file) and file[at] == 0xFF:
        marker = file[at + 1]
        if marker in _START_OF_FRAME:
            return at
        if marker == 0xFF:  # fill byte
            at += 1
        elif marker in _WITHOUT_LENGTH:
            at += 2
        else:
            at += 2 + int.from_bytes(file[at + 2 : at + 4], "big")
    return None


def jpeg2000_header(data: bytes) -> StillImageHeader:
    """Read the SIZ segment of a JPEG 2000 image. Raises PixelFormatError."""
    at = data.find(_CODESTREAM)
    if at < 0 or len(data) < at + 45:
        raise PixelFormatError("the camera sends a JPEG 2000 image without a codestream header (SIZ)")
    right, bottom, left, top = struct.unpack_from(">IIII", data, at + 8)
    components, depth = struct.unpack_from(">HB", data, at + 40)
    return _header("JPEG 2000", right - left, bottom - top, (depth & 0x7F) + 1, components)


def _header(name: str, width: int, height: int, depth: int, components: int) -> StillImageHeader:
    names = {(1, 8): "Mono8", (3, 8): "BGR8", (4, 8): "BGRa8"}
    if components == 1 and 8 < depth <= 16:
        pixel_format = pfnc.by_name("Mono16" if depth not in (10, 12, 14) else f"Mono{depth}")
    elif components == 3 and 8 < depth <= 16:
        pixel_format = pfnc.by_code(0x0230004B)  # BGR16
    elif (components, depth) in names:
        pixel_format = pfnc.by_name(names[components, depth])
    else:
        raise PixelFormatError(f"a {name} image of {components} components with {depth} bits is unknown")
    if problem := _size_problem(width, height):
        raise PixelFormatError(f"a {name} image announces {width}×{height} pixels{problem}")
    return StillImageHeader(width, height, pixel_format)


def _size_problem(width: int, height: int) -> str:
    """Return why an image of this size is not decoded, to follow the size; empty if it is."""
    if width <= 0 or height <= 0:
        return ", so it is empty"
    if max(width, height) > LARGEST_SIDE:
        return f"; a side has at most {LARGEST_SIDE}"
    if width * height > MOST_PIXELS:
        return f"; at most {MOST_PIXELS} in all are decoded"
    return ""


def decode(file: NDArray[np.uint8]) -> NDArray[Any]:
    """Decode the 1-D bytes of a file into OpenCV's layout: (height, width[, 3 or 4]), colours as B G R A.

    Values are uint8 or uint16, or of any type that a TIFF can have. Raises RemoteProtocolError for bytes that
    are no image, for one that is cut short, and for one of more than `MOST_PIXELS`.
    """
    size = announced_size(file.data)
    if size is None:  # another kind, of which OpenCV would allocate up to 2^30 pixels
        raise RemoteProtocolError(f"{file.size} bytes that are no image, or one that was cut short")
    if size[0] * size[1] > MOST_PIXELS:
        raise RemoteProtocolError(
            f"an image that announces {size[0]}×{size[1]} pixels; at most {MOST_PIXELS} are decoded"
        )
    if not _png_is_whole(file.data):
        raise RemoteProtocolError(f"{file.size} bytes of a PNG image that was cut short")
    try:
        image = cv2.imdecode(file, cv2.IMREAD_UNCHANGED) if file.size else None
    except cv2.error:
        image = None
    if image is None:
        raise RemoteProtocolError(f"{file.size} bytes that are no image, or one that was cut short")
    return image


def announced_size(file: bytes | memoryview) -> tuple[int, int] | None:
    """Return width and height from a file's header; None for another kind, or one that ends before them."""
    if (at := _frame_header_at(file)) is not None:
        height, width = struct.unpack_from(">HH", file, at + 5)
        return width, height
    if file[:8] == _PNG and file[12:16] == b"IHDR" and len(file) >= 24:
        width, height = struct.unpack_from(">II", file, 16)
        return width, height
    if file[:2] == _BMP and len(file) >= 26 and struct.unpack_from("<I", file, 14)[0] >= 40:
        width, height = struct.unpack_from("<ii", file, 18)
        return abs(width), abs(height)  # a negative height: the first line is at the top
    if found := _NETPBM.match(bytes(file[:200])):
        return int(found[1]), int(found[2])
    return _tiff_size(file)


def _tiff_size(file: bytes | memoryview) -> tuple[int, int] | None:
    """Return the size of the first page of a TIFF or BigTIFF (tags 256 and 257); None for another kind."""
    order = {b"II": "<", b"MM": ">"}.get(bytes(file[:2]))
    version = struct.unpack_from(f"{order}H", file, 2)[0] if order and len(file) >= 16 else 0
    if version not in (42, 43):
        return None
    count, place, begin, entry = ("H", "I", 4, 12) if version == 42 else ("Q", "Q", 8, 20)
    found = {}
    try:
        (at,) = struct.unpack_from(f"{order}{place}", file, begin)
        (tags,) = struct.unpack_from(f"{order}{count}", file, at)
        first = at + struct.calcsize(f"={count}")
        for index in range(min(tags, _MOST_TAGS)):
            tag, kind = struct.unpack_from(f"{order}HH", file, first + index * entry)
            if tag in (256, 257) and kind in _TIFF_NUMBERS:
                value = first + index * entry + entry - struct.calcsize(f"={place}")
                found[tag] = struct.unpack_from(f"{order}{_TIFF_NUMBERS[kind]}", file, value)[0]
    except (struct.error, OverflowError, ValueError):
        return None
    return (found[256], found[257]) if len(found) == 2 else None


def _png_is_whole(file: memoryview) -> bool:
    """Return whether a file contains every chunk of its PNG image; true for other kinds."""
    if file[:8] != _PNG:
        return True
    at = len(_PNG)
    while at + 8 <= len(file):
        length, kind = struct.unpack_from(">I4s", file, at)
        if kind == b"IEND":
            return bool(at + 8 + length <= len(file))
        at += 12 + length
    return False


def jpeg_to_show(image: NDArray[np.uint8]) -> bytes:
    """Encode an RGB image (height, width, 3) as a JPEG of at most `SHOWN_WIDTH` × `SHOWN_HEIGHT` pixels."""
    height, width = image.shape[:2]
    scale = min(SHOWN_WIDTH / width, SHOWN_HEIGHT / height)
    if scale < 1:
        size = (max(1, int(width * scale)), max(1, int(height * scale)))
        image = np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.uint8)
    bgr = cv2.cvtColor(image, cv2.COLOR_RGB2BGR)
    encoded, content = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, 80])
    if not encoded:
        raise PixelFormatError(f"an image of {width}×{height} pixels cannot be shown as JPEG")
    return content.tobytes()
