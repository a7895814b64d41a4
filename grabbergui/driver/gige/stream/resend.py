"""When to ask for lost packets, and when to stop: part of the machine that puts blocks together, without I/O.

A packet that others overtook comes by itself: how late such packets are is learned, and so long a gap waits.
A device answers as fast as it can, and a busy or distant one is slow. So the time to wait before a packet is
asked for again is learned from the answers, as TCP learns it, and doubles with each try; and only so many
requests are unanswered at once. Asking a slow device more often would make it slower still.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grabbergui.driver.gige.gvcp import PacketResend
from grabbergui.driver.gige.stream.block import NEVER, Block, Ids, ends, runs


@dataclass(frozen=True)
class ResendPolicy:
    """When to ask for lost packets, and when to stop."""

    enabled: bool = True
    "Off where the device cannot resend: it is then never asked."
    initial_wait: float = 0.001
    "Seconds from noticing a gap to asking, at least: the packet may only have been overtaken."
    longest_initial_wait: float = 0.02
    "The same at most, where packets were seen to be overtaken and to come late."
    look_again: float = 0.005
    """Seconds between two looks at what a block misses, at least, while the rest of it comes: what shows
    meanwhile is asked for together, and the picture is there no later."""
    first_answer_wait: float = 0.02
    "Seconds to wait for the answer to a request, before any answer showed how long it takes."
    shortest_answer_wait: float = 0.005
    longest_answer_wait: float = 0.1
    "Bounds of what is learned, before it is doubled from try to try."
    tail_wait: float = 0.03
    "Seconds of silence after which the end of a block counts as lost too."
    max_tries: int = 6
    "Requests for one packet."
    max_unanswered: int = 512
    "Packets asked for at once. They come in one burst, which the socket's buffer must hold."
    max_ratio: float = 0.5
    "A block that misses more than this share of its packets is not worth asking for."
    always_worth: int = 16
    "So many missing packets are asked for, however small the block."
    give_up: float = 0.5
    "Seconds of silence after which a block is finished as it is."
    reorder_wait: float = 0.01
    "The same, once a later block has begun and nothing more is asked for."
    max_blocks: int = 32
    "Blocks under way at once; the oldest is finished when one more begins."


class LearnedWait:
    """How long to wait for something, from how long it took before."""

    def __init__(self, first: float, shortest: float, longest: float) -> None:
        """Seconds: to wait before anything is known, and the bounds of what is learned."""
        self._first, self._shortest, self._longest = first, shortest, longest
        self._mean: float | None = None
        self._deviation = 0.0

    def learn(self, seconds: float) -> None:
        """It came after so long."""
        if self._mean is None:
            self._mean, self._deviation = seconds, seconds / 2
            return
        self._deviation += (abs(seconds - self._mean) - self._deviation) / 4
        self._mean += (seconds - self._mean) / 8

    @property
    def wait(self) -> float:
        """Seconds after which it counts as lost."""
        if self._mean is None:
            return self._first
        # Twice the deviation and not four times as TCP: times here include answers that were lost, and with
        # four the wait would grow without end on a link that loses a tenth of its packets.
        return min(max(self._mean + 2 * self._deviation, self._shortest), self._longest)


class AnswerWindow:
    """How many packets are asked for and neither came nor count as lost; so many and no more at once."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._asked: deque[tuple[float, int]] = deque()
        "Of each request when it counts as lost and how many of its packets are awaited, the oldest first."
        self._awaited = 0

    def room(self, now: float) -> int:
        """How many more may be asked for."""
        while self._asked and self._asked[0][0] <= now:
            self._awaited -= self._asked.popleft()[1]
        return self._most - self._awaited

    def asked(self, packets: int, until: float) -> None:
        """So many are asked for, and count as lost at `until`."""
        self._asked.append((until, packets))
        self._awaited += packets

    def came(self, packets: int) -> None:
        """So many came; answers come in the order of the requests, or nearly."""
        while packets and self._asked:
            until, awaited = self._asked.popleft()
            if awaited > packets:
                self._asked.appendleft((until, awaited - packets))
            settled = min(awaited, packets)
            packets -= settled
            self._awaited -= settled


