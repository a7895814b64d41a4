"""A packet ring on the loopback, packet by packet: what it sees, what it does not, and who takes over."""

from __future__ import annotations

import mmap
import socket
import struct
import threading
import time
from collections.abc import Iterator

import numpy as np
import pytest
from packet_sockets import may_open_packet_sockets

from grabbergui.core.frame import BufferPool
from grabbergui.core.pfnc import by_name
from grabbergui.driver.gige.gvsp import Leader, PacketFormat, PacketHeader, PayloadKind, Trailer
from grabbergui.driver.gige.stream import packet_ring, ring_memory
from grabbergui.driver.gige.stream.assembler import BlockAssembler
from grabbergui.driver.gige.stream.batches import BatchSource
from grabbergui.driver.gige.stream.packet_ring import PacketRing
from grabbergui.driver.gige.stream.recvmmsg import DONT_WAIT
from grabbergui.driver.gige.stream.ring_memory import Geometry, SpareRing
from grabbergui.driver.gige.stream.sockets import NOTHING
from patience import PATIENCE, until

pytestmark = pytest.mark.skipif(not may_open_packet_sockets(), reason="packet sockets need CAP_NET_RAW")

DEVICE, HOST, STRANGER = "127.16.8.2", "127.16.8.1", "127.16.8.3"
PACKET_SIZE = 1000
STRIDE = PACKET_SIZE - 28 - 8
WIDTH, HEIGHT = 600, 40
PAYLOAD = WIDTH * HEIGHT
UDP_SEGMENT = 103


def block(block_id: int) -> list[bytes]:
    """All packets of a frame whose pixels depend on its id."""

    def packet(kind: PacketFormat, packet_id: int, body: bytes) -> bytes:
        return PacketHeader(kind, block_id, packet_id).encode() + body

    pixels = image(block_id)
    pieces = [pixels[at : at + STRIDE] for at in range(0, PAYLOAD, STRIDE)]
    leader = Leader(PayloadKind.IMAGE, 0, by_name("Mono8").code, WIDTH, HEIGHT).encode()
    return [
        packet(PacketFormat.LEADER, 0, leader),
        *(packet(PacketFormat.PAYLOAD, index, piece) for index, piece in enumerate(pieces, 1)),
        packet(PacketFormat.TRAILER, len(pieces) + 1, Trailer(PayloadKind.IMAGE, HEIGHT).encode()),
    ]


def image(block_id: int) -> bytes:
    return (np.arange(PAYLOAD) * 7 + block_id).astype(np.uint8).tobytes()


class Stand:
    """A ring, its UDP socket, a device that sends, and the blocks that arrive."""

    def __init__(self, packet_size: int = PACKET_SIZE, spare: SpareRing | None = None) -> None:
        self.spare = spare or SpareRing()
        self.device = bound(DEVICE)
        self.receiver = bound(HOST)
        self.address = self.receiver.getsockname()
        pool = BufferPool(PAYLOAD)
        self.assembler = BlockAssembler(STRIDE, PAYLOAD, pool.take)
        self.ring = PacketRing(
            self.receiver,
            DEVICE,
            lambda: BatchSource(self.receiver, DEVICE),
            self.spare,
            packet_size=packet_size,
            wanted=0,
        )

    def send(self, packets: list[bytes]) -> None:
        for packet in packets:
            self.device.sendto(packet, self.address)

    def expect(self, *block_ids: int) -> None:
        """These blocks, whole, and nothing else."""
        deadline = time.monotonic() + PATIENCE
        found: list[int] = []
        while len(found) < len(block_ids):
            self.ring.receive(self.assembler, 0.05)
            for each in self.assembler.finished():
                assert each.complete and each.payload.tobytes() == image(each.block_id)
                found.append(each.block_id)
            assert time.monotonic() < deadline, f"only {found} of {block_ids} arrived: {self.statistics}"
        assert tuple(found) == block_ids

    def idle(self) -> None:
        """Wait for packets, of which none come."""
        self.ring.receive(self.assembler, 0.001)

    @property
    def statistics(self) -> dict[str, object]:
        return self.assembler.statistics.as_dict()

    def socket_is_empty(self) -> bool:
        try:
            self.receiver.recv(1, DONT_WAIT | socket.MSG_PEEK)
        except BlockingIOError:
            return True
        return False

    def close(self) -> None:
        self.ring.close()
        self.spare.free()
        self.receiver.close()
        self.device.close()


