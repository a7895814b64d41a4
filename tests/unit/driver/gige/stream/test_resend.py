"""Asking for lost packets: a device, a lossy line and the assembler in memory; time is a number."""

from __future__ import annotations

import heapq
import itertools
import random

import numpy as np
import pytest

from block_bench import LAST, SIZE, STRIDE, Bench, block, ids, is_image
from grabbergui.driver.gige.gvcp import PacketResend, Status
from grabbergui.driver.gige.packet_header import PacketFormat, PacketHeader
from grabbergui.driver.gige.stream.assembler import BlockAssembler
from grabbergui.driver.gige.stream.resend import (
    NEVER,
    AnswerWindow,
    BlockRequests,
    LearnedWait,
    Resender,
    ResendPolicy,
)

KEPT = 16
"Blocks that the device can send again."


class LossyLine:
    """A device that sends blocks at a steady rate and answers requests one after another, over a bad line."""

    def __init__(
        self,
        bench: Bench,
        *,
        loss: float,
        period: float,
        service: float,
        busy: float = 0.0,
        detour: float = 0.0,
        marks: bool = False,
    ) -> None:
        """`service`: seconds for an answer; `busy`: seconds at first in which it answers nothing at all.

        `detour`: seconds, more or less, that three packets of four take longer than the fourth.
        `marks`: whether it says that packets are sent again.
        """
        self.bench = bench
        self._detour = detour
        self._marks = marks
        self.answers = 0
        self._dice = random.Random(1)
        self._loss = loss
        self._period = period
        self._service = service
        self._free_at = bench.now + busy
        self._order = itertools.count()
        self._queue: list[tuple[float, int, bytes]] = []
        self._kept: dict[int, list[bytes]] = {}

    def run(self, blocks: int) -> list[int]:
        """Send so many, and wait for the last answer; which came as they were sent."""
        bench, done = self.bench, []
        for block_id in range(1, blocks + 1):
            begun = bench.now
            self._kept[block_id] = block(block_id)
            self._kept.pop(block_id - KEPT, None)
            step = 0.9 * self._period / (LAST + 1)
            for index, datagram in enumerate(self._kept[block_id]):
                self._carry(begun + index * step, datagram)
            done += self._until(begun + self._period)
        return done + self._until(bench.now + 5.0)

    def _until(self, end: float) -> list[int]:
        bench, done = self.bench, []
        while True:
            arrival = self._queue[0][0] if self._queue else end
            bench.now = max(bench.now, min(arrival, bench.assembler.timer(), end))
            if bench.now >= end:
                return done
            while self._queue and self._queue[0][0] <= bench.now:
                bench.assembler.receive(heapq.heappop(self._queue)[2], bench.now)
            done += [finished.block_id for finished in bench.tick() if is_image(finished)]
            while bench.requests:
                self._answer(bench.requests.pop(0))

    def _answer(self, request: PacketResend) -> None:
        kept = self._kept.get(request.block_id)
        for packet_id in range(request.first, request.last + 1):
            self._free_at = max(self._free_at, self.bench.now) + self._service
            self.answers += 1
            if kept is not None:
                mark = int(Status.PACKET_RESEND).to_bytes(2, "big") if self._marks else b"\0\0"
                self._carry(self._free_at, mark + kept[packet_id][2:])

    def _carry(self, at: float, datagram: bytes) -> None:
        if self._detour and self._dice.random() < 0.75:
            at += self._detour * self._dice.uniform(0.8, 1.2)
        if self._dice.random() >= self._loss:
            heapq.heappush(self._queue, (at, next(self._order), datagram))


@pytest.mark.parametrize("fps", [30, 240])
@pytest.mark.parametrize("loss", [0.001, 0.01, 0.05])
def test_every_block_gets_complete_on_a_lossy_line(loss: float, fps: float) -> None:
    """Leaders, trailers and what is sent again are lost like everything else."""
    bench = Bench(buffers=64)
    line = LossyLine(bench, loss=loss, period=1 / fps, service=0.0005)
    done = line.run(300)
    assert done == list(range(1, 301))
    assert line.answers < 1.5 * (1 + loss) * loss * 300 * (LAST + 1) + 10, "hardly anything asked for twice"


@pytest.mark.parametrize("busy", [0.15, 0.3])
def test_a_device_that_is_busy_for_a_while_costs_no_block(busy: float) -> None:
    """Requests that wait at the device are not repeated until they are worthless."""
    bench = Bench(buffers=64)
    line = LossyLine(bench, loss=0.02, period=1 / 30, service=0.002, busy=busy)
    done = line.run(60)
    assert done == list(range(1, 61))
    assert bench.statistics.incomplete == bench.statistics.lost == 0


