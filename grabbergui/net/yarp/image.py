"""YARP's images: header and pixels, what a frame grabber sends of a frame, and JPEG over mjpeg. No I/O.

Over mjpeg the reader asks the source by HTTP, and gets JPEG images without end.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.errors import LocalProtocolError, RemoteProtocolError
from grabbergui.net.yarp.os.bottle import BLOB, INT32, LIST, VOCAB, Bottle, Buffer
from grabbergui.net.yarp.os.values import Vocab

HEADER: Final = struct.Struct("<15i")
DEFAULT_QUANTUM: Final = 8
SIDE_LIMIT: Final = 1 << 20
BAYER_ORDER: Final = "grbg"
"""The order of a pattern whose sender does not name one, as in YARP's plug-in bayer."""

_MAT: Final = Vocab("mat")


@dataclass(frozen=True)
class PixelCode:
    """Pixel layout of one of YARP's codes."""

    vocab: str
    depth: int
    "Bytes a pixel."
    dtype: str = "u1"
    "numpy's type of one component; little endian."

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
BAYER: Final = {
    order: {"mono": order, "mo16": f"{order[:2]}16"} for order in ("grbg", "bggr", "gbrg", "rggb")
}
"""The codes of a Bayer pattern, by its order and by the code of its samples without colour."""
_CODE_AT: Final = struct.calcsize("<5i")


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


def as_bayer(message: memoryview, order: str) -> memoryview:
    """Make a [mono] or [mo16] image a Bayer pattern of this `order`; any other message stays as it is.

    Its memory is changed where that may be written, or else copied.
    """
    try:
        code = BAYER[order].get(ImageHeader.decode(message).code)
    except RemoteProtocolError:
        return message
    if code is None:
        return message
    if message.readonly:
        message = memoryview(bytearray(message))
    struct.pack_into("<i", message, _CODE_AT, Vocab(code))
    return message


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
