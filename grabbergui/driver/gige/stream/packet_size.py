"""The size of stream packets: what the user wants, the path carries and the camera accepts."""

from __future__ import annotations

import logging
import socket
import time
from dataclasses import dataclass

from grabbergui.core.errors import AccessDeniedError, DeviceStatusError, UsageError
from grabbergui.driver.gige.bootstrap import PACKET_SIZE_MASK, PacketSizeFlag, StreamChannel
from grabbergui.driver.gige.device_memory import DeviceMemory
from grabbergui.driver.gige.gvsp import IP_UDP_BYTES
from grabbergui.driver.gige.interfaces import Interface
from grabbergui.driver.gige.stream.waits import readable

log = logging.getLogger(__name__)

SMALLEST = 576
"Bytes that every path carries."
UNKNOWN_SIZE = 1500
"Packet size of a camera that does not report it: most have it at power-on."
STEP = 4
"Packet sizes are multiples of it on most devices."
TEST_WAIT = 0.05
"Seconds until a test packet counts as lost."
TEST_TRIES = 2
USUAL_SIZES = (9000, 8228, 4088, 1500, 1400, SMALLEST)
"Sizes to try, largest first, with the camera's current size and the interface's limit."


@dataclass(frozen=True)
class PacketSizePolicy:
    """Requested packet size: the camera's (`keep`), the best (`auto`), or a number of bytes."""

    mode: str = "auto"
    size: int = 0
    "Bytes of the whole IP datagram, where mode is `fixed`."

    @classmethod
    def parse(cls, text: str) -> PacketSizePolicy:
        """Parse a URI's `packet_size`. Raises UsageError."""
        if text in ("", "auto"):
            return cls()
        if text == "keep":
            return cls("keep")
        if text.isdecimal() and SMALLEST <= int(text) <= PACKET_SIZE_MASK:
            return cls("fixed", int(text))
        raise UsageError(f"packet_size={text}: write auto, keep, or {SMALLEST} … {PACKET_SIZE_MASK} bytes")


class PacketSizer:
    """Settles the packet size of an opened stream channel."""

    def __init__(
        self,
        channel: StreamChannel,
        memory: DeviceMemory,
        interface: Interface,
    ) -> None:
        self._register = channel.packet_size
        self._memory = memory
        self._interface = interface
        self.big_endian = False
        "Byte order of pixels, which stands beside the size in the register, and stays."
        self.source_port = 0
        "UDP port that a test packet came from; 0 if none arrived."
        self.tests_arrive = True
        "False once test packets were requested in vain."

    def settle(
        self, policy: PacketSizePolicy, receiver: socket.socket, device_ip: str, *, can_test: bool = True
    ) -> int:
        """Settle the packet size; return it as read back from the camera.

        Never writes more than the interface carries in one piece. `receiver` is the stream's socket, which
        test packets arrive at; none is requested unless `can_test`. Raises as register reads and writes do.
        """
        limit = min(self._interface.mtu, PACKET_SIZE_MASK)
        register = self._memory.read_optional(self._register, UNKNOWN_SIZE)
        current = register & PACKET_SIZE_MASK
        self.big_endian = bool(register & PacketSizeFlag.BIG_ENDIAN_PIXELS)
        if policy.mode == "keep" or (policy.mode == "auto" and self._interface.loopback and current):
            self._warn_if_too_large(current, limit)
            return current
        if policy.mode == "fixed":
            if policy.size > limit:
                log.warning("packet_size=%d: %s carries only %d", policy.size, self._interface.name, limit)
            return self._set(min(policy.size, limit), current)
        return self._negotiate(current, limit, receiver, device_ip, can_test=can_test)

    def _negotiate(
        self, current: int, limit: int, receiver: socket.socket, device_ip: str, *, can_test: bool
    ) -> int:
        # Larger sizes are tried only where a test shows that they arrive: a switch may carry less.
        sizes = sorted(
            {size for size in (*USUAL_SIZES, current, limit) if SMALLEST <= size <= limit}, reverse=True
        )
        if can_test:
            for size in sizes:
                if self.arrives(size - size % STEP, receiver, device_ip):
                    return self._set(size, current)
            self.tests_arrive = False
            log.info("no test packet arrived; the packet size is kept at %d", current)
        return self._set(min(current, limit), current) if current > limit or can_test else current

    def arrives(self, size: int, receiver: socket.socket, device_ip: str) -> bool:
        """Return whether a test packet of `size` bytes, not to be fragmented, arrives."""
        flags = PacketSizeFlag.FIRE_TEST_PACKET | PacketSizeFlag.DO_NOT_FRAGMENT
        for _ in range(TEST_TRIES):
            try:
                self._memory.write_register(self._register, flags | self._kept | size)
            except (DeviceStatusError, AccessDeniedError):  # some devices do not answer what they refuse
                return False
            deadline = time.monotonic() + TEST_WAIT
            while (left := deadline - time.monotonic()) > 0:
                if not readable([receiver], left):
                    break
                datagram, (source, port) = receiver.recvfrom(65536)
                if source == device_ip and len(datagram) == size - IP_UDP_BYTES:
                    self.source_port = port
                    return True
        return False

    @property
    def _kept(self) -> int:
        return PacketSizeFlag.BIG_ENDIAN_PIXELS if self.big_endian else 0

    def _set(self, size: int, current: int) -> int:
        size -= size % STEP
        if not self._memory.write_optional(self._register, self._kept | size):
            log.warning("the camera keeps its packet size of %d bytes", current)
            self._warn_if_too_large(current, self._interface.mtu)
            return current
        return self._memory.read_optional(self._register, size) & PACKET_SIZE_MASK

    def _warn_if_too_large(self, size: int, limit: int) -> None:
        if size > limit:
            log.warning(
                "the camera sends packets of %d bytes, %s carries %d in one piece: write packet_size=auto",
                size,
                self._interface.name,
                limit,
            )
