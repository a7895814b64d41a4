"""One block while its packets arrive: which came, which are missing, when to ask again."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grabbergui.driver.gige.gvsp import Leader, PayloadKind, Trailer

NEVER = float("inf")


@dataclass(frozen=True)
class ResendPolicy:
    """When to ask for lost packets, and when to stop."""

    enabled: bool = True
    "Off where the device cannot resend: it is then never asked."
    initial_wait: float = 0.001
    "Seconds from noticing a gap to asking: the packet may only have been overtaken."
    repeat_wait: float = 0.02
    "Seconds between two requests for the same packet."
    tail_wait: float = 0.01
    "Seconds of silence after which the end of a block counts as lost too."
    max_tries: int = 5
    "Requests for one packet."
    max_ratio: float = 0.25
    "A block that misses more than this share of its packets is not worth asking for."
    always_worth: int = 16
    "So many missing packets are asked for, however small the block."
    give_up: float = 0.1
    "Seconds of silence after which a block is finished as it is."
    reorder_wait: float = 0.01
    "The same, once a later block has begun and nothing more is asked for."
    max_blocks: int = 4
    "Blocks under way at once; the oldest is finished when one more begins."


class Block:
    """The packets of one block. Packet ids: 0 the leader, then payload, last the trailer."""

    def __init__(
        self, block_id: int, extended: bool, buffer: NDArray[np.uint8] | None, packets: int, now: float
    ):
        self.block_id = block_id
        self.extended = extended
        self.buffer = buffer
        "None where no buffer was free: the block is only counted."
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
        self.asked_at = np.zeros(0)
        self.tries = np.zeros(0, np.uint8)
        self.next_check = NEVER
        "When to look for packets to ask for."
        self.tail_checked = -NEVER
        "`last_packet_at` when the end of the block was last looked at."

    def holds(self, packet_id: int) -> bool:
        """Whether a packet came already."""
        return packet_id < len(self.received) and bool(self.received[packet_id])

    def mark(self, packet_id: int, now: float) -> bool:
        """Note that a packet came; whether it had been asked for."""
        if packet_id >= len(self.received):
            self.received = _grown(self.received, packet_id)
        self.received[packet_id] = 1
        self.count += 1
        self.highest = max(self.highest, packet_id)
        self.last_packet_at = now
        return packet_id < len(self.tries) and bool(self.tries[packet_id])

    def mark_run(self, first: int, count: int, now: float) -> None:
        """Note that `count` consecutive packets came, none of them before."""
        end = first + count
        if end > len(self.received):
            self.received = _grown(self.received, end)
        self.received[first:end] = 1
        self.count += count
        self.highest = max(self.highest, end - 1)
        self.last_packet_at = now

    def payload_packets(self, stride: int) -> int | None:
        """How many payload packets make up the block, where that is known."""
        if self.last_id is not None:
            return self.last_id - 1
        leader = self.leader
        if leader is None or leader.kind == PayloadKind.MULTI_PART or leader.payload_bytes is None:
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

    def missing(self, end: int) -> NDArray[np.intp]:
        """Ids up to and including `end` of packets that did not come."""
        if end >= len(self.received):
            self.received = _grown(self.received, end)
        ids: NDArray[np.intp] = np.flatnonzero(self.received[: end + 1] == 0)
        return ids

    def to_ask(self, missing: NDArray[np.intp], policy: ResendPolicy, now: float) -> NDArray[np.intp]:
        """Those of the missing packets whose time to be asked for has come; notes that they are asked for."""
        if not len(missing) or len(missing) > max(policy.always_worth, policy.max_ratio * len(self.received)):
            self.next_check = NEVER
            return missing[:0]
        if len(self.tries) < len(self.received):
            self.tries = _grown(self.tries, len(self.received) - 1)
            self.asked_at = np.concatenate([self.asked_at, np.zeros(len(self.tries) - len(self.asked_at))])
        open_ids: NDArray[np.intp] = missing[self.tries[missing] < policy.max_tries]
        if not len(open_ids):
            self.next_check = NEVER
            return open_ids
        # Deadlines are compared as sums, exactly as they are announced: a difference may round the other way.
        again_at = self.asked_at[open_ids] + policy.repeat_wait
        due: NDArray[np.intp] = open_ids[(self.tries[open_ids] == 0) | (again_at <= now)]
        self.tries[due] += 1
        self.asked_at[due] = now
        self.next_check = float((self.asked_at[open_ids] + policy.repeat_wait).min())
        return due

    def give_up_on(self, packet_id: int, policy: ResendPolicy) -> None:
        """The device no longer has this packet: do not ask again."""
        if packet_id < len(self.tries):
            self.tries[packet_id] = policy.max_tries

    @property
    def only_leader(self) -> bool:
        """Some devices send it when acquisition starts, long before the rest."""
        return self.count == 1 and self.leader is not None and self.trailer is None


def _grown(array: NDArray[np.uint8], index: int) -> NDArray[np.uint8]:
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
