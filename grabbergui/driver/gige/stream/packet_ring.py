"""Packets from memory that the kernel shares with us, without a system call for receiving them. Linux.

A packet socket with a ring (`packet(7)`, PACKET_RX_RING, TPACKET_V2) has each packet written into a slot of
fixed length while it arrives; the process only reads the slots. This needs CAP_NET_RAW, and receives what
arrives at the interface, before any firewall. A filter in the kernel admits only the stream's packets, and
another keeps them from the UDP socket, which stays open to reserve its port.
"""

from __future__ import annotations

import ctypes
import logging
import mmap
import platform
import socket
import struct
import sys
import time
from typing import Final

import numpy as np

from grabbergui.driver.gige.discovery.interfaces import Interface, waiter
from grabbergui.driver.gige.stream.assembler import BlockAssembler
from grabbergui.driver.gige.stream.pace import Pace
from grabbergui.driver.gige.stream.packet_source import PacedSource
from grabbergui.driver.gige.stream.recvmmsg import BatchSource
from grabbergui.driver.gige.stream.sockets import kernel_bytes

log = logging.getLogger(__name__)

AF_PACKET = 17
"The socket module names it on Linux only."
SOL_PACKET, PACKET_RX_RING, PACKET_VERSION, TPACKET_V2 = 263, 5, 10, 1
SO_ATTACH_FILTER, SO_DETACH_FILTER = 26, 27
ETH_P_IP = 0x0800
OURS = 1
"TP_STATUS_USER: the slot holds a packet, and belongs to us until 0 is written."
IP_AT = 80
"Bytes of a slot before the IP header: `struct tpacket2_hdr`, `struct sockaddr_ll` and what aligns them."
PAYLOAD_AT, UDP_BYTES = 28, 8
"From the IP header on, which has no options: the filter rejects others."
_UDP_LENGTH = slice(24, 26)
ALIGNMENT = 16
BLOCK_BYTES = 1 << 18
"Contiguous memory of the kernel; slots do not span two."
LEAST_SLOTS = 4096
MOST_BYTES = 64 << 20

_HEADER = np.dtype(
    [("status", "<u4"), ("length", "<u4"), ("captured", "<u4"), ("link", "<u2"), ("network", "<u2")]
)
"The beginning of `struct tpacket2_hdr`."
_LOAD_BYTE, _LOAD_HALF, _LOAD_WORD = 0x30, 0x28, 0x20
_JUMP_IF_EQUAL, _JUMP_IF_SET, _RETURN = 0x15, 0x45, 0x06
_PACKET_TYPE, _OUTGOING = 0xFFFFF004, 4
"SKF_AD_OFF + SKF_AD_PKTTYPE: on the loopback each packet passes twice."
_NOTHING: Final = [(_RETURN, 0, 0, 0)]


def usable(interface: Interface, packet_size: int) -> bool:
    """Return whether packets of this size arrive whole, on a processor that keeps the order of stores."""
    known = sys.platform == "linux" and platform.machine() == "x86_64"
    return known and packet_size <= interface.mtu


