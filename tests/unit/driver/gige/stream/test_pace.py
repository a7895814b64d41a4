"""Pauses that let packets gather: learned from when blocks end, bounded by the buffer; time is a number."""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest

from every_case import every_case
from grabbergui.driver.gige.stream.pace import (
    FASTEST,
    LAST_PAUSE,
    LONGEST_PAUSE,
    PAUSE_SHARE,
    SHORTEST_PAUSE,
    Pace,
)
from grabbergui.driver.gige.stream.sockets import kernel_bytes

ROOMY = 64 << 20
STOCK = 425_984
"What Linux grants of its 212,992 bytes, counted twice as it counts."
GIGABIT = 125e6
PACKET = 1400
NOW = 1e5


@dataclass
class Camera:
    """Sends blocks at an even rate and looks at them when its pace says so."""

    pace: Pace
    packets: int
    duration: float
    "Seconds in which a block arrives."
    late: float = 0.0
    "Seconds by which every pause ends late."
    now: float = NOW
    looks: list[float] = field(default_factory=list)
    "Seconds from the last block's beginning to each look at it."

    def send(self, blocks: int = 1, period: float = 0.1) -> float:
        """Return by how much later than its last packet the last block was complete."""
        for _ in range(blocks):
            begun, taken = self.now, 0
            self.looks = []
            self.pace.woke(begun)
            while taken < self.packets:
                pause = self.pace.pause(self.packets - taken, PACKET, self.now)
                assert pause == 0 or pause >= SHORTEST_PAUSE
                self.now += (pause or SHORTEST_PAUSE) + self.late
                self.pace.slept(pause, pause + self.late)
                arrived = min(int(self.packets * (self.now - begun) / self.duration), self.packets)
                ended = arrived == self.packets
                self.pace.took(arrived - taken, self.now, more=not ended, ended=ended)
                taken = arrived
                self.looks.append(self.now - begun)
            behind = self.now - begun - self.duration
            self.now = begun + period
        return behind


def test_nothing_is_waited_for_between_blocks() -> None:
    pace = Pace(ROOMY, 4096)
    assert pace.pause(3000, PACKET, NOW) == 0, "no block was seen"
    pace.woke(NOW)
    assert pace.pause(0, PACKET, NOW) == 0, "nothing is expected"


def test_the_first_block_is_read_often() -> None:
    camera = Camera(Pace(ROOMY, 1 << 16), 1000, 0.01)
    camera.send()
    assert len(camera.looks) > 10


@every_case("late", [0.0, 0.00006])
@every_case("duration", [0.0003, 0.001, 0.003, 0.009, 0.025])
def test_a_known_block_takes_two_or_three_looks_and_is_complete_soon(duration: float, late: float) -> None:
    camera = Camera(Pace(ROOMY, 1 << 16), round(duration * GIGABIT / PACKET), duration, late)
    camera.send(300)
    looks, behind = [], []
    for _ in range(100):
        behind.append(camera.send())
        looks.append(len(camera.looks))
    assert sum(looks) / 100 <= 3
    assert max(behind) < 2 * SHORTEST_PAUSE + 2 * late + 0.01 * duration
    assert sum(behind) / 100 < SHORTEST_PAUSE + late + 0.01 * duration


def test_a_look_shortly_before_the_end_leaves_little_work() -> None:
    camera = Camera(Pace(ROOMY, 1 << 16), 1000, 0.02)
    camera.send(300)
    assert camera.looks[0] == pytest.approx(0.02 - LAST_PAUSE, rel=0.02)


def test_blocks_that_become_shorter_are_complete_soon_again() -> None:
    camera = Camera(Pace(ROOMY, 1 << 16), 1000, 0.02)
    camera.send(300)
    camera.duration = 0.01
    behind = [camera.send() for _ in range(24)]
    assert behind[0] < 0.011 and max(behind[20:]) < 0.0003


def test_blocks_of_varying_length_are_complete_soon() -> None:
    """What is missing at the last look decides, not how long other blocks took."""
    camera = Camera(Pace(ROOMY, 1 << 16), 1000, 0.02)
    camera.send(300)
    behind = []
    for step in range(100):
        camera.duration = 0.02 * (0.97, 1.0, 1.01, 0.98, 1.03)[step % 5]
        behind.append(camera.send())
    assert sum(behind) / 100 < 2 * SHORTEST_PAUSE and max(behind) < 0.001


def test_one_late_block_says_little_about_the_next() -> None:
    camera = Camera(Pace(ROOMY, 1 << 16), 1000, 0.004)
    camera.send(300)
    camera.duration = 0.1
    camera.send(period=0.2)
    camera.duration = 0.004
    assert camera.send() < 0.0013


def test_blocks_of_another_size_are_awaited_by_their_packets() -> None:
    camera = Camera(Pace(ROOMY, 1 << 16), 1000, 0.02)
    camera.send(300)
    camera.packets, camera.duration = 100, 0.002
    assert camera.send() < 0.0002


