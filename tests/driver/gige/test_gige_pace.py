"""Pauses that let packets gather: learned from the rate, bounded by the buffer; time is a number."""

from __future__ import annotations

import pytest

from grabbergui.driver.gige.stream.receiver import (
    FASTEST,
    LAST_PAUSE,
    LONGEST_PAUSE,
    MOST_POLLING,
    MOST_USUALLY_LATE,
    ONE_BY_ONE_SHARE,
    PAUSE_SHARE,
    POLLING_SHARE,
    SHORTEST_PAUSE,
    STEADY_SPAN,
    Pace,
)
from grabbergui.driver.gige.stream.sockets import kernel_bytes

ROOMY = 16 << 20
STOCK = 425_984
"What Linux grants of its 212,992 bytes, counted twice as it counts."
GIGABIT = 125e6
PACKET = 1400


NOW = 1e5
"When `learned` saw its last packets."


def learned(buffer_bytes: int, rate: float, most_packets: int = 4096) -> Pace:
    """A pace that saw packets at `rate` a second, until now."""
    pace = Pace(buffer_bytes, most_packets)
    for step in range(-20, 1):
        pace.took(round(rate * 0.003), NOW + 0.003 * step, more=True, ended=False)
    return pace


def test_nothing_is_waited_for_before_the_rate_is_known_or_a_length() -> None:
    assert Pace(ROOMY, 4096).pause(3000, PACKET, NOW) == 0
    assert learned(ROOMY, GIGABIT / PACKET).pause(0, PACKET, NOW) == 0


def test_a_block_is_waited_for_in_equal_pauses_until_shortly_before_its_end() -> None:
    rate = GIGABIT / PACKET
    pace = learned(4 * ROOMY, rate, 1 << 16)
    for expected, pauses in ((5000, 2), (3000, 2), (1000, 1)):
        pause = pace.pause(expected, PACKET, NOW)
        assert pause * pauses == pytest.approx(expected / rate - LAST_PAUSE, rel=0.02)


