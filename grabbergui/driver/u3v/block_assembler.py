"""Assembles blocks from bulk transfers: chooses the requests and interprets their completion. No I/O.

The assembler makes requests ahead of the data, following the transfer plan. When a device ends a block early
(fewer valid bytes than planned) or loses a transfer, the requests in flight no longer match the data. The
assembler then discards them and makes one request at a time, chosen by the data received before, until
several blocks in a row have followed the plan.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.driver.u3v.stream_protocol import (
    Leader,
    Trailer,
    TransferPlan,
    is_leader,
    is_trailer,
    round_up,
)

BLOCKS_TO_TRUST = 8
"Consecutive blocks that must follow the plan before requests are made ahead again."


class TransferKind(Enum):
    """Kind of transfer that a request expects."""

    LEADER = "leader"
    PAYLOAD = "payload"
    TRAILER = "trailer"


@dataclass(eq=False)
class Block:
    """Leader, payload and trailer, received or still expected."""

    buffer: NDArray[np.uint8]
    "Memory for the payload: 1-D, at least the plan's payload space and one packet."
    dropped: bool
    "True if no pooled buffer was free: the payload goes to a common scratch buffer and is lost."
    leader: Leader | None = None
    trailer: Trailer | None = None
    received: int = 0
    "Contiguous payload bytes from the start."
    gap: bool = False
    "True after a short payload transfer; later bytes do not count."

    @property
    def missing(self) -> int:
        """Number of valid bytes that were not received."""
        valid = self.trailer.valid_payload_size if self.trailer else 0
        return max(valid - self.received, 0)


@dataclass(eq=False)
class TransferRequest:
    """One bulk transfer to submit."""

    kind: TransferKind
    block: Block
    view: NDArray[np.uint8]
    "Memory for the transfer; its length is a multiple of the packet size."
    size: int = 0
    "Planned bytes of a payload transfer."


@dataclass(eq=False)
class BlockAssembler:
    """Makes requests and assembles blocks from their data. Use from one thread."""

    plan: TransferPlan
    take_buffer: Callable[[], NDArray[np.uint8] | None]
    "Returns a payload buffer of `buffer_size` bytes, or None if all are in use."
    packet_size: int = 1024
    in_step: bool = True
    "True while requests may be made ahead of the data."
    ignored: int = 0
    "Number of transfers that belonged to no block."
    broken: int = 0
    "Number of blocks that were begun and discarded."
    _followed: int = 0
    _ahead: list[TransferRequest] = field(default_factory=list)
    _block: Block | None = None
    _piece: int = 0

    def __post_init__(self) -> None:
        self._sizes = self.plan.payload_sizes
        self._offsets = list(itertools.accumulate(self._sizes, initial=0))
        self._scratch = np.empty(self.buffer_size, np.uint8)

    @property
    def buffer_size(self) -> int:
        """Size of a payload buffer in bytes: the last request may be longer than its transfer."""
        return round_up(self.plan.payload_space, self.packet_size) + self.packet_size

    def next_request(self) -> TransferRequest:
        """Return the next request after those returned before; when out of step, one at a time."""
        if not self.in_step:
            return self._request_one()
        if not self._ahead:
            self._ahead = self._requests_of_a_block()[::-1]
        return self._ahead.pop()

    def put_back(self, request: TransferRequest) -> None:
        """Undo the last `next_request`."""
        if self.in_step:
            self._ahead.append(request)

    def give_up(self) -> None:
        """Discard all requests in flight and start with the next leader."""
        self._ahead.clear()
        self._drop_block()
        self.in_step = False
        self._followed = 0

    def complete(self, request: TransferRequest, length: int) -> Block | None:
        """Process the first `length` bytes of a request; return the block that they complete, if any.

        Sets `in_step` to False if the request expected other data: the caller then cancels the requests in
        flight and calls `give_up`.
        """
        head = request.view[: min(length, 64)].tobytes()
        if is_leader(head) and (request.kind is not TransferKind.PAYLOAD or self._is_successor(head)):
            self._begin(request, head)
            return None
        block = self._block
        if block is None or block is not request.block or block.leader is None:
            self.ignored += 1
            self._lose_step()
            return None
        # Pixels may look like a trailer; an early trailer has the id of its block, too.
        if is_trailer(head) and (request.kind is not TransferKind.PAYLOAD or _closes(head, block)):
            return self._end(request, head, block)
        if request.kind is not TransferKind.PAYLOAD:
            self.ignored += 1
            self._drop_block()
            self._lose_step()
            return None
        self._piece += 1
        if not block.gap:
            block.received += length
        block.gap = block.gap or length < request.size
        return None

    def _begin(self, request: TransferRequest, head: bytes) -> None:
        """Begin a block with a leader, which may have arrived in place of the previous block's end."""
        expected = request.kind is TransferKind.LEADER
        if self._block is not None:
            self._drop_block()
        try:
            request.block.leader = Leader.decode(head)
        except RemoteProtocolError:
            self.ignored += 1
            self._lose_step()
            return
        self._block = request.block
        self._block.received, self._block.gap = 0, False
        self._piece = 0
        if not expected:
            self._lose_step()

    def _end(self, request: TransferRequest, head: bytes, block: Block) -> Block | None:
        assert block.leader is not None
        trailer = Trailer.decode(head, block.leader.payload_type)
        if trailer.block_id != block.leader.block_id:
            # Leader and trailer contradict each other: one of them belongs to another block.
            self.ignored += 1
            self._drop_block()
            self._lose_step()
            return None
        block.trailer = trailer
        self._block = None
        if request.kind is TransferKind.TRAILER:
            self._followed += 1
            self.in_step = self.in_step or self._followed >= BLOCKS_TO_TRUST
        else:
            self._lose_step()
        return block

    def _is_successor(self, head: bytes) -> bool:
        """Return whether a payload transfer brought the next block's leader instead of pixels."""
        try:
            leader = Leader.decode(head)
        except RemoteProtocolError:
            return False
        before = self._block.leader if self._block else None
        return before is None or 0 < leader.block_id - before.block_id < 1 << 16

    def _requests_of_a_block(self) -> list[TransferRequest]:
        block = self._new_block()
        payload = [self._payload_request(block, index) for index in range(len(self._sizes))]
        return [self._leader_request(block), *payload, self._trailer_request(block)]

    def _request_one(self) -> TransferRequest:
        if self._block is None:
            # Any transfer must fit: it may be the payload of a block whose leader was lost.
            block = self._new_block()
            return TransferRequest(TransferKind.LEADER, block, self._scratch[: self._longest()])
        if self._piece < len(self._sizes):
            return self._payload_request(self._block, self._piece)
        return self._trailer_request(self._block)

    def _new_block(self) -> Block:
        buffer = self.take_buffer()
        return Block(self._scratch if buffer is None else buffer, dropped=buffer is None)

    def _leader_request(self, block: Block) -> TransferRequest:
        return TransferRequest(TransferKind.LEADER, block, self._space(self.plan.leader_size))

    def _trailer_request(self, block: Block) -> TransferRequest:
        return TransferRequest(TransferKind.TRAILER, block, self._space(self.plan.trailer_size))

    def _payload_request(self, block: Block, index: int) -> TransferRequest:
        size, offset = self._sizes[index], self._offsets[index]
        # A transfer that is no multiple of the packet ends in a short one, so asking for more is harmless,
        # and a device that sends too much does not overflow the request.
        view = block.buffer[offset : offset + round_up(size, self.packet_size)]
        return TransferRequest(TransferKind.PAYLOAD, block, view, size)

    def _longest(self) -> int:
        sizes = (*self._sizes, self.plan.leader_size, self.plan.trailer_size)
        return min(round_up(max(sizes), self.packet_size), len(self._scratch))

    def _space(self, size: int) -> NDArray[np.uint8]:
        return np.empty(round_up(size, self.packet_size), np.uint8)

    def _drop_block(self) -> None:
        if self._block is not None:
            self.broken += 1
            self._block = None

    def _lose_step(self) -> None:
        self.in_step = False
        self._followed = 0


def _closes(head: bytes, block: Block) -> bool:
    """Return whether data that begin like a trailer are the trailer of this block."""
    assert block.leader is not None
    return Trailer.decode(head, block.leader.payload_type).block_id == block.leader.block_id
