"""Several UDP sockets at one port, where one may not have a buffer that is large enough. Linux.

An unprivileged socket buffers 208 KiB on a stock system, less than two milliseconds of gigabit Ethernet. Each
socket of a shared port (SO_REUSEPORT) has that much, and a short classic BPF program distributes the packets:
by packet_id, consecutive runs alternate between the sockets.
"""

from __future__ import annotations

import ctypes
import logging
import socket
import struct
import sys
from typing import Final

from grabbergui.driver.gige.packet_header import EXTENDED, EXTENDED_BIT, STANDARD, offset_of
from grabbergui.driver.gige.stream.sockets import buffer_bytes, kernel_bytes

log = logging.getLogger(__name__)

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
        _attach(receiver, SO_ATTACH_REUSEPORT_CBPF, distribution(run_bits(granted, packet_bytes)))
    except OSError as error:
        log.info("one socket receives the frames, and not several: %s", error)
        for member in more:
            member.close()
        return []
    return more


def run_bits(granted: int, packet_bytes: int) -> int:
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
