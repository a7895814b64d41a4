"""Several sockets at one port hold what one would lose, over real sockets on the loopback."""

from __future__ import annotations

import socket
import sys
from collections.abc import Iterator
from contextlib import ExitStack, closing
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from block_bench import LAST, Bench, block, ids, is_image
from grabbergui.driver.gige.packet_header import PacketFormat, PacketHeader
from grabbergui.driver.gige.stream import socket_group
from grabbergui.driver.gige.stream.batch_source import BatchSource
from grabbergui.driver.gige.stream.packet_origin import PacketOrigin
from grabbergui.driver.gige.stream.socket_group import MEMBERS, run_bits, widen
from grabbergui.driver.gige.stream.sockets import buffer_bytes

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="sockets that share a port are Linux's")

DEVICE = "127.0.0.7"
LITTLE = 16_384
"Bytes for SO_RCVBUF; granted twice, as the kernel counts."
WANTED = 1 << 20


class Port:
    """A device's socket, and ours with a small buffer."""

    def __init__(self, stack: ExitStack) -> None:
        self.device = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        self.device.bind((DEVICE, 0))
        self.receiver = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        self.receiver.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, LITTLE)
        self.receiver.bind(("127.0.0.1", 0))

    def send(self, datagrams: list[bytes]) -> None:
        for datagram in datagrams:
            self.device.sendto(datagram, self.receiver.getsockname())


@pytest.fixture
def port() -> Iterator[Port]:
    with ExitStack() as stack:
        yield Port(stack)


def drain(source: BatchSource, bench: Bench) -> list:  # type: ignore[type-arg]
    done, before = [], -1
    while bench.statistics.packets != before:
        before = bench.statistics.packets
        source.receive(bench.assembler, 0.05)
        done += bench.tick()
    return done


@pytest.mark.parametrize("extended", [False, True])
def test_stretches_of_packets_alternate_between_the_sockets(port: Port, extended: bool) -> None:
    run = 1 << run_bits(buffer_bytes(port.receiver), 1400)
    more = widen(port.receiver, WANTED, 1400)
    assert len(more) == MEMBERS - 1
    wanted = [0, 1, run - 1, run, 2 * run, run * MEMBERS - 1, run * MEMBERS]
    with ExitStack() as stack:
        members = [port.receiver, *(stack.enter_context(member) for member in more)]
        for each in wanted:
            port.send([PacketHeader(PacketFormat.PAYLOAD, 7, each, extended=extended).encode()])
        port.send([b"\3"])
        found = []
        for index, member in enumerate(members):
            member.setblocking(False)
            while True:
                try:
                    datagram = member.recv(2048)
                except BlockingIOError:
                    break
                if len(datagram) == 1:
                    assert index == 0, "a datagram that is too short goes to the first socket"
                else:
                    found.append((PacketHeader.decode(datagram).packet_id, index))
    assert sorted(found) == [(each, each // run % MEMBERS) for each in wanted]


def long_block(stride: int, packets: int, *, extended: bool = False) -> list[bytes]:
    """The datagrams of one frame with so many payload packets."""
    bodies = bytes(index % 251 for index in range(stride * packets))
    leader = block(1, extended=extended)[0]
    payload = [
        PacketHeader(PacketFormat.PAYLOAD, 1, index + 1, extended=extended).encode()
        + bodies[index * stride : (index + 1) * stride]
        for index in range(packets)
    ]
    trailer = PacketHeader(PacketFormat.TRAILER, 1, packets + 1, extended=extended).encode()
    return [leader, *payload, trailer + block(1, extended=extended)[-1][-8:]]


@pytest.mark.parametrize("extended", [False, True])
def test_more_is_held_than_one_socket_can(port: Port, extended: bool) -> None:
    """Nobody reads while the images come; they are in order afterwards and nothing is asked for."""
    stride, packets = 100, 400
    bench = Bench(payload_size=stride * packets, stride=stride, buffers=8)
    alone = int(buffer_bytes(port.receiver) / 768)
    assert alone < packets / 4, "one socket holds a fraction of it"
    more = widen(port.receiver, WANTED, stride)
    source = BatchSource(port.receiver, PacketOrigin(DEVICE), more)
    try:
        port.send(long_block(stride, packets, extended=extended))
        drain(source, bench)
        bench.assembler.flush()
    finally:
        source.close()
    assert bench.statistics.packets == packets + 2
    assert bench.statistics.incomplete == 0 and bench.requests == []


def test_packets_of_several_sockets_are_taken_at_once(port: Port, monkeypatch: pytest.MonkeyPatch) -> None:
    stride, packets = 100, 60
    assert packets > 4 << run_bits(buffer_bytes(port.receiver), stride), "they lie in several sockets"
    bench = Bench(payload_size=stride * packets, stride=stride, buffers=8)
    batches: list[int] = []
    receive_rows = bench.assembler.receive_rows

    def counting(rows: NDArray[np.uint8], *arguments: Any) -> None:
        batches.append(len(rows))
        receive_rows(rows, *arguments)

    monkeypatch.setattr(bench.assembler, "receive_rows", counting)
    source = BatchSource(port.receiver, PacketOrigin(DEVICE), widen(port.receiver, WANTED, stride))
    try:
        port.send(long_block(stride, packets))
        drain(source, bench)
    finally:
        source.close()
    assert max(batches) == packets and bench.statistics.packets == packets + 2


def test_images_arrive_in_order(port: Port) -> None:
    bench = Bench(buffers=30)
    source = BatchSource(port.receiver, PacketOrigin(DEVICE), widen(port.receiver, WANTED, 100))
    done = []
    try:
        for block_id in range(1, 21):
            port.send(block(block_id))
            done += drain(source, bench)
    finally:
        source.close()
    assert ids(done) == list(range(1, 21)) and all(map(is_image, done))
    assert bench.statistics.packets == 20 * (LAST + 1) and bench.requests == []


def test_one_socket_that_holds_enough_stays_alone(port: Port) -> None:
    assert widen(port.receiver, buffer_bytes(port.receiver), 1400) == []


def test_a_system_that_cannot_leaves_one_socket(port: Port, monkeypatch: pytest.MonkeyPatch) -> None:
    opened = []

    def refuse(receiver: socket.socket, option: int, program: list[socket_group.Instruction]) -> None:
        opened.append(len(program))
        raise OSError("not here")

    monkeypatch.setattr(socket_group, "_attach", refuse)
    assert widen(port.receiver, WANTED, 1400) == [] and opened
    bench = Bench()
    with closing(BatchSource(port.receiver, PacketOrigin(DEVICE))) as source:
        port.send(block(1))
        assert ids(drain(source, bench)) == [1]


def test_a_stretch_is_half_of_what_a_socket_holds() -> None:
    assert [1 << run_bits(425_984, size) for size in (576, 1400, 8164, 65_000)] == [64, 64, 16, 2]
    assert run_bits(2304, 9000) == 0