class PacketRing(PacedSource):
    """Feeds an assembler from a ring; from the UDP socket once packets arrive that do not fit its slots."""

    def __init__(
        self,
        receiver: socket.socket,
        device_ip: str,
        interface: Interface,
        *,
        packet_size: int,
        wanted: int,
    ) -> None:
        """Make a ring for `wanted` bytes of payload, to receive in place of the bound socket `receiver`.

        `packet_size` counts the headers of IP and UDP. Raises OSError, PermissionError without CAP_NET_RAW.
        """
        self._receiver = receiver
        self._device_ip = device_ip
        self._fallback: BatchSource | None = None
        slot = -(-(IP_AT + packet_size) // ALIGNMENT) * ALIGNMENT
        in_block = BLOCK_BYTES // slot
        slots = max(min(wanted, MOST_BYTES) // packet_size, LEAST_SLOTS)
        blocks = -(-slots // in_block)
        packets = blocks * in_block
        super().__init__(Pace(int(packets * kernel_bytes(packet_size)), packets))
        self._socket = socket.socket(AF_PACKET, socket.SOCK_DGRAM, 0)
        try:
            self._socket.setsockopt(SOL_PACKET, PACKET_VERSION, TPACKET_V2)
            geometry = struct.pack("=4I", BLOCK_BYTES, blocks, slot, packets)
            self._socket.setsockopt(SOL_PACKET, PACKET_RX_RING, geometry)
            self._memory = mmap.mmap(self._socket.fileno(), blocks * BLOCK_BYTES)
            _attach(self._socket, _stream_filter(device_ip, receiver.getsockname()[1]))
            self._socket.bind((interface.name, ETH_P_IP))
            _attach(receiver, _NOTHING)
        except BaseException:
            self._socket.close()
            raise
        strides = (BLOCK_BYTES, slot)
        self._headers = np.ndarray((blocks, in_block), _HEADER, self._memory, 0, strides)
        self._packets = np.ndarray(
            (blocks, in_block, slot - IP_AT), np.uint8, self._memory, IP_AT, (*strides, 1)
        )
        self._block = self._slot = 0
        "Position of the next packet."
        self._wait = waiter([self._socket])

    def receive(self, assembler: BlockAssembler, timeout: float) -> None:
        """Take packets from the ring, or since they do not fit its slots, from the socket."""
        if self._fallback is None:
            super().receive(assembler, timeout)
        else:
            self._fallback.receive(assembler, timeout)

    def close(self) -> None:
        """Release the memory."""
        self._socket.close()
        # The memory is unmapped with the last array that is a view of it.
        del self._headers, self._packets, self._memory
        if self._fallback is not None:
            self._fallback.close()

    def _take_all(self, assembler: BlockAssembler, timeout: float) -> float:
        if timeout and not self._headers["status"][self._block, self._slot] & OURS:
            self._wait(timeout)
        now = time.monotonic()
        blocks, in_block = self._headers.shape
        for _ in range(blocks + 1):
            statuses = self._headers["status"][self._block, self._slot :]
            ready = (statuses & OURS).astype(bool)
            count = len(ready) if ready.all() else int(ready.argmin())
            if count and not self._take(assembler, count, now):
                return now
            statuses[:count] = 0
            self._slot += count
            if self._slot < in_block:
                return now
            self._block, self._slot = (self._block + 1) % blocks, 0
            now = time.monotonic()
        self._drained = False
        return now

    def _take(self, assembler: BlockAssembler, count: int, now: float) -> bool:
        """Give packets to the assembler, those of equal length at once; return False if some do not fit."""
        headers = self._headers[self._block, self._slot : self._slot + count]
        packets = self._packets[self._block, self._slot : self._slot + count]
        if (headers["captured"] < headers["length"]).any() or (headers["network"] != IP_AT).any():
            self._fall_back()
            return False
        # Not the captured length: Ethernet pads short packets.
        lengths = packets[:, _UDP_LENGTH].view(">u2")[:, 0].astype(np.intp) - UDP_BYTES
        lengths = np.clip(lengths, 0, headers["captured"].astype(np.intp) - PAYLOAD_AT)
        breaks = ((lengths[1:] != lengths[:-1]).nonzero()[0] + 1).tolist()
        for begin, end in zip([0, *breaks], [*breaks, count], strict=True):
            payload = packets[begin:end, PAYLOAD_AT : PAYLOAD_AT + int(lengths[begin])]
            assembler.receive_rows(payload, now)
        return True

    def _discard(self) -> None:
        # All slots at once: a packet that the kernel writes meanwhile counts as lost at worst.
        statuses = self._headers["status"]
        waiting = (statuses & OURS).astype(bool)
        taken = int(waiting.sum())
        statuses[waiting] = 0
        in_block = statuses.shape[1]
        at = self._block * in_block + self._slot + taken
        self._block, self._slot = divmod(at % statuses.size, in_block)

    def _fall_back(self) -> None:
        """Receive from the UDP socket: packets are joined on their way (GRO), and longer than a slot."""
        log.info("packets come joined: they are received by system calls, not through a packet ring")
        self._receiver.setsockopt(socket.SOL_SOCKET, SO_DETACH_FILTER, 0)
        self._wait = waiter([])
        _attach(self._socket, _NOTHING)
        self._fallback = BatchSource(self._receiver, self._device_ip)


def _stream_filter(device_ip: str, port: int) -> list[tuple[int, int, int, int]]:
    """Return a filter that admits unfragmented UDP packets from the device to our port, and nothing else."""
    source = int.from_bytes(socket.inet_aton(device_ip), "big")
    checks = [
        (_LOAD_BYTE, _PACKET_TYPE, _JUMP_IF_EQUAL, _OUTGOING, False),
        (_LOAD_BYTE, 0, _JUMP_IF_EQUAL, 0x45, True),  # IPv4 without options
        (_LOAD_BYTE, 9, _JUMP_IF_EQUAL, socket.IPPROTO_UDP, True),
        (_LOAD_HALF, 6, _JUMP_IF_SET, 0x3FFF, False),  # a fragment
        (_LOAD_WORD, 12, _JUMP_IF_EQUAL, source, True),
        (_LOAD_HALF, 22, _JUMP_IF_EQUAL, port, True),
    ]
    program: list[tuple[int, int, int, int]] = []
    for index, (load, offset, jump, value, wanted) in enumerate(checks):
        refuse = 2 * (len(checks) - index - 1) + 1
        program += [(load, 0, 0, offset), (jump, *((0, refuse) if wanted else (refuse, 0)), value)]
    return [*program, (_RETURN, 0, 0, 0xFFFF), *_NOTHING]


def _attach(target: socket.socket, program: list[tuple[int, int, int, int]]) -> None:
    encoded = b"".join(struct.pack("=HBBI", *instruction) for instruction in program)
    code = ctypes.create_string_buffer(encoded, len(encoded))
    header = struct.pack("@HP", len(program), ctypes.addressof(code))
    target.setsockopt(socket.SOL_SOCKET, SO_ATTACH_FILTER, header)
