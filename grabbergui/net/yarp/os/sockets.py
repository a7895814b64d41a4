"""Blocking sockets as ports use them: gathered writes, exact reads, datagrams, deadlines kept by the kernel.

Deadlines are SO_RCVTIMEO and SO_SNDTIMEO rather than Python's, which would turn one read of an image
into many small ones.

With a key in `auth.conf` both sides of a connection first prove to each other that they know it: `Handshake`.
"""

from __future__ import annotations

import errno
import select
import socket
import struct
import sys
from collections.abc import Sequence
from contextlib import suppress
from typing import Final

from grabbergui.core.errors import AckTimeoutError, ResourceExhaustedError, TransportError
from grabbergui.core.socket_timeouts import wait_readable, wait_writable
from grabbergui.net.yarp.os.authentication import _HANDSHAKE_BYTES, Handshake
from grabbergui.net.yarp.os.bottle import Buffer

CONNECT_TIMEOUT = 5.0
_GATHER = 64
_SMALL_BYTES = 1 << 14
"""Size of a message whose pieces are joined, since that costs less than a gathering write."""
_WAKE_BYTES = 1 << 20
"""How much of a long body has arrived when the thread that reads it is woken."""
NO_MORE_THREADS = "this program has as many threads as it may (`ulimit -u`, systemd's TasksMax)"


def connect(
    address: tuple[str, int], timeout: float = CONNECT_TIMEOUT, key: bytes | None = None
) -> socket.socket:
    """Connect to a port and authenticate. Raises TransportError, AccessDeniedError."""
    host, port = address
    try:
        sock = socket.create_connection(address, timeout)
    except OSError as error:
        raise ResourceExhaustedError.of(error) or TransportError(
            f"nothing answers at {host}:{port}: {reason(error)}"
        ) from error
    except UnicodeError as error:  # a..b, or a part of more than 63 letters
        raise TransportError(f"'{host}' is no name of a host") from error
    try:
        prepare(sock)
        set_deadline(sock, timeout)
        if key:
            authenticate(sock, key, accepting=False)
    except BaseException:
        sock.close()
        raise
    return sock


def listen(address: tuple[str, int]) -> socket.socket:
    """Listen at an address; port 0 means any free one. Raises TransportError."""
    host, port = address
    try:
        return socket.create_server(address, backlog=128)
    except OSError as error:
        if failure := ResourceExhaustedError.of(error):
            raise failure from error
        hint = "" if error.errno == errno.EADDRINUSE else "; is it an address of this machine?"
        place = f"{host}:{port}" if port else host
        raise TransportError(f"cannot listen at {place}: {reason(error)}{hint}") from error


def reason(error: OSError) -> str:
    """Return the system's message without number and address, which our messages contain anyway."""
    return (error.strerror or str(error)).partition(" (while")[0]


_KEEPALIVE: Final = {"TCP_KEEPIDLE": 60, "TCP_KEEPINTVL": 10, "TCP_KEEPCNT": 6}
"""A peer whose machine lost its power is noticed after two minutes; the kernel's own values are two hours."""


def prepare(sock: socket.socket) -> None:
    """Set the options: no delay, detection of dead peers.

    The buffers are left to the kernel: it lets them grow as a connection needs, but no more once a program
    has set them, and what a program may set (net.core.rmem_max) is often far less than they grow to.
    """
    sock.settimeout(None)
    sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for name, value in _KEEPALIVE.items():
        if hasattr(socket, name):  # macOS has no TCP_KEEPIDLE in Python 3.10
            sock.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)


def set_deadline(sock: socket.socket, seconds: float | None, *, sending: bool = True) -> None:
    """Set the timeout in seconds of one read or write; None waits forever."""
    # A limit that is rounded to zero would be none at all.
    if sys.platform == "win32":
        value = struct.pack("@L", max(1, round(seconds * 1000)) if seconds else 0)
    else:
        microseconds = max(1, round(seconds * 1_000_000)) if seconds else 0
        value = struct.pack("@ll", *divmod(microseconds, 1_000_000))
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, value)
    if sending:
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, value)


def send(sock: socket.socket, parts: Sequence[Buffer]) -> int:
    """Write all parts as one; returns their bytes. Raises AckTimeoutError, TransportError."""
    pending = [memoryview(part).cast("B") for part in parts if len(part)]
    if len(pending) > 1 and sum(map(len, pending)) <= _SMALL_BYTES:
        pending = [memoryview(b"".join(pending))]
    total = 0
    try:
        while pending:
            flags = wait_writable(sock)
            if len(pending) == 1 or sys.platform == "win32":
                sent = sock.send(pending[0], flags)
            else:
                sent = sock.sendmsg(pending[:_GATHER], (), flags)
            total += sent
            while sent and pending:
                if sent < len(pending[0]):
                    pending[0] = pending[0][sent:]
                    break
                sent -= len(pending.pop(0))
    except BlockingIOError as error:
        raise AckTimeoutError("the peer takes no more bytes") from error
    except OSError as error:
        raise TransportError(f"the connection broke: {reason(error)}") from error
    return total


