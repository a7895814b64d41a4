"""UDP sockets that receive frames: buffers, multicast groups, waiting, several sockets on one port, filters.

`select.select` raises for descriptors from 1024 on, and Windows has no `poll`; `selectors` knows what a
system has.

An unprivileged socket buffers 208 KiB on a stock system, less than two milliseconds of gigabit Ethernet. On
Linux each socket of a shared port (SO_REUSEPORT) has that much, and a short classic BPF program distributes
the packets: by packet_id, consecutive stretches alternate between the sockets.
"""

from __future__ import annotations

import ctypes
import logging
import select
import selectors
import socket
import struct
import sys
import threading
from collections.abc import Callable, Iterable
from typing import Final

from grabbergui.core.errors import ResourceExhaustedError, TransportError
from grabbergui.driver.gige.packet_header import EXTENDED, EXTENDED_BIT, STANDARD, offset_of

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


class Waits:
    """The waits of one thread, for packets or for time to pass, which another thread can end."""

    def __init__(self) -> None:
        self._over = threading.Lock()
        "Taken until `end`."
        self._over.acquire()
        self._bell, self._button = socket.socketpair()

    def end(self) -> None:
        """Let every wait return at once from now on. Any thread, once."""
        self._over.release()
        self._button.send(b"\0")

    def close(self) -> None:
        """Close the sockets that wake the thread."""
        self._bell.close()
        self._button.close()

    def rest(self, seconds: float) -> None:
        """Let time pass."""
        if self._over.acquire(timeout=seconds):
            self._over.release()

    def readable(self, receiver: socket.socket, timeout: float) -> bool:
        """Return whether the socket has something to read, after at most `timeout` seconds."""
        return receiver in readable([receiver, self._bell], timeout)

    def waiter(self, sockets: Iterable[socket.socket]) -> Callable[[float], list[int]]:
        """Return a function that waits for at most the given seconds and returns the readable descriptors.

        For a loop: the sockets are registered once, and nothing must be closed afterwards. Not on Windows.
        """
        if sys.platform == "win32":
            raise OSError("Windows has no poll")
        poll, bell = select.poll(), self._bell.fileno()
        for each in (*sockets, self._bell):
            poll.register(each, select.POLLIN)
        return lambda timeout: [ready for ready, _ in poll.poll(1000 * timeout) if ready != bell]


def readable(sockets: Iterable[socket.socket], timeout: float) -> list[socket.socket]:
    """Return those sockets that have something to read, after at most `timeout` seconds."""
    with selectors.DefaultSelector() as selector:
        for each in sockets:
            selector.register(each, selectors.EVENT_READ, each)
        return [key.data for key, _ in selector.select(timeout)]


# -- programs that the kernel runs on packets ----------------------------------------------------
SO_ATTACH_REUSEPORT_CBPF = 51
"Option of a Linux socket; the socket module does not name it."
Instruction = tuple[int, int, int, int]
"Code, instructions to skip if true and if false, value."
_LOAD_BYTE, _LOAD_WORD = 0x30, 0x20
_JUMP, _ANY_BIT = 0x05, 0x45
_SHIFT_RIGHT, _AND, _RETURN_CHOSEN = 0x74, 0x54, 0x16

MEMBERS = 32
"Sockets at one port, a power of two."
FORMAT_AT: Final = offset_of(STANDARD, "format_and_packet_id")
"Byte of a packet's format, and of the word that ends in a standard packet_id."
EXTENDED_ID_AT: Final = offset_of(EXTENDED, "packet_id")


def widen(receiver: socket.socket, wanted: int, packet_bytes: int) -> list[socket.socket]:
    """Return further bound sockets at the port of `receiver`; together they hold `wanted` bytes.

    Empty if one is enough, or the system cannot. The caller closes them.
    """
    granted = buffer_bytes(receiver)
    if granted >= wanted or sys.platform != "linux":
        return []
    more: list[socket.socket] = []
    try:
        # Not before it is bound: otherwise a free port may be one that another stream has.
        receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        for _ in range(MEMBERS - 1):
            member = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            more.append(member)
            member.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
            member.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, granted)
            member.bind(receiver.getsockname())
        _attach(receiver, SO_ATTACH_REUSEPORT_CBPF, distribution(stretch_bits(granted, packet_bytes)))
    except OSError as error:
        log.info("one socket receives the frames, and not several: %s", error)
        for member in more:
            member.close()
        return []
    return more


def stretch_bits(granted: int, packet_bytes: int) -> int:
    """Return how many packets go to one socket before the next, as a power of two: half its room."""
    return max(int(granted / kernel_bytes(packet_bytes) / 2).bit_length() - 1, 0)


def distribution(bits: int) -> list[Instruction]:
    """Return instructions that choose a packet's socket; a packet without an id goes to the first."""
    return [
        (_LOAD_BYTE, 0, 0, FORMAT_AT),
        (_ANY_BIT, 2, 0, EXTENDED_BIT),
        (_LOAD_WORD, 0, 0, FORMAT_AT),
        (_JUMP, 0, 0, 1),
        (_LOAD_WORD, 0, 0, EXTENDED_ID_AT),
        (_SHIFT_RIGHT, 0, 0, bits),
        (_AND, 0, 0, MEMBERS - 1),
        (_RETURN_CHOSEN, 0, 0, 0),
    ]


def _attach(target: socket.socket, option: int, program: list[Instruction]) -> None:
    encoded = b"".join(struct.pack("=HBBI", *instruction) for instruction in program)
    code = ctypes.create_string_buffer(encoded, len(encoded))
    target.setsockopt(socket.SOL_SOCKET, option, struct.pack("@HP", len(program), ctypes.addressof(code)))
