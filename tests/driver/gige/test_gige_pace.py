"""Pauses that let packets gather: learned from the rate, bounded by the buffer; time is a number."""

from __future__ import annotations

import pytest

from grabbergui.driver.gige.pace import FASTEST, LONGEST_PAUSE, SHORTEST_PAUSE, Pace

ROOMY = 16 << 20
STOCK = 425_984
"What Linux grants of its 212,992 bytes, counted twice as it counts."
GIGABIT = 125e6
PACKET = 1400


def learned(buffer_bytes: int, rate: float, most_packets: int = 4096) -> Pace:
    """A pace that saw packets at `rate` a second."""
    pace = Pace(buffer_bytes, most_packets)
    for step in range(20):
        pace.took(round(rate * 0.001), 1e5 + 0.001 * step, more=True)
    return pace


def test_nothing_is_waited_for_before_the_rate_is_known_or_between_blocks() -> None:
    assert Pace(ROOMY, 4096).pause(3000, PACKET) == 0
    assert learned(ROOMY, GIGABIT / PACKET).pause(0, PACKET) == 0


def test_pauses_end_when_the_block_should() -> None:
    rate = GIGABIT / PACKET
    pace = learned(ROOMY, rate)
    assert pace.pause(3000, PACKET) == pytest.approx(LONGEST_PAUSE, rel=0.01)
    assert pace.pause(1000, PACKET) == pytest.approx(500 / rate, rel=0.05), "two equal ones"
    assert pace.pause(500, PACKET) == pytest.approx(500 / rate, rel=0.05)
    assert pace.pause(2, PACKET) == 0, "too short to be worth it"


@pytest.mark.parametrize("buffer_bytes", [STOCK, 1 << 20, ROOMY])
@pytest.mark.parametrize("packet", [576, 1400, 8164])
@pytest.mark.parametrize("bandwidth", [GIGABIT, 10 * GIGABIT])
def test_no_pause_fills_more_than_a_part_of_the_buffer(
    buffer_bytes: int, packet: int, bandwidth: float
) -> None:
    rate = bandwidth / packet
    pause = learned(buffer_bytes, rate).pause(100_000, packet)
    assert pause == 0 or SHORTEST_PAUSE <= pause <= LONGEST_PAUSE
    kernel_bytes = {576: 1280, 1400: 2304, 8164: 8164 + 2304}[packet]
    assert pause * rate * kernel_bytes < 0.3 * buffer_bytes


def test_what_comes_very_fast_gathers_by_itself() -> None:
    assert learned(4 * ROOMY, 2 * FASTEST / 8164).pause(100_000, 8164) == 0


def test_no_pause_gathers_more_than_a_batch() -> None:
    assert learned(ROOMY, 90_000, most_packets=256).pause(100_000, PACKET) * 90_000 < 256


def test_a_faster_rate_counts_at_once_a_slower_one_by_and_by() -> None:
    pace = learned(STOCK, 10_000)
    before = pace.pause(100_000, PACKET)
    pace.took(100, 1e5 + 0.020, more=True)
    faster = pace.pause(100_000, PACKET)
    assert faster == pytest.approx(before / 2, rel=0.01), "twice as fast, and no more in one step"
    pace.took(10, 1e5 + 0.021, more=True)
    assert faster < pace.pause(100_000, PACKET) < 1.2 * faster


def test_where_pauses_end_late_the_buffer_must_hold_that_too() -> None:
    """On a busy machine a fast stream is not waited for; a slow one still is."""
    fast, slow = learned(ROOMY, 40_000), learned(ROOMY, 15_000)
    assert fast.pause(100_000, 8164) > SHORTEST_PAUSE
    for pace in (fast, slow):
        pace.slept(0.001, 0.016)
    assert fast.pause(100_000, 8164) == 0
    assert slow.pause(100_000, 8164) > 0.8 * LONGEST_PAUSE
    fast.took(10, 1e5 + 0.020, more=False)
    fast.took(10, 1e5 + 10.0, more=False)
    assert fast.pause(100_000, 8164) > SHORTEST_PAUSE, "that is forgotten by and by"


def test_the_pause_between_blocks_is_no_rate() -> None:
    pace = learned(ROOMY, 90_000)
    before = pace.pause(100_000, PACKET)
    pace.took(5, 1e5 + 0.020, more=False)
    pace.took(5, 1e5 + 10.0, more=True)
    assert pace.pause(100_000, PACKET) == pytest.approx(before, rel=0.3)