def closed_by_peer(sock: socket.socket) -> bool:
    """Return whether the peer closed a connection on which it never sends anything. Does not wait."""
    try:
        if sys.platform == "win32":
            return bool(select.select([sock], [], [], 0)[0]) and not sock.recv(1, socket.MSG_PEEK)
        return not sock.recv(1, socket.MSG_PEEK | socket.MSG_DONTWAIT)
    except BlockingIOError:
        return False
    except OSError:
        return True


def receive_some(sock: socket.socket, into: memoryview, *, all_of_it: bool = False) -> int:
    """Read the bytes that have arrived, or `all_of_it` within the deadline; 0 means the peer has closed.

    Raises AckTimeoutError if nothing arrived within the deadline, TransportError.
    """
    try:
        return sock.recv_into(into, 0, wait_readable(sock) | (socket.MSG_WAITALL if all_of_it else 0))
    except BlockingIOError as error:
        raise AckTimeoutError("the peer sends nothing") from error
    except OSError as error:
        raise TransportError(f"the connection broke: {reason(error)}") from error


def receive_body(sock: socket.socket, into: memoryview) -> int:
    """Fill `into`, or most of a long one: call again for the rest. Less if the deadline passes before.

    0 means the peer has closed. Raises as `receive_some`.
    """
    if len(into) < 2 * _WAKE_BYTES or sys.platform != "linux":
        return receive_some(sock, into, all_of_it=True)
    # A wake-up costs this thread and the sender time: with one for each packet, a seventh of the rate.
    filled = 0
    _wake_at(sock, _WAKE_BYTES)
    try:
        # The kernel may take some bytes first and then wait for as many as this: the body must have both.
        while len(into) - filled >= 2 * _WAKE_BYTES and (count := receive_some(sock, into[filled:])):
            filled += count
    except AckTimeoutError:
        if not filled:
            raise
    finally:
        _wake_at(sock, 1)
    return filled


def _wake_at(sock: socket.socket, size: int) -> None:
    with suppress(OSError):  # it was closed, which the next read reports
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVLOWAT, size)


def receive(sock: socket.socket, size: int) -> bytes:
    """Return up to `size` bytes that have arrived, none if the peer has closed. Raises as `receive_some`."""
    try:
        return sock.recv(size, wait_readable(sock))
    except BlockingIOError as error:
        raise AckTimeoutError("the peer sends nothing") from error
    except OSError as error:
        raise TransportError(f"the connection broke: {reason(error)}") from error


def receive_exactly(sock: socket.socket, size: int) -> bytes:
    """Read exactly that many bytes. Raises AckTimeoutError, and TransportError if the peer closes earlier."""
    data = bytearray(size)
    view = memoryview(data)
    while len(view):
        count = receive_some(sock, view, all_of_it=True)
        if not count:
            raise TransportError("the peer closed the connection")
        view = view[count:]
    return bytes(data)


def authenticate(sock: socket.socket, key: bytes, *, accepting: bool) -> None:
    """Prove to each other that both know the key. Raises AccessDeniedError, TransportError."""
    handshake = Handshake(key, accepting=accepting)
    first = handshake.begin()
    if first:
        send(sock, [first])
    while not handshake.done:
        answer = handshake.received(receive_exactly(sock, _HANDSHAKE_BYTES))
        if answer:
            send(sock, [answer])


def shut_down(sock: socket.socket) -> None:
    """Close a socket and wake the threads that wait in it. Never raises."""
    with suppress(OSError):
        sock.shutdown(socket.SHUT_RDWR)
    sock.close()


def peer_address(sock: socket.socket) -> str:
    """Return the peer's IP address; empty if the connection is already closed."""
    try:
        return str(sock.getpeername()[0])
    except OSError:
        return ""


def local_address_towards(host: str, port: int) -> str:
    """Return our address as seen from another; sends nothing. Raises TransportError."""
    try:
        family, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
        with socket.socket(family, socket.SOCK_DGRAM) as probe:
            probe.connect(address)
            return str(probe.getsockname()[0])
    except OSError as error:
        raise ResourceExhaustedError.of(error) or TransportError(
            f"no way to {host}:{port}: {reason(error)}"
        ) from error
    except UnicodeError as error:
        raise TransportError(f"'{host}' is no name of a host") from error


def is_this_machine(host: str) -> bool:
    """Return whether a name or address is one of this machine's. Raises TransportError."""
    towards = local_address_towards(host, 1)
    return towards.startswith("127.") or towards == "::1" or towards == _resolved(host)


def _resolved(host: str) -> str:
    return str(socket.getaddrinfo(host, 1, type=socket.SOCK_DGRAM)[0][4][0])


def local_addresses() -> list[str]:
    """Return this machine's IP addresses."""
    import psutil  # takes a while, and few need it

    found = [address for addresses in psutil.net_if_addrs().values() for address in addresses]
    return [address.address for address in found if address.family in (socket.AF_INET, socket.AF_INET6)]
