"""Unpacks samples into whole bytes (PFNC, pixel packing).

A loop that numba compiled does it, if there is one (`compiled_loops`). Until then, and without numba, numpy
unpacks four samples at a time in 64-bit words and returns the same values. Each step masks some bits, shifts
them and joins the parts, so that every step is one pass of numpy over a block that fits the cache.
"""

from __future__ import annotations

import sys
from functools import cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core.compiled_loops import unpacker
from grabbergui.core.pfnc import SampleLayout

_Part = tuple[int, int]
"Mask of the bits to keep, and their shift to the left."

_STEPS: dict[tuple[SampleLayout, int], tuple[tuple[_Part, ...], ...]] = {
    (SampleLayout.PACKED_LSB, 10): (
        ((0x00_000F_FFFF, 0), (0xFF_FFF0_0000, 12)),
        ((0x0000_03FF_0000_03FF, 0), (0x000F_FC00_000F_FC00, 6)),
    ),
    (SampleLayout.PACKED_LSB, 12): (
        ((0x0000_00FF_FFFF, 0), (0xFFFF_FF00_0000, 8)),
        ((0x0000_0FFF_0000_0FFF, 0), (0x00FF_F000_00FF_F000, 4)),
    ),
    (SampleLayout.PACKED_LSB, 14): (
        ((0x0000_0FFF_FFFF, 0), (0xFF_FFFF_F000_0000, 4)),
        ((0x0000_3FFF_0000_3FFF, 0), (0x0FFF_C000_0FFF_C000, 2)),
    ),
    (SampleLayout.PACKED_GIGE, 10): (
        ((0x0000_00FF_FFFF, 0), (0xFFFF_FF00_0000, 8)),
        ((0x00FF_00FF_00FF_00FF, 2), (0x0000_0300_0000_0300, -8), (0x0000_3000_0000_3000, 4)),
    ),
    (SampleLayout.PACKED_GIGE, 12): (
        ((0x0000_00FF_FFFF, 0), (0xFFFF_FF00_0000, 8)),
        ((0x00FF_F0FF_00FF_F0FF, 4), (0x0000_0F00_0000_0F00, -8)),
    ),
}
"""How four packed samples become four of 16 bits: two into each half of the word, one into each quarter."""

_SAMPLES_PER_WORD = 4
_BLOCK = 16384
"""Words in a block: 128 KiB, so that intermediate results stay in the processor's cache."""


def packed_bits(layout: SampleLayout, depth: int) -> int:
    """Return the average size of a sample in the payload, in bits."""
    return 12 if layout is SampleLayout.PACKED_GIGE else depth


def samples_per_group(layout: SampleLayout, depth: int) -> int:
    """Return the number of samples in a group that begins and ends on a byte."""
    return _SAMPLES_PER_WORD if depth > 8 else 8 // depth


def bytes_per_group(layout: SampleLayout, depth: int) -> int:
    """Return the size of such a group in bytes."""
    return samples_per_group(layout, depth) * packed_bits(layout, depth) // 8


def unpack(data: NDArray[np.uint8], layout: SampleLayout, depth: int, count: int) -> NDArray[Any]:
    """Return the first `count` samples of contiguous bytes: uint8 up to 8 bits, else native uint16."""
    if depth < 8:
        groups = -(-count // (8 // depth))
        words = cv2.LUT(np.ascontiguousarray(data[:groups]), _table(depth))
        return words.view(np.uint8).reshape(-1)[:count]
    samples = np.empty(count, np.uint16)
    done = _compiled(data, layout, depth, samples)
    if done < count:
        samples[done:] = _unpack_words(_from(data, layout, depth, done), layout, depth, count - done)
    return samples


def unpack_high(data: NDArray[np.uint8], layout: SampleLayout, depth: int, count: int) -> NDArray[np.uint8]:
    """Return the eight highest bits, for display, of the first `count` samples of 10 to 14 bits."""
    samples = np.empty(count, np.uint8)
    done = _compiled(data, layout, depth, samples)
    if done < count:
        rest = _unpack_words(_from(data, layout, depth, done), layout, depth, count - done)
        samples[done:] = rest >> (depth - 8)
    return samples


def _compiled(data: NDArray[np.uint8], layout: SampleLayout, depth: int, samples: NDArray[Any]) -> int:
    """Unpack whole groups with a compiled loop, if there is one; return the number of samples done."""
    kernel = unpacker(layout, depth, samples.dtype.itemsize)
    if kernel is None:
        return 0
    groups = min(samples.size // _SAMPLES_PER_WORD, data.size // bytes_per_group(layout, depth))
    kernel(data, samples[: groups * _SAMPLES_PER_WORD])
    return groups * _SAMPLES_PER_WORD


def _from(data: NDArray[np.uint8], layout: SampleLayout, depth: int, first: int) -> NDArray[np.uint8]:
    return data[first // _SAMPLES_PER_WORD * bytes_per_group(layout, depth) :]


@cache
def _table(depth: int) -> NDArray[Any]:
    """Return a table from a byte to its samples, the lowest bits first, joined to one word for cv2.LUT."""
    shifts = np.arange(0, 8, depth, dtype=np.uint8)
    values: NDArray[np.uint8] = (np.arange(256, dtype=np.uint8)[:, None] >> shifts) & np.uint8(
        (1 << depth) - 1
    )
    return values.view({1: np.float64, 2: np.int32, 4: np.uint16}[depth]).reshape(-1)


def _unpack_words(
    data: NDArray[np.uint8], layout: SampleLayout, depth: int, count: int
) -> NDArray[np.uint16]:
    steps = _STEPS[layout, depth]
    words = _words(data, bytes_per_group(layout, depth), -(-count // _SAMPLES_PER_WORD))
    joined, moved = np.empty(_BLOCK, "<u8"), np.empty(_BLOCK, "<u8")
    for start in range(0, words.size, _BLOCK):
        block = words[start : start + _BLOCK]
        for parts in steps:
            _rearrange(block, parts, joined[: block.size], moved[: block.size])
    samples: NDArray[np.uint16] = words.view("<u2")[:count]
    return samples if sys.byteorder == "little" else samples.astype(np.uint16)


def _rearrange(
    block: NDArray[np.uint64],
    parts: tuple[_Part, ...],
    joined: NDArray[np.uint64],
    moved: NDArray[np.uint64],
) -> None:
    """Replace each word by its shifted parts; `joined` and `moved` are scratch arrays of the block's size."""
    _extract(block, parts[0], joined)
    for part in parts[1:-1]:
        _extract(block, part, moved)
        np.bitwise_or(joined, moved, out=joined)
    _extract(block, parts[-1], moved)
    np.bitwise_or(joined, moved, out=block)


def _extract(block: NDArray[np.uint64], part: _Part, out: NDArray[np.uint64]) -> None:
    mask, left = part
    np.bitwise_and(block, np.uint64(mask), out=out)
    if left:
        shift = np.left_shift if left > 0 else np.right_shift
        shift(out, np.uint64(abs(left)), out=out)


def _words(data: NDArray[np.uint8], step: int, count: int) -> NDArray[np.uint64]:
    """Return `count` little-endian words, one from every `step` bytes; bytes of the next fill their tops."""
    words = np.zeros(count, "<u8")
    whole = max(0, min(count, (data.size - 8) // step + 1))
    if whole:
        words[:whole] = np.ndarray((whole,), "<u8", data, 0, (step,))
    for index in range(whole, count):
        words[index] = int.from_bytes(data[index * step : (index + 1) * step].tobytes(), "little")
    return words
