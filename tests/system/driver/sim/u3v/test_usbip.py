"""The USB/IP server by its own protocol, as the kernel of another machine speaks it."""

from __future__ import annotations

import socket
import struct
import threading
from collections.abc import Iterator

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from grabbergui.core.errors import SourceUnavailableError, UsageError
from grabbergui.driver.sim.registers import serial_at
from grabbergui.driver.sim.u3v import usbip
from grabbergui.driver.sim.u3v.device import SimulatedU3vDevice
from grabbergui.driver.sim.u3v.registers import CONTROL_IN, EVENT_IN
from grabbergui.driver.sim.u3v.serve import Via, place_of, serve
from grabbergui.driver.sim.u3v.usbip import UsbIpServer
from grabbergui.driver.sim.u3v.virtual_host import _free_port
from grabbergui.driver.u3v import gencp
from grabbergui.driver.u3v.gencp import CommandId, Packet
from patience import PATIENCE, until

SUBMIT, UNLINK, SUBMIT_REPLY, UNLINK_REPLY = 1, 2, 3, 4
CONNECTION_RESET = 0xFFFFFFFF - 103
IMPORT = struct.pack(">HHI", 0x0111, 0x8003, 0) + b"1-1".ljust(32, b"\0")


class Host:
    """The host's end of USB/IP, with the requests of vhci-hcd."""

    def __init__(self, address: tuple[str, int]) -> None:
        self.socket = socket.create_connection(address, timeout=PATIENCE)
        self.sequence = 0

    def attach(self) -> bytes:
        self.socket.sendall(IMPORT)
        return self.receive(8 + 312)

    def submit(self, endpoint: int, length: int, data: bytes = b"", setup: bytes = bytes(8)) -> int:
        self.sequence += 1
        inward = int(not data and not (endpoint == 0 and not setup[0] & 0x80))
        header = (SUBMIT, self.sequence, 0x10002, inward, endpoint, 0, length, 0, 0, 0, setup)
        self.socket.sendall(struct.pack(">10I8s", *header) + data)
        return self.sequence

    def unlink(self, sequence: int) -> int:
        self.sequence += 1
        self.socket.sendall(
            struct.pack(">10I8s", UNLINK, self.sequence, 0, 0, 0, sequence, 0, 0, 0, 0, bytes(8))
        )
        return self.sequence

    def reply(self, inward: bool) -> tuple[int, int, int, bytes]:
        """Command, sequence, status, data."""
        command, sequence, _, _, _, status, length, *_ = struct.unpack(">10I8s", self.receive(48))
        data = self.receive(length) if inward and command == SUBMIT_REPLY and length else b""
        return command, sequence, status, data

    def receive(self, length: int) -> bytes:
        data = b""
        while len(data) < length:
            part = self.socket.recv(length - len(data))
            assert part, "the device hung up"
            data += part
        return data

    def get_descriptor(self, kind: int, index: int = 0) -> tuple[int, bytes]:
        self.submit(0, 255, setup=struct.pack("<BBHHH", 0x80, 6, kind << 8 | index, 0, 255))
        _, _, status, data = self.reply(True)
        return status, data


@pytest.fixture(scope="module")
def server() -> Iterator[UsbIpServer]:
    camera = SimulatedU3vDevice()
    camera.start()
    server = UsbIpServer(camera, "127.0.0.23", 0)
    thread = threading.Thread(target=server.run)
    thread.start()
    yield server
    server.close()
    camera.stop()
    thread.join(PATIENCE)
    assert not thread.is_alive()


@pytest.fixture
def host(server: UsbIpServer) -> Iterator[Host]:
    host = Host(server.address)
    with host.socket:
        yield host


def test_the_camera_is_on_the_list(host: Host) -> None:
    host.socket.sendall(struct.pack(">HHI", 0x0111, 0x8005, 0))
    reply = host.receive(8 + 4 + 312 + 12)
    assert struct.unpack_from(">HHII", reply) == (0x0111, 0x0005, 0, 1)
    assert reply[-12:] == bytes((0xEF, 5, 0, 0, 0xEF, 5, 1, 0, 0xEF, 5, 2, 0))


def test_another_bus_id_is_refused(host: Host) -> None:
    host.socket.sendall(struct.pack(">HHI", 0x0111, 0x8003, 0) + b"9-9".ljust(32, b"\0"))
    assert struct.unpack(">HHI", host.receive(8)) == (0x0111, 0x0003, 1)