def test_what_may_have_arrived_since_the_last_look_shortens_a_pause() -> None:
    rate = GIGABIT / PACKET
    for pace in (learned(ROOMY // 4, rate), learned(16 * ROOMY, rate, 512)):
        pause = pace.pause(3000, PACKET, NOW)
        assert 0.001 < pause < 0.01, "limited by a buffer"
        assert pace.pause(3000, PACKET, NOW + 0.0005) == pytest.approx(pause - 0.0005)


def test_a_rate_is_measured_over_several_batches() -> None:
    rate = 90_000
    pace = Pace(ROOMY, 4096)
    for step in range(-20, 1):
        pace.took(round(rate * 0.001), NOW + 0.001 * step, more=True, ended=False)
    assert pace.pause(90, PACKET, NOW) == pytest.approx(0.001, rel=0.02)


@pytest.mark.parametrize("share, waits", [(0.8, True), (1.2, False)])
def test_the_mean_rate_counts_each_batch_of_a_block(share: float, waits: bool) -> None:
    period = 0.01
    packets = round(share * FASTEST / kernel_bytes(PACKET) * period / 2)
    pace = Pace(64 * ROOMY, 1 << 20)
    for block in range(-9, 1):
        pace.took(packets, NOW + block * period - 0.006, more=True, ended=False)
        pace.took(packets, NOW + block * period, more=False, ended=True)
    pace.took(packets, NOW + 0.004, more=True, ended=False)
    assert bool(pace.pause(4 * packets, PACKET, NOW + 0.004)) is waits


def test_the_last_pause_ends_with_the_block() -> None:
    rate = GIGABIT / PACKET
    pace = learned(ROOMY, rate)
    assert pace.pause(round(rate * LAST_PAUSE), PACKET, NOW) == pytest.approx(LAST_PAUSE, rel=0.02)
    assert pace.pause(2, PACKET, NOW) == 0, "too short to be worth it"


def with_blocks_every(period: float, rate: float) -> Pace:
    """A pace that saw blocks end so many seconds apart, the last of them now."""
    pace = learned(ROOMY, rate)
    pace.took(1, NOW, more=False, ended=True)
    pace.took(1, NOW + period, more=False, ended=True)
    return pace


@pytest.mark.parametrize(
    ("period", "left"), [(1.0, 0.0), (0.01, LAST_PAUSE - ONE_BY_ONE_SHARE * 0.01)], ids=["slow", "fast"]
)
def test_a_real_time_thread_reads_the_last_packets_as_they_arrive(period: float, left: float) -> None:
    """A pause until the expected end may last too long; many short blocks would cost many wake-ups."""
    rate = GIGABIT / PACKET
    pace, now = with_blocks_every(period, rate), NOW + period
    last = round(rate * LAST_PAUSE)
    usual = pace.pause(1000, PACKET, now)
    assert pace.pause(last, PACKET, now) == pytest.approx(LAST_PAUSE, rel=0.02)
    pace.realtime = True
    assert pace.pause(1000, PACKET, now) == usual, "it pauses as others do before"
    assert pace.pause(last, PACKET, now) == pytest.approx(left, rel=0.02)


def test_a_trailer_that_comes_later_does_not_end_a_block_again() -> None:
    rate, period = GIGABIT / PACKET, 0.01
    pace = with_blocks_every(period, rate)
    now = NOW + period + 0.0002
    pace.took(1, now, more=False, ended=False)
    pace.realtime = True
    left = LAST_PAUSE - ONE_BY_ONE_SHARE * period
    assert pace.pause(round(rate * LAST_PAUSE), PACKET, now) == pytest.approx(left, rel=0.02)


def test_the_time_for_reading_ends_pauses_before_the_last_one_sooner() -> None:
    rate = GIGABIT / PACKET
    pace = learned(4 * ROOMY, rate, 1 << 16)
    for _ in range(50):
        pace.read(0.01, 0.002)
        pace.read(LAST_PAUSE, LAST_PAUSE)
    for expected, pauses in ((5000, 2), (1000, 1)):
        taken = pauses * pace.pause(expected, PACKET, NOW) * (1 + 0.002 / 0.01)
        assert taken == pytest.approx(expected / rate - LAST_PAUSE, rel=0.02)
    last = round(rate * LAST_PAUSE)
    assert pace.pause(last, PACKET, NOW) == pytest.approx(LAST_PAUSE, rel=0.02)


def test_the_end_of_a_block_is_watched_for_without_sleeping() -> None:
    rate = GIGABIT / PACKET
    pace, now = with_blocks_every(1.0, rate), NOW + 1.0
    due = round(rate * MOST_POLLING) - 1
    assert pace.polling(due, now) == MOST_POLLING
    assert pace.polling(2 * due, now) == 0, "it is not due yet"
    assert pace.polling(2 * due, now + MOST_POLLING) == MOST_POLLING, "the time that a batch took counts"
    assert pace.polling(0, now) == 0, "nothing more is to come"


def test_watching_takes_a_small_share_of_the_time() -> None:
    rate = GIGABIT / PACKET
    assert with_blocks_every(0.001, rate).polling(5, NOW + 0.001) == pytest.approx(POLLING_SHARE * 0.001)
    assert learned(ROOMY, rate).polling(5, NOW) == 0, "how often blocks end is not known yet"
    assert Pace(ROOMY, 4096).polling(5, NOW) == 0, "nor how fast packets come"


def test_the_time_that_a_batch_took_counts() -> None:
    """What comes while packets are put in place is not counted yet, but it came."""
    rate = GIGABIT / PACKET
    pace = learned(ROOMY, rate)
    last = round(rate * LAST_PAUSE)
    assert pace.pause(last, PACKET, NOW + 0.0004) == pytest.approx(LAST_PAUSE - 0.0004, rel=0.02)
    assert pace.pause(last, PACKET, NOW + 0.0009) == 0
    assert pace.pause(500, PACKET, NOW + 0.001) == pytest.approx(500 / rate - LAST_PAUSE - 0.001, rel=0.02)


def test_pauses_that_usually_end_late_end_the_sooner() -> None:
    rate = GIGABIT / PACKET
    pace = learned(ROOMY, rate)
    for _ in range(50):
        pace.slept(0.001, 0.0011)
    last = round(rate * LAST_PAUSE)
    assert pace.pause(last, PACKET, NOW) == pytest.approx(LAST_PAUSE - 0.0001, rel=0.02)
    for _ in range(50):
        pace.slept(0.001, 0.005)
    assert pace.pause(last, PACKET, NOW) == pytest.approx(LAST_PAUSE - MOST_USUALLY_LATE, rel=0.02)


@pytest.mark.parametrize("buffer_bytes", [STOCK, 1 << 20, ROOMY])
@pytest.mark.parametrize("packet", [576, 1400, 8164])
@pytest.mark.parametrize("bandwidth", [GIGABIT, 10 * GIGABIT])
def test_no_pause_fills_more_than_a_part_of_the_buffer(
    buffer_bytes: int, packet: int, bandwidth: float
) -> None:
    rate = bandwidth / packet
    pause = learned(buffer_bytes, rate).pause(100_000, packet, NOW)
    assert pause == 0 or SHORTEST_PAUSE <= pause <= LONGEST_PAUSE
    kernel_bytes = {576: 1280, 1400: 2304, 8164: 8164 + 2304}[packet]
    assert pause * rate * kernel_bytes < 0.3 * buffer_bytes


def test_what_comes_very_fast_gathers_by_itself() -> None:
    assert learned(4 * ROOMY, 2 * FASTEST / 8164).pause(100_000, 8164, NOW) == 0


def test_a_burst_is_waited_for_if_the_camera_rests_after_it() -> None:
    """25 blocks a second, each sent within 8 ms."""
    pace = Pace(ROOMY, 4096)
    for block in range(5):
        begun = NOW + 0.04 * block
        for step in range(1, 9):
            pace.took(400, begun + 0.001 * step, more=step < 8, ended=step == 8)
    rate = 400 / 0.001
    assert rate * kernel_bytes(PACKET) > FASTEST
    pace.took(400, NOW + 0.201, more=True, ended=False)
    pause = pace.pause(2800, PACKET, NOW + 0.201)
    assert pause > 0.002
    assert pause * rate * kernel_bytes(PACKET) < 0.3 * ROOMY


def test_no_pause_gathers_more_than_a_batch() -> None:
    assert learned(ROOMY, 90_000, most_packets=256).pause(100_000, PACKET, NOW) * 90_000 < 256


def test_a_faster_rate_counts_at_once_a_slower_one_by_and_by() -> None:
    pace = learned(STOCK, 10_000)
    before = pace.pause(100_000, PACKET, NOW)
    later = NOW + 0.003
    pace.took(300, later, more=True, ended=False)
    faster = pace.pause(100_000, PACKET, later)
    assert faster == pytest.approx(before / 2, rel=0.01), "twice as fast, and no more in one step"
    later += 0.003
    pace.took(10, later, more=True, ended=False)
    assert faster < pace.pause(100_000, PACKET, later) < 1.2 * faster


def test_a_burst_fills_the_buffer_but_ends_no_block_sooner() -> None:
    pace = learned(STOCK, 10_000)
    last = round(10_000 * LAST_PAUSE)
    pause, long_pause = (pace.pause(expected, PACKET, NOW) for expected in (last, 100_000))
    pace.took(14, NOW + STEADY_SPAN / 3, more=True, ended=False)
    assert pace.pause(last, PACKET, NOW + STEADY_SPAN / 3) == pytest.approx(pause, rel=0.02)
    assert pace.pause(100_000, PACKET, NOW + STEADY_SPAN / 3) == pytest.approx(long_pause / 2, rel=0.02)


def test_short_blocks_are_measured_too() -> None:
    pace = Pace(ROOMY, 4096)
    pace.took(1, NOW, more=True, ended=False)
    pace.took(90, NOW + 0.001, more=False, ended=True)
    assert pace.pause(180, PACKET, NOW + 0.001) == pytest.approx(0.001, rel=0.02)


def test_a_block_whose_end_was_read_late_does_not_tell_the_first_rate() -> None:
    """The first frame's memory is new and takes long to fill; meanwhile the camera has finished sending."""
    pace = Pace(ROOMY, 4096)
    pace.took(430, NOW, more=True, ended=False)
    pace.took(87, NOW + 0.02, more=False, ended=True)
    pace.took(300, NOW + 0.03, more=True, ended=False)
    assert pace.pause(200, PACKET, NOW + 0.03) == 0, "still unknown"
    pace.took(180, NOW + 0.032, more=True, ended=False)
    assert pace.pause(90, PACKET, NOW + 0.032) == pytest.approx(0.001, rel=0.02)


def test_where_pauses_end_late_the_buffer_must_hold_that_too() -> None:
    """On a busy machine a fast stream is waited for less; a slow one as ever."""
    fast, slow = learned(ROOMY, 40_000), learned(ROOMY, 5_000)
    usual = fast.pause(100_000, 8164, NOW)
    for pace in (fast, slow):
        pace.slept(0.001, 0.016)
    least = PAUSE_SHARE * ROOMY / (40_000 * kernel_bytes(8164))
    assert fast.pause(100_000, 8164, NOW) == pytest.approx(least, rel=0.1) and least < usual
    assert slow.pause(100_000, 8164, NOW) > 0.8 * LONGEST_PAUSE
    fast.took(10, NOW + 0.001, more=False, ended=True)
    fast.took(10, NOW + 10.0, more=False, ended=True)
    assert fast.pause(100_000, 8164, NOW + 10.0) == pytest.approx(usual, rel=0.1), "forgotten by and by"


def test_the_time_between_blocks_is_no_rate() -> None:
    pace = learned(ROOMY, 90_000)
    before = pace.pause(100_000, PACKET, NOW)
    pace.took(90, NOW + 0.001, more=False, ended=True)
    pace.took(5, NOW + 10.0, more=True, ended=False)
    pace.took(270, NOW + 10.003, more=True, ended=False)
    assert pace.pause(100_000, PACKET, NOW + 10.003) == pytest.approx(before, rel=0.02)
