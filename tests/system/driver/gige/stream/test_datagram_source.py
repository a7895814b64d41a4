"""Both ways of receiving, over real sockets on the loopback, give the same images."""

from __future__ import annotations

import random
import socket
import threading
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from block_bench import LAST, SIZE, STRIDE, Bench, block, ids, is_image
from grabbergui.driver.gige.stream import batch_source, recvmmsg
from grabbergui.driver.gige.stream.assembler import BlockAssembler
from grabbergui.driver.gige.stream.block import Places
from grabbergui.driver.gige.stream.datagram_source import DatagramSource, PlainSource
from grabbergui.driver.gige.stream.in_place import Received
from grabbergui.driver.gige.stream.packet_origin import PacketOrigin
from grabbergui.driver.gige.stream.waits import Waits
from patience import PATIENCE, attempts

DEVICE = "127.0.0.7"
UDP_SEGMENT = 103


class InPlaceSource(batch_source.BatchSource):
    """Receives in place whatever it can, whether joined or not, and also after packets out of order."""

    def _can_receive_in_place(self, assembler: BlockAssembler, now: float) -> bool:
        return True


linux_only = pytest.mark.skipif(not recvmmsg.available(), reason="recvmmsg is Linux's")
SOURCES = [
    PlainSource,
    pytest.param(batch_source.BatchSource, marks=linux_only),
    pytest.param(InPlaceSource, marks=linux_only),
]


class Wire:
    """A device's socket, a stranger's and ours."""

    def __init__(self, stack: ExitStack, kind: type[DatagramSource]) -> None:
        def bound(ip: str) -> socket.socket:
            opened = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
            opened.bind((ip, 0))
            return opened

        self.device, self.stranger, self.receiver = bound(DEVICE), bound("127.0.0.8"), bound("127.0.0.1")
        self.source = kind(self.receiver, PacketOrigin(DEVICE, named=self.device.getsockname()[1]))  # type: ignore[call-arg]
        stack.callback(self.source.close)

        self.impostor = bound(DEVICE)
        "Sends from the device's address, but from another port."

    def send(self, datagrams: list[bytes], sender: socket.socket | None = None) -> None:
        for datagram in datagrams:
            (sender or self.device).sendto(datagram, self.receiver.getsockname())

    def drain(self, bench: Bench, packets: int) -> list:  # type: ignore[type-arg]
        """Receive so many datagrams, wherever they are counted."""
        done: list = []  # type: ignore[type-arg]
        while bench.statistics.packets + bench.statistics.packets_ignored < packets:
            self.source.receive(bench.assembler, 5.0)
            done += bench.assembler.finished()
        return done


@pytest.fixture(params=SOURCES)
def wire(request: pytest.FixtureRequest) -> Iterator[Wire]:
    with ExitStack() as stack:
        yield Wire(stack, request.param)


def test_a_wait_for_packets_ends_when_the_stream_does(wire: Wire) -> None:
    waiting = threading.Thread(target=wire.source.receive, args=(Bench().assembler, 600.0))
    waiting.start()
    wire.source.wake()
    waiting.join(PATIENCE)
    assert not waiting.is_alive()


def test_a_pause_ends_when_the_stream_does() -> None:
    waits = Waits()
    pausing = threading.Thread(target=waits.rest, args=(600.0,))
    pausing.start()
    waits.end()
    pausing.join(PATIENCE)
    waits.rest(600.0)  # nor does a later one last
    waits.close()
    assert not pausing.is_alive()


@pytest.mark.parametrize("extended", [False, True])
def test_every_image_sent_arrives_whole_and_in_order(wire: Wire, extended: bool) -> None:
    bench = Bench(buffers=20)
    sent = [datagram for block_id in range(1, 11) for datagram in block(block_id, extended=extended)]
    wire.send(sent)
    done = wire.drain(bench, len(sent))
    assert ids(done) == list(range(1, 11)) and all(map(is_image, done))
    assert bench.statistics.packets_ignored == bench.statistics.packets_duplicate == 0


def test_packets_from_another_port_of_the_cameras_address_forge_nothing(wire: Wire) -> None:
    """Without the check, 34 of 60 images were forged, and 50 leaders made it 372072 lost frames."""
    bench = Bench(buffers=20)
    sent, refused, done = 0, 0, []  # type: ignore[var-annotated]
    for block_id in range(1, 11):
        leader, *others = block(block_id)
        forged = [block(block_id + 40_000)[0], *(packet[:8] + bytes(len(packet) - 8) for packet in others)]
        wire.send(forged, wire.impostor)
        wire.send([leader, *others])
        wire.send(forged, wire.impostor)
        refused += 2 * len(forged)
        sent += 3 * len(forged)
        done += wire.drain(bench, sent)
    assert ids(done) == list(range(1, 11)) and all(map(is_image, done))
    assert bench.statistics.lost == bench.statistics.packets_duplicate == 0
    assert bench.statistics.packets_foreign == bench.statistics.packets_ignored == refused