class Resender:
    """Asks for the missing packets of one stream's blocks."""

    def __init__(self, policy: ResendPolicy) -> None:
        self.policy = policy
        self._answer = LearnedWait(
            policy.first_answer_wait, policy.shortest_answer_wait, policy.longest_answer_wait
        )
        self._overtaken = LearnedWait(policy.initial_wait, policy.initial_wait, policy.longest_initial_wait)
        "How late packets come that others overtook."
        self._marks = False
        "Whether the device marks what it sends again."
        self._window = AnswerWindow(policy.max_unanswered)
        self._requests: deque[PacketResend] = deque()

    @property
    def initial_wait(self) -> float:
        """Seconds from noticing a gap to asking."""
        return self._overtaken.wait

    def missed(self, block: Block, ids: NDArray[np.intp], now: float) -> None:
        """Note that packets did not come in their turn."""
        block.asked.make_room(len(block.received))
        # Packets gather before they are looked at, so a gap showed before: by the mean rate, when the packet
        # behind it came.
        since = now - (block.highest - ends(ids)) * block.packet_period(now)
        block.asked.missed_at[ids] = since
        block.asked.again_at[ids] = since + self.initial_wait
        block.asked.next_check = min(block.asked.next_check, float(since[0]) + self.initial_wait)

    def came(self, block: Block, ids: Ids, now: float, marked: NDArray[np.bool_] | bool) -> int:
        """Note that packets arrived; how many of them had been asked for, or are marked.

        `marked`: the device says that it sent them again.
        """
        count = int(np.count_nonzero(marked))
        self._marks = self._marks or count > 0
        asked = block.asked
        if not len(asked.tries):
            return count
        asked.make_room(len(block.received))
        answers = asked.tries[ids] > 0
        missed_at = asked.missed_at[ids]
        overtaken = missed_at > -NEVER
        if answers.any():
            self._window.came(int(np.count_nonzero(answers)))
            count = int(np.count_nonzero(answers | marked))
            # Which of several requests was answered cannot be told. Taken as the first, a device that is
            # slower than we thought is found out.
            surely = answers & marked if self._marks else answers
            for asked_at in asked.first_at[ids][surely].tolist():
                self._answer.learn(now - asked_at)
                self._overtaken.learn(0.0)
            overtaken &= ~surely
        for turn in missed_at[overtaken].tolist():
            self._overtaken.learn(now - turn)
        return count

    def doubled(self, block: Block, packet_id: int) -> None:
        """A packet came twice: if it was asked for, then too soon. By how much, only marks tell."""
        asked = block.asked
        if not self._marks and packet_id < len(asked.tries) and asked.tries[packet_id]:
            self._overtaken.learn(2 * self.initial_wait)

    def refused(self, block: Block, packet_id: int) -> None:
        """The device no longer has this packet: it is not asked for again."""
        asked = block.asked
        if packet_id < len(asked.tries):
            asked.tries[packet_id] = self.policy.max_tries
            asked.again_at[packet_id] = -NEVER

    def ask(self, block: Block, missing: NDArray[np.intp], now: float) -> None:
        """Ask for those of the missing packets whose time has come; sets when to look at the block again."""
        policy, asked = self.policy, block.asked
        asked.checked, asked.next_check = now, NEVER
        if len(missing) > max(policy.always_worth, policy.max_ratio * len(block.received)):
            return
        asked.make_room(len(block.received))
        due = missing[(asked.tries[missing] < policy.max_tries) & (asked.again_at[missing] <= now)]
        room = self._window.room(now)
        if len(due) > room:
            due = due[: max(room, 0)]
            asked.next_check = now + policy.shortest_answer_wait
        if len(due):
            wait = self._answer.wait
            asked.note(due, now, wait)
            self._window.asked(len(due), now + wait)
            for first, last in runs(due):
                self._requests.append(PacketResend(block.block_id, first, last, 0, block.extended))
        waiting = asked.again_at[missing]
        next_turn = float(waiting[waiting > now].min(initial=NEVER))
        asked.next_check = min(asked.next_check, max(next_turn, now + policy.initial_wait))

    def requests(self) -> Iterator[PacketResend]:
        """Commands to send, each once."""
        while self._requests:
            yield self._requests.popleft()