def bound(ip: str) -> socket.socket:
    opened = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    opened.bind((ip, 0))
    return opened


@pytest.fixture
def stand() -> Iterator[Stand]:
    made = Stand()
    yield made
    made.close()


def test_frames_come_through_the_ring_once_and_the_socket_is_emptied(stand: Stand) -> None:
    for block_id in (1, 2, 3):
        stand.send(block(block_id))
        stand.expect(block_id)
    assert not stand.ring.failed
    assert stand.socket_is_empty()
    assert stand.assembler.statistics.packets == 3 * len(block(1))
    assert stand.assembler.statistics.packets_duplicate == 0


@pytest.mark.parametrize("proved", [False, True])
def test_a_wait_for_packets_ends_when_the_stream_does(stand: Stand, proved: bool) -> None:
    """Whether the UDP socket still receives all, or the trailers only."""
    for block_id in range(1, packet_ring.PROOF // len(block(1)) + 2 if proved else 1):
        stand.send(block(block_id))
        stand.expect(block_id)
    waiting = threading.Thread(target=stand.ring.receive, args=(stand.assembler, 600.0))
    waiting.start()
    stand.ring.wake()
    waiting.join(PATIENCE)
    assert not waiting.is_alive()


def test_each_full_round_of_the_ring_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ring_memory, "LEAST_BYTES", 300 * PACKET_SIZE)
    stand = Stand()
    try:
        for first in range(1, 200, 5):  # 140 of some 340 slots at a time
            ids = range(first, first + 5)
            for block_id in ids:
                stand.send(block(block_id))
            stand.expect(*ids)
        assert not stand.ring.failed
    finally:
        stand.close()


def test_packets_are_discarded_up_to_the_first_that_still_arrives(stand: Stand) -> None:
    """Otherwise the ring would wait for a slot behind one that the kernel waits for, for ever."""
    stand.send(block(1)[:5])
    statuses = stand.ring._ring.statuses
    until(lambda: statuses[:5].all())
    statuses[2] = 0
    stand.ring._discard()
    assert statuses[:5].astype(bool).tolist() == [False, False, False, True, True]
    statuses[2] = 1
    stand.ring._discard()
    assert not statuses.any()
    stand.send(block(2))
    stand.expect(2)


def test_a_pause_ends_with_the_block_in_which_packets_gather(stand: Stand) -> None:
    stand.send(block(1))
    stand.expect(1)
    *others, trailer = block(2)
    stand.send(others)
    assert stand.ring._rest(0.002)
    stand.send([trailer])
    assert not stand.ring._rest(PATIENCE)
    assert stand.socket_is_empty()
    stand.expect(2)


# -- packets that a ring cannot read -----------------------------------------------------------------
def fragments(packet: bytes, address: tuple[str, int], source_port: int) -> list[bytes]:
    """IP packets, from the header on, whose fragments the kernel joins to one datagram."""
    udp = struct.pack(">4H", source_port, address[1], 8 + len(packet), 0) + packet
    found = []
    for at in range(0, len(udp), 504):
        piece = udp[at : at + 504]
        more = at + len(piece) < len(udp)
        number = int.from_bytes(packet[2:8], "big") & 0xFFFF
        found.append(
            struct.pack(">BBHHHBBH", 0x45, 0, 20 + len(piece), number, more << 13 | at // 8, 64, 17, 0)
            + socket.inet_aton(DEVICE)
            + socket.inet_aton(address[0])
            + piece
        )
    return found


def test_fragments_are_received_by_the_socket(stand: Stand) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_RAW, socket.IPPROTO_RAW) as raw:
        for packet in block(1):
            for fragment in fragments(packet, stand.address, stand.device.getsockname()[1]):
                raw.sendto(fragment, (HOST, 0))
    stand.expect(1)
    assert stand.ring.failed