@pytest.mark.parametrize("seed", range(20))
def test_gaps_doubles_and_late_packets_land_where_they_belong(wire: Wire, seed: int) -> None:
    dice = random.Random(seed)
    bench = Bench(buffers=20, initial_wait=60.0, max_blocks=8)
    sent = [datagram for block_id in range(1, 6) for datagram in block(block_id) * dice.choice([1, 2])]
    sent = [
        datagram for _, datagram in sorted(enumerate(sent), key=lambda pair: pair[0] + dice.uniform(0, 5))
    ]
    late = [sent.pop(dice.randrange(len(sent))) for _ in range(2)]
    sent[-1:-1] = late
    done = []
    for begin in range(0, len(sent), 50):
        wire.send(sent[begin : begin + 50])
        done += wire.drain(bench, min(begin + 50, len(sent)))
    assert ids(done) == [1, 2, 3, 4, 5] and all(map(is_image, done))


@linux_only
@pytest.mark.parametrize("kind", [batch_source.BatchSource, InPlaceSource])
@pytest.mark.parametrize("extended", [False, True])
@pytest.mark.parametrize("seed", range(5))
def test_packets_that_the_kernel_joined_are_taken_apart(
    kind: type[DatagramSource], seed: int, extended: bool
) -> None:
    """Sent in segments, they arrive joined: of changing number, with gaps, the last of them shorter."""
    dice = random.Random(seed)
    bench = Bench(buffers=20, initial_wait=60.0, max_blocks=8)
    with ExitStack() as stack:
        wire = Wire(stack, kind)
        packets, late = 0, []
        for block_id in range(1, 6):
            leader, *payload, trailer = block(block_id, extended=extended)
            late += [payload.pop(dice.randrange(len(payload) - 1)) for _ in range(2)]
            wire.send([leader])
            try:
                wire.device.setsockopt(socket.SOL_UDP, UDP_SEGMENT, len(payload[0]))
            except OSError:
                pytest.skip("this system does not segment")
            while payload:
                count = dice.choice([1, 3, 9])
                group, payload = payload[:count], payload[count:]
                wire.send([b"".join(group)])
                packets += len(group)
            wire.device.setsockopt(socket.SOL_UDP, UDP_SEGMENT, 0)
            wire.send([trailer])
            packets += 2
        done = wire.drain(bench, packets)
        wire.send(late)
        done += wire.drain(bench, packets + len(late))
    assert ids(done) == [1, 2, 3, 4, 5] and all(map(is_image, done))


@linux_only
@pytest.mark.parametrize("stride", [96, 100, 768, SIZE])
@pytest.mark.parametrize("seed", range(5))
def test_blocks_in_order_are_received_in_place(
    monkeypatch: pytest.MonkeyPatch, seed: int, stride: int
) -> None:
    """The last packet is full or short, the kernel joins any number of packets, and a stranger interferes."""
    dice = random.Random(seed)
    bench = Bench(buffers=20, stride=stride)
    placed: list[int] = []
    receive = bench.assembler.receive_in_place

    def receive_in_place(headers: NDArray[np.uint8], places: Places, now: float) -> int:
        placed.append(len(headers))
        return receive(headers, places, now)

    monkeypatch.setattr(bench.assembler, "receive_in_place", receive_in_place)
    done, packets, foreign = [], 0, 0
    with ExitStack() as stack:
        wire = Wire(stack, InPlaceSource)
        for block_id in range(1, 6):
            leader, *payload, trailer = block(block_id, stride=stride)
            packets += len(payload) + 2
            wire.send([leader])
            try:
                wire.device.setsockopt(socket.SOL_UDP, UDP_SEGMENT, len(payload[0]))
            except OSError:
                pytest.skip("this system does not segment")
            while payload:
                count = dice.choice([1, 2, 5, 16])
                group, payload = payload[:count], payload[count:]
                if dice.random() < 0.3:
                    wire.send(group[:1], dice.choice([wire.stranger, wire.impostor]))
                    foreign += 1
                wire.send([b"".join(group)])
            wire.device.setsockopt(socket.SOL_UDP, UDP_SEGMENT, 0)
            wire.send([trailer])
            done += wire.drain(bench, packets + foreign)
    assert ids(done) == [1, 2, 3, 4, 5] and all(map(is_image, done))
    assert bench.statistics.packets_ignored == foreign and bench.statistics.packets_duplicate == 0
    assert sum(placed) == SIZE // stride * 5


