"""The receiving thread: packets from a source to the assembler, finished frames to the consumer.

`PlainSource` runs everywhere; other sources (`batches`, `packet_ring`) take packets in batches, and let them
gather as long as that delays no frame. `Pace` decides how long; it has no I/O and reads no clock.
"""

from __future__ import annotations

import logging
import math
import socket
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable

from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import RateMeter, StreamStatistics
from grabbergui.core.scheduling import RealtimeThread
from grabbergui.driver.device import deliver_or_log
from grabbergui.driver.gige.bootstrap import GVCP_PORT
from grabbergui.driver.gige.stream.assembler import BlockAssembler
from grabbergui.driver.gige.stream.frame_builder import FrameBuilder
from grabbergui.driver.gige.stream.sockets import Waits, kernel_bytes

log = logging.getLogger(__name__)

MAX_DATAGRAM = 65536
"Bytes."
BURST = 64
"Datagrams taken before timers and finished frames have their turn."


class DatagramSource(ABC):
    """Feeds an assembler from a socket. One thread."""

    realtime = False
    "Whether the thread wakes without delay when packets arrive."

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

    def __init__(self, receiver: socket.socket, device_ip: str) -> None:
        super().__init__()
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
                self._waits.readable(self._socket, timeout)
                continue
            if source == device_ip:
                assembler.receive(scratch[:size], time.monotonic())
            else:
                assembler.ignore(1)


# -- pauses between batches ----------------------------------------------------------------------
LONGEST_PAUSE = 0.03
"Seconds. A wake-up costs as much as about a hundred packets; lost packets are requested only after it."
SHORTEST_PAUSE = 0.0002
"Seconds; a shorter pause is not worth the wake-up."
LAST_PAUSE = 0.001
"Seconds before a block's end at which queued packets are read, so that little work is left at the end."
MOST_READING = 0.5
"Largest known time for reading what accumulated in a pause, as a share of the pause."
MOST_USUALLY_LATE = 0.0003
"Largest reduction of the last pause in seconds: packets that arrive in this time are read one by one."
MOST_POLLING = 0.0003
"Seconds before a block's end in which the thread watches for packets without sleeping."
POLLING_SHARE = 0.01
"Share of the time between two blocks' ends that may be spent so."
ONE_BY_ONE_SHARE = 0.01
"""Share of the time between two blocks' ends in which a real-time thread reads packets as they arrive, since
a pause may end late. `LAST_PAUSE` at most."""
FASTEST = 600e6
"""Bytes per second by the kernel's count. Packets that always arrive faster accumulate without a pause while
others are read. We still wait for a burst if the camera rests after it."""
BUFFER_SHARE = 0.25
"Share of the socket's buffer that may fill during a pause, including a late end of the pause."
PAUSE_SHARE = 1 / 16
"Least share for the pause alone: if every pause ends late, reading packets one by one would not help."
BURST_SPAN = 0.0002
"Seconds; over a shorter span no burst is measured."
LEAST_SPAN = 0.0005
"Seconds; over a shorter span no rate is measured."
STEADY_SPAN = 0.002
"Seconds within a block after which bursts average out, so that the rate predicts the block's end."
FALL, STEADY_FALL = 0.005, 0.02
"Weight of a rate below the known one: a sender resumes at full speed after a stall."
RISE = 2.0
"""Largest immediate increase of the known rate, as a factor: fast, because no buffer may overflow, but
limited, because a delayed thread sees packets arrive faster than they do."""
HALF_LIFE = 1.0
"Half-life in seconds of the memory of how late pauses ended."


