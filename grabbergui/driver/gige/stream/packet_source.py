"""How datagrams get from a socket to the assembler, without any extra package or system call."""

from __future__ import annotations

import logging
import socket
import time
from abc import ABC, abstractmethod

from grabbergui.core.grabber import StreamStatistics
from grabbergui.driver.gige.discovery.interfaces import readable
from grabbergui.driver.gige.stream.assembler import BlockAssembler
from grabbergui.driver.gige.stream.pace import Pace

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
                assembler.ignore(1)


log = logging.getLogger(__name__)

ANSWER_PAUSE = 0.001
"Seconds that packets gather at most, where a block waits for some that were lost."
OVERRUN = 0.03
"""Seconds of work without once emptying the buffer, in which more frames were lost than came whole, after
which all that waits is thrown away: behind a full buffer frames have holes, which cost more time to take."""


class PacedSource(DatagramSource):
    """Takes packets in batches. One thread."""

    def __init__(self, pace: Pace) -> None:
        self._pace = pace
        self._drained = True
        "Whether the buffer was empty when it was last looked at."
        self._busy_since = 0.0
        "The thread's CPU time when it was last found empty, or last judged whether too much comes, and"
        self._lost_by_then = 0
        "how many frames more were incomplete than whole by then."
        self._told = False
        "Whether it was told that packets were skipped."
        self._flowing = False
        "Whether anything came when it was last looked at."

    @abstractmethod
    def _take_all(self, assembler: BlockAssembler, timeout: float) -> float:
        """Wait at most `timeout` seconds for packets and take what is there; when it was last looked for.

        Clears `_drained` where more may be left. Raises OSError.
        """

    @abstractmethod
    def _discard(self) -> None:
        """Throw away what waits."""

    def receive(self, assembler: BlockAssembler, timeout: float) -> None:
        """See DatagramSource."""
        before = assembler.statistics.packets
        if self._overrun(assembler.statistics):
            assembler.note_overrun()
            self._skip()
        paused = self._drained and self._flowing and self._gather(assembler, timeout)
        wait = timeout if self._drained and not paused else 0.0
        self._drained = True
        now = self._take_all(assembler, wait)
        packets = assembler.statistics.packets - before
        self._flowing = packets > 0
        self._pace.took(packets, now, more=assembler.block_in_progress)

    def _overrun(self, statistics: StreamStatistics) -> bool:
        """Whether packets come faster than they can be taken. By CPU time: others may have had the rest."""
        worked = time.thread_time()
        if not self._drained and worked - self._busy_since <= OVERRUN:
            return False
        lost = statistics.incomplete - statistics.frames
        overrun = not self._drained and lost > self._lost_by_then
        self._busy_since, self._lost_by_then = worked, lost
        return overrun

    def _skip(self) -> None:
        """Throw away what waits: the oldest, and what comes next is whole again."""
        self._discard()
        self._drained = True
        if not self._told:
            self._told = True
            log.warning(
                "packets come faster than this machine takes them: those that waited are skipped;"
                " larger packets or a lower frame rate help"
            )

    def _gather(self, assembler: BlockAssembler, timeout: float) -> bool:
        """Let packets gather for a while, where that delays no picture; whether there was time to."""
        begun = time.monotonic()
        pause = min(self._pace.pause(assembler.expected(), assembler.stride, begun), timeout)
        if assembler.block_waits:
            pause = min(pause, ANSWER_PAUSE)
        if not pause:
            return False
        time.sleep(pause)
        self._pace.slept(pause, time.monotonic() - begun)
        return True