def test_a_device_slower_than_thought_is_asked_less_often() -> None:
    bench = Bench(buffers=64)
    line = LossyLine(bench, loss=0.02, period=1 / 30, service=0.012)
    done = line.run(300)
    assert len(done) == 300
    assert line.answers < 1.6 * 0.02 * 300 * (LAST + 1)


@pytest.mark.parametrize("marks", [False, True])
def test_what_was_only_overtaken_is_hardly_ever_asked_for(marks: bool) -> None:
    """How late overtaken packets come is learned. Else thirty times as many as lost are asked for."""
    bench = Bench(buffers=64)
    line = LossyLine(bench, loss=0.01, period=1 / 30, service=0.0005, detour=0.005, marks=marks)
    assert line.run(600) == list(range(1, 601))
    assert line.answers < 3 * 0.01 * 600 * (LAST + 1)


def test_the_number_of_awaited_packets_is_limited() -> None:
    bench = Bench(max_unanswered=4, max_ratio=1.0, first_answer_wait=0.02)
    bench.feed(datagram for index, datagram in enumerate(block(1)) if index % 2 == 0)
    bench.wait(0.015)
    assert [request.first for request in bench.requests] == [1, 3, 5, 7]
    bench.wait(0.02)
    assert len(bench.requests) == 8, "the first four count as lost"


def feed_at_once(bench: Bench, datagrams: list[bytes], gathered: float) -> None:
    """Packets that came one after the other, and gathered for so many seconds before they are looked at."""
    bench.now += gathered
    rows = np.frombuffer(b"".join(datagrams), np.uint8).reshape(len(datagrams), -1)
    bench.assembler.receive_rows(rows, bench.now)
    bench.tick()


def test_gaps_behind_which_others_gathered_are_asked_for_at_once() -> None:
    """They showed when the packet behind them came, not when that was looked at."""
    bench = Bench()
    sent = block(1)
    bench.feed(sent[:1])
    feed_at_once(bench, [*sent[1:3], *sent[4:12]], 0.01)
    assert [(request.first, request.last) for request in bench.requests] == [(3, 3)]
    feed_at_once(bench, [sent[12], *sent[14:15]], 0.001)
    assert len(bench.requests) == 1, "13 may only have been overtaken"


def test_while_a_block_comes_its_gaps_are_asked_for_together() -> None:
    bench = Bench(look_again=0.005)
    sent = block(1)
    bench.feed([*sent[:2], *sent[3:4]])
    bench.now += 0.002
    bench.feed([sent[5]])
    assert [request.first for request in bench.requests] == [2]
    assert bench.assembler.timer() == pytest.approx(bench.now + 0.005, abs=1e-4)
    bench.now += 0.002
    bench.feed([sent[7]])
    assert len(bench.requests) == 1, "4 is due, but looked for a moment ago"
    bench.now += 0.004
    bench.feed([sent[8]])
    assert [request.first for request in bench.requests] == [2, 4, 6]


@pytest.mark.parametrize("begins", [0, 3], ids=["it ends", "the next begins"])
def test_a_block_of_which_nothing_more_comes_waits_no_longer_for_its_gaps(begins: int) -> None:
    bench = Bench(look_again=0.1)
    sent = block(1)
    bench.feed([*sent[:2], *sent[3:4]])
    bench.now += 0.002
    bench.feed(sent[5:6])
    assert [request.first for request in bench.requests] == [2]
    bench.feed([*sent[6:], *block(2)[:begins]])
    bench.wait(0.005)
    assert [request.first for request in bench.requests] == [2, 4]


def test_when_a_block_ends_its_gaps_have_a_timer() -> None:
    bench = Bench(look_again=0.005)
    sent = block(1)
    bench.feed([*sent[:13], *sent[14:]])
    assert bench.now < bench.assembler.timer() <= bench.now + bench.assembler.policy.initial_wait
    bench.wait(0.002)
    assert [request.first for request in bench.requests] == [13]


@pytest.mark.parametrize("lost", [slice(3, 4), slice(1, None)], ids=["a packet", "all but the leader"])
def test_a_loss_that_cannot_be_mended_holds_up_the_next_image_for_a_moment_only(lost: slice) -> None:
    bench = Bench(enabled=False)
    sent = block(1)
    del sent[lost]
    assert bench.feed([*sent, *block(2)]) == []
    assert ids(bench.wait(0.011)) == [2] and bench.statistics.incomplete == 1


