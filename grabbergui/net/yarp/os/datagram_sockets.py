"""Sockets of the carriers udp and mcast."""

from __future__ import annotations

import errno
import os
import socket
import sys
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
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


def multicast_sender(sock: socket.socket, group: tuple[str, int]) -> socket.socket:
    """Close the TCP connection, and return a UDP socket to a group on its network. Raises TransportError."""
    local = sock.getsockname()[0]
    sock.close()
    datagrams = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        datagrams.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(local))
        datagrams.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _BUFFER_BYTES)
        datagrams.connect(group)
    except OSError as error:
        datagrams.close()
        place = f"{group[0]}:{group[1]} from {local}"
        raise TransportError(f"no multicast to {place}: {reason(error)}") from error
    return datagrams


def multicast_receiver(sock: socket.socket, group: tuple[str, int]) -> socket.socket:
    """Close the TCP connection, and return a UDP socket that receives a group. Raises TransportError.

    It listens on the connection's network and on that of the default route: a YARP built without ACE sends
    there.
    """
    local = sock.getsockname()[0]
    sock.close()
    host, port = group
    datagrams = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        datagrams.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        datagrams.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER_BYTES)
        if sys.platform == "win32":
            datagrams.bind(("", port))
        else:
            datagrams.bind(group)  # other groups at the same port go elsewhere
        joined = [_join_group(datagrams, host, interface) for interface in (local, "0.0.0.0")]
        if not any(joined):
            raise OSError(errno.ENODEV, os.strerror(errno.ENODEV))
        set_deadline(datagrams, _POLL_SECONDS)
    except OSError as error:
        datagrams.close()
        raise TransportError(f"cannot listen to group {host}:{port} at {local}: {reason(error)}") from error
    return datagrams


def _join_group(sock: socket.socket, group: str, interface: str) -> bool:
    """Join a group on the network of one of our addresses; return whether that is possible."""
    try:
        membership = socket.inet_aton(group) + socket.inet_aton(interface)
        sock.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
    except OSError as error:
        return error.errno == errno.EADDRINUSE  # both are the same network
    return True


def receive_datagrams(
    sock: socket.socket, senders: Collection[str], ended: Callable[[], bool]
) -> Iterator[memoryview]:
    """Yield the datagrams from some addresses until `ended` is true; each is valid until the next."""
    buffer = memoryview(bytearray(65536))
    while not ended():
        try:
            size, address = sock.recvfrom_into(buffer)
        except (BlockingIOError, ConnectionError):
            continue
        # The port may differ: a YARP built without ACE does not send from that of its TCP connection.
        if address and address[0] in senders and not ended():  # no address: it was shut down
            yield buffer[:size]
