"""Requests for lost packets: when to send them and when to stop. Part of the sans-I/O stream protocol.

A packet that others overtook arrives by itself, so the protocol learns the usual delay of such packets and
requests nothing from a gap before it has passed. A busy or distant device answers slowly, and more requests
would slow it down further. So the wait before a repeated request is learned from the answers, as TCP does it,
and doubles with each try; the number of unanswered requests is limited. Each block has times and tries of its
own, `BlockRequests`; all blocks of a stream share a `Resender`, which learns the waits.
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
    """What the blocks of one stream share: learned waits, the limit of requests, and the commands to send."""

    def __init__(self, policy: ResendPolicy, channel: int) -> None:
        self.policy = policy
        self._channel = channel
        self.answer = LearnedWait(
            policy.first_answer_wait, policy.shortest_answer_wait, policy.longest_answer_wait
        )
        "From a request to its answer."
        self.overtaken = LearnedWait(policy.initial_wait, policy.initial_wait, policy.longest_initial_wait)
        "Delay of packets that others overtook."
        self.flags = False
        "Whether the device flags what it sends again."
        self.window = AnswerWindow(policy.max_unanswered)
        self._commands: deque[PacketResend] = deque()

    @property
    def initial_wait(self) -> float:
        """Seconds from noticing a gap to the request."""
        return self.overtaken.wait

    def request(self, block_id: int, extended: bool, ids: NDArray[np.intp]) -> None:
        """Make the commands that request these packets of a block."""
        for first, last in id_runs(ids):
            self._commands.append(PacketResend(block_id, first, last, self._channel, extended))

    def requests(self) -> Iterator[PacketResend]:
        """Yield commands to send, each once."""
        while self._commands:
            yield self._commands.popleft()


class BlockRequests:
    """Missing and requested packets of a block with their times. Empty, at no cost, if none was missing.

    `packets` in its methods is the number of packets that the block may have.
    """

    def __init__(self, resender: Resender) -> None:
        self._resender = resender
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

    def make_room(self, packets: int) -> None:
        """Grow to at least `packets` entries."""
        if len(self.tries) < packets:
            known = len(self.tries)
            self.tries = grown(self.tries, packets)
            self.missed_at = grown(self.missed_at, packets)
            self.missed_at[known:] = -NEVER
            self.first_at = grown(self.first_at, packets)
            self.again_at = grown(self.again_at, packets)

    def note_missing(
        self, ids: NDArray[np.intp], packets: int, highest: int, period: float, now: float
    ) -> None:
        """Note packets whose successors up to `highest` arrived without them, one each `period` seconds."""
        self.make_room(packets)
        # Packets gather before they are looked at, so the gap opened earlier: by the mean rate, when the
        # packet behind it arrived.
        since = now - (highest - run_ends(ids)) * period
        wait = self._resender.initial_wait
        self.missed_at[ids] = since
        self.again_at[ids] = since + wait
        self.next_check = min(self.next_check, float(since[0]) + wait)

    def note_received(self, ids: Ids, packets: int, now: float, flagged: NDArray[np.bool_] | bool) -> int:
        """Record received packets; return how many of them were requested or are flagged.

        `flagged` is true for each packet that the device marks as resent.
        """
        if flagged is False and not len(self.tries):  # as nearly always
            return 0
        resender = self._resender
        count = int(np.count_nonzero(flagged))
        resender.flags = resender.flags or count > 0
        if not len(self.tries):
            return count
        self.make_room(packets)
        answers = self.tries[ids] > 0
        missed_at = self.missed_at[ids]
        overtaken = missed_at > -NEVER
        if answers.any():
            resender.window.received(int(np.count_nonzero(answers)))
            count = int(np.count_nonzero(answers | flagged))
            # An answer does not identify its request. The first request is assumed, so that the wait adapts
            # to a device that is slower than expected.
            certain = answers & flagged if resender.flags else answers
            for requested_at in self.first_at[ids][certain].tolist():
                resender.answer.learn(now - requested_at)
                resender.overtaken.learn(0.0)
            overtaken &= ~certain
        for missed in missed_at[overtaken].tolist():
            resender.overtaken.learn(now - missed)
        return count

    def note_duplicate(self, packet_id: int) -> None:
        """Record a duplicate. If it was requested, we asked too early, so learn a longer wait.

        Only flagged resends show how much longer, and are learned from as they arrive.
        """
        resender = self._resender
        if not resender.flags and packet_id < len(self.tries) and self.tries[packet_id]:
            resender.overtaken.learn(2 * resender.initial_wait)

    def note_unavailable(self, packet_id: int) -> None:
        """Note that the device no longer has a packet: it is not requested again."""
        if packet_id < len(self.tries):
            self.tries[packet_id] = self._resender.policy.max_tries
            self.again_at[packet_id] = -NEVER

    def note_requested(self, ids: NDArray[np.intp], now: float, wait: float) -> None:
        """Record requests; each try waits twice as long as the previous one."""
        tries = self.tries[ids]
        self.first_at[ids] = np.where(tries == 0, now, self.first_at[ids])
        self.again_at[ids] = now + np.ldexp(wait, tries)
        self.tries[ids] = tries + 1

    def request_due(
        self, block_id: int, extended: bool, missing: NDArray[np.intp], packets: int, now: float
    ) -> None:
        """Request those of the missing packets that are due, and set when to check the block again."""
        resender, policy = self._resender, self._resender.policy
        self.next_check = NEVER
        if len(missing) > max(policy.always_worth, policy.max_ratio * packets):
            return
        self.make_room(packets)
        due = missing[(self.tries[missing] < policy.max_tries) & (self.again_at[missing] <= now)]
        room = resender.window.room(now)
        if len(due) > room:
            due = due[: max(room, 0)]
            self.next_check = now + policy.shortest_answer_wait
        if len(due):
            wait = resender.answer.wait
            self.note_requested(due, now, wait)
            resender.window.requested(len(due), now + wait)
            resender.request(block_id, extended, due)
        waiting = self.again_at[missing]
        next_due = float(waiting[waiting > now].min(initial=NEVER))
        self.next_check = min(self.next_check, max(next_due, now + policy.initial_wait))


def grown(array: NDArray[Any], length: int) -> NDArray[Any]:
    """Return a copy of at least that length, at least twice as long as before, filled up with zeros."""
    larger = np.zeros(max(length, 2 * len(array)), array.dtype)
    larger[: len(array)] = array
    return larger
