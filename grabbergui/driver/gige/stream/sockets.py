"""UDP sockets that receive frames: their buffers and multicast groups."""

from __future__ import annotations

import logging
import socket
import struct
import sys

from grabbergui.core.errors import ResourceExhaustedError, TransportError

log = logging.getLogger(__name__)

SO_RCVBUFFORCE = 33
"Linux socket option: exceeds the system's limit, requires CAP_NET_ADMIN."
MIN_BUFFER_BYTES = 2 << 20
MAX_BUFFER_BYTES = 64 << 20
KERNEL_OVERHEAD = 2
"Factor for the kernel's own accounting: a packet of 1500 bytes takes more than 2300."
KERNEL_BYTES = 1024
"Bytes of the buffer that a queued packet takes in addition to its data."
KERNEL_FACTOR = 1.3
"Factor for the data of a queued packet: memory is allocated in pages."

_warned: set[int] = set()


def open_stream_socket(
    local_address: str, payload_size: int, port: int = 0, *, shared: bool = False
) -> socket.socket:
    """Open a bound UDP socket whose buffer holds two payloads, as far as the system allows.

    `port` 0 takes a free one; with `shared`, other programs on this host can join the same multicast group.
    Raises TransportError.
    """
    try:
        receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    except OSError as error:
        raise _no_socket(local_address, error) from error
    try:
        if shared:
            receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        _grow_buffer(receiver, wanted_bytes(payload_size))
        receiver.bind((local_address, port))
    except OSError as error:
        receiver.close()
        raise _no_socket(local_address, error) from error
    return receiver


def _no_socket(local_address: str, error: OSError) -> TransportError:
    no_more = ResourceExhaustedError.of(error)
    return no_more or TransportError(f"no socket for frames on {local_address}: {error}")


def wanted_bytes(payload_size: int) -> int:
    """Return the size of a buffer for two payloads."""
    return min(max(KERNEL_OVERHEAD * 2 * payload_size, MIN_BUFFER_BYTES), MAX_BUFFER_BYTES)


def listening_address(group: str) -> str:
    """Return where to bind a socket for a group: to the group itself if the system can."""
    return "" if sys.platform == "win32" else group


def join_multicast(receiver: socket.socket, group: str, local_address: str) -> None:
    """Receive what is sent to a group, on the interface of `local_address`. Raises TransportError."""
    request = struct.pack("4s4s", socket.inet_aton(group), socket.inet_aton(local_address))
    try:
        receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, request)
    except OSError as error:
        raise TransportError(f"cannot join multicast group {group} on {local_address}: {error}") from error


def is_multicast(ip: str) -> bool:
    """Return whether an address is a multicast group (224.0.0.0/4)."""
    return socket.inet_aton(ip)[0] >> 4 == 0xE


def buffer_bytes(receiver: socket.socket) -> int:
    """Return the size of the buffer, the kernel's overhead included."""
    return receiver.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF)


def kernel_bytes(packet_bytes: int) -> float:
    """Return the bytes that a waiting packet takes of the buffer, at most."""
    return KERNEL_FACTOR * packet_bytes + KERNEL_BYTES


def _grow_buffer(receiver: socket.socket, wanted: int) -> None:
    receiver.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, wanted)
    if buffer_bytes(receiver) >= wanted:
        return
    if sys.platform == "linux":
        try:
            receiver.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, wanted)
            return
        except PermissionError:
            pass
    granted = buffer_bytes(receiver)
    if granted not in _warned:
        _warned.add(granted)
        log.warning(
            "the system grants a socket %d KiB for arriving packets, %d KiB are wanted; a busy machine may"
            " lose packets. Allow more with: sudo sysctl -w net.core.rmem_max=%d",
            granted >> 10,
            wanted >> 10,
            wanted,
        )
