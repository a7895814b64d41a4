"""Inner loops compiled by numba, where the extra `fast` is installed; without it nothing is lost but speed.

Importing numba and compiling takes seconds the first time on a machine (its results are kept on disk) and
about half a second later, so a thread does it when the first loop of a module is asked for. Until then there
are no loops, and callers take their slower way, which gives the same results.
"""

from __future__ import annotations

import importlib
import logging
import threading
from collections.abc import Callable
from types import ModuleType
from typing import Any

from numpy.typing import NDArray

from grabbergui.core.pfnc import Layout

_log = logging.getLogger(__name__)

Unpacker = Callable[[NDArray[Any], NDArray[Any]], None]
"Packed bytes into samples: contiguous, four samples for each whole group of bytes."
YuvConverter = Callable[..., None]
"""Pairs of pixels, 4 bytes each, into 6 bytes R G B R G B, both contiguous and flat; then six numbers of the
matrix times 2¹⁴: luma, the constant with the half that rounds, V to red, U and V to green, U to blue."""


class CompiledLoops:
    """A module that numba compiles while it is imported. Any thread."""

    def __init__(self, module: str) -> None:
        self._name = module
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self._module: ModuleType | None = None
        self.disabled = False
        "Set to do without, in benchmarks and tests."

    @property
    def module(self) -> ModuleType | None:
        """The module once it is compiled. Asking for it starts that."""
        if self.disabled:
            return None
        if self._module is None:
            self.request()
        return self._module

    def request(self) -> threading.Thread:
        """Start to compile, unless that was done before."""
        with self._lock:
            if self._thread is None:
                self._thread = threading.Thread(target=self._compile, name="compile loops", daemon=True)
                self._thread.start()
            return self._thread

    def wait(self, timeout: float = 120.0) -> bool:
        """Wait until the loops are compiled; return whether there are any. For benchmarks and tests."""
        self.request().join(timeout)
        return self._module is not None

    def _compile(self) -> None:
        try:
            self._module = importlib.import_module(self._name)
        except ImportError:
            _log.debug("numba is not installed; %s is done without", self._name)
        except Exception as error:
            _log.warning("numba could not compile %s, which is done without: %s", self._name, error)


_pixels = CompiledLoops("grabbergui.core.compiled_loops")


def unpacker(layout: Layout, depth: int, sample_bytes: int) -> Unpacker | None:
    """Return the loop for a packing, into uint16 values or (1 byte) their eight highest bits."""
    loops = _pixels.module
    found: Unpacker | None = loops.UNPACKERS.get((layout, depth, sample_bytes)) if loops else None
    return found


def yuv422(order: str) -> YuvConverter | None:
    """Return the loop that turns 8-bit YUV 4:2:2 of an order (`YUYV`, `UYVY`) into R G B by any matrix."""
    loops = _pixels.module
    found: YuvConverter | None = loops.YUV422.get(order) if loops else None
    return found


def wait(timeout: float = 120.0) -> bool:
    """Wait for the loops for pixels; return whether there are any. For benchmarks and tests."""
    return _pixels.wait(timeout)


def disable(disabled: bool) -> None:
    """Do without compiled loops for pixels, or with them again. For benchmarks and tests."""
    _pixels.disabled = disabled
