"""Sockets of the carrier udp."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress

from grabbergui.core.errors import TransportError
from grabbergui.net.yarp.os.bottle import Buffer
from grabbergui.net.yarp.os.sockets import reason, send, set_deadline

_BUFFER_BYTES = 4 << 20
"""Buffer size of a socket for datagrams; the kernel sizes those of TCP itself."""
_POLL_SECONDS = 0.5
_LONG_DATAGRAM = 49_000
_GAP_SECONDS = 0.001
"""Pause after a long datagram, as in YARP: a reader's kernel holds three of them by default, and a lost one
takes its whole image with it."""


def send_datagrams(sock: socket.socket, datagrams: Iterable[Sequence[Buffer]]) -> None:
    """Send the datagrams of a message. Raises TransportError."""
    for datagram in datagrams:
        if send(sock, datagram) > _LONG_DATAGRAM:
            time.sleep(_GAP_SECONDS)


def datagram_sender(sock: socket.socket, port: int) -> socket.socket:
    """Close the TCP connection and return a UDP socket to `port` at its other end. Raises TransportError."""
    # The receiver knows us by the address and port that the TCP connection had.
    local, remote = sock.getsockname(), sock.getpeername()
    sock.close()
    if not 0 < port < 65536:
        raise TransportError(f"it offers UDP port {port}")
    datagrams = socket.socket(sock.family, socket.SOCK_DGRAM)
    try:
        datagrams.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        datagrams.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _BUFFER_BYTES)
        # A YARP built without ACE takes that very port for itself; on one machine we must use another.
        with suppress(OSError):
            datagrams.bind(local[:2])
        datagrams.connect((remote[0], port))
    except OSError as error:
        datagrams.close()
        raise TransportError(f"no UDP to {remote[0]}:{port}: {reason(error)}") from error
    return datagrams


def datagram_receiver(sock: socket.socket) -> socket.socket:
    """Return a UDP socket at a free port of the address at which a TCP connection arrived."""
    datagrams = socket.socket(sock.family, socket.SOCK_DGRAM)
    try:
        datagrams.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER_BYTES)
        datagrams.bind((sock.getsockname()[0], 0))
        set_deadline(datagrams, _POLL_SECONDS)
    except BaseException:
        datagrams.close()
        raise
    return datagrams


def receive_datagrams(sock: socket.socket, sender: str, ended: Callable[[], bool]) -> Iterator[memoryview]:
    """Yield the datagrams from one address until `ended` is true; each is valid until the next."""
    buffer = memoryview(bytearray(65536))
    while not ended():
        try:
            size, address = sock.recvfrom_into(buffer)
        except (BlockingIOError, ConnectionError):
            continue
        # The port may differ: a YARP built without ACE does not send from that of its TCP connection.
        if address[0] == sender:
            yield buffer[:size]
