"""The finished blocks of a stream, which give a meaning to a packet for which no block is open."""

from __future__ import annotations

from collections import OrderedDict
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from grabbergui.driver.device import FARTHEST_BLOCK, lost_between
from grabbergui.driver.gige.packet_header import PacketFormat, PacketHeader

RESTART_DISTANCE = 100
"A block id that jumps back so far, or beyond `FARTHEST_BLOCK` ahead, belongs to a new stream."
REMEMBERED = 64
"Finished blocks whose late packets are still recognised."


class Meaning(Enum):
    """Meaning of a packet for which no block is open."""

    NEXT = "begins a block"
    LATE = "of a finished block"
    STALE = "of a block from long ago"
    RESTART = "begins the first block of a new stream"


class BlockHistory:
    """The finished blocks of one stream."""

    def __init__(self) -> None:
        self._recent: OrderedDict[int, NDArray[np.uint8]] = OrderedDict()
        "By block id, which packets were received."
        self._last: int | None = None
        self._late_leader: int | None = None

    def meaning(self, header: PacketHeader) -> Meaning:
        """Classify a packet."""
        if header.block_id in self._recent:
            return Meaning.LATE
        if self._last is None:
            return Meaning.NEXT
        steps = distance(self._last, header.block_id, header.extended)
        if steps <= -RESTART_DISTANCE or steps > FARTHEST_BLOCK or self._restarted(header, steps):
            return Meaning.RESTART
        return Meaning.NEXT if steps > 0 else Meaning.STALE

    def note_late(self, header: PacketHeader) -> bool:
        """Note a late packet; return whether it is a duplicate, and not the first of its id, or a refusal."""
        received = self._recent[header.block_id]
        if header.packet_id >= len(received) or header.failed:
            return False
        duplicate = bool(received[header.packet_id])
        received[header.packet_id] = 1
        return duplicate

    def add(self, block_id: int, extended: bool, received: NDArray[np.uint8]) -> int:
        """Add a finished block and the packets that it received; return how many blocks before it were lost.

        Blocks are finished in the order of their ids.
        """
        steps = 1 if self._last is None else distance(self._last, block_id, extended)
        self._last = block_id
        self._late_leader = None
        self._recent[block_id] = received
        while len(self._recent) > REMEMBERED:
            self._recent.popitem(last=False)
        return lost_between(steps)

    def clear(self) -> None:
        """Forget all: a new stream begins."""
        self._recent.clear()
        self._last = self._late_leader = None

    def _restarted(self, header: PacketHeader, steps: int) -> bool:
        """Return whether ids restarted a short way back: two leaders in a row show it."""
        if header.format not in (PacketFormat.LEADER, PacketFormat.ALL_IN):
            return False
        if steps > 0:
            self._late_leader = None
            return False
        previous, self._late_leader = self._late_leader, header.block_id
        return previous is not None and distance(previous, header.block_id, header.extended) == 1


def distance(older: int, newer: int, extended: bool) -> int:
    """Return how many blocks `newer` is after `older`; negative if before.

    Standard ids go from 65535 to 1, so there are 65535 of them.
    """
    if extended:
        return newer - older
    steps = (newer - older) % 0xFFFF
    return steps - 0xFFFF if steps > 0x7FFF else steps
