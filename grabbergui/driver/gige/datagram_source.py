"""How datagrams get from a socket to the assembler, without any extra package or system call."""

from __future__ import annotations

import socket
import time
from abc import ABC, abstractmethod

from grabbergui.driver.gige.block_assembler import BlockAssembler
from grabbergui.driver.gige.readiness import readable

MAX_DATAGRAM = 65536
BURST = 64
"Datagrams taken before timers and finished frames are looked after."


class DatagramSource(ABC):
    """Feeds an assembler from a socket. One thread."""

    @abstractmethod
    def receive(self, assembler: BlockAssembler, timeout: float) -> None:
        """Wait at most `timeout` seconds for a datagram, then take what is there. Raises OSError."""

    def close(self) -> None:  # noqa: B027 - most have nothing to let go
        """Let go of what the source opened itself."""


class PlainSource(DatagramSource):
    """A system call for each datagram: runs everywhere."""

    def __init__(self, receiver: socket.socket, device_ip: str) -> None:
        self._socket = receiver
        self._device_ip = device_ip
        self._scratch = memoryview(bytearray(MAX_DATAGRAM))
        receiver.setblocking(False)

    def receive(self, assembler: BlockAssembler, timeout: float) -> None:
        """See DatagramSource."""
        receive_into, scratch, device_ip = self._socket.recvfrom_into, self._scratch, self._device_ip
        for count in range(BURST):
            try:
                size, (source, _) = receive_into(scratch)
            except BlockingIOError:
                if count:
                    return
                readable([self._socket], timeout)
                continue
            if source == device_ip:
                assembler.receive(scratch[:size], time.monotonic())
            else:
                assembler.statistics.packets_ignored += 1