@every_case("buffer_bytes", [STOCK, 1 << 20, 16 << 20])
@every_case("packet", [576, 1400, 8164])
@every_case("bandwidth", [GIGABIT, 10 * GIGABIT])
def test_no_pause_fills_more_than_a_part_of_the_buffer(
    buffer_bytes: int, packet: int, bandwidth: float
) -> None:
    rate = bandwidth / packet
    pause = learned(buffer_bytes, rate).pause(100_000, packet, NOW)
    assert pause == 0 or SHORTEST_PAUSE <= pause <= LONGEST_PAUSE
    assert pause * rate * kernel_bytes(packet) < 0.3 * buffer_bytes


def learned(buffer_bytes: int, rate: float, most_packets: int = 1 << 16) -> Pace:
    """A pace that saw one long block at `rate` packets a second, and much of the next, until now."""
    pace = Pace(buffer_bytes, most_packets)
    pace.woke(NOW - 2.0)
    pace.took(round(rate), NOW - 1.0, more=False, ended=True)
    pace.woke(NOW - 0.03)
    for step in range(-9, 1):
        pace.took(round(rate * 0.003), NOW + 0.003 * step, more=True, ended=False)
    return pace


def test_what_may_have_arrived_since_the_last_look_shortens_a_pause() -> None:
    rate = GIGABIT / PACKET
    for pace in (learned(4 << 20, rate), learned(16 * ROOMY, rate, 512)):
        pause = pace.pause(100_000, PACKET, NOW)
        assert 0.001 < pause < 0.01, "limited by a buffer"
        assert pace.pause(100_000, PACKET, NOW + 0.0005) == pytest.approx(pause - 0.0005, rel=0.02)


def test_no_pause_gathers_more_than_a_batch() -> None:
    assert learned(ROOMY, 90_000, most_packets=256).pause(100_000, PACKET, NOW) * 90_000 < 256


def test_what_comes_very_fast_gathers_by_itself() -> None:
    assert learned(ROOMY, 2 * FASTEST / 8164).pause(100_000, 8164, NOW) == 0


def test_where_pauses_end_late_the_buffer_must_hold_that_too() -> None:
    """On a busy machine a fast stream is waited for less; a slow one as ever."""
    fast, slow = learned(16 << 20, 40_000), learned(16 << 20, 5_000)
    usual = fast.pause(100_000, 8164, NOW)
    for pace in (fast, slow):
        pace.slept(0.001, 0.016)
    least = PAUSE_SHARE * (16 << 20) / (40_000 * kernel_bytes(8164))
    assert fast.pause(100_000, 8164, NOW) == pytest.approx(least, rel=0.1) and least < usual
    assert slow.pause(100_000, 8164, NOW) > 0.8 * LONGEST_PAUSE
    fast.took(10, NOW + 10.0, more=False, ended=True)
    fast.woke(NOW + 10.0)
    assert fast.pause(100_000, 8164, NOW + 10.0) == pytest.approx(usual, rel=0.1), "forgotten by and by"


def test_a_pause_that_ended_on_time_costs_no_reserve() -> None:
    pace = learned(4 << 20, GIGABIT / PACKET)
    before = pace.pause(100_000, PACKET, NOW)
    pace.slept(0.02, 0.02)
    assert pace.pause(100_000, PACKET, NOW) == before


@pytest.mark.parametrize(("packets", "spacing"), [(101, 1e-5), (2, 1e-3), (1, 1e-3)])
def test_the_wait_is_learned_from_the_look_before_the_last(packets: int, spacing: float) -> None:
    """The first packet was there when the block began; the others took a millisecond."""
    pace = Pace(ROOMY, 1 << 16)
    pace.woke(NOW)
    pace.took(packets, NOW + 0.001, more=True, ended=False)
    pace.took(1, NOW + 0.0011, more=False, ended=True)
    pace.woke(NOW + 1.0)
    expected = round(0.001 / spacing)
    assert pace.pause(expected, PACKET, NOW + 1.0) == pytest.approx(0.001, rel=1e-3)


@pytest.mark.parametrize(("period", "paused"), [(0.02, True), (0.005, False)])
def test_a_burst_is_waited_for_if_the_camera_rests_after_it(period: float, paused: bool) -> None:
    packets = round(0.005 * 1.5 * FASTEST / kernel_bytes(8164))
    pace = Pace(ROOMY, 1 << 16)
    for block in range(3):
        begun = NOW + block * period
        pace.woke(begun)
        pace.took(packets - 1, begun + 0.004, more=True, ended=False)
        pace.took(1, begun + 0.005, more=False, ended=True)
    pace.woke(begun + period)
    assert (pace.pause(packets, 8164, begun + period) > 0) is paused


def test_a_known_rate_rises_at_once_but_not_beyond_the_double_and_falls_slowly() -> None:
    rate = GIGABIT / PACKET
    usual = learned(4 << 20, rate).pause(100_000, PACKET, NOW)
    faster, slower = learned(4 << 20, rate), learned(4 << 20, rate)
    faster.took(round(10 * rate * 0.001), NOW + 0.001, more=True, ended=False)
    assert faster.pause(100_000, PACKET, NOW + 0.001) == pytest.approx(usual / 2, rel=0.02)
    slower.took(1, NOW + 0.001, more=True, ended=False)
    assert slower.pause(100_000, PACKET, NOW + 0.001) == pytest.approx(usual * 1.005, rel=0.003)
