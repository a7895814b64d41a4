"""YARP's images: header and pixels, what a frame grabber sends of a frame, and JPEG over mjpeg. No I/O.

Over mjpeg the reader asks the source by HTTP, and gets JPEG images without end.
"""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass
from enum import Enum
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core import encoded_image
from grabbergui.core.errors import LocalProtocolError, RemoteProtocolError
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family
from grabbergui.net.yarp.os.bottle import BLOB, INT32, LIST, VOCAB, Bottle, Buffer
from grabbergui.net.yarp.os.carrier import BOUNDARY
from grabbergui.net.yarp.os.values import Vocab

# -- header and pixels ---------------------------------------------------------------------------
HEADER: Final = struct.Struct("<15i")
DEFAULT_QUANTUM: Final = 8
SIDE_LIMIT: Final = 1 << 20

_MAT: Final = Vocab("mat")


@dataclass(frozen=True)
class PixelCode:
    """Pixel layout of one of YARP's codes."""

    vocab: str
    depth: int
    "Bytes a pixel."
    dtype: str = "u1"
    "Of one component, as numpy names it; little endian."

    @property
    def channels(self) -> int:
        """Components a pixel."""
        return self.depth // np.dtype(self.dtype).itemsize


_CODES: Final = (
    PixelCode("mono", 1),
    PixelCode("mo16", 2, "<u2"),
    PixelCode("sign", 1, "i1"),
    PixelCode("dec", 4, "<f4"),
    PixelCode("int", 4, "<i4"),
    PixelCode("rgb", 3),
    PixelCode("bgr", 3),
    PixelCode("hsv", 3),
    PixelCode("rgb-", 3, "i1"),
    PixelCode("rgba", 4),
    PixelCode("bgra", 4),
    PixelCode("rgbi", 12, "<i4"),
    PixelCode("rgb.", 12, "<f4"),
    PixelCode("hsv.", 12, "<f4"),
    *(PixelCode(order, 1) for order in ("grbg", "bggr", "gbrg", "rggb")),
    *(PixelCode(order, 2, "<u2") for order in ("gr16", "bg16", "gb16", "rg16")),
    *(PixelCode(name, 1) for name in ("yuva", "yuvb", "yuvc", "yuvd")),
)
CODES: Final = {code.vocab: code for code in _CODES}
"""By the vocab that names them on the wire."""


