"""Packets taken as rows of an array give what they give one by one."""

from __future__ import annotations

import itertools
import random
from collections.abc import Iterable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from block_bench import LAST, SIZE, STRIDE, Bench, block, fuzz_headers, ids, image, is_image
from every_case import every_case
from grabbergui.driver.gige.packet_header import PacketFormat, PacketHeader, count_in_order
from grabbergui.driver.gige.stream.block import Block
from grabbergui.driver.gige.stream.packet_sorting import packet_runs


def rows_of(datagrams: list[bytes]) -> NDArray[np.uint8]:
    return np.frombuffer(b"".join(datagrams), np.uint8).reshape(len(datagrams), -1)


def runs(datagrams: list[bytes]) -> list[NDArray[np.uint8]]:
    """Datagrams as a source gives them: those of equal length that follow each other together."""
    return [rows_of(list(group)) for _, group in itertools.groupby(datagrams, len)]


def feed_rows(bench: Bench, datagrams: list[bytes]) -> list:  # type: ignore[type-arg]
    for rows in runs(datagrams):
        bench.assembler.receive_rows(rows, bench.now)
    return bench.tick()


def bounds(datagrams: list[bytes]) -> list[tuple[int, int]]:
    return [(run.begin, run.end) for run in packet_runs(rows_of(datagrams))]


@pytest.mark.parametrize("extended", [False, True])
def test_a_run_is_of_one_block_and_one_kind(extended: bool) -> None:
    """Gaps, doubles and the mark of what is sent again end none."""

    def header(packet_id: int, block_id: int = 1, status: int = 0, kind: int = PacketFormat.PAYLOAD) -> bytes:
        return PacketHeader(kind, block_id, packet_id, status, extended).encode().ljust(32, b"\x01")

    packets = [header(1), header(2), header(5), header(3, status=0x100), header(6), header(6), header(7, 2)]
    packets += [header(8, 2, status=0x100), header(9, 2, status=0x800C), header(10, 2, kind=9)]
    runs = list(packet_runs(rows_of(packets)))
    assert [(run.begin, run.end) for run in runs] == [(0, 6), (6, 8), (8, 9), (9, 10)]
    assert [run.ids.tolist() for run in runs] == [[1, 2, 5, 3, 6, 6], [7, 8], [9], [10]]
    assert [int(run.resent.sum()) for run in runs] == [1, 1, 0, 0]
    assert bounds(packets[:1]) == [(0, 1)] and bounds(packets[:3]) == [(0, 3)]


def test_extended_headers_are_marked_by_a_flag_and_have_64_bit_block_ids() -> None:
    def header(block_id: int, packet_id: int = 4, flags: int = 0) -> bytes:
        return PacketHeader(PacketFormat.PAYLOAD, block_id, packet_id, 0, True, flags).encode()

    first, second = packet_runs(rows_of([header(1), header(1, flags=1), header(1 << 40 | 1)]))
    assert (first.begin, first.end) == (0, 2) and first.resent.tolist() == [False, True]
    assert (second.begin, second.end) == (2, 3)
    highest = [header((1 << 64) - 2, 4), header((1 << 64) - 1, 5), header((1 << 64) - 1, 6)]
    assert bounds(highest) == [(0, 1), (1, 3)] and count_in_order(rows_of(highest)) == 1
    assert count_in_order(rows_of(highest[1:])) == 2


def test_standard_and_extended_headers_are_apart() -> None:
    standard = PacketHeader(PacketFormat.PAYLOAD, 1, 1).encode().ljust(32, b"\0")
    extended = PacketHeader(PacketFormat.PAYLOAD, 1, 1, extended=True).encode().ljust(32, b"\0")
    assert bounds([standard, standard, extended, extended, standard]) == [(0, 2), (2, 4), (4, 5)]


def test_short_extended_headers_belong_to_nothing() -> None:
    packet = PacketHeader(PacketFormat.PAYLOAD, 1, 1, extended=True).encode()[:12]
    assert bounds([packet, packet]) == [(0, 1), (1, 2)]


