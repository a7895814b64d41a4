"""More room for arriving packets than the system grants one socket: several at the same port. Linux.

An unprivileged socket holds 208 KiB on a stock system, less than two milliseconds of gigabit Ethernet.
Sockets that share a port (SO_REUSEPORT) each have that much, and a few instructions of classic BPF tell the
kernel which one a packet goes to: by its packet_id, stretches of packets in turn.
"""

from __future__ import annotations

import ctypes
import logging
import socket
import struct
import sys

from grabbergui.driver.gige.gvsp import EXTENDED_BIT
from grabbergui.driver.gige.stream_socket import buffer_bytes, kernel_bytes

log = logging.getLogger(__name__)

MEMBERS = 32
"Sockets, a power of two."
SO_ATTACH_REUSEPORT_CBPF = 51
FORMAT_AT = 4
"Of the format byte in a stream packet, and of the word that ends in a standard packet_id."
EXTENDED_ID_AT = 16

_LOAD_WORD, _LOAD_BYTE, _JUMP, _JUMP_IF_SET = 0x20, 0x30, 0x05, 0x45
_SHIFT_RIGHT, _AND, _RETURN = 0x74, 0x54, 0x16


def widen(receiver: socket.socket, wanted: int, packet_bytes: int) -> list[socket.socket]:
    """Further sockets at the port of `receiver`, bound already, so that together they hold `wanted` bytes.

    None where one is enough, or the system cannot. The caller closes them.
    """
    granted = buffer_bytes(receiver)
    if granted >= wanted or sys.platform != "linux":
        return []
    more: list[socket.socket] = []
    try:
        # Not before it is bound: with it a free port may be one that another stream has.
        receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        for _ in range(MEMBERS - 1):
            member = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            more.append(member)
            member.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
            member.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, granted)
            member.bind(receiver.getsockname())
        _attach(receiver, distribution(stretch_bits(granted, packet_bytes)))
    except OSError as error:
        log.info("one socket receives pictures, and not several: %s", error)
        for member in more:
            member.close()
        return []
    return more


def stretch_bits(granted: int, packet_bytes: int) -> int:
    """How many packets go to one socket before the next has its turn, as a power of two: half its room."""
    return max(int(granted / kernel_bytes(packet_bytes) / 2).bit_length() - 1, 0)


def distribution(bits: int) -> bytes:
    """The instructions: which socket a packet goes to. One too short to tell goes to the first."""
    program = [
        (_LOAD_BYTE, 0, 0, FORMAT_AT),
        (_JUMP_IF_SET, 2, 0, EXTENDED_BIT),
        (_LOAD_WORD, 0, 0, FORMAT_AT),
        (_JUMP, 0, 0, 1),
        (_LOAD_WORD, 0, 0, EXTENDED_ID_AT),
        (_SHIFT_RIGHT, 0, 0, bits),
        (_AND, 0, 0, MEMBERS - 1),
        (_RETURN, 0, 0, 0),
    ]
    return b"".join(struct.pack("=HBBI", *instruction) for instruction in program)


def _attach(receiver: socket.socket, program: bytes) -> None:
    code = ctypes.create_string_buffer(program, len(program))
    header = struct.pack("@HP", len(program) // 8, ctypes.addressof(code))
    receiver.setsockopt(socket.SOL_SOCKET, SO_ATTACH_REUSEPORT_CBPF, header)
