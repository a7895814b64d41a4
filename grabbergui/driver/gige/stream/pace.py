"""How long packets may gather before they are read: no I/O, no clock.

A wake-up costs as much as a hundred packets, so the thread sleeps until a block is complete, or the buffer a
quarter full. When a block ends is computed from the packets that were missing at the last look at the buffer,
so that only what happens since then can make it late.
"""

from __future__ import annotations

import math
import statistics
from collections import deque

from grabbergui.driver.gige.stream.sockets import kernel_bytes

LONGEST_PAUSE = 0.03
"Seconds; lost packets are requested only after a pause."
LAST_PAUSE = 0.001
"Seconds before a block's end at which queued packets are read, so that little work is left at the end."
SHORTEST_PAUSE = 0.0001
"""Seconds. While a block arrives no pause is shorter: to be woken by each of its last packets costs more than
reading them a little later."""
BLOCKS = 3
"Blocks whose median counts: one that came late says nothing about the next."
SHORTENING = 0.05
"Share by which the next block is awaited for less time, if this one was complete at the first look."
FASTEST = 600e6
"""Bytes per second by the kernel's count. Packets that always arrive faster accumulate without a pause while
others are read. We still wait for a burst if the camera rests after it."""
BUFFER_SHARE = 0.25
"Share of the socket's buffer that may fill during a pause, including a late end of the pause."
PAUSE_SHARE = 1 / 16
"Least share for the pause alone: if every pause ends late, reading packets one by one would not help."
BURST_SPAN = 0.0002
"Seconds; over a shorter span no rate is measured."
FALL = 0.005
"Weight of a rate below the known one: a sender resumes at full speed after a stall."
RISE = 2.0
"""Largest immediate increase of the known rate, as a factor: fast, because no buffer may overflow, but
limited, because a delayed thread sees packets arrive faster than they do."""
HALF_LIFE = 1.0
"Half-life in seconds of the memory of how late pauses ended."


class Pace:
    """Learns how long a stream's blocks take to arrive, and decides how long to wait for the next batch."""

    def __init__(self, buffer_bytes: int, most_packets: int) -> None:
        """`buffer_bytes` as the kernel counts; `most_packets` are taken in one batch."""
        self._buffer_bytes = buffer_bytes
        self._most_packets = most_packets
        self._spacing = 0.0
        "Seconds from one packet of a block to the next; 0 while unknown."
        self._spacings: deque[float] = deque(maxlen=BLOCKS)
        "The same of the last blocks."
        self._begun: float | None = None
        "Time at which the block in progress was first seen; None between blocks."
        self._packets = 0
        "Packets received since then."
        self._peak = 0.0
        "Packets per second within a block, bursts included; it determines the buffer's reserve."
        self._mean = 0.0
        "Packets per second including the time between blocks; 0 while unknown."
        self._ended = 0.0
        "Time at which the last block ended."
        self._since_end = 0
        "Packets received since then."
        self._looked_at = 0.0
        "Time of the last read; later packets are not counted yet."
        self._late = 0.0
        "Seconds by which pauses ended late: on a busy machine a thread waits for a processor."

    def woke(self, now: float) -> None:
        """Note that packets arrived between two blocks: the next one begins."""
        self._begun, self._packets = now, 0
        self._looked_at = now

    def slept(self, intended: float, took: float) -> None:
        """Note that a pause meant to last `intended` seconds lasted `took`."""
        self._late = max(self._late, took - intended)

    def took(self, packets: int, now: float, *, more: bool, ended: bool) -> None:
        """Note a batch read at `now`.

        `more`: more of the newest block is to arrive. `ended`: a block ended; its trailer may come later.
        """
        span = now - self._looked_at
        if self._begun is not None:
            if packets and span >= BURST_SPAN:
                self._peak = _followed(self._peak, packets / span, FALL)
            self._packets += packets
            if ended and self._packets:
                self._learn(self._begun, packets, now)
        self._since_end += packets
        if ended:
            self._mean = self._since_end / (now - self._ended) if self._ended else 0.0
            self._ended, self._since_end = now, 0
        if not more:
            self._begun = None
        elif ended or self._begun is None:
            self._begun, self._packets = now, 0
        self._late *= 0.5 ** (span / HALF_LIFE)
        self._looked_at = now

    def _learn(self, begun: float, packets: int, now: float) -> None:
        """Learn from a block that was complete at the look `now`, with the last `packets` of it.

        What counts is the look before, when packets were still missing. If there was none, the next block is
        looked at a little earlier.
        """
        before = self._looked_at - begun
        if before > BURST_SPAN:
            spacing = before / max(self._packets - packets - 1, 1)
        else:
            spacing = (now - begun) / self._packets
            spacing = min(spacing, self._spacing or spacing) * (1 - SHORTENING)
        self._spacings.append(spacing)
        self._spacing = statistics.median(self._spacings)

    def pause(self, expected: int, packet_bytes: int, now: float) -> float:
        """Return the seconds to wait while `expected` packets of `packet_bytes` remain until a block's end.

        0 if nothing is expected, or packets accumulate without a pause. The last pause begins shortly before
        the block's end, when all earlier packets have been read, and ends with it.
        """
        if not expected or self._begun is None:
            return 0.0
        longest = self._longest(packet_bytes, now)
        pause = self._spacing * expected - (now - self._looked_at)
        before_last = pause - LAST_PAUSE
        if before_last > SHORTEST_PAUSE:  # equal pauses rather than long ones and a tiny one
            pause = before_last / math.ceil(before_last / min(longest, LONGEST_PAUSE)) if longest > 0 else 0.0
        pause = min(max(pause, SHORTEST_PAUSE), longest)
        return pause if pause >= SHORTEST_PAUSE else 0.0

    def _longest(self, packet_bytes: int, now: float) -> float:
        """Return after how many seconds too much of the buffer, or more than a batch, may have arrived."""
        if not self._peak:
            return LAST_PAUSE
        in_kernel = kernel_bytes(packet_bytes)
        if (self._mean or self._peak) * in_kernel > FASTEST:
            return 0.0
        buffer = self._buffer_bytes / (self._peak * in_kernel)
        since = now - self._looked_at
        longest = max(BUFFER_SHARE * buffer - self._late, PAUSE_SHARE * buffer) - since
        return min(LONGEST_PAUSE, longest, 0.9 * self._most_packets / self._peak - since)


def _followed(known: float, seen: float, fall: float) -> float:
    """Return the known rate, adjusted to a measured one."""
    if not known:
        return seen
    return min(seen, RISE * known) if seen > known else known + fall * (seen - known)