@every_case("extended", [False, True])
@every_case("seed", range(10))
def test_rows_repair_lost_duplicate_and_swapped_packets(seed: int, extended: bool) -> None:
    dice = random.Random(seed)
    bench = Bench(buffers=20, initial_wait=60.0)
    sent = [datagram for block_id in range(1, 6) for datagram in block(block_id, extended=extended)]
    lost = [sent.pop(dice.randrange(len(sent))) for _ in range(8)]
    for _ in range(4):
        at = dice.randrange(len(sent))
        sent.insert(at, sent[at])
    for _ in range(4):
        at = dice.randrange(len(sent) - 1)
        sent[at], sent[at + 1] = sent[at + 1], sent[at]
    done = feed_rows(bench, sent) + feed_rows(bench, lost)
    assert ids(done) == [1, 2, 3, 4, 5] and all(map(is_image, done))
    assert bench.statistics.packets_ignored == 0


def test_rows_sent_again_are_counted() -> None:
    bench = Bench()
    sent = block(1)
    bench.feed([*sent[:3], *sent[9:]])
    bench.wait(0.01)
    assert [(request.first, request.last) for request in bench.requests] == [(3, 8)]
    (done,) = feed_rows(bench, sent[3:9])
    assert is_image(done) and bench.statistics.packets_resent == 6


def test_rows_of_a_block_whose_leader_is_lost() -> None:
    bench = Bench()
    sent = block(1)
    assert feed_rows(bench, sent[1:]) == []
    (done,) = bench.feed(sent[:1])
    assert is_image(done)


def test_rows_that_reach_beyond_the_payload_are_dropped() -> None:
    bench = Bench(payload_size=SIZE - SIZE % STRIDE)
    many = [PacketHeader(PacketFormat.PAYLOAD, 1, index).encode() + bytes(STRIDE) for index in range(1, 30)]
    feed_rows(bench, many)
    assert bench.statistics.packets_ignored == 29 - SIZE // STRIDE


def test_rows_in_order_that_arrive_twice_are_duplicates() -> None:
    bench = Bench()
    sent = block(1)
    bench.feed(sent[:1])
    for _ in range(2):
        bench.assembler.receive_rows(rows_of(sent[1:6]), bench.now)
    bench.assembler.receive_rows(rows_of(sent[4:9]), bench.now)
    assert (bench.statistics.packets, bench.statistics.packets_duplicate) == (16, 7)
    (done,) = bench.feed(sent[9:])
    assert is_image(done)


def test_rows_in_order_beyond_the_payload_are_ignored() -> None:
    bench = Bench()
    sent = block(1)
    bench.feed(sent[:1])
    first = SIZE // STRIDE - 1
    beyond = [
        PacketHeader(PacketFormat.PAYLOAD, 1, packet_id).encode() + sent[1][8:]
        for packet_id in range(first, first + 5)
    ]
    bench.assembler.receive_rows(rows_of(beyond), bench.now)
    assert bench.statistics.packets_ignored == 2, "the third ends with padding, as some cameras add it"


def test_rows_without_a_free_buffer_are_only_counted() -> None:
    bench = Bench(buffers=1)
    (held,) = bench.feed(block(1))
    assert feed_rows(bench, block(2)) == [] and bench.statistics.underruns == 1
    assert held.payload.tobytes() == image(1)
    assert bench.statistics.packets == 2 * (LAST + 1)


Outcome = list[tuple[int, bool, int, bytes]]
"Id, completeness, number of missing bytes and payload of each block."


def check_rows_and_singles_agree(*batches: list[bytes], **options: object) -> tuple[Bench, Outcome]:
    """Feed packets singly to one assembler, as rows to another; the results are equal. Return the other."""
    one, other = (Bench(deliver_incomplete=True, buffers=100, **options) for _ in range(2))  # type: ignore[arg-type]
    done: dict[Bench, list[Block]] = {one: [], other: []}
    for batch in batches:
        done[one] += one.feed(batch, 0.0)
        done[other] += feed_rows(other, batch)
    outcomes: list[Outcome] = []
    for bench in (one, other):
        bench.assembler.flush()
        done[bench] += bench.tick()
        outcomes.append(
            [
                (each.block_id, each.complete, each.missing_bytes, each.payload.tobytes())
                for each in done[bench]
            ]
        )
    assert outcomes[0] == outcomes[1]
    assert one.statistics == other.statistics
    return other, outcomes[1]


