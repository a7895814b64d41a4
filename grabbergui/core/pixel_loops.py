"""Inner loops over pixels: unpack samples into whole bytes (PFNC, pixel packing), and YUV 4:2:2 to R G B.

If the extra `fast` is installed, numba compiles them. Importing numba and compiling takes seconds the first
time on a computer (the results are cached on disk) and about half a second later, so a thread does it when
the first loop is requested. Until then, and without numba, a slower implementation returns the same values:
it unpacks four samples at a time in 64-bit words. Each step masks some bits, shifts them and joins the parts,
so that every step is one pass of numpy over a block that fits the cache.

The compiled loops work byte by byte, which LLVM turns into vector instructions; joining bytes to words first
is several times slower.
"""

from __future__ import annotations

import logging
import sys
import threading
from collections.abc import Callable
from functools import cache
from typing import Any, cast

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core.pfnc import Layout

_log = logging.getLogger(__name__)

# -- unpacking -----------------------------------------------------------------------------------
Unpacker = Callable[[NDArray[Any], NDArray[Any]], None]
"Unpacks contiguous bytes into samples, four for each whole group of bytes."
YuvConverter = Callable[..., None]
"""Converts pairs of pixels, 4 bytes each, into 6 bytes R G B R G B; both arrays are contiguous and flat. The
other arguments are factors times 2¹⁴: luma, the constant plus one half, V to red, U and V to green, U to
blue."""

_Part = tuple[int, int]
"Mask of the bits to keep, and their shift to the left."

