"""Sockets of ports: what a peer did is seen without waiting, and long bodies are read with few wake-ups."""

from __future__ import annotations

import os
import resource
import socket
import struct
import sys
import threading
import time
from collections.abc import Iterator

import pytest

from grabbergui.core.errors import AckTimeoutError, TransportError
from grabbergui.net.yarp.os import sockets
from patience import PATIENCE

MB = 1 << 20


def test_a_peer_that_closed_is_noticed_and_one_that_waits_or_sends_is_not() -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        assert not sockets.closed_by_peer(ours)
        theirs.send(b"x")
        assert not sockets.closed_by_peer(ours)
        assert ours.recv(1) == b"x"  # looking has taken nothing
        theirs.close()
        assert sockets.closed_by_peer(ours)
    assert sockets.closed_by_peer(ours)


@pytest.mark.skipif(sys.platform != "linux", reason="the options have Linux's names")
def test_a_peer_that_lost_its_power_is_noticed_within_minutes() -> None:
    def seconds(sock: socket.socket) -> int:
        idle, pause, count = (
            sock.getsockopt(socket.IPPROTO_TCP, option)
            for option in (socket.TCP_KEEPIDLE, socket.TCP_KEEPINTVL, socket.TCP_KEEPCNT)
        )
        assert sock.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE)
        return idle + pause * count

    with (
        sockets.listen(("127.0.0.1", 0)) as server,
        sockets.connect(server.getsockname()) as opened,
        server.accept()[0] as accepted,
    ):
        sockets.prepare(accepted)
        assert seconds(opened) <= 180 and seconds(accepted) <= 180


@pytest.mark.parametrize("host", ["a..b", "a" * 64 + ".example"])
def test_an_invalid_host_name_is_reported(host: str) -> None:
    for ask in (
        lambda: sockets.connect((host, 10000)),
        lambda: sockets.local_address_towards(host, 10000),
    ):
        with pytest.raises(TransportError, match=f"'{host}' is no name of a host"):
            ask()


@pytest.mark.skipif(sys.platform == "win32", reason="limits are milliseconds there")
@pytest.mark.parametrize("seconds", [2.5, 1.9999999, 0.9999999, 1e-9])
def test_a_short_deadline_is_not_rounded_to_none(seconds: float) -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        sockets.set_deadline(ours, seconds)
        limit = ours.getsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, struct.calcsize("@ll"))
    whole, microseconds = struct.unpack("@ll", limit)
    found = whole + microseconds / 1e6
    assert found > 0
    assert found == pytest.approx(seconds, abs=0.02)  # the kernel counts in its own ticks


@pytest.fixture
def connection() -> Iterator[tuple[socket.socket, socket.socket]]:
    """Both ends of a connection on the loopback: the reader's and the sender's."""
    with socket.create_server(("127.27.0.1", 0)) as server:
        theirs = socket.create_connection(server.getsockname())
        ours, _ = server.accept()
    with ours, theirs:
        sockets.prepare(ours)
        sockets.set_deadline(ours, PATIENCE)
        yield ours, theirs


def read_body(ours: socket.socket, size: int) -> bytes:
    body = bytearray(size)
    rest = memoryview(body)
    while len(rest):
        count = sockets.receive_body(ours, rest)
        if not count:
            break
        rest = rest[count:]
    return bytes(body[: size - len(rest)])


def send_in(sock: socket.socket, data: bytes, pieces: list[int], pause: float) -> threading.Thread:
    """Send `data`, cut at `pieces` and with pauses between them, while the caller reads."""

    def send() -> None:
        for begin, end in zip([0, *pieces], [*pieces, len(data)], strict=True):
            sock.sendall(data[begin:end])
            time.sleep(pause)

    thread = threading.Thread(target=send)
    thread.start()
    return thread


@pytest.mark.parametrize("size", [1000, MB, 2 * MB, 3 * MB - 1, 5 * MB + 7])
@pytest.mark.parametrize("first", [1, 900, MB - 1, MB + MB // 20])
def test_a_body_is_complete_although_nothing_follows_it(
    connection: tuple[socket.socket, socket.socket], size: int, first: int
) -> None:
    """As over tcp, where the sender waits for the acknowledgement: no wait for bytes beyond the body."""
    ours, theirs = connection
    body = os.urandom(size)
    sender = send_in(theirs, body, [min(first, size - 1)], 0.02)
    began = time.monotonic()
    assert read_body(ours, size) == body
    assert time.monotonic() - began < PATIENCE / 2
    sender.join()
    theirs.send(b"x")
    assert ours.recv(4096) == b"x", "short messages are read at once again"


def test_a_slow_sender_is_not_a_silent_one(connection: tuple[socket.socket, socket.socket]) -> None:
    """The deadline is for a pause, however little a network carries until it passes."""
    ours, theirs = connection
    sockets.set_deadline(ours, 0.2)
    body = os.urandom(3 * MB)
    sender = send_in(theirs, body, list(range(MB // 8, 3 * MB, MB // 8)), 0.05)
    assert read_body(ours, len(body)) == body
    sender.join()


def test_a_sender_that_falls_silent_within_a_body_is_noticed(
    connection: tuple[socket.socket, socket.socket],
) -> None:
    ours, theirs = connection
    sockets.set_deadline(ours, 0.1)
    body = memoryview(bytearray(4 * MB))
    theirs.sendall(b"x" * 1000)
    assert sockets.receive_body(ours, body) == 1000
    with pytest.raises(AckTimeoutError):
        sockets.receive_body(ours, body[1000:])
    theirs.close()
    assert sockets.receive_body(ours, body[1000:]) == 0


def test_a_connection_closed_while_a_body_is_read_is_reported(
    connection: tuple[socket.socket, socket.socket],
) -> None:
    ours, _ = connection
    ours.close()
    with pytest.raises(TransportError):
        sockets.receive_body(ours, memoryview(bytearray(4 * MB)))


@pytest.mark.skipif(sys.platform != "linux", reason="other systems wake a reader for each packet")
def test_a_long_body_wakes_its_reader_once_a_megabyte(
    connection: tuple[socket.socket, socket.socket],
) -> None:
    ours, theirs = connection
    size = 6 * MB
    sender = send_in(theirs, bytes(size), list(range(MB // 16, size, MB // 16)), 0.002)
    before = resource.getrusage(resource.RUSAGE_THREAD).ru_nvcsw
    assert len(read_body(ours, size)) == size
    waits = resource.getrusage(resource.RUSAGE_THREAD).ru_nvcsw - before
    sender.join()
    # The last two megabytes, 32 pieces, are read as they come.
    assert waits < 32 + 12, f"woken {waits} times for 96 pieces"
