"""The compiled loops store packets as the assembler does one by one: the same packets, the same result."""

from __future__ import annotations

import random
import socket
import time
from collections.abc import Iterator
from dataclasses import asdict

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_gige_block_assembler import LAST, STRIDE, Bench, block, ids, is_picture

from grabbergui.driver.gige.gvcp import Status
from grabbergui.driver.gige.gvsp import EXTENDED_BIT, FLAG_RESEND, Leader, PacketFormat, PacketHeader
from grabbergui.driver.gige.stream import fast_path, recvmmsg
from grabbergui.driver.gige.stream.block import Block
from grabbergui.driver.gige.stream.fast_path import LOOPS

pytest.importorskip("numba", reason="the loops are compiled by numba")
pytestmark = pytest.mark.skipif(not recvmmsg.available(), reason="the loops call Linux's recvmmsg")

DEVICE, HOST = "127.21.0.7", "127.21.0.1"
UDP_SEGMENT = 103


@pytest.fixture(scope="module", autouse=True)
def loops() -> None:
    assert LOOPS.wait()


class Wire:
    """A device's socket, and a source that reads it by the loops."""

    def __init__(self) -> None:
        self.device = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.device.bind((DEVICE, 0))
        self.host = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.host.bind((HOST, 0))
        self.source = recvmmsg.BatchSource(self.host, DEVICE)

    def receive(self, datagrams: list[bytes], bench: Bench) -> list[Block]:
        """Send them, and take what arrives."""
        done = []
        for begin in range(0, len(datagrams), 40):
            for datagram in datagrams[begin : begin + 40]:
                self.device.sendto(datagram, self.host.getsockname())
            done += self.drain(bench)
        return done

    def drain(self, bench: Bench) -> list[Block]:
        """Take all that was sent: on the loopback it has arrived."""
        done: list[Block] = []
        counters, unchanged = bench.statistics, 0
        while unchanged < 2:
            before = counters.packets, counters.packets_ignored
            self.source.receive(bench.assembler, 0.0)
            done += bench.assembler.finished()
            unchanged = unchanged + 1 if before == (counters.packets, counters.packets_ignored) else 0
        return done

    def close(self) -> None:
        self.device.close()
        self.host.close()


@pytest.fixture
def wire() -> Iterator[Wire]:
    made = Wire()
    yield made
    made.close()


def sent_again(datagram: bytes, extended: bool) -> bytes:
    """The packet as a device marks it when it sends it again."""
    header = bytearray(datagram)
    if extended:
        header[3] |= FLAG_RESEND
    else:
        header[:2] = int(Status.PACKET_RESEND).to_bytes(2, "big")
    return bytes(header)


def renumbered(datagrams: list[bytes], block_id: int) -> list[bytes]:
    """The same packets with another block id, perhaps one of 64 bits."""
    if datagrams[0][4] & EXTENDED_BIT:
        return [each[:8] + block_id.to_bytes(8, "big") + each[16:] for each in datagrams]
    return [each[:2] + block_id.to_bytes(2, "big") + each[4:] for each in datagrams]


def disturbed(dice: random.Random, *, extended: bool, first: int) -> list[bytes]:
    """Packets of some blocks, in disorder, some of them missing, doubled, marked or of no use."""
    block_ids = [first + index for index in range(5)]
    if not extended:
        block_ids = [(block_id - 1) % 0xFFFF + 1 for block_id in block_ids]
    packets = []
    for block_id in block_ids:
        loss, double, late = dice.choice([0, 0, 0.1]), dice.choice([0, 0, 0.2]), dice.choice([0, 0, 3, 25])
        own: list[tuple[float, bytes]] = []
        whole = block(block_id % 1000, extended=extended, payload_type=dice.choice([1, 0x4001]))
        for index, datagram in enumerate(renumbered(whole, block_id)):
            if dice.random() < loss:
                continue
            again = sent_again(datagram, extended) if dice.random() < loss else datagram
            place = index + (dice.uniform(0, late) if dice.random() < 0.3 else 0)
            own.append((place, again))
            if dice.random() < double:
                own.append((place + dice.uniform(0, 5), datagram))
        packets += [datagram for _, datagram in sorted(own, key=lambda pair: pair[0])]
        if dice.random() < 0.3:
            packets.insert(dice.randrange(len(packets)), dice.randbytes(dice.choice([1, 8, STRIDE + 8])))
    return packets


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 1 << 32), st.booleans(), st.sampled_from([1, 65533, (1 << 63) - 2, (1 << 64) - 8]))
def test_the_result_is_that_of_single_packets(seed: int, extended: bool, first: int) -> None:
    if not extended:
        first = first % 0xFFFF or 1
    datagrams = disturbed(random.Random(seed), extended=extended, first=first)
    singly, compiled = (
        Bench(
            buffers=20,
            initial_wait=60.0,
            tail_wait=60.0,
            give_up=600.0,
            max_blocks=8,
            deliver_incomplete=True,
        )
        for _ in range(2)
    )
    expected = singly.feed(datagrams, period=0)
    wire = Wire()
    try:
        found = wire.receive(datagrams, compiled)
    finally:
        wire.close()
    for bench, done in ((singly, expected), (compiled, found)):
        bench.assembler.flush()
        done += bench.assembler.finished()
    assert asdict(compiled.statistics) == asdict(singly.statistics)
    assert ids(found) == ids(expected)
    for mine, theirs in zip(found, expected, strict=True):
        assert mine.complete == theirs.complete and mine.missing_bytes == theirs.missing_bytes
        assert mine.payload.tobytes() == theirs.payload.tobytes()