def test_what_the_device_no_longer_has_holds_up_the_next_image_for_a_moment_only() -> None:
    bench = Bench()
    sent = block(1)
    bench.feed([*sent[:3], *sent[4:], *block(2)])
    gone = PacketHeader(PacketFormat.PAYLOAD, 1, 3, Status.PACKET_UNAVAILABLE).encode()
    assert ids(bench.wait(0.03, lambda request: [gone])) == [2]


def test_a_long_gap_is_asked_for_in_pieces() -> None:
    """What fills the socket's buffer at once would be lost again."""
    bench = Bench(max_unanswered=3)
    sent = block(1)
    bench.feed([*sent[:2], *sent[9:]])
    asked = []

    def answer(request: PacketResend) -> list[bytes]:
        asked.append((request.first, request.last))
        return sent[request.first : request.last + 1]

    (done,) = bench.wait(0.015, answer)
    assert is_image(done) and asked == [(2, 4), (5, 7), (8, 8)], "answers make room before time does"


def test_the_window_opens_with_answers_and_with_time() -> None:
    window = AnswerWindow(10)
    window.requested(6, 1.0)
    window.requested(4, 2.0)
    assert window.room(0.5) == 0
    window.received(3)
    assert window.room(0.5) == 3
    assert window.room(1.0) == 6, "three of the first six count as lost"
    window.received(9)
    assert window.room(1.0) == window.room(5.0) == 10


def test_waits_double_from_try_to_try() -> None:
    bench = Bench(max_tries=4, first_answer_wait=0.02, initial_wait=0.0, give_up=10.0)
    bench.feed(datagram for index, datagram in enumerate(block(1)) if index != 3)
    begun, asked = bench.now, []
    bench.requests.clear()
    while bench.assembler.timer() < begun + 1.0:
        bench.wait(bench.assembler.timer() - bench.now)
        asked += [bench.now - begun] * len(bench.requests)
        bench.requests.clear()
    assert asked == pytest.approx([0.02, 0.06, 0.14], abs=0.002), "the first left with the data"


def test_what_was_not_sent_yet_is_asked_for_again(caplog: pytest.LogCaptureFixture) -> None:
    bench = Bench()
    sent = block(1)
    bench.feed(sent[:10])
    bench.wait(0.04)
    (request,) = bench.requests
    assert (request.first, request.last) == (10, LAST), "silence: the rest may be lost"
    status = Status.PACKET_NOT_YET_AVAILABLE
    assert bench.feed([PacketHeader(PacketFormat.PAYLOAD, 1, 10, status).encode()]) == []
    assert ids(bench.feed(sent[10:])) == [1] and bench.statistics.incomplete == 0
    assert not caplog.records, "nothing is wrong with such a stream"


def test_the_wait_follows_the_answers_within_its_bounds() -> None:
    policy = ResendPolicy()
    time = LearnedWait(policy.first_answer_wait, policy.shortest_answer_wait, policy.longest_answer_wait)
    assert time.wait == policy.first_answer_wait
    for _ in range(100):
        time.learn(0.03)
    assert time.wait == pytest.approx(0.03, rel=0.05)
    for _ in range(200):
        time.learn(0.0001)
    assert time.wait == policy.shortest_answer_wait
    for _ in range(200):
        time.learn(3.0)
    assert time.wait == policy.longest_answer_wait


@pytest.mark.parametrize("extended", [False, True])
def test_a_request_names_channel_and_block(extended: bool) -> None:
    memory = np.zeros(SIZE, np.uint8)
    assembler = BlockAssembler(STRIDE, SIZE, lambda: memory, channel=2)
    for index, datagram in enumerate(block(7, extended=extended)):
        if index != 3:
            assembler.receive(datagram, 0.0)
    assembler.handle_timer(0.01)
    assert list(assembler.resend_requests()) == [PacketResend(7, 3, 3, 2, extended)]


@pytest.mark.parametrize(
    "limits", [{"max_ratio": 0.5, "always_worth": 0}, {"max_ratio": 0.0, "always_worth": 9}]
)
@pytest.mark.parametrize("lost", [9, 10])
def test_a_block_of_which_half_is_lost_is_just_worth_its_requests(
    lost: int, limits: dict[str, float]
) -> None:
    bench = Bench(**limits)
    sent = block(1)
    assert len(sent) == 18
    bench.feed([sent[0], *sent[1 + lost :]])
    bench.wait(0.01)
    assert bool(bench.requests) is (lost == 9)


