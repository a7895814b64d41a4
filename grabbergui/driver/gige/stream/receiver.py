"""The receiving thread: packets from a source to the assembler, finished frames to the consumer.

`PlainSource` runs everywhere. A `PacedSource` (`recvmmsg`, `packet_ring`) takes packets in batches, and lets
them gather as long as that delays no frame.
"""

from __future__ import annotations

import logging
import socket
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable

from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import RateMeter, StreamStatistics
from grabbergui.core.priority import PromptThread
from grabbergui.driver.gige.bootstrap import GVCP_PORT
from grabbergui.driver.gige.stream.assembler import BlockAssembler
from grabbergui.driver.gige.stream.frame_builder import FrameBuilder
from grabbergui.driver.gige.stream.pace import Pace
from grabbergui.driver.gige.stream.sockets import readable

log = logging.getLogger(__name__)

MAX_DATAGRAM = 65536
BURST = 64
"Datagrams taken before timers and finished frames have their turn."


class DatagramSource(ABC):
    """Feeds an assembler from a socket. One thread."""

    prompt = False
    "Whether the thread wakes without delay when packets arrive."

    @abstractmethod
    def receive(self, assembler: BlockAssembler, timeout: float) -> None:
        """Wait at most `timeout` seconds for a datagram, then take what is there. Raises OSError."""

    def close(self) -> None:  # noqa: B027 - most own nothing
        """Close what the source opened itself."""


class PlainSource(DatagramSource):
    """A system call for each datagram: runs everywhere."""

    def __init__(self, receiver: socket.socket, device_ip: str) -> None:
        self._socket = receiver
        self._device_ip = device_ip
        self._scratch = memoryview(bytearray(MAX_DATAGRAM))
        receiver.setblocking(False)

    def receive(self, assembler: BlockAssembler, timeout: float) -> None:
        """Take up to `BURST` datagrams, a system call each."""
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


ANSWER_PAUSE = 0.001
"Seconds that packets may gather while a block waits for lost ones."
OVERRUN = 0.03
"""Seconds of work without once emptying the buffer, with more incomplete frames than complete ones, after
which all waiting packets are discarded: a full buffer makes holes in every frame, and holes cost time."""


class PacedSource(DatagramSource):
    """Takes packets in batches. One thread."""

    def __init__(self, pace: Pace, wait: Callable[[float], list[int]]) -> None:
        """`wait` waits up to so many seconds; it returns the descriptors of sockets with packets."""
        self._pace = pace
        self._wait = wait
        self._drained = True
        "Whether the last read emptied the buffer."
        self._busy_since = 0.0
        "The thread's CPU time when the buffer was last empty, or overrun was last checked."
        self._lost_by_then = 0
        "Incomplete less complete frames at that time."
        self._overrun_logged = False
        self._flowing = False
        "Whether the last read found packets."

    @abstractmethod
    def _take_all(self, assembler: BlockAssembler, timeout: float) -> float:
        """Wait at most `timeout` seconds for packets and take all; return the time of the last read.

        Clears `_drained` if more may be left. Raises OSError.
        """

    @abstractmethod
    def _discard(self) -> None:
        """Discard all waiting packets."""

    def receive(self, assembler: BlockAssembler, timeout: float) -> None:
        """Let packets gather if that delays no frame, then take all; discard them after an overrun."""
        before = assembler.statistics.packets
        self._pace.prompt = self.prompt
        if self._overrun(assembler.statistics):
            assembler.note_overrun()
            self._skip()
        paused = self._drained and self._flowing and self._gather(assembler, timeout)
        wait = timeout if self._drained and not paused else 0.0
        if wait and self._flowing:
            self._poll(assembler)
        self._drained = True
        now = self._take_all(assembler, wait)
        packets = assembler.statistics.packets - before
        self._flowing = packets > 0
        self._pace.took(packets, now, more=assembler.block_in_progress)

    def _overrun(self, statistics: StreamStatistics) -> bool:
        """Return whether packets arrive faster than we take them (by CPU time, as other programs run too)."""
        worked = time.thread_time()
        if not self._drained and worked - self._busy_since <= OVERRUN:
            return False
        lost = statistics.incomplete - statistics.frames
        overrun = not self._drained and lost > self._lost_by_then
        self._busy_since, self._lost_by_then = worked, lost
        return overrun

    def _skip(self) -> None:
        """Discard waiting packets, so that the next frames are complete again."""
        self._discard()
        self._drained = True
        if not self._overrun_logged:
            self._overrun_logged = True
            log.warning(
                "packets arrive faster than this machine takes them: waiting packets are discarded;"
                " larger packets or a lower frame rate help"
            )

    def _gather(self, assembler: BlockAssembler, timeout: float) -> bool:
        """Let packets gather if that delays no frame; return whether there was time."""
        begun = time.monotonic()
        pause = min(self._pace.pause(assembler.expected(), assembler.stride, begun), timeout)
        if assembler.block_waits:
            pause = min(pause, ANSWER_PAUSE)
        if not pause:
            return False
        if self._rest(pause):
            self._pace.slept(pause, time.monotonic() - begun)
        return True

    def _poll(self, assembler: BlockAssembler) -> None:
        """Watch for the last packets of a block, if they are due, without sleeping."""
        now = time.monotonic()
        end = now + self._pace.polling(assembler.expected(), now)
        while now < end and not self._wait(0.0):
            now = time.monotonic()

    def _rest(self, seconds: float) -> bool:
        """Wait; return False if that ended early, because a block did."""
        time.sleep(seconds)
        return True


