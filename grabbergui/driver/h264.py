"""H.264 streams (ITU-T H.264, Annex B): their units, their frame size, and their decoder.

An image is coded as the difference from earlier images, back to the
last key frame. So its stream keeps the compressed bytes since the last key frame but one, and PyAV decodes up
to the requested image.
"""

from __future__ import annotations

import threading
from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grabbergui.core import pfnc
from grabbergui.core.component import Component
from grabbergui.core.errors import PixelFormatError

MOST_UNITS, MOST_BYTES = 600, 64 << 20
"Largest number of images kept for decoding, and of their bytes; older ones are dropped."
LARGEST_H264_SIDE = 1 << 14
"Pixels; a larger one means a damaged parameter set."
_SLICE, _KEY_SLICE, _PARAMETERS = 1, 5, 7
"Types of NAL units: slice, slice of a key frame (IDR), sequence parameter set."
_WITH_CHROMA = frozenset((100, 110, 122, 244, 44, 83, 86, 118, 128, 138, 139, 134, 135))
"Profiles whose parameter set states the chroma format (7.3.2.1.1)."


@dataclass(frozen=True)
class _Unit:
    number: int
    data: bytes
    key: bool


@dataclass(frozen=True, eq=False)
class H264Image:
    """One image of a stream, as an encoding of `core.encoded_image`."""

    stream: H264Stream
    number: int
    size: tuple[int, int]
    "Width and height from the stream's parameter set."
    name: str = "H.264"

    def decode(self, data: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return the image's RGB8 bytes. Raises PixelFormatError if images before it are missing."""
        image = self.stream.decode(self.number)
        if image.size != 3 * self.size[0] * self.size[1]:
            raise PixelFormatError(f"the H.264 image has another size than {self.size[0]}×{self.size[1]}")
        return image


class H264Stream:
    """The images of one stream: `add` from the stream's thread, `decode` from any."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._units: deque[_Unit] = deque()
        self._bytes = 0
        self._size: tuple[int, int] | None = None
        self._last_number: int | None = None
        self._added = 0
        self._intact = False
        "Whether no image was lost since the last key frame."
        self._decoder: Any = None
        self._next = 0
        "Number of the next unit for the decoder."

    def add(self, number: int, data: NDArray[np.uint8], *, complete: bool = True) -> Component | None:
        """Add the next image; return None if images that it depends on were lost or never received.

        `number` is one more than the previous image's, unless images were lost in between.
        """
        content = data.tobytes()
        key, size = scan_h264(content)
        follows = self._last_number is not None and number == self._last_number + 1
        self._last_number = number
        self._intact = complete and (key or (self._intact and follows))
        if size is not None:
            self._size = size
        if not self._intact or self._size is None:
            return None
        with self._lock:
            self._added += 1
            self._keep(_Unit(self._added, content, key))
        width, height = self._size
        image = H264Image(self, self._added, self._size)
        return Component(data, width, height, pfnc.by_name("RGB8"), encoding=image)

    def decode(self, number: int) -> NDArray[np.uint8]:
        """Decode up to an image. Raises PixelFormatError."""
        with self._lock:
            units = self._path_to(number)
            image = None
            for unit in units:
                image = self._decode_unit(unit)
            if image is None:
                raise PixelFormatError("this H.264 image is not decodable; wait for the next key frame")
            return image

    def _keep(self, unit: _Unit) -> None:
        self._units.append(unit)
        self._bytes += len(unit.data)
        if unit.key:
            keys = [kept.number for kept in self._units if kept.key]
            if len(keys) > 2:
                self._forget_before(keys[-2])
        while len(self._units) > MOST_UNITS or self._bytes > MOST_BYTES:
            self._forget_before(self._units[0].number + 1)

    def _forget_before(self, number: int) -> None:
        while self._units and self._units[0].number < number:
            self._bytes -= len(self._units.popleft().data)

    def _path_to(self, number: int) -> list[_Unit]:
        """Return the units to decode: from the decoder's position, or from a key frame."""
        held = [unit for unit in self._units if unit.number <= number]
        keys = [unit.number for unit in held if unit.key]
        if not held or held[-1].number != number:
            raise PixelFormatError("this H.264 image is no longer kept: newer key frames have replaced it")
        first = keys[-1] if keys else held[0].number
        if self._decoder is not None and first <= self._next <= number:
            return [unit for unit in held if unit.number >= self._next]
        if not keys:
            raise PixelFormatError("this H.264 image cannot be decoded: its key frame is no longer kept")
        self._decoder = _new_decoder()
        return [unit for unit in held if unit.number >= keys[-1]]

    def _decode_unit(self, unit: _Unit) -> NDArray[np.uint8] | None:
        import av

        self._next = unit.number + 1
        try:
            frames = self._decoder.decode(av.Packet(unit.data))
        except av.FFmpegError as error:
            self._decoder = None
            reason = "its data are damaged" if isinstance(error, av.InvalidDataError) else error
            raise PixelFormatError(f"the H.264 image cannot be decoded: {reason}") from error
        if not frames:
            return None
        image: NDArray[np.uint8] = frames[-1].to_ndarray(format="rgb24")
        return np.ascontiguousarray(image).reshape(-1)


def _new_decoder() -> Any:
    import av

    decoder = av.CodecContext.create("h264", "r")
    decoder.thread_count = 1  # each further thread would delay images by one
    decoder.flags |= 1 << 19  # low delay: images leave in the order of their arrival
    return decoder


def scan_h264(data: bytes) -> tuple[bool, tuple[int, int] | None]:
    """Return whether an access unit is a key frame, and its (width, height), or None if not stated."""
    size = None
    at = data.find(b"\0\0\1")
    while 0 <= at < len(data) - 4:
        kind = data[at + 3] & 0x1F
        if kind in (_SLICE, _KEY_SLICE):
            return kind == _KEY_SLICE, size
        after = data.find(b"\0\0\1", at + 3)
        if kind == _PARAMETERS:
            size = _frame_size(data[at + 4 : after if after > 0 else len(data)]) or size
        at = after
    return False, size


class _Bits:
    """Bits of a NAL unit, most significant first; zeros after the end."""

    def __init__(self, data: bytes) -> None:
        data = data[:256].replace(b"\0\0\3", b"\0\0")  # a parameter set is shorter; 7.4.1
        self._value = int.from_bytes(data, "big")
        self._left = 8 * len(data)

    def take(self, count: int = 1) -> int:
        self._left -= count
        return self._value >> self._left & (1 << count) - 1 if self._left >= 0 else 0

    def number(self) -> int:
        """Take an unsigned Exp-Golomb code (9.1)."""
        zeros = 0
        while not self.take():
            zeros += 1
            if zeros > 32:
                return 0
        return (1 << zeros) - 1 + self.take(zeros)

    def signed(self) -> int:
        """Take a signed Exp-Golomb code."""
        code = self.number()
        return (code + 1) // 2 if code & 1 else -(code // 2)


def _frame_size(parameters: bytes) -> tuple[int, int] | None:
    """Read (width, height) from a sequence parameter set (7.3.2.1.1); None if it is not plausible."""
    bits = _Bits(parameters)
    profile = bits.take(8)
    bits.take(16)
    bits.number()
    chroma = 1
    if profile in _WITH_CHROMA:
        chroma = bits.number()
        if chroma == 3:
            bits.take()
        bits.number()
        bits.number()
        bits.take()
        if bits.take():
            for index in range(8 if chroma != 3 else 12):
                if bits.take():
                    _skip_scaling_list(bits, 16 if index < 6 else 64)
    bits.number()
    order = bits.number()
    if order == 0:
        bits.number()
    elif order == 1:
        bits.take()
        bits.signed()
        bits.signed()
        for _ in range(min(bits.number(), 255)):
            bits.signed()
    bits.number()
    bits.take()
    width, units = 16 * (bits.number() + 1), bits.number() + 1
    frames_only = bits.take()
    height = 16 * units * (2 - frames_only)
    if not frames_only:
        bits.take()
    bits.take()
    if bits.take():
        left, right, top, bottom = (bits.number() for _ in range(4))
        across = 2 if chroma in (1, 2) else 1
        down = (2 if chroma == 1 else 1) * (2 - frames_only)
        width, height = width - across * (left + right), height - down * (top + bottom)
    sensible = 0 < width <= LARGEST_H264_SIDE and 0 < height <= LARGEST_H264_SIDE
    return (width, height) if sensible else None


def _skip_scaling_list(bits: _Bits, size: int) -> None:
    last = following = 8
    for _ in range(size):
        if following:
            following = (last + bits.signed()) % 256
        last = following or last
