"""How large stream packets are: what the user asked, what the path carries, what the camera took."""

from __future__ import annotations

import logging
import socket
import time
from collections.abc import Callable
from dataclasses import dataclass

from grabbergui.core.errors import DeviceStatusError, UsageError
from grabbergui.driver.gige.bootstrap import PACKET_SIZE_MASK, PacketSizeFlag, StreamChannel
from grabbergui.driver.gige.gvsp import IP_UDP_BYTES
from grabbergui.driver.gige.interfaces import Interface
from grabbergui.driver.gige.readiness import readable

log = logging.getLogger(__name__)

SMALLEST = 576
"Every path carries this."
STEP = 4
"Packet sizes are multiples of it on most devices."
TEST_WAIT = 0.05
"Seconds until a test packet counts as lost."
TEST_TRIES = 2
USUAL_SIZES = (9000, 8228, 4088, 1500, 1400, SMALLEST)
"Tried between the camera's present size and the interface's limit, largest first."


@dataclass(frozen=True)
class PacketSizePolicy:
    """`keep` what the camera holds, find the best (`auto`), or a number of bytes."""

    mode: str = "auto"
    size: int = 0
    "Bytes of the whole IP datagram, where mode is `fixed`."

    @classmethod
    def parse(cls, text: str) -> PacketSizePolicy:
        """Of a URI's `packet_size`. Raises UsageError."""
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
        read: Callable[[int], int],
        write: Callable[[int, int], None],
        interface: Interface,
    ) -> None:
        self._register = channel.packet_size
        self._read = read
        self._write = write
        self._interface = interface

    def settle(
        self, policy: PacketSizePolicy, receiver: socket.socket, device_ip: str, *, can_test: bool
    ) -> int:
        """The size that holds in the end, read back from the camera.

        Never writes more than the interface carries in one piece. `receiver` is the stream's socket, which
        test packets arrive at. Raises as register reads and writes do.
        """
        limit = min(self._interface.mtu, PACKET_SIZE_MASK)
        current = self._read(self._register) & PACKET_SIZE_MASK
        if policy.mode == "keep" or (policy.mode == "auto" and self._interface.loopback and current):
            self._warn_if_too_large(current, limit)
            return current
        if policy.mode == "fixed":
            if policy.size > limit:
                log.warning("packet_size=%d: %s carries only %d", policy.size, self._interface.name, limit)
            return self._set(min(policy.size, limit))
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
                if self._test(size - size % STEP, receiver, device_ip):
                    return self._set(size - size % STEP)
            log.info("no test packet arrived; the packet size is kept at %d", current)
        return self._set(min(current, limit)) if current > limit or can_test else current

    def _test(self, size: int, receiver: socket.socket, device_ip: str) -> bool:
        """Whether a test packet of `size` bytes, not to be fragmented, arrives."""
        flags = PacketSizeFlag.FIRE_TEST_PACKET | PacketSizeFlag.DO_NOT_FRAGMENT
        for _ in range(TEST_TRIES):
            try:
                self._write(self._register, flags | size)
            except DeviceStatusError:
                return False
            deadline = time.monotonic() + TEST_WAIT
            while (left := deadline - time.monotonic()) > 0:
                if not readable([receiver], left):
                    break
                datagram, (source, _) = receiver.recvfrom(65536)
                if source == device_ip and len(datagram) == size - IP_UDP_BYTES:
                    return True
        return False

    def _set(self, size: int) -> int:
        kept = self._read(self._register) & PacketSizeFlag.BIG_ENDIAN_PIXELS
        self._write(self._register, kept | size - size % STEP)
        return self._read(self._register) & PACKET_SIZE_MASK

    def _warn_if_too_large(self, size: int, limit: int) -> None:
        if size > limit:
            log.warning(
                "the camera sends packets of %d bytes, %s carries %d in one piece: write packet_size=auto",
                size,
                self._interface.name,
                limit,
            )
