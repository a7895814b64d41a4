"""The simulated camera's look-up table.

It is the file LUTLuminance and, at the same time, LUTValueAll, LUTIndex and LUTValue.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.enumerations import File
from grabbergui.driver.sim.file_store import LUT_ENTRIES, LUT_INPUT_BITS, FileStore
from grabbergui.driver.sim.memory import RegisterMemory, RegisterValue


class LookUpTable:
    """The table's registers over a buffer, big-endian; the file has the same values, little-endian.

    The caller holds the camera's lock.
    """

    def __init__(self, memory: RegisterMemory, store: FileStore) -> None:
        self._memory = memory
        self._store = store
        self._buffer = memory.add_buffer(*reg.LUT_VALUE_ALL)
        memory.on_read(reg.LUT_VALUE, self._value)
        memory.on_check(reg.LUT_VALUE, self._set_value)
        self.load()

    def load(self) -> None:
        """Take over the file; one that has no whole table means that values pass unchanged."""
        content = self._store.content(File.LUT_LUMINANCE)
        table = np.arange(LUT_ENTRIES, dtype="<u2") * 16
        if len(content) == table.nbytes:
            table = np.frombuffer(content, "<u2")
        self._loaded = table.astype(">u2").tobytes()
        self._buffer[:] = self._loaded

    def save(self) -> None:
        """Bring the file up to date if the registers were written."""
        present = bytes(self._buffer)
        if present != self._loaded:
            self._store.replace(File.LUT_LUMINANCE, np.frombuffer(present, ">u2").astype("<u2").tobytes())
            self._loaded = present

    def _place(self) -> slice:
        index = self._memory.integer(reg.LUT_INDEX)
        return slice(2 * index, 2 * index + 2)

    def _value(self) -> RegisterValue:
        return int.from_bytes(self._buffer[self._place()], "big")

    def _set_value(self, value: RegisterValue) -> RegisterValue:
        self._buffer[self._place()] = int(value).to_bytes(2, "big")
        return value


def look_up(values: NDArray[Any], depth: int, table: bytes) -> None:
    """Replace values of `depth` bits (8 to 16, uint8 or uint16) in place by those of a table."""
    values[...] = _by_value(depth, table)[values]


@lru_cache(maxsize=4)
def _by_value(depth: int, table: bytes) -> NDArray[Any]:
    places = np.arange(1 << depth)
    places = places << LUT_INPUT_BITS - depth if depth <= LUT_INPUT_BITS else places >> depth - LUT_INPUT_BITS
    if depth < LUT_INPUT_BITS:
        places |= (1 << LUT_INPUT_BITS - depth) - 1  # the brightest value is the last entry
    found = np.frombuffer(table, ">u2")[places].astype(np.uint16) >> 16 - depth
    return found.astype(np.uint8 if depth == 8 else np.uint16)
