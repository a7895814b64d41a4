"""Inner loops compiled by numba, where the extra `fast` is installed; without it nothing is lost but speed.

Importing numba and compiling takes seconds the first time on a machine (its results are kept on disk) and
about half a second later, so one thread does it when the first loop is asked for. Until then every function
here returns None and callers take their slower way, which gives the same values.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from typing import Any

from numpy.typing import NDArray

from grabbergui.core.pfnc import Layout

_log = logging.getLogger(__name__)

Unpacker = Callable[[NDArray[Any], NDArray[Any]], None]
"Packed bytes into samples: contiguous, four samples for each whole group of bytes."
YuvConverter = Callable[..., None]
"""Pairs of pixels, 4 bytes each, into 6 bytes R G B R G B, both contiguous and flat; then six numbers of the
matrix times 2¹⁴: luma, the constant with the half that rounds, V to red, U and V to green, U to blue."""


class _Kernels:
    """The loops, once they are compiled. Any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self.unpackers: dict[tuple[Layout, int, int], Unpacker] = {}
        self.yuv422: dict[str, YuvConverter] = {}
        self.disabled = False

    def request(self) -> threading.Thread:
        """Start to compile, unless that was done before."""
        with self._lock:
            if self._thread is None:
                self._thread = threading.Thread(target=self._compile, name="compile loops", daemon=True)
                self._thread.start()
            return self._thread

    def _compile(self) -> None:
        try:
            from grabbergui.core import compiled_loops
        except ImportError:
            _log.debug("numba is not installed; pixels are unpacked more slowly")
            return
        except Exception as error:
            _log.warning("numba could not compile the loops for pixels, which are slower now: %s", error)
            return
        self.unpackers = compiled_loops.UNPACKERS
        self.yuv422 = compiled_loops.YUV422


_kernels = _Kernels()


def unpacker(layout: Layout, depth: int, sample_bytes: int) -> Unpacker | None:
    """Return the loop for a packing, into uint16 values or (1 byte) their eight highest bits."""
    if _kernels.disabled:
        return None
    _kernels.request()
    return _kernels.unpackers.get((layout, depth, sample_bytes))


def yuv422(order: str) -> YuvConverter | None:
    """Return the loop that turns 8-bit YUV 4:2:2 of an order (`YUYV`, `UYVY`) into R G B by any matrix."""
    if _kernels.disabled:
        return None
    _kernels.request()
    return _kernels.yuv422.get(order)


def wait(timeout: float = 120.0) -> bool:
    """Wait until the loops are compiled; return whether there are any. For benchmarks and tests."""
    _kernels.request().join(timeout)
    return bool(_kernels.unpackers)


def disable(disabled: bool) -> None:
    """Do without compiled loops, or with them again. For benchmarks and tests."""
    _kernels.disabled = disabled