@linux_only
def test_as_many_packets_as_a_sender_joins_are_received_in_place() -> None:
    """GRO joins up to 64, but a local sender up to 128 since Linux 6.9, which arrive as they were sent."""
    bench = Bench(stride=16)
    with ExitStack() as stack:
        wire = Wire(stack, InPlaceSource)
        leader, *payload, trailer = block(1, stride=16)
        wire.send([leader])
        wire.drain(bench, 1)
        try:
            wire.device.setsockopt(socket.SOL_UDP, UDP_SEGMENT, len(payload[0]))
            wire.send([b"".join(payload)])
        except OSError:
            pytest.skip("this system does not segment, or not so many packets")
        wire.device.setsockopt(socket.SOL_UDP, UDP_SEGMENT, 0)
        wire.send([trailer])
        (done,) = wire.drain(bench, len(payload) + 2)
    assert is_image(done)


@linux_only
def test_packets_without_a_known_place_are_read_many_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """A trailer and a leader are read singly, as joined packets may follow; packets sent again are not."""
    bench = Bench(stride=16)
    reads: list[int] = []
    with ExitStack() as stack:
        wire = Wire(stack, InPlaceSource)
        slots = wire.source._slots  # type: ignore[attr-defined]
        receive = slots.receive

        def count(descriptor: int, begin: int, end: int) -> int:
            reads.append(end - begin)
            received: int = receive(descriptor, begin, end)
            return received

        monkeypatch.setattr(slots, "receive", count)
        leader, *payload, _ = block(1, stride=16)
        wire.send([*payload, leader])
        (done,) = wire.drain(bench, len(payload) + 1)
    assert is_image(done)
    assert reads.count(1) == batch_source.SHORT_DATAGRAMS and len(reads) < 10


@linux_only
def test_a_stream_out_of_order_is_not_received_in_place_for_a_while(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batch_source, "LONG", STRIDE)
    monkeypatch.setattr(batch_source, "LARGE", SIZE)
    bench = Bench(buffers=40, initial_wait=60.0, max_blocks=20)
    reads: list[int] = []
    with ExitStack() as stack:
        wire = Wire(stack, batch_source.BatchSource)
        reader = wire.source._in_place  # type: ignore[attr-defined]
        read = reader.receive

        def receive(*arguments: Any) -> Received:
            reads.append(1)
            received: Received = read(*arguments)
            return received

        monkeypatch.setattr(reader, "receive", receive)
        done, packets = [], 0
        for block_id in range(1, 31):
            sent = block(block_id)
            sent[1:5] = sent[4:0:-1]
            packets += len(sent)
            wire.send(sent)
            done += wire.drain(bench, packets)
    assert ids(done) == list(range(1, 31)) and all(map(is_image, done))
    assert 0 < len(reads) < 10


def test_strangers_are_not_heard(wire: Wire) -> None:
    bench = Bench()
    mine, foreign = block(1), block(1, data=bytes(64 * 24))
    for own, other in zip(mine, foreign, strict=True):
        wire.send([other], wire.stranger)
        wire.send([own])
    (done,) = wire.drain(bench, 2 * (LAST + 1))
    assert is_image(done) and bench.statistics.packets_ignored == LAST + 1


def test_odd_datagrams_are_dropped(wire: Wire) -> None:
    bench = Bench()
    sent = block(1)
    odd = [b"", b"\0", bytes(60000), sent[3] + bytes(50000)]
    wire.send([*sent[:3], *odd])
    assert wire.drain(bench, 3 + 3) == []
    wire.source.receive(bench.assembler, 0.0)
    assert bench.statistics.packets_ignored == 3, "block id 0 is a test packet, which is no fault"


def test_ids_change_their_width_in_mid_stream(wire: Wire) -> None:
    bench = Bench()
    sent = [*block(1), *block(2, extended=True), *block(3, extended=True), *block(4)]
    wire.send(sent)
    done = wire.drain(bench, len(sent))
    assert len(done) == 4 and all(map(is_image, done))


def test_nothing_to_receive_takes_no_longer_than_allowed(wire: Wire) -> None:
    for watch in attempts(0.1):
        with watch:
            wire.source.receive(Bench().assembler, 0.01)


@linux_only
def test_behind_packets_that_never_end_what_waits_is_skipped(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(recvmmsg, "SLOTS", 4)
    monkeypatch.setattr(batch_source, "BATCHES", 1)
    monkeypatch.setattr(batch_source, "OVERRUN", 0.0)
    bench = Bench(max_blocks=1)
    with ExitStack() as stack:
        wire = Wire(stack, batch_source.BatchSource)
        wire.send([datagram for block_id in range(1, 9) for datagram in block(block_id)[:3]])
        while not bench.statistics.incomplete:
            wire.source.receive(bench.assembler, 0.0)
        assert bench.statistics.packets < 12
        for _ in range(2):
            wire.source.receive(bench.assembler, 0.0)
        assert bench.statistics.packets < 12 and "faster than this machine" in caplog.text
        assert bench.statistics.overruns > 0
        monkeypatch.undo()
        wire.send([*block(9), *block(10)])
        done = wire.drain(bench, bench.statistics.packets + 2 * (LAST + 1))
    assert ids(done) == [9, 10] and all(map(is_image, done))
