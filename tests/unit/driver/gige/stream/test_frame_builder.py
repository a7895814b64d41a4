"""Device time in terms of the host's."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator

import pytest

from grabbergui.driver.gige.stream.frame_builder import MOST_DELAY_NS, ClockMapper, ticks_to_ns


def test_ticks_become_nanoseconds_without_rounding() -> None:
    assert ticks_to_ns(2**63, 1_000_000_000) == 2**63
    assert ticks_to_ns(125_000_000 * 3 + 1, 125_000_000) == 3_000_000_008
    assert ticks_to_ns(5, 0) == 0


def test_the_fastest_packets_tell_the_offset() -> None:
    dice = random.Random(1)
    mapper = ClockMapper()
    offset = 1_700_000_000_000_000_000
    worst = 0
    for frame in range(500):
        device = frame * 40_000_000
        arrival = device + offset + 50_000 + int(dice.expovariate(1 / 2e6))
        mapped = mapper.map(device, arrival)
        assert mapped <= arrival
        if frame > 50:
            worst = max(worst, abs(mapped - device - offset))
    assert worst < 300_000, "0.3 ms although packets come 2 ms late on average"


def test_it_follows_a_drifting_clock_and_one_set_back() -> None:
    mapper = ClockMapper(window_ns=1_000_000_000)
    for frame in range(1000):
        device = frame * 40_000_000
        mapped = mapper.map(device, device * 10001 // 10000)
    assert abs(mapped - device * 10001 // 10000) < 200_000
    assert mapper.map(5, 1_000_000) == 1_000_000


def test_two_messages_of_one_moment_are_no_clock_that_was_set_back() -> None:
    mapper = ClockMapper()
    assert mapper.map(100, 150) == 150
    assert mapper.map(100, 300) == 150, "the second one travelled longer"
    assert mapper.map(99, 400) == 400, "set back: nothing earlier counts"


def map_all(mapper: ClockMapper, rate: float, delays: Callable[[int], int], seconds: int) -> Iterator[int]:
    """Yield how much older than its arrival each frame is dated, by a clock that runs at a wrong rate."""
    for true in range(0, seconds * 1_000_000_000, 40_000_000):
        arrival = true + delays(true)
        yield arrival - mapper.map(round(true * rate), arrival)


@pytest.mark.parametrize("rate", [0.95, 0.9, 0.5, 0.125, 1e-3, 2.0, 1e3])
def test_a_clock_of_another_frequency_than_stated_dates_no_frame_a_second_wrong(rate: float) -> None:
    ages = list(map_all(ClockMapper(), rate, lambda _: 1_000_000, 100))
    assert max(ages) <= MOST_DELAY_NS and min(ages) >= 0
    if rate < 0.95:
        assert max(ages[25 * 30 :]) == 0, "the arrival is known better than by such a clock"


def test_late_packets_of_a_right_clock_are_believed() -> None:
    mapper = ClockMapper()
    burst = list(map_all(mapper, 1.0, lambda true: true // 5 if true < 4 * 10**9 else 1_000_000, 60))
    assert max(burst) > 700_000_000, "frames of a burst that wait in the camera until the link is free"
    later = mapper.map(60 * 10**9, 62_000_000_000)
    assert later == pytest.approx(60 * 10**9, abs=2_000_000), (
        "the longer it is right, the more it is believed"
    )


def test_a_clock_that_was_set_forward_is_judged_anew() -> None:
    mapper = ClockMapper()
    list(map_all(mapper, 0.5, lambda _: 0, 20))
    hour = 3_600_000_000_000
    assert mapper.map(hour, 20 * 10**9) == 20 * 10**9
    assert mapper.map(hour + 10**9, 21 * 10**9 + 300_000_000) == 21 * 10**9
