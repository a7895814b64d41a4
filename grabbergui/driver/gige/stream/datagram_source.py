"""Where a stream's packets come from: the interface of sources, and the one that runs everywhere."""

from __future__ import annotations

import socket
import time
from abc import ABC, abstractmethod

from grabbergui.driver.gige.stream.assembler import BlockAssembler
from grabbergui.driver.gige.stream.packet_origin import PacketOrigin
from grabbergui.driver.gige.stream.waits import Waits

MAX_DATAGRAM = 65536
"Bytes."
BURST = 64
"Datagrams taken before timers and finished frames have their turn."


class DatagramSource(ABC):
    """Feeds an assembler from a socket. One thread."""

    def __init__(self) -> None:
        self._waits = Waits()

    @abstractmethod
    def receive(self, assembler: BlockAssembler, timeout: float) -> None:
        """Wait at most `timeout` seconds for a datagram, then take what is there. Raises OSError."""

    def wake(self) -> None:
        """Let `receive` return at once from now on. Any thread, once."""
        self._waits.end()

    def close(self) -> None:
        """Close what the source opened itself."""
        self._waits.close()


class PlainSource(DatagramSource):
    """A system call for each datagram: runs everywhere."""

    def __init__(self, receiver: socket.socket, origin: PacketOrigin) -> None:
        super().__init__()
        self._socket = receiver
        self._origin = origin
        self._scratch = memoryview(bytearray(MAX_DATAGRAM))
        receiver.setblocking(False)

    def receive(self, assembler: BlockAssembler, timeout: float) -> None:
        """Take up to `BURST` datagrams, a system call each."""
        receive_into, scratch, origin = self._socket.recvfrom_into, self._scratch, self._origin
        for count in range(BURST):
            try:
                size, (ip, port) = receive_into(scratch)
            except BlockingIOError:
                if count:
                    return
                self._waits.readable(self._socket, timeout)
                continue
            now = time.monotonic()
            if origin.admits(ip, port, now):
                assembler.receive(scratch[:size], now)
            else:
                assembler.ignore(1)
