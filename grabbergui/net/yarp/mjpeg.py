"""JPEG images as YARP's mjpeg carrier sends them, in parts of one HTTP answer. No I/O."""

from __future__ import annotations

import re
import struct
from typing import Final

import cv2
import numpy as np

from grabbergui.core import encoded_image
from grabbergui.core.errors import LocalProtocolError, RemoteProtocolError
from grabbergui.net.yarp.image import decode, encode
from grabbergui.net.yarp.os.bottle import Buffer
from grabbergui.net.yarp.os.carrier import BOUNDARY

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
