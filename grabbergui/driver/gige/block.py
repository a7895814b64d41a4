"""One block while its packets arrive: which came, which are missing, which were asked for."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grabbergui.driver.gige.gvsp import Leader, PayloadKind, Trailer

NEVER = float("inf")


class RequestLog:
    """Which packets of a block were asked for, and when. Empty, and free of cost, where none was."""

    def __init__(self) -> None:
        self.tries = np.zeros(0, np.uint8)
        "Requests for each packet, by packet id."
        self.missed_at = np.zeros(0)
        "When it did not come in its turn; minus infinity where that was not noticed."
        self.first_at = np.zeros(0)
        "When the first request left."
        self.again_at = np.zeros(0)
        "When it is time for the next."
        self.next_check = NEVER
        "When to look for packets to ask for."
        self.tail_checked = -NEVER
        "The block's `last_packet_at` when its end was last looked at."

    def make_room(self, packets: int) -> None:
        """Hold at least so many packets."""
        if len(self.tries) < packets:
            known = len(self.tries)
            self.tries = _grown(self.tries, packets - 1)
            self.missed_at = _grown(self.missed_at, packets - 1)
            self.missed_at[known:] = -NEVER
            self.first_at = _grown(self.first_at, packets - 1)
            self.again_at = _grown(self.again_at, packets - 1)

    def note(self, first: int, last: int, now: float, wait: float) -> None:
        """Packets `first` to `last` are asked for; each try waits twice as long as the one before."""
        asked = slice(first, last + 1)
        self.first_at[asked] = np.where(self.tries[asked] == 0, now, self.first_at[asked])
        self.again_at[asked] = now + np.ldexp(wait, self.tries[asked])
        self.tries[asked] += 1


class Block:
    """The packets of one block. Packet ids: 0 the leader, then payload, last the trailer."""

    def __init__(
        self, block_id: int, extended: bool, buffer: NDArray[np.uint8] | None, packets: int, now: float
    ):
        self.block_id = block_id
        self.extended = extended
        self.buffer = buffer
        "None where no buffer was free: the block is only counted."
        self.began = now
        "When its first packet came."
        self.leader: Leader | None = None
        self.trailer: Trailer | None = None
        self.last_id: int | None = None
        "Packet id of the trailer, once it came."
        self.refused = False
        "Whether the device announced more than the buffer holds."
        self.received = np.zeros(packets, np.uint8)
        "1 for each packet that came, by packet id."
        self.count = 0
        "How many came."
        self.highest = -1
        "Highest packet id that came."
        self.extent = 0
        "End of the data that came, in bytes from the start of the payload."
        self.ended_short = False
        "Whether the packet at `extent` was shorter than a full one, so nothing follows it."
        self.last_packet_at = now
        self.asked = RequestLog()

    def holds(self, packet_id: int, count: int = 1) -> bool:
        """Whether any of `count` packets from `packet_id` on came already."""
        return bool(self.received[packet_id : packet_id + count].any())

    def mark(self, first: int, count: int, now: float) -> None:
        """Note that `count` consecutive packets came, none of them before."""
        end = first + count
        if end > len(self.received):
            self.received = _grown(self.received, end)
        self.received[first:end] = 1
        self.count += count
        self.highest = max(self.highest, end - 1)
        self.last_packet_at = now

    def place(self, offset: int, data: NDArray[np.uint8] | memoryview) -> None:
        """Put data into the payload, `offset` bytes from its start; rows of a 2-D array follow each other."""
        size = data.nbytes
        if self.buffer is not None and not self.refused:
            room = self.buffer[offset : offset + size]
            room.reshape(data.shape)[...] = data
        self.extent = max(self.extent, offset + size)

    def payload_packets(self, stride: int) -> int | None:
        """How many payload packets make up the block, where that is known."""
        if self.last_id is not None:
            return self.last_id - 1
        leader = self.leader
        if leader is None or self.refused:  # a leader that was refused may announce any number
            return None
        if leader.kind == PayloadKind.MULTI_PART or leader.payload_bytes is None:
            return None
        return -(-leader.payload_bytes // stride)

    def complete(self, stride: int) -> bool:
        """Whether all that matters came; a trailer that says nothing new is not waited for."""
        if self.leader is None or self.refused:
            return False
        if self.last_id is not None:
            return self.count == self.last_id + 1
        packets = self.payload_packets(stride)
        return packets is not None and self.count == packets + 1 and self.highest == packets

    def all_arrived(self) -> bool:
        """Chunks end where the trailer says; where it was lost, a short last packet says the same."""
        leader = self.leader
        return (
            leader is not None
            and not self.refused
            and self.last_id is None
            and leader.has_chunks
            and self.ended_short
            and self.extent >= leader.image_bytes
            and self.count == self.highest + 1
        )

    def missing(self, end: int) -> NDArray[np.intp]:
        """Ids up to and including `end` of packets that did not come."""
        if end >= len(self.received):
            self.received = _grown(self.received, end)
        ids: NDArray[np.intp] = np.flatnonzero(self.received[: end + 1] == 0)
        return ids

    @property
    def only_leader(self) -> bool:
        """Some devices send it when acquisition starts, long before the rest."""
        return self.count == 1 and self.leader is not None and self.trailer is None


def _grown(array: NDArray[Any], index: int) -> NDArray[Any]:
    """A copy with room for `index`."""
    larger = np.zeros(max(index + 1, 2 * len(array)), array.dtype)
    larger[: len(array)] = array
    return larger


def runs(ids: NDArray[np.intp]) -> Iterator[tuple[int, int]]:
    """Sorted ids as (first, last) of consecutive ones."""
    if len(ids):
        breaks = np.flatnonzero(np.diff(ids) != 1)
        firsts = ids[np.concatenate([[0], breaks + 1])]
        lasts = ids[np.concatenate([breaks, [len(ids) - 1]])]
        yield from zip(firsts.tolist(), lasts.tolist(), strict=True)


def distance(older: int, newer: int, extended: bool) -> int:
    """How many blocks `newer` is after `older`; negative where it is before.

    Standard ids go from 65535 to 1, so there are 65535 of them.
    """
    if extended:
        return newer - older
    steps = (newer - older) % 0xFFFF
    return steps - 0xFFFF if steps > 0x7FFF else steps
