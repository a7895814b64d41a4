"""Payload bytes to arrays of whole lines (PFNC 2.x, sections on pixel packing).

Packed formats are unpacked four pixels at a time in 64-bit words: each step keeps some bits with a mask,
shifts them, and joins the parts, so that every step is one pass of numpy over a block that fits the cache.
"""

from __future__ import annotations

import sys
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.errors import PixelFormatError
from grabbergui.core.pfnc import Layout, PixelFormat


class SensorPicture(Protocol):
    """What must be known of a payload to lay out its pixels; a `Frame` is one and documents the fields."""

    payload: NDArray[np.uint8]
    width: int
    height: int
    pixel_format: PixelFormat
    padding_x: int
    big_endian: bool


_Part = tuple[int, int]
"Mask of the bits to keep, and how far they move to the left."

_STEPS: dict[tuple[Layout, int], tuple[tuple[_Part, ...], ...]] = {
    (Layout.PACKED_LSB, 10): (
        ((0x00_000F_FFFF, 0), (0xFF_FFF0_0000, 12)),
        ((0x0000_03FF_0000_03FF, 0), (0x000F_FC00_000F_FC00, 6)),
    ),
    (Layout.PACKED_LSB, 12): (
        ((0x0000_00FF_FFFF, 0), (0xFFFF_FF00_0000, 8)),
        ((0x0000_0FFF_0000_0FFF, 0), (0x00FF_F000_00FF_F000, 4)),
    ),
    (Layout.PACKED_GIGE, 10): (
        ((0x0000_00FF_FFFF, 0), (0xFFFF_FF00_0000, 8)),
        ((0x00FF_00FF_00FF_00FF, 2), (0x0000_0300_0000_0300, -8), (0x0000_3000_0000_3000, 4)),
    ),
    (Layout.PACKED_GIGE, 12): (
        ((0x0000_00FF_FFFF, 0), (0xFFFF_FF00_0000, 8)),
        ((0x00FF_F0FF_00FF_F0FF, 4), (0x0000_0F00_0000_0F00, -8)),
    ),
}
"""How four packed pixels become four of 16 bits: two into each half of the word, one into each quarter."""

_PIXELS_PER_WORD = 4
_BLOCK = 16384
"""Words handled at once: 128 KiB, so that the steps between them stay in the processor's cache."""


def packed(pixel_format: PixelFormat) -> bool:
    """Whether pixels do not begin on bytes, so that reading them means copying."""
    return pixel_format.layout in (Layout.PACKED_LSB, Layout.PACKED_GIGE)


def check(frame: SensorPicture) -> None:
    """Raise PixelFormatError unless the payload holds a picture that can be laid out."""
    pixel_format, size = frame.pixel_format, f"{frame.width}×{frame.height}"
    if not pixel_format.convertible:
        code = f" (0x{pixel_format.code:08X})" if not pixel_format.name.startswith("0x") else ""
        raise PixelFormatError(
            f"pixel format {pixel_format.name}{code} cannot be shown; the raw bytes can still be saved, "
            f"or choose another PixelFormat such as Mono8"
        )
    if frame.width < 1 or frame.height < 1 or frame.padding_x < 0:
        raise PixelFormatError(f"a picture of {size} pixels with {frame.padding_x} bytes of padding is empty")
    if packed(pixel_format) and not frame.padding_x:
        needed = pixel_format.image_bytes(frame.width, frame.height)
    else:
        line = pixel_format.line_bytes(frame.width)
        needed = (frame.height - 1) * (line + frame.padding_x) + line
    if frame.payload.size < needed:
        raise PixelFormatError(
            f"a {pixel_format.name} picture of {size} needs {needed} bytes, the payload has "
            f"{frame.payload.size}; the raw bytes can still be saved"
        )


def lines(frame: SensorPicture, first: int = 0, last: int | None = None) -> NDArray[Any]:
    """Lines `first` up to, but without, `last` as the sensor gave them.

    Shape (lines, width) uint8 or native uint16 with the value in the low bits; (lines, width, n) uint8 for
    interleaved components, in memory order. A view of the payload where its bytes can be used as they are:
    pixels packed, big-endian, or 16-bit at an odd address are copied. Raises PixelFormatError.
    """
    check(frame)
    last = frame.height if last is None else last
    payload = np.ascontiguousarray(frame.payload)
    if not packed(frame.pixel_format):
        return _whole_lines(frame, payload, first, last)
    if frame.padding_x:
        return _padded_packed_lines(frame, payload, first, last)
    # The bit stream goes on over the ends of lines, so a line may begin in the middle of a word.
    begin, end = first * frame.width, last * frame.width
    word = begin // _PIXELS_PER_WORD
    data = payload[word * _bytes_per_word(frame.pixel_format) :]
    skipped = begin - word * _PIXELS_PER_WORD
    pixels = _unpack(data, frame.pixel_format, end - begin + skipped)
    return pixels[skipped:].reshape(last - first, frame.width)