def test_packets_with_ip_options_are_received_by_the_socket(stand: Stand) -> None:
    stand.device.setsockopt(socket.IPPROTO_IP, socket.IP_OPTIONS, b"\x01\x01\x01\x00")
    stand.send(block(1))
    stand.expect(1)
    assert stand.ring.failed


def send_joined(stand: Stand, packets: list[bytes]) -> None:
    """As a sender on the same host does that lets the kernel cut packets out of large sends."""
    leader, *payload, short, trailer = packets
    stand.send([leader])
    stand.device.setsockopt(socket.SOL_UDP, UDP_SEGMENT, len(payload[0]))
    stand.device.sendto(b"".join(payload), stand.address)
    stand.device.setsockopt(socket.SOL_UDP, UDP_SEGMENT, 0)
    stand.send([short, trailer])


def test_joined_packets_are_received_by_the_socket_from_the_first_on(stand: Stand) -> None:
    send_joined(stand, block(1))
    send_joined(stand, block(2))
    stand.expect(1, 2)
    assert stand.ring.failed


def test_packets_that_come_joined_later_are_received_by_the_socket(stand: Stand) -> None:
    stand.send(block(1))
    stand.expect(1)
    assert not stand.ring.failed
    send_joined(stand, block(2))  # this one would be asked for again
    stand.ring.receive(stand.assembler, PATIENCE)
    assert stand.ring.failed
    stand.send(block(2))
    stand.expect(2)


def test_packets_longer_than_announced_are_received_by_the_socket() -> None:
    stand = Stand(packet_size=600)
    try:
        stand.send(block(1))
        stand.expect(1)
        assert stand.ring.failed
    finally:
        stand.close()


def test_closing_does_not_wait_for_the_kernel_to_free_the_ring(
    stand: Stand, monkeypatch: pytest.MonkeyPatch
) -> None:
    may_free, freed, free = threading.Event(), threading.Event(), ring_memory._free

    def free_later(descriptor: int, memory: mmap.mmap) -> None:
        may_free.wait(PATIENCE)
        free(descriptor, memory)
        assert memory.closed
        freed.set()

    monkeypatch.setattr(ring_memory, "_free", free_later)
    stand.send(block(1))
    stand.expect(1)
    stand.ring.close()
    stand.spare.free()
    assert not freed.is_set()
    may_free.set()
    assert freed.wait(PATIENCE)


# -- from one stream to the next ---------------------------------------------------------------------
def test_the_next_stream_has_the_ring_of_the_last_without_its_packets(stand: Stand) -> None:
    stand.send(block(1))
    stand.expect(1)
    last, statuses = stand.ring, stand.ring._ring.statuses
    stand.send(block(2)[:5])
    until(lambda: int(statuses.astype(bool).sum()) == 5)
    last.close()
    stand.send(block(3))  # to the port of the last stream
    following = Stand(spare=stand.spare)
    try:
        assert following.ring._ring is last._ring
        stand.send(block(4))
        following.send(block(11))
        following.expect(11)
        assert not following.ring.failed
        assert following.assembler.statistics.packets == len(block(11))
        assert not statuses.any()
    finally:
        following.close()


@pytest.mark.parametrize(
    ("packet_size", "wanted", "serves"),
    [
        (PACKET_SIZE, 10 << 20, True),
        (PACKET_SIZE + 400, 10 << 20, True),
        (PACKET_SIZE, 5 << 20, True),
        (PACKET_SIZE, 40 << 20, False),  # too small
        (PACKET_SIZE, 1 << 20, False),  # far too large
        (9000, 10 << 20, False),  # slots of another length
    ],
)
def test_a_ring_is_kept_if_it_serves_the_next_stream(
    packet_size: int, wanted: int, serves: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ring_memory, "LEAST_BYTES", 0)
    spare = SpareRing()
    first = spare.take(Geometry(PACKET_SIZE, 10 << 20))
    spare.keep(first)
    second = spare.take(Geometry(packet_size, wanted))
    assert (second is first) == serves == (first.socket.fileno() >= 0)
    second.free()


def test_a_ring_that_no_stream_takes_is_freed(stand: Stand, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ring_memory, "KEPT", 0.01)
    stand.ring.close()
    until(lambda: stand.ring._ring.socket.fileno() < 0)
    assert stand.spare._let_go() is None


