"""How long to let packets gather: fewer, larger batches cost less, as long as no buffer runs over."""

from __future__ import annotations

from grabbergui.driver.gige.stream_socket import kernel_bytes

LONGEST_PAUSE = 0.01
"Seconds."
SHORTEST_PAUSE = 0.0002
"Seconds; less is not worth the wake-up."
FASTEST = 600e6
"Bytes a second, as the kernel counts: packets that come faster gather by themselves while others are taken."
BUFFER_SHARE = 0.25
"Of the socket's buffer that may fill meanwhile."
LEAST_SPAN = 0.0002
"Seconds; over a shorter one no rate is measured."
FALL = 0.005
"Weight of a rate below the known one: a sender that stalled goes on as fast as before."
RISE = 2.0
"""Times the known rate that a higher one counts for, and at once, since no buffer must run over. Not more: a
thread that was held up sees packets come faster than they do."""
HALF_LIFE = 1.0
"Seconds in which half is forgotten of how late pauses ended."


class Pace:
    """Learns the rate at which a stream's packets come, and tells how long to wait for the next batch."""

    def __init__(self, buffer_bytes: int, most_packets: int) -> None:
        """`buffer_bytes` as the kernel counts; `most_packets` are taken in one batch."""
        self._buffer_bytes = buffer_bytes
        self._most_packets = most_packets
        self._rate = 0.0
        "Packets a second within a block."
        self._last: float | None = None
        self._late = 0.0
        "Seconds that pauses lasted longer than asked for: on a busy machine a thread waits for its turn."
        self._remembered_at: float | None = None

    def slept(self, asked: float, took: float) -> None:
        """A pause of `asked` seconds has lasted `took`."""
        self._late = max(self._late, took - asked)

    def took(self, packets: int, now: float, *, more: bool) -> None:
        """A batch was taken; `more` of its block is to come."""
        if self._last is not None and now - self._last >= LEAST_SPAN and packets:
            rate = packets / (now - self._last)
            if rate > self._rate:
                self._rate = min(rate, RISE * self._rate) if self._rate else rate
            else:
                self._rate += FALL * (rate - self._rate)
        self._last = now if more else None
        if self._remembered_at is not None:
            self._late *= 0.5 ** ((now - self._remembered_at) / HALF_LIFE)
        self._remembered_at = now

    def pause(self, expected: int, packet_bytes: int) -> float:
        """Seconds to wait where `expected` packets of so many bytes are still to come of a block."""
        if not expected or not self._rate:
            return 0.0
        filling = self._rate * kernel_bytes(packet_bytes)
        if filling > FASTEST:
            return 0.0
        longest = min(
            LONGEST_PAUSE,
            BUFFER_SHARE * self._buffer_bytes / filling - self._late,
            0.9 * self._most_packets / self._rate,
        )
        rest = expected / self._rate
        # Two equal pauses rather than a long and a tiny one.
        pause = rest if rest <= longest else min(longest, rest / 2)
        return pause if pause >= SHORTEST_PAUSE else 0.0
