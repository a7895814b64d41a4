"""Whether this process may open packet sockets (CAP_NET_RAW), and how it is without that right."""

from __future__ import annotations

import ctypes
import socket
import struct
from collections.abc import Iterator
from contextlib import contextmanager

CAP_NET_RAW = 13
_CAPABILITIES_3 = 0x20080522


def may_open_packet_sockets() -> bool:
    try:
        socket.socket(socket.AF_PACKET, socket.SOCK_DGRAM, 0).close()
    except (PermissionError, AttributeError):
        return False
    return True


@contextmanager
def without_the_right() -> Iterator[None]:
    """This thread, and threads that it starts, may not open packet sockets meanwhile."""
    libc = ctypes.CDLL(None, use_errno=True)
    header = struct.pack("=Ii", _CAPABILITIES_3, 0)
    before = ctypes.create_string_buffer(24)

    def call(function: str, sets: ctypes.Array[ctypes.c_char]) -> None:
        if getattr(libc, function)(header, sets):
            raise OSError(ctypes.get_errno(), function)

    call("capget", before)
    effective, *others = struct.unpack("=6I", before.raw)
    call(
        "capset",
        ctypes.create_string_buffer(struct.pack("=6I", effective & ~(1 << CAP_NET_RAW), *others), 24),
    )
    try:
        yield
    finally:
        call("capset", before)
