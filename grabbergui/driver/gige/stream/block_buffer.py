"""The memory of one block: packets are copied to their places, and what did not arrive becomes zero."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.driver.gige.stream.packet_sorting import PacketRun

SCATTERED = 4
"Mean length of runs of packets below which packets are copied by one indexed assignment, not run by run."


class BlockBuffer:
    """A buffer and what of it is filled. Without memory, the block is only counted."""

    def __init__(self, memory: NDArray[np.uint8] | None, size: int) -> None:
        """`memory` is None if no buffer was free; `size` is the largest payload in bytes."""
        self.memory = memory
        self.writable = memory is not None
        "Whether packets are copied; False for a block of which no frame can be made."
        self.extent = 0
        "End of the data received, in bytes from the start of the payload."
        self.clipped = 0
        "Packets with padding beyond the end of the payload."
        self._size = size
        self._pieces: list[tuple[int, int, int]] = []
        "Packet id, begin and end of the data in packets that carry their position."
        self._unfilled: list[tuple[int, int]] = []
        "Begin and end of what a short packet, or the trailer, left of its place as it was."

    @property
    def has_pieces(self) -> bool:
        """Whether packets carried their position."""
        return bool(self._pieces)

    def place(self, offset: int, data: memoryview) -> int:
        """Copy data without the padding that some cameras add to the last packet; return its length.

        Raises RemoteProtocolError if the rest exceeds the payload.
        """
        room = self._size - offset
        if 0 < room < len(data):
            self.clipped += 1
            data = data[:room]
        end = offset + len(data)
        if offset < 0 or end > self._size:
            raise RemoteProtocolError(f"data up to byte {end} of a payload of {self._size}")
        if self.writable and self.memory is not None:
            self.memory[offset:end] = data
        self.extent = max(self.extent, end)
        return len(data)

    def place_piece(self, packet_id: int, offset: int, data: memoryview) -> None:
        """Copy the data of a packet that carries its position. Raises RemoteProtocolError."""
        self._pieces.append((packet_id, offset, offset + self.place(offset, data)))

    def place_in_order(self, first: int, bodies: NDArray[np.uint8]) -> None:
        """Copy full packets that follow each other from the `first` id on. The last must fit."""
        stride = bodies.shape[1]
        end = (first - 1 + len(bodies)) * stride
        self.extent = max(self.extent, end)
        if self.writable and self.memory is not None:
            self.memory[:end].reshape(-1, stride)[first - 1 :] = bodies

    def place_run(self, run: PacketRun, rows: NDArray[np.uint8], at: NDArray[np.intp]) -> None:
        """Copy full packets, the i-th of the run from `rows[at[i]]`. The highest must fit."""
        if run.consecutive and at[-1] - at[0] == len(at) - 1:
            self.place_in_order(run.lowest, rows[at[0] : at[-1] + 1])
            return
        ids, stride = run.ids, rows.shape[1]
        end = run.highest * stride
        self.extent = max(self.extent, end)
        if not self.writable or self.memory is None:
            return
        lines = self.memory[:end].reshape(-1, stride)
        breaks = ((ids[1:] - ids[:-1] != 1) | (at[1:] - at[:-1] != 1)).nonzero()[0]
        begins = [0, *(breaks + 1).tolist()]
        if SCATTERED * len(begins) > len(ids):
            lines[ids - 1] = rows[at]
            return
        for begin, stop in zip(begins, [*begins[1:], len(ids)], strict=True):
            line, row, count = int(ids[begin]) - 1, int(at[begin]), stop - begin
            lines[line : line + count] = rows[row : row + count]

    def leave(self, begin: int, end: int) -> None:
        """Note that a packet did not fill these bytes of its place."""
        self._unfilled.append((begin, end))

    def join_pieces(self) -> None:
        """Move the data of packets, each in its slot, together."""
        assert self.memory is not None
        end = 0
        pieces = sorted(self._pieces)
        self._pieces = []
        for packet_id, first, last in pieces:
            self.memory[end : end + last - first] = self.memory[first:last].copy()
            self._pieces.append((packet_id, end, end + last - first))
            end += last - first
        self.extent = end

    def blank_gaps(self, end: int) -> int:
        """Zero the gaps between pieces, and behind the last up to `end`; return their number of bytes."""
        assert self.memory is not None
        payload = self.memory[:end]
        at = blanked = 0
        for first, last in sorted((first, last) for _, first, last in self._pieces):
            if first > at:
                payload[at:first] = 0
                blanked += first - at
            at = max(at, last)
        payload[at:] = 0
        return blanked + max(len(payload) - at, 0)

    def blank(self, end: int, missing: Iterable[tuple[int, int]] = ()) -> int:
        """Zero these places, and what packets left of theirs, up to `end`; return the number of bytes."""
        assert self.memory is not None
        payload, blanked = self.memory[:end], 0
        for begin, stop in (*missing, *self._unfilled):
            place = payload[begin:stop]
            place[:] = 0
            blanked += len(place)
        return blanked
