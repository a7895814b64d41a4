"""Packets sorted before they are stored: batches into runs, single packets by the blocks that are finished.

numpy compares the headers of many packets, so that these are handled by the run. `BlockHistory` gives the
meaning of a packet for which no block is open.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator
from enum import Enum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grabbergui.driver.device import FARTHEST_BLOCK, lost_between
from grabbergui.driver.gige.packet_header import PacketFormat, PacketHeader, decode_rows

Ids = slice | NDArray[np.intp]
"Packet ids, or rows: a `slice` of consecutive ones is faster."


class PacketRun(NamedTuple):
    """Neighbouring rows whose headers differ only in the packet id and in being resent."""

    begin: int
    end: int
    ids: NDArray[np.intp]
    "Packet ids in the order of arrival."
    resent: NDArray[np.bool_]
    "True for each packet that the device flags as resent."
    lowest: int
    highest: int
    increasing: bool
    "Whether each id is higher than the one before."

    @classmethod
    def of(cls, begin: int, end: int, ids: NDArray[np.intp], resent: NDArray[np.bool_]) -> PacketRun:
        """Make a run of any ids."""
        if (ids[1:] > ids[:-1]).all():
            return cls(begin, end, ids, resent, int(ids[0]), int(ids[-1]), True)
        return cls(begin, end, ids, resent, int(ids.min()), int(ids.max()), False)

    @property
    def consecutive(self) -> bool:
        """Whether each id is one more than the one before."""
        return self.increasing and self.highest - self.lowest + 1 == len(self.ids)

    def places(self) -> Ids:
        """Return the ids as an index, a slice where they are consecutive."""
        return slice(self.lowest, self.highest + 1) if self.consecutive else self.ids

    def chosen(self, which: NDArray[np.bool_] | slice) -> PacketRun:
        """Return the run with some of the packets only."""
        return PacketRun.of(self.begin, self.end, self.ids[which], self.resent[which])

    def first_occurrences(self) -> NDArray[np.bool_]:
        """Return which packets are not duplicates of earlier ones in the run."""
        first = np.zeros(len(self.ids), np.bool_)
        first[np.unique(self.ids, return_index=True)[1]] = True
        return first


def packet_runs(rows: NDArray[np.uint8]) -> Iterator[PacketRun]:
    """Divide rows (n, length), which begin with a standard header at least, into runs."""
    ids, resent, differs = decode_rows(rows)
    breaks = (differs.nonzero()[0] + 1).tolist()
    for begin, end in zip([0, *breaks], [*breaks, len(rows)], strict=True):
        yield PacketRun.of(begin, end, ids[begin:end], resent[begin:end])


# -- runs of packet ids --------------------------------------------------------------------------
def id_runs(ids: NDArray[np.intp]) -> Iterator[tuple[int, int]]:
    """Yield (first, last) of each run of consecutive ids among sorted ones."""
    if len(ids):
        breaks = np.flatnonzero(np.diff(ids) != 1)
        firsts = ids[np.concatenate([[0], breaks + 1])]
        lasts = ids[np.concatenate([breaks, [len(ids) - 1]])]
        yield from zip(firsts.tolist(), lasts.tolist(), strict=True)


def run_ends(ids: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return for each of sorted ids the first id after its run."""
    breaks = (ids[1:] - ids[:-1] != 1).nonzero()[0]
    if len(breaks) == len(ids) - 1:  # as mostly
        return ids + 1
    lasts = np.append(breaks, len(ids) - 1)
    return np.repeat(ids[lasts] + 1, np.diff(lasts, prepend=-1))


# -- packets for which no block is open ----------------------------------------------------------
RESTART_DISTANCE = 100
"A block id that jumps back so far, or beyond `FARTHEST_BLOCK` ahead, belongs to a new stream."
REMEMBERED = 64
"Finished blocks whose late packets are still recognised."


class Meaning(Enum):
    """Of a packet for which no block is open."""

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
