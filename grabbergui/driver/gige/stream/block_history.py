"""Finished blocks: what the id of a packet means for which no block is open."""

from __future__ import annotations

from collections import OrderedDict
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.grabber import StreamStatistics
from grabbergui.driver.gige.gvsp import PacketFormat, PacketHeader
from grabbergui.driver.gige.stream.block import Block, distance

RESTART_DISTANCE = 100
"A block id that jumps back so far, or this far times a hundred ahead, belongs to a new stream."
REMEMBERED = 64
"Finished blocks whose late packets are still recognised."


class Meaning(Enum):
    """Of a packet for which no block is open."""

    NEXT = "begins a block"
    LATE = "of a block that is finished"
    STALE = "of a block from long ago"
    RESTART = "begins the first block of a new stream"


class BlockHistory:
    """The finished blocks of one stream."""

    def __init__(self, statistics: StreamStatistics) -> None:
        """Counts lost blocks and late packets."""
        self._statistics = statistics
        self._recent: OrderedDict[int, NDArray[np.uint8]] = OrderedDict()
        "Block id to which packets came."
        self._last: int | None = None
        self._late_leader: int | None = None

    def meaning(self, header: PacketHeader) -> Meaning:
        """What the packet is; a late one is counted."""
        if header.block_id in self._recent:
            self._note_late(self._recent[header.block_id], header)
            return Meaning.LATE
        if self._last is None:
            return Meaning.NEXT
        steps = distance(self._last, header.block_id, header.extended)
        if steps <= -RESTART_DISTANCE or steps > 100 * RESTART_DISTANCE or self._restarted(header, steps):
            return Meaning.RESTART
        return Meaning.NEXT if steps > 0 else Meaning.STALE

    def add(self, block: Block) -> None:
        """A block is finished; blocks are finished in the order of their ids."""
        if self._last is not None and (steps := distance(self._last, block.block_id, block.extended)) > 1:
            self._statistics.lost += steps - 1
        self._last = block.block_id
        self._late_leader = None
        self._recent[block.block_id] = block.received
        while len(self._recent) > REMEMBERED:
            self._recent.popitem(last=False)

    def forget(self) -> None:
        """A new stream begins."""
        self._recent.clear()
        self._last = self._late_leader = None

    def _note_late(self, received: NDArray[np.uint8], header: PacketHeader) -> None:
        """Its block's trailer, a duplicate, or too late."""
        self._statistics.packets += 1
        if header.packet_id < len(received) and not header.failed:
            self._statistics.packets_duplicate += int(received[header.packet_id])
            received[header.packet_id] = 1

    def _restarted(self, header: PacketHeader, steps: int) -> bool:
        """Whether ids began anew not far back: two leaders in a row say so."""
        if header.format not in (PacketFormat.LEADER, PacketFormat.ALL_IN):
            return False
        if steps > 0:
            self._late_leader = None
            return False
        previous, self._late_leader = self._late_leader, header.block_id
        return previous is not None and distance(previous, header.block_id, header.extended) == 1
