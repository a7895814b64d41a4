"""Device time in terms of the host's."""

from __future__ import annotations

import random

from grabbergui.driver.gige.stream.frame_builder import ClockMapper, ticks_to_ns


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
