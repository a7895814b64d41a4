"""Inner loops over pixels that numba compiles: unpacking of samples (PFNC), and YUV 4:2:2 to R G B.

Importing numba (the extra `fast`) and compiling takes seconds the first time on a computer (the results are
cached on disk) and about half a second later, so a thread does it when the first loop is requested.

The loops work byte by byte, which LLVM turns into vector instructions; joining bytes to words first is
several times slower.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.pfnc import SampleLayout

_log = logging.getLogger(__name__)

Unpacker = Callable[[NDArray[Any], NDArray[Any]], None]
"Unpacks contiguous bytes into samples, four for each whole group of bytes."
YuvConverter = Callable[..., None]
"""Converts pairs of pixels, 4 bytes each, into 6 bytes R G B R G B; both arrays are contiguous and flat. The
other arguments are factors times 2¹⁴: luma, the constant plus one half, V to red, U and V to green, U to
blue."""

_Maker = Callable[..., Any]
_Array = np.ndarray[Any, np.dtype[Any]]


class _Kernels:
    """The compiled loops. Any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self.unpackers: dict[tuple[SampleLayout, int, int], Unpacker] = {}
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


def unpacker(layout: SampleLayout, depth: int, sample_bytes: int) -> Unpacker | None:
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


def _compiled_loops() -> tuple[dict[tuple[SampleLayout, int, int], Unpacker], dict[str, YuvConverter]]:
    """Compile all loops. Raises ImportError without numba, and numba's own errors."""
    import numba

    data = numba.types.Array(numba.types.uint8, 1, "C", readonly=True)
    bytes_out, words_out = numba.uint8[::1], numba.uint16[::1]

    def compiled(loop: Any, *rest: Any) -> Any:
        return numba.njit([numba.void(data, *rest)], nogil=True, cache=True)(loop)

    unpackers = {
        (layout, depth, size): compiled(cast(_Maker, make)(*arguments, depth - 8 if size == 1 else 0), out)
        for layout, depth, make, arguments in (
            (SampleLayout.PACKED_LSB, 10, _unpacker_10p, ()),
            (SampleLayout.PACKED_LSB, 12, _unpacker_12p, ()),
            (SampleLayout.PACKED_LSB, 14, _unpacker_14p, ()),
            (SampleLayout.PACKED_GIGE, 10, _unpacker_gige, (2,)),
            (SampleLayout.PACKED_GIGE, 12, _unpacker_gige, (4,)),
        )
        for size, out in ((1, bytes_out), (2, words_out))
    }
    matrix = (numba.int32,) * 6
    return unpackers, {
        "YUYV": compiled(_yuv422(0, 1, 2, 3), bytes_out, *matrix),
        "UYVY": compiled(_yuv422(1, 0, 3, 2), bytes_out, *matrix),
    }