class Pace:
    """Learns a stream's packet rate and decides how long to wait for the next batch."""

    def __init__(self, buffer_bytes: int, most_packets: int) -> None:
        """`buffer_bytes` as the kernel counts; `most_packets` are taken in one batch."""
        self.realtime = False
        "Whether the thread wakes without delay. Then it waits for a block's last packets one by one."
        self._buffer_bytes = buffer_bytes
        self._most_packets = most_packets
        self._peak = 0.0
        "Peak packets per second within a block, bursts included; it determines the buffer's reserve."
        self._rate = 0.0
        "Packets per second over a longer time; it predicts the block's end."
        self._mean = 0.0
        "Packets per second including the time between blocks; 0 while unknown."
        self._ended = 0.0
        "Time at which the last block ended."
        self._period = 0.0
        "Seconds between the ends of the last two blocks; 0 while unknown."
        self._since_end = 0
        "Packets received since the last block ended."
        self._since: float | None = None
        "Time from which `_packets` of a block are counted; None between blocks."
        self._packets = 0
        self._looked_at = 0.0
        "Time of the last read; later packets are not counted yet."
        self._late = 0.0
        "Seconds by which pauses ended late: on a busy machine a thread waits for a processor."
        self._usually_late = 0.0
        self._reading = 0.0
        "Seconds that it takes to read what accumulates in a second."

    def slept(self, intended: float, took: float) -> None:
        """Note that a pause meant to last `intended` seconds lasted `took`."""
        late = took - intended
        self._late = max(self._late, late)
        self._usually_late += (min(late, MOST_USUALLY_LATE) - self._usually_late) / 8

    def read(self, paused: float, seconds: float) -> None:
        """Note that reading took `seconds` after a pause of `paused` seconds."""
        if paused > LAST_PAUSE:  # a few packets cost more each
            self._reading += (min(seconds / paused, MOST_READING) - self._reading) / 8

    def took(self, packets: int, now: float, *, more: bool, ended: bool) -> None:
        """Note a batch read at `now`.

        `more`: more of the newest block is to arrive. `ended`: a block ended; its trailer may come later.
        """
        if self._since is not None:
            span = now - self._looked_at
            if packets and span >= BURST_SPAN:
                self._peak = _followed(self._peak, packets / span, FALL)
            self._packets += packets
            span = now - self._since
            # The first block fills new memory, which takes long: it may have ended well before this read.
            timely = more or self._ended or now - self._looked_at <= STEADY_SPAN
            if self._packets and timely and span >= (STEADY_SPAN if more else LEAST_SPAN):
                self._rate = _followed(self._rate, self._packets / span, STEADY_FALL)
                self._since = None
        self._since_end += packets
        if ended:
            self._period = now - self._ended if self._ended else 0.0
            self._mean = self._since_end / self._period if self._period else 0.0
            self._ended, self._since_end = now, 0
        if self._since is None or not more:
            self._packets, self._since = 0, now if more else None
        self._late *= 0.5 ** ((now - self._looked_at) / HALF_LIFE)
        self._looked_at = now

    def pause(self, expected: int, packet_bytes: int, now: float) -> float:
        """Return the seconds to wait while `expected` packets of `packet_bytes` remain until a block's end.

        The last pause begins shortly before the end, when all earlier packets have been read, and ends with
        it, so that the frame is complete soon.
        That of a `realtime` thread ends earlier.
        """
        if not expected or not self._rate or not self._peak:
            return 0.0
        in_kernel = kernel_bytes(packet_bytes)
        if (self._mean or self._peak) * in_kernel > FASTEST:
            return 0.0
        filling = self._peak * in_kernel
        since = now - self._looked_at
        buffer = self._buffer_bytes / filling
        longest = min(
            LONGEST_PAUSE,
            max(BUFFER_SHARE * buffer - self._late, PAUSE_SHARE * buffer) - since,
            0.9 * self._most_packets / self._peak - since,
        )
        pause = expected / self._rate - since - self._usually_late
        before_last = pause - LAST_PAUSE
        if before_last > SHORTEST_PAUSE:
            # Equal pauses rather than long ones and a tiny one; reading takes time after each.
            before_last /= 1 + self._reading
            pause = before_last / math.ceil(before_last / LONGEST_PAUSE)
        elif self.realtime:
            pause -= min(LAST_PAUSE, ONE_BY_ONE_SHARE * self._period)
        pause = min(pause, longest)
        return pause if pause >= SHORTEST_PAUSE else 0.0

    def polling(self, expected: int, now: float) -> float:
        """Return the seconds to watch without sleeping for the `expected` packets until a block's end.

        Once it sleeps, a thread wakes later than they arrive; so it does not when they are due.
        """
        if not expected or not self._rate or expected / self._rate - (now - self._looked_at) > MOST_POLLING:
            return 0.0
        return min(MOST_POLLING, POLLING_SHARE * self._period)


def _followed(known: float, seen: float, fall: float) -> float:
    """Return the known rate, adjusted to a measured one."""
    if not known:
        return seen
    return min(seen, RISE * known) if seen > known else known + fall * (seen - known)


# -- the thread ----------------------------------------------------------------------------------
IDLE_WAIT = 0.03
"Seconds that the thread waits for a datagram before it checks whether to stop, as long as `Pace` pauses."
HAND_OVER = 0.00003
"""Seconds that a real-time thread sleeps after it has delivered a frame: otherwise the consumer waits for the
processor and the interpreter until the next block's first packets are read."""


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
        self._source.wake()
        if self._thread is not threading.current_thread():
            self._thread.join()
        self._source.close()
        self._socket.close()

    def statistics(self) -> StreamStatistics:
        """Return a snapshot. Any thread."""
        return self._assembler.statistics.snapshot(self._rate)

    def _run(self) -> None:
        assembler, thread = self._assembler, RealtimeThread()
        while not self._stopping:
            now = time.monotonic()
            self._source.realtime = thread.review(now)
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
            if assembler.has_finished:
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
            try:
                frame = self._builder.build(block)
            except Exception as error:  # without this thread nothing would arrive any more
                block.layout.warn_once("a block became no frame", f"{type(error).__name__}: {error}")
                continue
            if block.complete:
                self._rate.add(len(block.payload))
            deliver_or_log(self._deliver, frame)
        if self._source.realtime:
            time.sleep(HAND_OVER)