IDLE_WAIT = 0.03
"Seconds that the thread waits for a datagram before it checks whether to stop, as long as `pace` pauses."


class StreamReceiver:
    """Receives one stream until stopped."""

    def __init__(
        self,
        receiver: socket.socket,
        device_ip: str,
        assembler: BlockAssembler,
        builder: FrameBuilder,
        deliver: Callable[[Frame], None],
        source: DatagramSource,
    ) -> None:
        """Start the thread, which owns the socket. `deliver` is called on it and must return at once."""
        self._socket = receiver
        self._device = (device_ip, GVCP_PORT)
        self._assembler = assembler
        self._builder = builder
        self._deliver = deliver
        self._source = source
        self._rate = RateMeter()
        self._next_req_id = 1
        self._stopping = False
        self._thread = threading.Thread(target=self._run, name="gige-receiver", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End the thread and close the socket; nothing is delivered any more on return."""
        self._stopping = True
        if self._thread is not threading.current_thread():
            self._thread.join()
        self._source.close()
        self._socket.close()

    def statistics(self) -> StreamStatistics:
        """Return a snapshot. Any thread."""
        return self._assembler.statistics.snapshot(self._rate)

    def _run(self) -> None:
        assembler, thread = self._assembler, PromptThread()
        while not self._stopping:
            now = time.monotonic()
            self._source.prompt = thread.review(now)
            wait = min(assembler.timer() - now, IDLE_WAIT)
            try:
                self._source.receive(assembler, max(wait, 0.0))
            except OSError as error:
                if self._stopping:
                    return
                log.debug("stream socket: %s", error)
                time.sleep(0.01)
            assembler.handle_timer(time.monotonic())
            self._request_missing()
            self._deliver_finished()

    def _request_missing(self) -> None:
        for request in self._assembler.resend_requests():
            try:
                self._socket.sendto(request.encode(self._next_req_id), self._device)
            except OSError as error:
                log.debug("requesting lost packets: %s", error)
            self._next_req_id = self._next_req_id % 0xFFFF + 1

    def _deliver_finished(self) -> None:
        for block in self._assembler.finished():
            frame = self._builder.build(block)
            if block.complete:
                self._rate.add(len(block.payload))
            try:
                self._deliver(frame)
            except Exception:
                log.exception("a consumer of frames failed")