@dataclass(frozen=True)
class ImageHeader:
    """The header that precedes the pixels."""

    code: str
    "A vocab of `CODES`; a number as text where it is none, see `depth`."
    width: int
    height: int
    depth: int
    "Bytes a pixel."
    row_bytes: int
    "Bytes from one row to the next."

    @property
    def size(self) -> int:
        """Bytes of all rows."""
        return self.row_bytes * self.height

    @classmethod
    def decode(cls, data: Buffer) -> ImageHeader:
        """Read and check the 60 bytes. Raises RemoteProtocolError."""
        if len(data) < HEADER.size:
            raise RemoteProtocolError(
                f"message of {len(data)} bytes is no image, whose header alone has {HEADER.size}"
            )
        values = HEADER.unpack_from(data)
        layout = (*values[:4], values[4], *values[6:8], values[13])
        if layout != (LIST, 4, VOCAB, _MAT, VOCAB, LIST + INT32, 5, BLOB):
            raise RemoteProtocolError(
                "message is no image: it does not begin with [mat] [code] (5 numbers) {pixels}"
            )
        code, depth, size, word, width, height, blob = *values[5:6], *values[8:13], values[14]
        known = CODES.get(str(Vocab(code)))
        quantum = max(1, word & 0xFFFF)
        row = -(-depth * width // quantum) * quantum
        if not (0 <= width <= SIDE_LIMIT and 0 <= height <= SIDE_LIMIT and 0 <= depth <= 64):
            raise RemoteProtocolError(f"image of {width}×{height} pixels of {depth} bytes each")
        if width and height and not depth:
            raise RemoteProtocolError(f"image of {width}×{height} pixels of no bytes")
        if known and depth != known.depth:
            raise RemoteProtocolError(f"image [{known.vocab}] with {depth} bytes a pixel, has {known.depth}")
        if size != blob or size < 0:
            raise RemoteProtocolError(f"image announces {size} bytes and has {blob}")
        if height and not word & 0xFFFF and size % height == 0:
            row = size // height
        if size != row * height or row < depth * width:
            raise RemoteProtocolError(f"image of {width}×{height} in rows of {row} bytes has {size} bytes")
        return cls(known.vocab if known else str(code), width, height, depth, row)


def encode_header(code: str, width: int, height: int, row_bytes: int) -> bytes:
    """Return the 60 bytes before `row_bytes * height` bytes of pixels. Raises LocalProtocolError."""
    pixel = CODES.get(code)
    if pixel is None:
        raise LocalProtocolError(f"YARP has no pixel code {code}; there are {', '.join(CODES)}")
    quantum = _quantum(pixel.depth * width, row_bytes)
    size = row_bytes * height
    return HEADER.pack(
        *(LIST, 4, VOCAB, _MAT, VOCAB, Vocab(code), LIST + INT32, 5),
        *(pixel.depth, size, quantum, width, height, BLOB, size),
    )


def encode(pixels: NDArray[Any], code: str) -> tuple[bytes, memoryview]:
    """Encode an array (height, width) or (height, width, channels) as header and pixels.

    The pixels are not copied when the rows are contiguous and as long as YARP wants them (a multiple of
    8 bytes); otherwise once, into padded rows. Raises LocalProtocolError.
    """
    pixel = CODES.get(code)
    if pixel is None:
        raise LocalProtocolError(f"YARP has no pixel code {code}; there are {', '.join(CODES)}")
    channels = pixels.shape[2] if pixels.ndim == 3 else 1
    if pixels.ndim not in (2, 3) or channels != pixel.channels or pixels.dtype != np.dtype(pixel.dtype):
        raise LocalProtocolError(
            f"[{code}] needs {pixel.channels} × {pixel.dtype}, not {pixels.dtype}{pixels.shape}"
        )
    height, width = pixels.shape[:2]
    used = pixel.depth * width
    row = -(-used // DEFAULT_QUANTUM) * DEFAULT_QUANTUM
    if row == used and pixels.flags.c_contiguous:
        rows = pixels
    else:
        rows = np.zeros((height, row), np.uint8)
        rows[:, :used] = np.ascontiguousarray(pixels).view(np.uint8).reshape(height, used)
    return encode_header(code, width, height, row), memoryview(rows.reshape(-1).view(np.uint8).data)


def decode(payload: Buffer) -> tuple[ImageHeader, NDArray[Any]]:
    """Return the array in a message: (height, width) or (height, width, channels), without a copy.

    A code we don't know gives (height, width, depth) uint8. Raises RemoteProtocolError.
    """
    header = ImageHeader.decode(payload)
    if len(payload) - HEADER.size < header.size:
        raise RemoteProtocolError(f"image lacks {header.size + HEADER.size - len(payload)} of its bytes")
    pixel = CODES.get(header.code) or PixelCode(header.code, header.depth)
    rows = np.frombuffer(payload, np.uint8, header.size, HEADER.size)
    if not header.size:
        shape = (header.height, header.width, pixel.channels)
        return header, np.zeros(shape if pixel.channels > 1 else shape[:2], pixel.dtype)
    component = np.dtype(pixel.dtype).itemsize
    shape3 = (header.height, header.width, pixel.channels)
    strides = (header.row_bytes, header.depth, component)
    dimensions = 3 if pixel.channels > 1 else 2
    return header, np.ndarray(shape3[:dimensions], pixel.dtype, rows, 0, strides[:dimensions])


def to_bottle(header: bytes, pixels: Buffer) -> Bottle:
    """Return the same image as an item for another Bottle, as replies carry it."""
    values = HEADER.unpack(header)
    numbers = Bottle(values[8:13], specialised=True)
    return Bottle([_MAT, Vocab(values[5]), numbers, pixels], specialised=False)


def _quantum(used: int, row_bytes: int) -> int:
    for quantum in (DEFAULT_QUANTUM, 1, 2, 4, 16, 32, 64, 128, 256):
        if -(-used // quantum) * quantum == row_bytes:
            return quantum
    raise LocalProtocolError(f"rows of {row_bytes} bytes for {used} bytes of pixels have no quantum")


# -- what a frame grabber sends ------------------------------------------------------------------
PixelsAndCode = tuple[NDArray[Any], str]
"""Pixels and YARP's code for them."""

PIXELS: Final = "pixels"
"""Our modifier of carriers; others ignore it. `fast_tcp+pixels.mono` asks for images without colour as [mono]
where everybody else gets [rgb], three times the bytes."""

MONO: Final = "mono"
"""The only value of `PIXELS` that means something."""

_INTERLEAVED = {"RGB": "rgb", "BGR": "bgr", "RGBa": "rgba", "BGRa": "bgra"}


class Capability(Enum):
    """YARP's two image interfaces."""

    COLOR = "COLOR"
    "RGB for every sensor."
    RAW = "RAW"
    "The sensor's own values; Bayer patterns as mono, which is what YARP's raw readers expect."

    def pixels(self, frame: Frame, *, mono: bool = False) -> PixelsAndCode:
        """Return the frame's pixels for this interface. Raises PixelFormatError.

        With `mono`, those of a sensor without colour are not repeated for each of three colours.
        """
        if self is Capability.RAW:
            return _raw(frame)
        if mono and frame.pixel_format.family is Family.MONO:
            return frame.mono(), "mono"
        return frame.rgb(), "rgb"

    def encode(self, frame: Frame, *, mono: bool = False) -> tuple[bytes, memoryview]:
        """Return the frame as an image message; `mono` as for `pixels`. Raises PixelFormatError."""
        return encode(*self.pixels(frame, mono=mono))

    def item(self, frame: Frame, box: tuple[int, int, int, int] | None = None) -> Bottle:
        """Return the frame, or its part (left, top, right, bottom), as an item of a reply."""
        pixels, code = self.pixels(frame)
        if box is not None:
            left, top, right, bottom = box
            pixels = pixels[top:bottom, left:right]
        return to_bottle(*encode(pixels, code))


def _raw(frame: Frame) -> PixelsAndCode:
    """Return the sensor's values where YARP has a code for their type, else the image for display."""
    pixels = frame.raw()
    if pixels.ndim == 2 and pixels.dtype == np.uint8:
        return pixels, "mono"
    if pixels.ndim == 2:
        deep = pixels.dtype == np.uint16
        return (pixels.astype("<u2", copy=False), "mo16") if deep else (frame.mono(), "mono")
    code = _INTERLEAVED.get(frame.pixel_format.order)
    return (pixels, code) if code and pixels.dtype == np.uint8 else (frame.rgb(), "rgb")


# -- JPEG over mjpeg -----------------------------------------------------------------------------
_HEADER_LIMIT: Final = 8192
_JPEG_LIMIT: Final = 64 << 20
_BLANK_LINE: Final = re.compile(rb"\r?\n\r?\n")
_LENGTH: Final = re.compile(rb"content-length:\s*(\d{1,9})", re.IGNORECASE)
_COMMENT: Final = b"\xff\xfe"

# The order in which OpenCV's encoder wants the components.
_TO_BGR: Final = {"rgb": cv2.COLOR_RGB2BGR, "rgba": cv2.COLOR_RGBA2BGR, "bgra": cv2.COLOR_BGRA2BGR}
_ONE_COMPONENT: Final = ("mono", "grbg", "bggr", "gbrg", "rggb")


def encode_part(message: Buffer, envelope: str, quality: int = 75) -> list[Buffer]:
    """Encode an image message as a part of the stream. Raises LocalProtocolError, RemoteProtocolError."""
    header, pixels = decode(message)
    if header.code in _TO_BGR:
        pixels = cv2.cvtColor(pixels, _TO_BGR[header.code])
    elif header.code == "mo16":
        pixels = (pixels >> 8).astype(np.uint8)
    elif header.code not in (*_ONE_COMPONENT, "bgr"):
        raise LocalProtocolError(
            f"an image [{header.code}] cannot be sent as JPEG, unlike mono, rgb, bgr and Bayer patterns"
        )
    encoded, jpeg = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, quality])
    if not encoded:
        raise LocalProtocolError(f"an image of {header.width}×{header.height} cannot be sent as JPEG")
    data = memoryview(jpeg.reshape(-1).data)
    comment = _comment(envelope) if envelope else b""
    start = 2 + (4 + int.from_bytes(data[4:6], "big") - 2 if bytes(data[2:4]) == b"\xff\xe0" else 0)
    size = len(data) + len(comment)
    head = b"Content-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n" % size
    return [head, data[:start], comment, data[start:], b"\r\n" + BOUNDARY]


def _comment(envelope: str) -> bytes:
    text = envelope.encode("utf-8", "surrogateescape") + b"\0"
    return _COMMENT + struct.pack(">H", len(text) + 2) + text


def decode_jpeg(jpeg: Buffer) -> tuple[bytes, memoryview, str]:
    """Decode an image to its header, pixels (rgb or mono) and envelope. Raises RemoteProtocolError."""
    data = np.frombuffer(jpeg, np.uint8)
    pixels = encoded_image.decode(data)
    if pixels.dtype != np.uint8:
        raise RemoteProtocolError(f"an image of {pixels.dtype}, JPEG has bytes")
    colour = pixels.ndim == 3
    if colour:
        pixels = cv2.cvtColor(pixels, cv2.COLOR_BGR2RGB)
    header, body = encode(pixels, "rgb" if colour else "mono")
    return header, body, find_comment(bytes(jpeg))


def find_comment(jpeg: bytes) -> str:
    """Return the text of the comment marker, which carries the envelope; empty if there is none."""
    at = 2
    while at + 4 <= len(jpeg) and jpeg[at] == 0xFF and jpeg[at + 1] != 0xDA:
        length = int.from_bytes(jpeg[at + 2 : at + 4], "big")
        if jpeg[at : at + 2] == _COMMENT:
            return jpeg[at + 4 : at + 2 + length].rstrip(b"\0").decode("utf-8", "surrogateescape")
        at += 2 + length
    return ""


class JpegStreamReader:
    """Finds the images in the answer to the request, sent by YARP, by us or by any HTTP camera."""

    def __init__(self) -> None:
        self._data = bytearray()
        self._length: int | None = None

    def feed(self, data: Buffer) -> list[bytes]:
        """Take received bytes; return the images that they complete. Raises RemoteProtocolError."""
        self._data += data
        images: list[bytes] = []
        while True:
            if self._length is None and not self._read_head():
                return images
            length = self._length or 0
            if len(self._data) < length:
                return images
            images.append(bytes(self._data[:length]))
            del self._data[:length]
            self._length = None

    def _read_head(self) -> bool:
        # Status line, headers and boundaries alike: all that matters is a length before a blank line.
        while True:
            end = _BLANK_LINE.search(self._data)
            if not end:
                if len(self._data) > _HEADER_LIMIT:
                    raise RemoteProtocolError(f"{len(self._data)} bytes without an image's header")
                return False
            head = bytes(self._data[: end.start()])
            if head.startswith(b"HTTP/") and b" 200" not in head.partition(b"\n")[0]:
                status = head.partition(b"\r")[0].decode("latin-1")
                raise RemoteProtocolError(f"the source answers '{status}'")
            del self._data[: end.end()]
            length = _LENGTH.search(head)
            if length and int(length[1]) > _JPEG_LIMIT:
                raise RemoteProtocolError(f"image of {int(length[1])} bytes, at most {_JPEG_LIMIT}")
            if length and int(length[1]):
                self._length = int(length[1])
                return True
