"""The assembler against devices that keep to the plan, and those that do not."""

from __future__ import annotations

from collections import deque

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from grabbergui.driver.sim.u3v.device import cut
from grabbergui.driver.u3v.block_assembler import BLOCKS_TO_TRUST, Block, BlockAssembler, TransferKind
from grabbergui.driver.u3v.stream_protocol import Leader, Trailer, TransferPlan, U3vPayloadType

PLAN = TransferPlan(1024, 2048, 2, 500, 0, 1024)
PAYLOAD = bytes(range(256)) * 17 + bytes(range(244))
assert len(PAYLOAD) == PLAN.payload_space


def block_transfers(block_id: int, length: int = len(PAYLOAD)) -> list[bytes]:
    leader = Leader(block_id, U3vPayloadType.IMAGE, 1000 + block_id, 0x01080001, 4, 2)
    trailer = Trailer(block_id, 0, length, 2)
    pieces = [bytes(piece) for piece in cut(memoryview(PAYLOAD)[:length], PLAN.payload_sizes)]
    # An empty packet ends the transfer before it; as a transfer of its own it is not seen.
    pieces = [piece for piece in pieces if piece]
    return [leader.encode(), *pieces, trailer.encode(U3vPayloadType.IMAGE)]


class Link:
    """Requests in flight meet a device's transfers, as the receiver would have it."""

    def __init__(self, depth: int = 8) -> None:
        self.assembler = BlockAssembler(PLAN, lambda: np.zeros(self.assembler.buffer_size, np.uint8))
        self.blocks: list[Block] = []
        self._depth = depth
        self._in_flight: deque = deque()

    def send(self, *transfers: bytes) -> None:
        for transfer in transfers:
            while not self._in_flight or (self.assembler.in_step and len(self._in_flight) < self._depth):
                self._in_flight.append(self.assembler.next_request())
            request = self._in_flight.popleft()
            data = transfer[: len(request.view)]
            request.view[: len(data)] = np.frombuffer(data, np.uint8)
            before = self.assembler.in_step
            block = self.assembler.complete(request, len(data))
            if before and not self.assembler.in_step and self._in_flight:
                self._in_flight.clear()
                self.assembler.give_up()
            if block is not None:
                self.blocks.append(block)

    @property
    def ids(self) -> list[int]:
        return [block.leader.block_id for block in self.blocks if block.leader]


def test_planned_blocks_arrive_whole_and_in_place() -> None:
    link = Link()
    for block_id in range(3):
        link.send(*block_transfers(block_id))
    assert link.ids == [0, 1, 2]
    assert link.assembler.in_step
    for block in link.blocks:
        assert block.missing == 0
        assert block.buffer[: len(PAYLOAD)].tobytes() == PAYLOAD


def test_blocks_that_end_early_are_complete() -> None:
    link = Link()
    for block_id in range(4):
        link.send(*block_transfers(block_id, length=1500))
    # All are counted: the first by its trailer, the others one request at a time.
    assert link.ids == [0, 1, 2, 3]
    for block in link.blocks:
        assert block.missing == 0
        assert block.received == 1500
    assert not link.assembler.in_step


def test_step_is_regained_after_blocks_that_keep_to_the_plan() -> None:
    link = Link()
    link.send(*block_transfers(0, length=1500))
    for block_id in range(1, BLOCKS_TO_TRUST + 2):
        assert not link.assembler.in_step or block_id > BLOCKS_TO_TRUST
        link.send(*block_transfers(block_id))
    assert link.assembler.in_step
    assert link.ids == list(range(BLOCKS_TO_TRUST + 2))


def test_a_lost_payload_transfer_makes_a_gap() -> None:
    link = Link()
    leader, _, *rest = block_transfers(0)
    link.send(leader, *rest)
    assert link.blocks[0].missing > 0


def test_a_lost_trailer_costs_one_block_of_those_after_it_at_most() -> None:
    link = Link()
    link.send(*block_transfers(0)[:-1])
    for block_id in range(1, 5):
        link.send(*block_transfers(block_id))
    assert link.ids[-3:] == [2, 3, 4]
    assert 0 not in link.ids


def test_a_leader_that_contradicts_its_trailer_is_no_block() -> None:
    link = Link()
    link.send(*block_transfers(0)[:-1], block_transfers(1)[-1])
    assert link.ids == []
    assert link.assembler.ignored == 1
    for block_id in range(2, 5):
        link.send(*block_transfers(block_id))
    assert link.ids[-2:] == [3, 4]


def test_a_block_for_which_no_buffer_was_free_is_marked() -> None:
    assembler = BlockAssembler(PLAN, lambda: None)
    request = assembler.next_request()
    assert request.block.dropped


def test_requests_ahead_lie_at_their_places() -> None:
    assembler = BlockAssembler(PLAN, lambda: np.zeros(8192, np.uint8))
    requests = [assembler.next_request() for _ in range(5)]
    assert [request.kind for request in requests] == [
        TransferKind.LEADER,
        *[TransferKind.PAYLOAD] * 3,
        TransferKind.TRAILER,
    ]
    assert [len(request.view) for request in requests] == [1024, 2048, 2048, 1024, 1024]
    assembler.put_back(requests[-1])
    assert assembler.next_request() is requests[-1]


@given(st.lists(st.one_of(st.binary(max_size=60), st.integers(0, 4)), max_size=40), st.integers(1, 9))
def test_no_order_of_transfers_confuses_it_for_long(noise: list[bytes | int], depth: int) -> None:
    link = Link(depth)
    for index, thing in enumerate(noise):
        if isinstance(thing, bytes):
            link.send(thing)
        else:
            link.send(block_transfers(index)[thing])
    for block_id in range(1000, 1005):
        link.send(*block_transfers(block_id))
    assert link.ids[-3:] == [1002, 1003, 1004]
    assert link.blocks[-1].missing == 0


def test_pixels_that_begin_as_a_trailer_are_pixels() -> None:
    link = Link()
    leader, first, _, last, trailer = block_transfers(5)
    pixels = Trailer(77, 0, 2048, 2).encode(U3vPayloadType.IMAGE).ljust(2048, b"\x55")
    link.send(leader, first, pixels, last, trailer)
    assert link.assembler.in_step
    assert link.ids == [5]
    assert link.blocks[0].missing == 0
    assert link.blocks[0].buffer[2048:4096].tobytes() == pixels


def test_a_plan_of_very_many_transfers_is_made_at_once() -> None:
    plan = TransferPlan(1024, 1024, 300_000, 512, 0, 1024)
    assembler = BlockAssembler(plan, lambda: None)
    requests = [assembler.next_request() for _ in range(300_003)]
    assert [request.kind for request in (requests[0], requests[-1])] == [
        TransferKind.LEADER,
        TransferKind.TRAILER,
    ]
    start = assembler.next_request().block.buffer.ctypes.data
    assert requests[-2].view.ctypes.data - start == 300_000 * 1024