def full(
    packet_ids: Iterable[int],
    *,
    size: int = STRIDE,
    status: int = 0,
    kind: int = PacketFormat.PAYLOAD,
    extended: bool = False,
) -> list[bytes]:
    """Packets of block 1 with content of `size` bytes."""
    return [
        PacketHeader(kind, 1, index, status, extended).encode() + bytes([index + 1]) * size
        for index in packet_ids
    ]


@pytest.mark.parametrize("order", [1, -1], ids=["in order", "backwards"])
@pytest.mark.parametrize("extended", [False, True])
def test_unusual_rows_are_as_good_as_single_packets(extended: bool, order: int) -> None:
    leader, *rest = block(1, extended=extended)
    trailer = rest.pop()
    for odd in (
        full(range(20, 30), extended=extended),  # beyond the payload
        full(range(12, 20), extended=extended),  # partly
        full(range(12, 17), extended=extended),  # by a part of the last
        full(range(4), extended=extended),  # the leader's id
        full(range(3, 7), size=STRIDE + 8, extended=extended),
        full(range(3, 7), size=0, extended=extended),
        full(range(3, 7), status=0x800C, extended=extended),
        full(range(3, 7), status=0x100, extended=extended),
        full(range(3, 7), kind=9, extended=extended),
    ):
        for before in ([leader], [leader, rest[0]], rest[:1], []):
            check_rows_and_singles_agree(before, odd[::order], [*rest, trailer])


@pytest.mark.parametrize("order", [1, -1], ids=["in order", "backwards"])
@pytest.mark.parametrize("extended", [False, True])
def test_rows_of_another_length_than_announced_are_followed(extended: bool, order: int) -> None:
    first, second = (block(block_id, extended=extended) for block_id in (1, 2))
    batches = (first[:2], first[2:LAST][::order], first[LAST:], second)
    bench, outcome = check_rows_and_singles_agree(*batches, stride=STRIDE + 36)
    assert outcome == [(1, True, 0, image(1)), (2, True, 0, image(2))]
    assert bench.assembler.stride == STRIDE


def test_after_rows_it_is_known_what_is_missing_and_what_is_to_come() -> None:
    bench, sent = Bench(), block(1)
    bench.feed(sent[:1])
    feed_rows(bench, sent[1:7])
    assert bench.assembler.expected() == LAST - 1 - 6
    feed_rows(bench, sent[9:12])
    assert bench.assembler.expected() == LAST - 1 - 11
    bench.wait(0.006)
    assert [(request.first, request.last) for request in bench.requests] == [(7, 8)]


def test_rows_that_the_device_marks_as_sent_again_are_counted() -> None:
    sent = block(1)
    again = full((5, 3, 4, 8), status=0x100)
    bench, _ = check_rows_and_singles_agree([sent[0], *again])
    assert bench.statistics.packets_resent == 4
    bench, _ = check_rows_and_singles_agree([*sent[:3], *again, *sent[9:]])
    assert bench.statistics.packets_resent == 4


datagram_lists = st.lists(
    st.one_of(
        fuzz_headers(),
        st.binary(max_size=30),
        st.builds(
            lambda block_id, index: block(block_id)[index],
            st.sampled_from([1, 2, 3]),
            st.integers(0, LAST),
        ),
        st.builds(lambda first, count: ("run", first, count), st.integers(1, LAST), st.integers(2, 12)),
    ),
    max_size=40,
)


@settings(max_examples=200)
@given(datagram_lists, st.booleans())
def test_rows_are_as_good_as_single_packets(drawn: list, extended: bool) -> None:  # type: ignore[type-arg]
    datagrams: list[bytes] = []
    for each in drawn:
        if isinstance(each, tuple):
            _, first, count = each
            datagrams += block(2, extended=extended)[first : first + count]
        else:
            datagrams.append(each)
    check_rows_and_singles_agree(datagrams)
