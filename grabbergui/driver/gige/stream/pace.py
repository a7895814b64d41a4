"""Pace of reading packets: fewer, larger batches cost less, as long as no buffer overflows."""

from __future__ import annotations

import math

from grabbergui.driver.gige.stream.sockets import kernel_bytes

LONGEST_PAUSE = 0.03
"Seconds. A wake-up costs as much as about a hundred packets; lost packets are requested only after it."
SHORTEST_PAUSE = 0.0002
"Seconds; a shorter pause is not worth the wake-up."
LAST_PAUSE = 0.001
"Seconds before a block's end at which queued packets are read, so that little work is left at the end."
MOST_USUALLY_LATE = 0.0003
"Largest reduction of the last pause in seconds: packets that arrive in this time are read one by one."
MOST_POLLING = 0.0003
"Seconds before a block's end in which the thread watches for packets without sleeping."
POLLING_SHARE = 0.01
"Share of the time between two blocks' ends that may be spent so."
ONE_BY_ONE_SHARE = 0.03
"""Share of the time between two blocks' ends in which a prompt thread reads packets as they arrive, since a
pause may end late. `LAST_PAUSE` at most."""
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
        self.prompt = False
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

    def slept(self, intended: float, took: float) -> None:
        """Note that a pause meant to last `intended` seconds lasted `took`."""
        late = took - intended
        self._late = max(self._late, late)
        self._usually_late += (min(late, MOST_USUALLY_LATE) - self._usually_late) / 8

    def took(self, packets: int, now: float, *, more: bool) -> None:
        """Note a batch read at `now`; `more`: its block has not ended."""
        if self._since is not None:
            span = now - self._looked_at
            if packets and span >= BURST_SPAN:
                self._peak = _followed(self._peak, packets / span, FALL)
            self._packets += packets
            span = now - self._since
            if self._packets and span >= (STEADY_SPAN if more else LEAST_SPAN):
                self._rate = _followed(self._rate, self._packets / span, STEADY_FALL)
                self._since = None
        self._since_end += packets
        if packets and not more:
            self._period = now - self._ended if self._ended else 0.0
            self._mean = self._since_end / self._period if self._period else 0.0
            self._ended, self._since_end = now, 0
        if self._since is None or not more:
            self._packets, self._since = 0, now if more else None
        self._late *= 0.5 ** ((now - self._looked_at) / HALF_LIFE)
        self._looked_at = now

    def pause(self, expected: int, packet_bytes: int, now: float) -> float:
        """Return the seconds to wait if `expected` packets of so many bytes remain until a block's end.

        The last pause begins shortly before the end and ends with it, so that the frame is complete soon.
        That of a `prompt` thread ends earlier.
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
            # Equal pauses rather than long ones and a tiny one.
            pause = before_last / math.ceil(before_last / LONGEST_PAUSE)
        elif self.prompt:
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