def test_an_attached_host_reads_descriptors_and_registers(host: Host) -> None:
    host.attach()
    status, device = host.get_descriptor(1)
    assert (status, device[:4]) == (0, bytes((18, 1, 0, 3)))
    assert host.get_descriptor(2)[1][:2] == bytes((9, 2))
    assert host.get_descriptor(3, 4)[1][2:].decode("utf-16-le") == "GRUI00SIM001"
    assert host.get_descriptor(3, 99)[0] == 0xFFFFFFFF - 31, "a stall"
    command = Packet(gencp.FLAG_ACKNOWLEDGE, CommandId.READMEM, 5, gencp.read_memory(0, 4)).encode()
    host.submit(1, len(command), command)
    assert host.reply(False)[2] == 0
    host.submit(CONTROL_IN & 0xF, 1024)
    assert Packet.decode(host.reply(True)[3]).data == b"\1\0\1\0"


def test_a_request_taken_back_is_answered_once(host: Host) -> None:
    host.attach()
    waiting = host.submit(EVENT_IN & 0xF, 1024)
    behind = host.submit(EVENT_IN & 0xF, 1024)
    for sequence in (waiting, behind):
        unlink = host.unlink(sequence)
        assert host.reply(True) == (UNLINK_REPLY, unlink, CONNECTION_RESET, b"")


def test_answers_and_unlinks_that_cross_come_in_the_kernels_order(host: Host, server: UsbIpServer) -> None:
    """Linux hangs up on an answer to a request whose unlink was answered before it."""
    host.attach()
    pipe = server._camera.pipes[EVENT_IN]
    for _ in range(200):
        sequence = host.submit(EVENT_IN & 0xF, 1024)
        sender = threading.Thread(target=pipe.put, args=(b"event",))
        sender.start()
        unlink = host.unlink(sequence)
        sender.join()
        first = host.reply(True)
        if first[0] == SUBMIT_REPLY:
            assert host.reply(True) == (UNLINK_REPLY, unlink, 0, b"")
        else:
            assert first == (UNLINK_REPLY, unlink, CONNECTION_RESET, b"")
        pipe.flush()


def test_a_host_that_asks_without_end_is_hung_up_on(host: Host, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(usbip, "MOST_REQUESTS", 4)
    host.attach()
    for _ in range(5):
        host.submit(EVENT_IN & 0x7F, 1024)
    assert host.socket.recv(1) == b""


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(noise=st.binary(min_size=1, max_size=120), attached=st.booleans())
def test_noise_ends_the_connection_and_nothing_else(
    server: UsbIpServer, noise: bytes, attached: bool
) -> None:
    host = Host(server.address)
    with host.socket:
        if attached:
            host.attach()
        host.socket.sendall(noise)
    next_host = Host(server.address)
    with next_host.socket:
        next_host.attach()
        assert next_host.get_descriptor(1)[0] == 0


def test_serving_on_tcp_ends_when_it_is_asked_to() -> None:
    stop, reported = threading.Event(), []
    thread = threading.Thread(
        target=lambda: serve("tcp", host="127.0.0.24", port=0, stop=stop, ready=reported.append)
    )
    thread.start()
    until(lambda: bool(reported))
    assert "attach -r 127.0.0.24 -b 1-1" in reported[0]
    stop.set()
    thread.join(PATIENCE)
    assert not thread.is_alive()


def test_what_cannot_be_served_says_why() -> None:
    with pytest.raises(UsageError, match="one of vhci, tcp, gadget"):
        serve("carrier pigeon")
    with pytest.raises(SourceUnavailableError, match="SuperSpeed ports"):
        _free_port("hub port sta spd dev sockfd local_busid\nhs 0000 004 000 00000000 000000 0-0\n")


def test_closing_while_a_host_is_just_being_greeted_ends_the_server(monkeypatch) -> None:
    camera = SimulatedU3vDevice()
    server = UsbIpServer(camera, "127.0.0.23", 0)
    greeting, closed = threading.Event(), threading.Event()
    describe = server._description

    def described_later() -> bytes:
        greeting.set()
        assert closed.wait(PATIENCE)
        return describe()

    monkeypatch.setattr(server, "_description", described_later)
    thread = threading.Thread(target=server.run)
    thread.start()
    host = Host(server.address)
    with host.socket:
        host.socket.sendall(IMPORT)
        assert greeting.wait(PATIENCE)
        server.close()
        closed.set()
        thread.join(PATIENCE)
        assert not thread.is_alive(), "it serves a host on, though it was closed"


def test_cameras_on_two_ports_have_two_serial_numbers() -> None:
    places = [place_of(Via.TCP, "127.0.0.1", port, "") for port in (3240, 3241, 3240)]
    first, second, again = map(serial_at, places)
    assert first == again != second
