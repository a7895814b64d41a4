"""Filters that the kernel runs on packets: which enter a packet ring, and which the UDP socket.

A filter is a classic BPF program (`packet(7)`, SO_ATTACH_FILTER). Offsets count from the IP header in a
packet socket, and from the UDP header in a UDP socket.
"""

from __future__ import annotations

import ctypes
import socket
import struct
from typing import Final

from grabbergui.driver.gige.gvsp import EXTENDED_BIT, PacketFormat

SO_ATTACH_FILTER, SO_DETACH_FILTER = 26, 27
"Options of a Linux socket; the socket module does not name them."
_LOAD_BYTE, _LOAD_HALF, _LOAD_WORD = 0x30, 0x28, 0x20
_EQUAL, _GREATER, _ANY_BIT, _AND, _RETURN = 0x15, 0x25, 0x45, 0x54, 0x06
_PACKET_TYPE = 0xFFFFF004
"SKF_AD_OFF + SKF_AD_PKTTYPE, which is not in the packet."
_TO_GROUP = 2
"""PACKET_MULTICAST. Lower types are to this host and broadcast; higher ones to other hosts (a promiscuous
interface sees them) and outgoing: on the loopback each packet passes twice."""
_PLAIN_HEADER = 0x45
"IPv4 without options."
_FRAGMENT = 0x3FFF
"More fragments follow, or the offset is not 0."

Instruction = tuple[int, int, int, int]
"Code, instructions to skip if true and if false, value."
NOTHING: Final[list[Instruction]] = [(_RETURN, 0, 0, 0)]
"Admits no packet."
_FORMAT_AT = 12
TRAILERS: Final[list[Instruction]] = [
    (_LOAD_BYTE, 0, 0, _FORMAT_AT),
    (_AND, 0, 0, 0xFF ^ EXTENDED_BIT),
    (_EQUAL, 0, 1, PacketFormat.TRAILER),
    (_RETURN, 0, 0, 0xFFFF),
    *NOTHING,
]
"Admits the last packets of blocks. In a UDP socket."


def stream_filter(device_ip: str, local_ip: str, port: int) -> list[Instruction]:
    """Return a filter that admits UDP packets from a device to a port of ours, and what hides such packets.

    Of fragments only the first has a port, and IP options move it: those from the device are admitted
    whatever their port, so that a ring sees that it cannot read them.
    """
    device, local = (int.from_bytes(socket.inet_aton(ip), "big") for ip in (device_ip, local_ip))
    refuse, admit, following = "refuse", "admit", "following"
    checks = [
        (_LOAD_BYTE, _PACKET_TYPE, _GREATER, _TO_GROUP, refuse, following),
        (_LOAD_WORD, 12, _EQUAL, device, following, refuse),
        (_LOAD_WORD, 16, _EQUAL, local, following, refuse),
        (_LOAD_BYTE, 9, _EQUAL, socket.IPPROTO_UDP, following, refuse),
        (_LOAD_BYTE, 0, _EQUAL, _PLAIN_HEADER, following, admit),
        (_LOAD_HALF, 6, _ANY_BIT, _FRAGMENT, admit, following),
        (_LOAD_HALF, 22, _EQUAL, port, admit, refuse),
    ]
    program: list[Instruction] = []
    for index, (load, offset, jump, value, if_true, if_false) in enumerate(checks):
        to_end = 2 * (len(checks) - index - 1)
        skipped = {following: 0, admit: to_end, refuse: to_end + 1}
        program += [(load, 0, 0, offset), (jump, skipped[if_true], skipped[if_false], value)]
    return [*program, (_RETURN, 0, 0, 0xFFFF), *NOTHING]


def attach(target: socket.socket, program: list[Instruction]) -> None:
    """Let a socket receive what the program admits, in place of its last one. Raises OSError."""
    encoded = b"".join(struct.pack("=HBBI", *instruction) for instruction in program)
    code = ctypes.create_string_buffer(encoded, len(encoded))
    header = struct.pack("@HP", len(program), ctypes.addressof(code))
    target.setsockopt(socket.SOL_SOCKET, SO_ATTACH_FILTER, header)


def detach(target: socket.socket) -> None:
    """Let a socket receive everything again. Raises OSError."""
    target.setsockopt(socket.SOL_SOCKET, SO_DETACH_FILTER, 0)