def test_a_ring_that_failed_is_freed(stand: Stand) -> None:
    stand.ring._fail("as in a test")
    assert stand.ring._ring.socket.fileno() < 0
    stand.ring.close()
    assert stand.spare._let_go() is None


# -- packets that a ring does not see ----------------------------------------------------------------
def blind(ring: PacketRing) -> None:
    ring._ring.admit(NOTHING)


def test_the_socket_takes_over_from_a_ring_that_sees_nothing(stand: Stand) -> None:
    blind(stand.ring)
    stand.send(block(1))
    stand.expect(1)
    assert stand.ring.failed
    assert stand.assembler.statistics.packets_duplicate == 0


def test_the_socket_takes_over_after_a_silence(stand: Stand, monkeypatch: pytest.MonkeyPatch) -> None:
    stand.send(block(1))
    stand.expect(1)
    blind(stand.ring)
    monkeypatch.setattr(packet_ring, "SILENCE", 0.0)
    stand.idle()
    stand.send(block(2))
    stand.expect(2)
    assert stand.ring.failed


def test_a_ring_that_sees_the_stream_survives_silences(stand: Stand, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(packet_ring, "SILENCE", 0.0)
    for block_id in (1, 2, 3):
        stand.send(block(block_id))
        stand.expect(block_id)
        stand.idle()
        stand.idle()
    assert not stand.ring.failed
    assert stand.assembler.statistics.packets_duplicate == 0


def test_a_few_packets_before_a_silence_are_not_received_twice(
    stand: Stand, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(packet_ring, "SILENCE", 0.0)
    packets = block(1)
    assert packet_ring.PROOF > 2
    stand.send(packets[:2])
    stand.ring.receive(stand.assembler, PATIENCE)
    stand.idle()
    assert stand.socket_is_empty()
    stand.send(packets[2:])
    stand.expect(1)
    assert not stand.ring.failed
    assert stand.assembler.statistics.packets_duplicate == 0


# -- packets of others -------------------------------------------------------------------------------
def test_packets_of_others_neither_enter_the_ring_nor_disable_it(stand: Stand) -> None:
    with bound(STRANGER) as stranger, bound(DEVICE) as other_stream:
        for _ in range(20):
            stranger.sendto(b"x" * 100, stand.address)  # from another device
            other_stream.sendto(block(9)[0], (HOST, stand.address[1] ^ 1))  # to another port
            other_stream.sendto(block(9)[0], (STRANGER, stand.address[1]))  # to another address
        stand.idle()
        stand.idle()
    assert stand.assembler.statistics.packets == stand.assembler.statistics.packets_ignored == 0
    stand.send(block(1))
    stand.expect(1)
    assert not stand.ring.failed


def test_two_rings_receive_a_stream_each() -> None:
    first, second = Stand(), Stand()
    try:
        for block_id in (1, 2):
            first.send(block(block_id))
            second.send(block(block_id + 10))
        first.expect(1, 2)
        second.expect(11, 12)
        assert first.assembler.statistics.packets == second.assembler.statistics.packets
    finally:
        first.close()
        second.close()


# -- memory ------------------------------------------------------------------------------------------
@pytest.mark.parametrize("packet_size", [576, 1400, 1500, 4000, 8164, 8228, 9000, 16000, 65535])
def test_slots_hold_the_packets_and_fill_whole_blocks(packet_size: int) -> None:
    size = Geometry(packet_size, 16 << 20)
    assert size.slot >= ring_memory.IP_AT + packet_size
    assert size.slot % 16 == 0 == size.block % ring_memory.PAGE
    assert size.slots * size.slot == size.blocks * size.block == size.bytes
    assert size.slots * packet_size >= 16 << 20
    assert size.bytes <= 64 << 20


def test_a_ring_takes_a_bounded_part_of_the_memory() -> None:
    assert Geometry(9000, 1 << 30).bytes <= 1.1 * ring_memory.MOST_BYTES
    assert Geometry(9000, 1 << 20).bytes <= 1.1 * ring_memory.LEAST_BYTES