_STEPS: dict[tuple[Layout, int], tuple[tuple[_Part, ...], ...]] = {
    (Layout.PACKED_LSB, 10): (
        ((0x00_000F_FFFF, 0), (0xFF_FFF0_0000, 12)),
        ((0x0000_03FF_0000_03FF, 0), (0x000F_FC00_000F_FC00, 6)),
    ),
    (Layout.PACKED_LSB, 12): (
        ((0x0000_00FF_FFFF, 0), (0xFFFF_FF00_0000, 8)),
        ((0x0000_0FFF_0000_0FFF, 0), (0x00FF_F000_00FF_F000, 4)),
    ),
    (Layout.PACKED_LSB, 14): (
        ((0x0000_0FFF_FFFF, 0), (0xFF_FFFF_F000_0000, 4)),
        ((0x0000_3FFF_0000_3FFF, 0), (0x0FFF_C000_0FFF_C000, 2)),
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
"""How four packed samples become four of 16 bits: two into each half of the word, one into each quarter."""

_SAMPLES_PER_WORD = 4
_BLOCK = 16384
"""Words in a block: 128 KiB, so that intermediate results stay in the processor's cache."""


def packed_bits(layout: Layout, depth: int) -> int:
    """Return the average size of a sample in the payload, in bits."""
    return 12 if layout is Layout.PACKED_GIGE else depth


def samples_per_group(layout: Layout, depth: int) -> int:
    """Return the number of samples in a group that begins and ends on a byte."""
    return _SAMPLES_PER_WORD if depth > 8 else 8 // depth


def bytes_per_group(layout: Layout, depth: int) -> int:
    """Return the size of such a group in bytes."""
    return samples_per_group(layout, depth) * packed_bits(layout, depth) // 8


def unpack(data: NDArray[np.uint8], layout: Layout, depth: int, count: int) -> NDArray[Any]:
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


def unpack_high(data: NDArray[np.uint8], layout: Layout, depth: int, count: int) -> NDArray[np.uint8]:
    """Return the eight highest bits, for display, of the first `count` samples of 10 to 14 bits."""
    samples = np.empty(count, np.uint8)
    done = _compiled(data, layout, depth, samples)
    if done < count:
        rest = _unpack_words(_from(data, layout, depth, done), layout, depth, count - done)
        samples[done:] = rest >> (depth - 8)
    return samples


def _compiled(data: NDArray[np.uint8], layout: Layout, depth: int, samples: NDArray[Any]) -> int:
    """Unpack whole groups with a compiled loop, if there is one; return the number of samples done."""
    kernel = _unpacker(layout, depth, samples.dtype.itemsize)
    if kernel is None:
        return 0
    groups = min(samples.size // _SAMPLES_PER_WORD, data.size // bytes_per_group(layout, depth))
    kernel(data, samples[: groups * _SAMPLES_PER_WORD])
    return groups * _SAMPLES_PER_WORD


def _from(data: NDArray[np.uint8], layout: Layout, depth: int, first: int) -> NDArray[np.uint8]:
    return data[first // _SAMPLES_PER_WORD * bytes_per_group(layout, depth) :]


@cache
def _table(depth: int) -> NDArray[Any]:
    """Return a table from a byte to its samples, the lowest bits first, joined to one word for cv2.LUT."""
    shifts = np.arange(0, 8, depth, dtype=np.uint8)
    values: NDArray[np.uint8] = (np.arange(256, dtype=np.uint8)[:, None] >> shifts) & np.uint8(
        (1 << depth) - 1
    )
    return values.view({1: np.float64, 2: np.int32, 4: np.uint16}[depth]).reshape(-1)


def _unpack_words(data: NDArray[np.uint8], layout: Layout, depth: int, count: int) -> NDArray[np.uint16]:
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


# -- compiling -----------------------------------------------------------------------------------
class _Kernels:
    """The compiled loops. Any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self.unpackers: dict[tuple[Layout, int, int], Unpacker] = {}
        self.yuv422: dict[str, YuvConverter] = {}
        self.disabled = False

    def request(self) -> threading.Thread:
        """Start compiling on the first call; return the thread."""
        with self._lock:
            if self._thread is None:
                self._thread = threading.Thread(target=self._compile, name="compile loops", daemon=True)
                self._thread.start()
            return self._thread

    def _compile(self) -> None:
        try:
            self.unpackers, self.yuv422 = _compiled_loops()
        except ImportError:
            _log.debug("numba is not installed; pixels are unpacked more slowly")
        except Exception as error:
            _log.warning("numba could not compile the loops for pixels, so slower ones are used: %s", error)


_kernels = _Kernels()


def _unpacker(layout: Layout, depth: int, sample_bytes: int) -> Unpacker | None:
    """Return the loop for a packing, to uint16 values or, for 1 byte, their eight highest bits."""
    if _kernels.disabled:
        return None
    _kernels.request()
    return _kernels.unpackers.get((layout, depth, sample_bytes))


def yuv422(order: str) -> YuvConverter | None:
    """Return the loop that converts 8-bit YUV 4:2:2 of an order (`YUYV`, `UYVY`) to R G B, if compiled."""
    if _kernels.disabled:
        return None
    _kernels.request()
    return _kernels.yuv422.get(order)


def wait(timeout: float = 120.0) -> bool:
    """Wait until the loops are compiled; return whether there are any. For benchmarks and tests."""
    _kernels.request().join(timeout)
    return bool(_kernels.unpackers)


def disable(disabled: bool) -> None:
    """Disable the compiled loops, or enable them again. For benchmarks and tests."""
    _kernels.disabled = disabled


# -- the loops that numba compiles ---------------------------------------------------------------
_Maker = Callable[..., Any]
_Array = np.ndarray[Any, np.dtype[Any]]


def _unpacker_10p(drop: int) -> Any:
    def loop(data: _Array, out: _Array) -> None:
        for i in range(out.size // 4):
            a, b, c, d, e = data[5 * i], data[5 * i + 1], data[5 * i + 2], data[5 * i + 3], data[5 * i + 4]
            out[4 * i] = (a | (np.uint16(b) & 3) << 8) >> drop
            out[4 * i + 1] = (b >> 2 | (np.uint16(c) & 15) << 6) >> drop
            out[4 * i + 2] = (c >> 4 | (np.uint16(d) & 63) << 4) >> drop
            out[4 * i + 3] = (d >> 6 | np.uint16(e) << 2) >> drop

    return loop


def _unpacker_12p(drop: int) -> Any:
    def loop(data: _Array, out: _Array) -> None:
        for i in range(out.size // 2):
            a, b, c = data[3 * i], data[3 * i + 1], data[3 * i + 2]
            out[2 * i] = (a | (np.uint16(b) & 15) << 8) >> drop
            out[2 * i + 1] = (b >> 4 | np.uint16(c) << 4) >> drop

    return loop


def _unpacker_14p(drop: int) -> Any:
    def loop(data: _Array, out: _Array) -> None:
        for i in range(out.size // 4):
            a, b, c, d = data[7 * i], data[7 * i + 1], data[7 * i + 2], data[7 * i + 3]
            e, f, g = data[7 * i + 4], data[7 * i + 5], data[7 * i + 6]
            out[4 * i] = (a | (np.uint16(b) & 63) << 8) >> drop
            out[4 * i + 1] = (b >> 6 | np.uint16(c) << 2 | (np.uint16(d) & 15) << 10) >> drop
            out[4 * i + 2] = (d >> 4 | np.uint16(e) << 4 | (np.uint16(f) & 3) << 12) >> drop
            out[4 * i + 3] = (f >> 2 | np.uint16(g) << 6) >> drop

    return loop


def _unpacker_gige(low: int, drop: int) -> Any:
    """Make a loop for samples with `low` bits in the byte that two of them share.

    All values are cast to 16 bits first, as LLVM's code for mixed widths is slower by half.
    """
    mask = (1 << low) - 1

    def loop(data: _Array, out: _Array) -> None:
        for i in range(out.size // 2):
            a, b, c = np.uint16(data[3 * i]), np.uint16(data[3 * i + 1]), np.uint16(data[3 * i + 2])
            out[2 * i] = np.uint16(np.uint16(a << low) | np.uint16(b & mask)) >> drop
            out[2 * i + 1] = np.uint16(np.uint16(c << low) | np.uint16(b >> 4 & mask)) >> drop

    return loop


def _yuv422(y0: int, u: int, y1: int, v: int) -> Any:
    """Make a loop for pairs of pixels with luma and chroma at these positions in their four bytes."""

    def loop(
        data: _Array, out: _Array, luma: Any, black: Any, red_v: Any, green_u: Any, green_v: Any, blue_u: Any
    ) -> None:
        for i in range(data.size // 4):
            first = luma * np.int32(data[4 * i + y0]) + black
            second = luma * np.int32(data[4 * i + y1]) + black
            blue, red = np.int32(data[4 * i + u]) - 128, np.int32(data[4 * i + v]) - 128
            to_red, to_green, to_blue = red_v * red, green_u * blue + green_v * red, blue_u * blue
            out[6 * i] = max(0, min(255, first + to_red >> 14))
            out[6 * i + 1] = max(0, min(255, first + to_green >> 14))
            out[6 * i + 2] = max(0, min(255, first + to_blue >> 14))
            out[6 * i + 3] = max(0, min(255, second + to_red >> 14))
            out[6 * i + 4] = max(0, min(255, second + to_green >> 14))
            out[6 * i + 5] = max(0, min(255, second + to_blue >> 14))

    return loop


def _compiled_loops() -> tuple[dict[tuple[Layout, int, int], Unpacker], dict[str, YuvConverter]]:
    """Compile all loops. Raises ImportError without numba, and numba's own errors."""
    import numba

    data = numba.types.Array(numba.types.uint8, 1, "C", readonly=True)
    bytes_out, words_out = numba.uint8[::1], numba.uint16[::1]

    def compiled(loop: Any, *rest: Any) -> Any:
        return numba.njit([numba.void(data, *rest)], nogil=True, cache=True)(loop)

    unpackers = {
        (layout, depth, size): compiled(cast(_Maker, make)(*arguments, depth - 8 if size == 1 else 0), out)
        for layout, depth, make, arguments in (
            (Layout.PACKED_LSB, 10, _unpacker_10p, ()),
            (Layout.PACKED_LSB, 12, _unpacker_12p, ()),
            (Layout.PACKED_LSB, 14, _unpacker_14p, ()),
            (Layout.PACKED_GIGE, 10, _unpacker_gige, (2,)),
            (Layout.PACKED_GIGE, 12, _unpacker_gige, (4,)),
        )
        for size, out in ((1, bytes_out), (2, words_out))
    }
    matrix = (numba.int32,) * 6
    return unpackers, {
        "YUYV": compiled(_yuv422(0, 1, 2, 3), bytes_out, *matrix),
        "UYVY": compiled(_yuv422(1, 0, 3, 2), bytes_out, *matrix),
    }