def test_a_log_that_grows_keeps_what_it_knows() -> None:
    log = BlockRequests(Resender(ResendPolicy(), 0))
    log.make_room(4)
    log.note_requested(np.array([1]), 5.0, 0.5)
    log.missed_at[1] = 4.0
    log.make_room(40)
    assert (log.tries[1], log.first_at[1], log.again_at[1], log.missed_at[1]) == (1, 5.0, 5.5, 4.0)
    assert not log.tries[2:].any() and (log.missed_at[4:] == -NEVER).all()
    log.note_requested(np.array([1]), 6.0, 0.5)
    assert (log.tries[1], log.first_at[1], log.again_at[1]) == (2, 5.0, 7.0)


def test_a_wait_covers_twice_the_deviation() -> None:
    learned = LearnedWait(1.0, 0.0, 100.0)
    learned.learn(4.0)
    assert learned.wait == 4.0 + 2 * 2.0
    learned.learn(12.0)
    assert learned.wait == 5.0 + 2 * (2.0 + (8.0 - 2.0) / 4)


def requested_too_early(status: int) -> tuple[Bench, bytes]:
    """A block in which packet 3 was only overtaken, but asked for; and the packet as it is sent again."""
    bench = Bench()
    sent = block(1)
    bench.feed([*sent[:3], *sent[4:12]])
    bench.wait(0.005)
    assert [request.first for request in bench.requests] == [3]
    return bench, PacketHeader(PacketFormat.PAYLOAD, 1, 3, status).encode() + sent[3][8:]


def test_what_was_asked_for_too_early_makes_the_next_wait_longer() -> None:
    bench, again = requested_too_early(Status.SUCCESS)
    wait = bench.assembler._resender
    bench.feed([again])
    assert wait.initial_wait == 0.001, "it may have been the answer"
    bench.feed([block(1)[2]])
    assert wait.initial_wait == 0.001, "a double that nobody asked for teaches nothing"
    bench.feed([again])
    assert wait.initial_wait == pytest.approx(0.00125)
    assert bench.statistics.packets_duplicate == 2


def test_of_a_device_that_marks_its_answers_a_double_teaches_nothing_more() -> None:
    bench, again = requested_too_early(Status.PACKET_RESEND)
    bench.feed([again])
    wait = bench.assembler._resender.initial_wait
    bench.feed([block(1)[3]])
    assert bench.assembler._resender.initial_wait == wait


def test_of_a_device_that_marks_its_answers_what_comes_unmarked_was_overtaken() -> None:
    bench = Bench(look_again=0.0)
    sent = block(1)
    resender = bench.assembler._resender
    bench.feed([*sent[:3], *sent[4:6], *sent[7:10]])
    bench.wait(0.005)
    assert [request.first for request in bench.requests] == [3, 6]
    bench.feed([PacketHeader(PacketFormat.PAYLOAD, 1, 3, Status.PACKET_RESEND).encode() + sent[3][8:]])
    bench.feed(sent[10:12])
    assert resender.initial_wait == 0.001, "neither the answer nor what follows was late"
    bench.wait(0.003)
    bench.feed([sent[6]])
    late = 0.008
    assert resender.initial_wait == pytest.approx(late / 8 + 2 * late / 4, rel=0.05)


def test_a_leader_that_comes_twice_is_a_double() -> None:
    bench = Bench()
    leader, *rest = block(1)
    assert ids(bench.feed([leader, leader, *rest])) == [1]
    assert bench.statistics.packets_duplicate == 1


def test_what_is_unavailable_before_anything_was_requested_does_no_harm() -> None:
    bench = Bench()
    sent = block(1)
    refused = PacketHeader(PacketFormat.PAYLOAD, 1, 0, Status.PACKET_UNAVAILABLE).encode()
    bench.feed([refused, *sent[:3]])
    later = PacketHeader(PacketFormat.PAYLOAD, 1, LAST + 50, Status.PACKET_UNAVAILABLE).encode()
    (done,) = bench.feed([later, *sent[3:]])
    assert is_image(done) and bench.requests == []


def test_a_gap_opened_when_the_packet_behind_it_arrived_not_when_it_was_read() -> None:
    """Fifteen packets are read at once, 1.5 ms after the first of the block: one came every 0.1 ms."""
    bench = Bench(initial_wait=0.001)
    sent = block(1)
    bench.feed(sent[:1], period=0.0)
    feed_at_once(bench, [*sent[1:12], *sent[13:16]], 0.0015)
    assert bench.requests == []
    assert bench.assembler.timer() == pytest.approx(bench.now - 0.0002 + 0.001, abs=2e-6)
