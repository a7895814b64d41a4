"""Requests for lost packets: when to send them and when to stop. Part of the sans-I/O stream protocol.

A packet that others overtook arrives by itself, so the protocol learns the usual delay of such packets and
requests nothing from a gap before it has passed. A busy or distant device answers slowly, and more requests
would slow it down further. So the wait before a repeated request is learned from the answers, as TCP does it,
and doubles with each try; the number of unanswered requests is limited. Times and tries are kept with each
block, in its `PacketAccount`.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grabbergui.driver.gige.gvcp import PacketResend
from grabbergui.driver.gige.stream.id_runs import id_runs, run_ends
from grabbergui.driver.gige.stream.packet_sorting import Ids

NEVER = float("inf")


@dataclass(frozen=True)
class ResendPolicy:
    """Limits and waiting times of resend requests."""

    enabled: bool = True
    "False if the device cannot resend: nothing is requested."
    initial_wait: float = 0.001
    "Shortest time in seconds from noticing a gap to the request: the packet may only have been overtaken."
    longest_initial_wait: float = 0.02
    "Longest such time, learned from packets that were overtaken and arrived late."
    look_again: float = 0.005
    """Shortest time in seconds between two checks for missing packets while the rest of a block arrives. Gaps
    that open in between are requested together, and the frame is completed no later."""
    first_answer_wait: float = 0.02
    "Seconds to wait for an answer before the first answer shows how long it takes."
    shortest_answer_wait: float = 0.005
    longest_answer_wait: float = 0.1
    "Bounds of the learned wait before it doubles with each try."
    tail_wait: float = 0.03
    "Seconds of silence after which the end of a block counts as lost."
    max_tries: int = 6
    "Requests for one packet."
    max_unanswered: int = 512
    "Packets requested at once. They arrive in one burst, which the socket's buffer must hold."
    max_ratio: float = 0.5
    "Largest share of missing packets for which a block is worth a request."
    always_worth: int = 16
    "Number of missing packets up to which a block of any size is worth a request."
    give_up: float = 0.5
    "Seconds of silence after which a block is finished as it is."
    reorder_wait: float = 0.01
    "Seconds of silence that suffice once a later block has begun and no request is outstanding."
    max_blocks: int = 32
    "Largest number of incomplete blocks; the oldest is finished when one more begins."


class RequestLog:
    """Requested packets of a block with their times. Empty, at no cost, if none was requested."""

    def __init__(self) -> None:
        self.tries = np.zeros(0, np.uint8)
        "Requests for each packet, by packet id."
        self.missed_at = np.zeros(0)
        "Time at which its successor arrived first; minus infinity if unknown."
        self.first_at = np.zeros(0)
        "Time of the first request."
        self.again_at = np.zeros(0)
        "Time of the next request."
        self.next_check = NEVER
        "Time of the next request for any packet."
        self.checked_at = -NEVER
        "Time of the last check for due requests."
        self.tail_checked = -NEVER
        "The block's `last_packet_at` when its end was last checked."

    def make_room(self, packets: int) -> None:
        """Grow to at least `packets` entries."""
        if len(self.tries) < packets:
            known = len(self.tries)
            self.tries = _grown(self.tries, packets)
            self.missed_at = _grown(self.missed_at, packets)
            self.missed_at[known:] = -NEVER
            self.first_at = _grown(self.first_at, packets)
            self.again_at = _grown(self.again_at, packets)

    def note_requested(self, ids: NDArray[np.intp], now: float, wait: float) -> None:
        """Record requests; each try waits twice as long as the previous one."""
        tries = self.tries[ids]
        self.first_at[ids] = np.where(tries == 0, now, self.first_at[ids])
        self.again_at[ids] = now + np.ldexp(wait, tries)
        self.tries[ids] = tries + 1


def _grown(array: NDArray[Any], length: int) -> NDArray[Any]:
    """Return a copy of at least that length, at least twice as long as before, filled up with zeros."""
    larger = np.zeros(max(length, 2 * len(array)), array.dtype)
    larger[: len(array)] = array
    return larger


class PacketAccount:
    """Which packets of a block were received and which were requested, by packet id."""

    def __init__(self, block_id: int, extended: bool, packets: int, now: float) -> None:
        """Begin with room for as many packets, at the time of the first one."""
        self.block_id = block_id
        self.extended = extended
        self.received = np.zeros(packets, np.uint8)
        "1 for each packet received."
        self.received_count = 0
        self.highest = -1
        "Highest packet id received."
        self.first_packet_at = now
        self.last_packet_at = now
        self.requests = RequestLog()

    def has(self, packet_id: int) -> bool:
        """Return whether a packet was received."""
        return packet_id < len(self.received) and bool(self.received[packet_id])

    def make_room(self, packets: int) -> None:
        """Grow `received` to at least `packets` entries."""
        if packets > len(self.received):
            self.received = _grown(self.received, packets)

    def note_received(self, ids: Ids, count: int, highest: int, now: float) -> None:
        """Record `count` new packets; `received` must already cover the `highest` of them."""
        self.received[ids] = 1
        self.received_count += count
        self.highest = max(self.highest, highest)
        self.last_packet_at = now

    def missing(self, end: int) -> NDArray[np.intp]:
        """Return the ids of missing packets up to and including `end`."""
        self.make_room(end + 1)
        ids: NDArray[np.intp] = np.flatnonzero(self.received[: end + 1] == 0)
        return ids

    def packet_period(self, now: float) -> float:
        """Return the mean time between packets in seconds."""
        return (now - self.first_packet_at) / max(self.highest, 1)


class LearnedWait:
    """Waiting time for an event, learned from earlier durations."""

    def __init__(self, first: float, shortest: float, longest: float) -> None:
        """Take the wait to begin with and the bounds of the learned wait, all in seconds."""
        self._first, self._shortest, self._longest = first, shortest, longest
        self._mean: float | None = None
        self._deviation = 0.0

    def learn(self, seconds: float) -> None:
        """Take a duration into account."""
        if self._mean is None:
            self._mean, self._deviation = seconds, seconds / 2
            return
        self._deviation += (abs(seconds - self._mean) - self._deviation) / 4
        self._mean += (seconds - self._mean) / 8

    @property
    def wait(self) -> float:
        """Seconds after which the event counts as missed."""
        if self._mean is None:
            return self._first
        # Twice the deviation, not four times as in TCP: durations here include lost answers, and a factor of
        # four would make the wait grow without bound on a link that loses a tenth of its packets.
        return min(max(self._mean + 2 * self._deviation, self._shortest), self._longest)


class AnswerWindow:
    """Limits the number of packets that are requested and neither received nor given up."""

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self._requests: deque[tuple[float, int]] = deque()
        "Time at which each request is given up and number of packets it still awaits, oldest first."
        self._awaited = 0

    def room(self, now: float) -> int:
        """Return the number of packets that may still be requested."""
        while self._requests and self._requests[0][0] <= now:
            self._awaited -= self._requests.popleft()[1]
        return self._limit - self._awaited

    def requested(self, packets: int, until: float) -> None:
        """Note a request for `packets` packets, which is given up at `until`."""
        self._requests.append((until, packets))
        self._awaited += packets

    def received(self, packets: int) -> None:
        """Note answers; they arrive in the order of the requests, or nearly."""
        while packets and self._requests:
            until, awaited = self._requests.popleft()
            if awaited > packets:
                self._requests.appendleft((until, awaited - packets))
            settled = min(awaited, packets)
            packets -= settled
            self._awaited -= settled


class Resender:
    """Requests the missing packets of one stream's blocks."""

    def __init__(self, policy: ResendPolicy, channel: int) -> None:
        self.policy = policy
        self._channel = channel
        self._answer = LearnedWait(
            policy.first_answer_wait, policy.shortest_answer_wait, policy.longest_answer_wait
        )
        self._overtaken = LearnedWait(policy.initial_wait, policy.initial_wait, policy.longest_initial_wait)
        "Delay of packets that others overtook."
        self._flags = False
        "Whether the device flags what it sends again."
        self._window = AnswerWindow(policy.max_unanswered)
        self._requests: deque[PacketResend] = deque()

    @property
    def initial_wait(self) -> float:
        """Seconds from noticing a gap to the request."""
        return self._overtaken.wait

    def note_missing(self, block: PacketAccount, ids: NDArray[np.intp], now: float) -> None:
        """Note packets whose successors arrived without them."""
        log = block.requests
        log.make_room(len(block.received))
        # Packets gather before they are looked at, so the gap opened earlier: by the mean rate, when the
        # packet behind it arrived.
        since = now - (block.highest - run_ends(ids)) * block.packet_period(now)
        log.missed_at[ids] = since
        log.again_at[ids] = since + self.initial_wait
        log.next_check = min(log.next_check, float(since[0]) + self.initial_wait)

    def note_received(
        self, block: PacketAccount, ids: Ids, now: float, flagged: NDArray[np.bool_] | bool
    ) -> int:
        """Record received packets; return how many of them were requested or are flagged.

        `flagged` is true for each packet that the device marks as resent.
        """
        count = int(np.count_nonzero(flagged))
        self._flags = self._flags or count > 0
        log = block.requests
        if not len(log.tries):
            return count
        log.make_room(len(block.received))
        answers = log.tries[ids] > 0
        missed_at = log.missed_at[ids]
        overtaken = missed_at > -NEVER
        if answers.any():
            self._window.received(int(np.count_nonzero(answers)))
            count = int(np.count_nonzero(answers | flagged))
            # An answer does not identify its request. The first request is assumed, so that the wait adapts
            # to a device that is slower than expected.
            certain = answers & flagged if self._flags else answers
            for requested_at in log.first_at[ids][certain].tolist():
                self._answer.learn(now - requested_at)
                self._overtaken.learn(0.0)
            overtaken &= ~certain
        for missed in missed_at[overtaken].tolist():
            self._overtaken.learn(now - missed)
        return count

    def note_duplicate(self, block: PacketAccount, packet_id: int) -> None:
        """Record a duplicate. If it was requested, we asked too early, so learn a longer wait.

        Only flagged resends show how much longer, and are learned from as they arrive.
        """
        tries = block.requests.tries
        if not self._flags and packet_id < len(tries) and tries[packet_id]:
            self._overtaken.learn(2 * self.initial_wait)

    def note_unavailable(self, block: PacketAccount, packet_id: int) -> None:
        """Note that the device no longer has a packet: it is not requested again."""
        log = block.requests
        if packet_id < len(log.tries):
            log.tries[packet_id] = self.policy.max_tries
            log.again_at[packet_id] = -NEVER

    def request_due(self, block: PacketAccount, missing: NDArray[np.intp], now: float) -> None:
        """Request those of the missing packets that are due, and set when to check the block again."""
        policy, log = self.policy, block.requests
        log.checked_at, log.next_check = now, NEVER
        if len(missing) > max(policy.always_worth, policy.max_ratio * len(block.received)):
            return
        log.make_room(len(block.received))
        due = missing[(log.tries[missing] < policy.max_tries) & (log.again_at[missing] <= now)]
        room = self._window.room(now)
        if len(due) > room:
            due = due[: max(room, 0)]
            log.next_check = now + policy.shortest_answer_wait
        if len(due):
            wait = self._answer.wait
            log.note_requested(due, now, wait)
            self._window.requested(len(due), now + wait)
            for first, last in id_runs(due):
                self._requests.append(
                    PacketResend(block.block_id, first, last, self._channel, block.extended)
                )
        waiting = log.again_at[missing]
        next_due = float(waiting[waiting > now].min(initial=NEVER))
        log.next_check = min(log.next_check, max(next_due, now + policy.initial_wait))

    def requests(self) -> Iterator[PacketResend]:
        """Yield commands to send, each once."""
        while self._requests:
            yield self._requests.popleft()
