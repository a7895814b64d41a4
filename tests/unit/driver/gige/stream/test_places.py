"""Packets whose data is in its place before their headers are looked at."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from block_bench import LAST, SIZE, STRIDE, Bench, block, is_image
from grabbergui.driver.gige.gvcp import Status
from grabbergui.driver.gige.gvsp import Leader, PayloadKind, Trailer
from grabbergui.driver.gige.packet_header import PacketFormat, PacketHeader
from grabbergui.driver.gige.stream.block import Places

FULL = SIZE // STRIDE
"Packets of an image that are full; another one is shorter."
EACH = pytest.mark.parametrize("extended", [False, True], ids=["standard", "extended"])


def places_of(bench: Bench) -> Places:
    places = bench.assembler.next_places()
    assert places is not None
    return places


def headers_of(datagrams: Sequence[bytes], size: int) -> NDArray[np.uint8]:
    return np.array([list(datagram[:size]) for datagram in datagrams], np.uint8)


def receive(bench: Bench, places: Places, datagrams: Sequence[bytes]) -> int:
    """Put the packets' data where the next ones belong, as `recvmsg` does, and their headers beside."""
    for line, datagram in enumerate(datagrams, places.first - 1):
        places.lines[line] = np.frombuffer(datagram[places.header_size :], np.uint8)
    headers = headers_of(datagrams, places.header_size)
    return bench.assembler.receive_in_place(headers, places, bench.now)


@EACH
def test_an_image_is_received_without_a_copy(extended: bool) -> None:
    bench = Bench()
    sent = block(1, extended=extended)
    bench.feed(sent[:1])
    places = places_of(bench)
    assert (places.first, places.header_size) == (1, 20 if extended else 8)
    assert places.packet_length == STRIDE + places.header_size and places.lines.shape == (FULL, STRIDE)
    assert receive(bench, places, sent[1:7]) == 6
    assert bench.assembler.expected() == LAST - 1 - 6
    places = places_of(bench)
    assert places.first == 7
    assert receive(bench, places, sent[7 : FULL + 1]) == FULL - 6
    assert bench.assembler.next_places() is None, "the last packet is shorter"
    (done,) = bench.feed(sent[FULL + 1 :])
    assert is_image(done) and bench.requests == []
    assert (bench.statistics.packets, bench.statistics.packets_duplicate) == (LAST + 1, 0)


def test_there_are_places_only_for_full_packets_of_an_open_image() -> None:
    bench = Bench()
    sent = block(1)
    assert bench.assembler.next_places() is None, "no block is open"
    bench.feed(sent[1:2])
    assert bench.assembler.next_places() is None, "its leader is missing"
    bench.feed(sent[:1])
    assert places_of(bench).first == 2
    bench.feed(sent[-1:])
    assert bench.assembler.next_places() is None, "only lost packets may still arrive"
    bench.feed(block(2)[:3])
    assert places_of(bench).first == 3, "of the newest block"


@pytest.mark.parametrize(
    "leader",
    [
        Leader(0x4001, 5, 0x01080001, 64, 24),
        Leader(PayloadKind.H264, size=SIZE),
        Leader(0x8001, 5),
        Leader(PayloadKind.IMAGE, 5, 0x01080001, 64, 200),
    ],
    ids=["chunks", "video", "unknown", "too large"],
)
def test_there_are_no_places_where_packets_are_no_lines_of_an_image(leader: Leader) -> None:
    bench = Bench()
    bench.feed([PacketHeader(PacketFormat.LEADER, 1, 0).encode() + leader.encode()])
    assert bench.assembler.next_places() is None


def test_there_are_no_places_without_a_buffer() -> None:
    bench = Bench(buffers=1)
    bench.feed(block(1)[:3])
    bench.feed(block(2)[:1])
    assert bench.statistics.underruns == 1 and bench.assembler.next_places() is None


def test_packets_are_in_place_up_to_a_gap() -> None:
    bench = Bench()
    sent = block(1)
    bench.feed(sent[:1])
    places = places_of(bench)
    assert receive(bench, places, [sent[1], sent[2], sent[4]]) == 2
    assert places_of(bench).first == 3
    (done,) = bench.feed(sent[3:])
    assert is_image(done) and bench.statistics.packets == LAST + 1


@EACH
@pytest.mark.parametrize(
    "header",
    [
        PacketHeader(PacketFormat.PAYLOAD, 1, 4),
        PacketHeader(PacketFormat.PAYLOAD, 1, 2),
        PacketHeader(PacketFormat.PAYLOAD, 2, 3),
        PacketHeader(PacketFormat.TRAILER, 1, 3),
        PacketHeader(PacketFormat.PAYLOAD, 1, 3, Status.PACKET_UNAVAILABLE),
        PacketHeader(PacketFormat.PAYLOAD, 1, 3, Status.PACKET_RESEND),
    ],
    ids=["later", "earlier", "next block", "trailer", "unavailable", "resent"],
)
def test_other_packets_than_the_next_are_not_taken(header: PacketHeader, extended: bool) -> None:
    bench = Bench()
    sent = block(1, extended=extended)
    bench.feed(sent[:3])
    places = places_of(bench)
    strange = PacketHeader(
        header.format, header.block_id, header.packet_id, header.status, extended
    ).encode() + bytes(STRIDE)
    assert receive(bench, places, [strange]) == 0
    assert bench.statistics.packets == 3
    (done,) = bench.feed(sent[3:])
    assert is_image(done)


def test_packets_of_another_length_are_not_taken() -> None:
    bench = Bench()
    sent = block(1)
    bench.feed(sent[:1])
    places = places_of(bench)
    shorter = Places(places.first, places.header_size, places.lines[:, :50])
    assert bench.assembler.receive_in_place(headers_of(sent[1:3], 8), shorter, bench.now) == 0
    (done,) = bench.feed(sent[1:])
    assert is_image(done)


def test_a_gap_before_packets_in_place_is_requested() -> None:
    bench = Bench()
    sent = block(1)
    bench.feed([sent[0], sent[3]])
    assert receive(bench, places_of(bench), sent[4:8]) == 4
    bench.wait(0.02)
    assert [(request.first, request.last) for request in bench.requests] == [(1, 2)]


def test_an_image_of_full_packets_only_ends_with_its_last_line() -> None:
    bench = Bench(payload_size=4 * STRIDE)
    leader = Leader(1, 5, 0x01080001, STRIDE, 4)
    data = [bytes([number]) * STRIDE for number in range(1, 5)]
    bench.feed([PacketHeader(PacketFormat.LEADER, 1, 0).encode() + leader.encode()])
    lines = [
        PacketHeader(PacketFormat.PAYLOAD, 1, packet_id).encode() + line
        for packet_id, line in enumerate(data, 1)
    ]
    assert receive(bench, places_of(bench), lines) == 4
    trailer = Trailer(1, 4).encode()
    (done,) = bench.tick() + bench.feed([PacketHeader(PacketFormat.TRAILER, 1, 5).encode() + trailer])
    assert done.complete and done.payload.tobytes() == b"".join(data)
