"""Preallocated payload buffers that come back by themselves.

A frame's array lies in a pooled buffer. When the last array that looks into it is gone, wherever that was
and on whatever thread, the buffer returns to its pool: consumers keep a frame as long as they like and
nobody releases anything by hand.
"""

from __future__ import annotations

import ctypes
import threading
import weakref
from collections import deque
from typing import Any

import numpy as np
from numpy.typing import NDArray

MEMORY = 512 << 20
"""Default limit of the memory for one stream's buffers, in bytes."""
FEWEST, MOST = 8, 1024
"""Buffers, however large or small they are."""


class BufferPool:
    """Buffers of one size for one stream. Thread-safe.

    Page faults make a fresh 8 MB buffer cost more than filling it, so buffers are reused; memory stays
    bounded because `take` gives nothing beyond `limit` buffers in use.
    """

    def __init__(self, size: int, limit: int | None = None) -> None:
        """`limit`: as many as `MEMORY` holds where it is None."""
        self.size = size
        "Bytes of each buffer."
        self.limit = limit or min(max(MEMORY // max(size, 1), FEWEST), MOST)
        "How many may be in use at once."
        self._free: deque[bytearray] = deque()
        self._in_use = 0
        # Reentrant: a garbage collection inside `take` may run a finaliser, which calls `_give_back`.
        self._lock = threading.RLock()

    @property
    def in_use(self) -> int:
        """Buffers that somebody still looks into."""
        return self._in_use

    def take(self) -> NDArray[np.uint8] | None:
        """A writable array of `size` bytes with undefined content; None when all are in use, or memory is."""
        with self._lock:
            if self._in_use >= self.limit:
                return None
            try:
                storage = self._free.pop() if self._free else bytearray(self.size)
            except MemoryError:
                return None  # a frame is lost; the thread that receives must go on
            self._in_use += 1
        # numpy collapses chains of array bases, but not this object: it lives as long as any view.
        lease: Any = (ctypes.c_ubyte * self.size).from_buffer(storage)
        weakref.finalize(lease, self._give_back, storage).atexit = False
        array: NDArray[np.uint8] = np.frombuffer(lease, np.uint8)
        return array

    def _give_back(self, storage: bytearray) -> None:
        with self._lock:
            self._in_use -= 1
            self._free.append(storage)