def value_at(frame: SensorPicture, x: int, y: int) -> tuple[int, ...]:
    """The components of one pixel in memory order, read from its own few bytes. Raises PixelFormatError."""
    check(frame)
    pixel_format, payload = frame.pixel_format, frame.payload
    bits = pixel_format.bits_per_pixel
    if not packed(pixel_format):
        offset = y * (pixel_format.line_bytes(frame.width) + frame.padding_x) + x * bits // 8
        if pixel_format.depth > 8:
            pair = payload[offset : offset + 2].tobytes()
            return (int.from_bytes(pair, "big" if frame.big_endian else "little"),)
        return tuple(payload[offset : offset + pixel_format.components].tolist())
    line_bits = 8 * (pixel_format.line_bytes(frame.width) + frame.padding_x) if frame.padding_x else 0
    start, index = (y * line_bits, x) if line_bits else (0, y * frame.width + x)
    if pixel_format.layout is Layout.PACKED_LSB:
        first_bit = start + index * bits
        stream = int.from_bytes(payload[first_bit // 8 : (first_bit + bits + 7) // 8].tobytes(), "little")
        return (stream >> first_bit % 8 & (1 << bits) - 1,)
    pair_offset = start // 8 + index // 2 * 3
    high, low_bits = int(payload[pair_offset + index % 2 * 2]), pixel_format.depth - 8
    shared = int(payload[pair_offset + 1]) >> index % 2 * 4
    return (high << low_bits | shared & (1 << low_bits) - 1,)


def _whole_lines(frame: SensorPicture, payload: NDArray[np.uint8], first: int, last: int) -> NDArray[Any]:
    pixel_format = frame.pixel_format
    item = 2 if pixel_format.depth > 8 else 1
    dtype = np.dtype(f"{'>' if frame.big_endian else '<'}u{item}")
    stride = pixel_format.line_bytes(frame.width) + frame.padding_x
    shape: tuple[int, ...] = (last - first, frame.width)
    strides: tuple[int, ...] = (stride, item * pixel_format.components)
    if pixel_format.components > 1:
        shape, strides = (*shape, pixel_format.components), (*strides, item)
    array: NDArray[Any] = np.ndarray(shape, dtype, payload, first * stride, strides)
    native = dtype.newbyteorder("=")
    return array if array.flags.aligned and dtype == native else array.astype(native)


def _padded_packed_lines(
    frame: SensorPicture, payload: NDArray[np.uint8], first: int, last: int
) -> NDArray[Any]:
    """Each line begins on a byte of its own: stretch it to whole words, unpack, and cut it off."""
    line = frame.pixel_format.line_bytes(frame.width)
    stride = line + frame.padding_x
    words = -(-frame.width // _PIXELS_PER_WORD)
    data = np.zeros((last - first, words * _bytes_per_word(frame.pixel_format)), np.uint8)
    data[:, :line] = np.ndarray((last - first, line), np.uint8, payload, first * stride, (stride, 1))
    pixels = _unpack(data.reshape(-1), frame.pixel_format, data.shape[0] * words * _PIXELS_PER_WORD)
    return np.ascontiguousarray(pixels.reshape(last - first, -1)[:, : frame.width])


def _bytes_per_word(pixel_format: PixelFormat) -> int:
    return pixel_format.bits_per_pixel * _PIXELS_PER_WORD // 8


def _unpack(data: NDArray[np.uint8], pixel_format: PixelFormat, count: int) -> NDArray[np.uint16]:
    """The first `count` pixels of contiguous packed bytes."""
    steps = _STEPS[pixel_format.layout, pixel_format.depth]
    words = _words(data, _bytes_per_word(pixel_format), -(-count // _PIXELS_PER_WORD))
    moved, joined = np.empty(_BLOCK, "<u8"), np.empty(_BLOCK, "<u8")
    for start in range(0, words.size, _BLOCK):
        block = words[start : start + _BLOCK]
        for parts in steps:
            _rearrange(block, parts, joined[: block.size], moved[: block.size])
    pixels: NDArray[np.uint16] = words.view("<u2")[:count]
    return pixels if sys.byteorder == "little" else pixels.astype(np.uint16)


def _rearrange(
    block: NDArray[np.uint64],
    parts: tuple[_Part, ...],
    joined: NDArray[np.uint64],
    moved: NDArray[np.uint64],
) -> None:
    """Replace each word by its parts, moved; `joined` and `moved` are scratch of the block's size."""
    joined[:] = 0
    for mask, left in parts:
        np.bitwise_and(block, np.uint64(mask), out=moved)
        if left:
            shift = np.left_shift if left > 0 else np.right_shift
            shift(moved, np.uint64(abs(left)), out=moved)
        np.bitwise_or(joined, moved, out=joined)
    block[:] = joined


def _words(data: NDArray[np.uint8], step: int, count: int) -> NDArray[np.uint64]:
    """`count` little-endian words, one from every `step` bytes, each with bytes of the next in its top."""
    words = np.zeros(count, "<u8")
    whole = max(0, min(count, (data.size - 8) // step + 1))
    if whole:
        words[:whole] = np.ndarray((whole,), "<u8", data, 0, (step,))
    for index in range(whole, count):
        words[index] = int.from_bytes(data[index * step : (index + 1) * step].tobytes(), "little")
    return words