@pytest.mark.parametrize("extended", [False, True])
def test_python_sees_few_packets_only(wire: Wire, monkeypatch: pytest.MonkeyPatch, extended: bool) -> None:
    """Leader, the short last packet and the trailer of each block; everything else stays in the loops."""
    bench = Bench(buffers=20)
    seen: list[int] = []
    receive = bench.assembler.receive

    def noted(datagram: bytes | memoryview, now: float) -> None:
        seen.append(PacketHeader.decode(datagram).packet_id)
        receive(datagram, now)

    monkeypatch.setattr(bench.assembler, "receive", noted)
    monkeypatch.setattr(bench.assembler, "receive_rows", None)
    done = wire.receive(
        [each for block_id in (1, 2, 3) for each in block(block_id, extended=extended)], bench
    )
    assert ids(done) == [1, 2, 3] and all(map(is_picture, done))
    assert seen == [0, LAST - 1, LAST] * 3


def test_a_gap_is_reported_before_the_block_ends(wire: Wire) -> None:
    """Lost packets are requested while the rest arrives, not when the loop happens to return."""
    bench = Bench(buffers=2, initial_wait=0.0, look_again=0.02, tail_wait=60.0)
    wire.receive([each for index, each in enumerate(block(1)) if index not in (5, 6)][:12], bench)
    bench.assembler.handle_timer(time.monotonic() + 0.1)
    (request,) = bench.assembler.resend_requests()
    assert (request.first, request.last) == (5, 6)


def test_a_packet_that_was_overtaken_is_learned_from(wire: Wire) -> None:
    bench = Bench(buffers=2)
    leader, *payload = block(1)
    payload[3], payload[9] = payload[9], payload[3]
    before = bench.assembler._resender.initial_wait
    done = wire.receive([leader, *payload], bench)
    assert ids(done) == [1] and is_picture(done[0])
    assert bench.assembler._resender._overtaken._mean is not None
    assert bench.assembler._resender.initial_wait >= before


def test_answers_are_counted_and_timed(wire: Wire) -> None:
    bench = Bench(buffers=2, initial_wait=0.0, look_again=0.0)
    packets = block(1)
    wire.receive([each for index, each in enumerate(packets) if index not in (5, 6)][:-3], bench)
    bench.assembler.handle_timer(time.monotonic() + 0.1)
    assert list(bench.assembler.resend_requests())
    for packet in packets[5:7]:
        wire.device.sendto(sent_again(packet, extended=False), wire.host.getsockname())
    wire.drain(bench)
    assert bench.statistics.packets_resent == 2
    assert bench.assembler._resender._window.room(1e9) == bench.assembler.policy.max_unanswered


def test_more_late_packets_than_the_loops_note(wire: Wire) -> None:
    size = 2 * fast_path.MOST_NOTED * STRIDE
    bench = Bench(payload_size=size, buffers=2)
    count = size // STRIDE
    leader = (
        PacketHeader(PacketFormat.LEADER, 1, 0).encode() + Leader(1, 0, 0x01080001, STRIDE, count).encode()
    )
    packets = [
        PacketHeader(PacketFormat.PAYLOAD, 1, index).encode() + bytes([index % 251]) * STRIDE
        for index in range(1, count + 1)
    ]
    done = wire.receive([leader, packets[-1], *packets[:-1]], bench)
    assert ids(done) == [1] and done[0].complete
    assert done[0].payload.reshape(count, STRIDE)[:, 0].tolist() == [i % 251 for i in range(1, count + 1)]
