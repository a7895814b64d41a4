"""What is said of losses: of the last seconds by colour, since the start by number."""

import pytest

from grabbergui.core.grabber import StreamStatistics
from grabbergui.models.diagnosis import WINDOW, Health, HealthMeter

BEFORE = {"frames": 100, "packets": 100_000}
NOW = {"frames": 200, "packets": 200_000}


def judged(before, after, meter=None):
    meter = meter or HealthMeter()
    meter.judge(0.0, StreamStatistics(**before))
    return meter.judge(1.0, StreamStatistics(**after))


@pytest.mark.parametrize(
    ("changes", "health", "text"),
    [
        ({}, Health.WHOLE, "0 lost · 0 incomplete"),
        ({"packets_resent": 5_000}, Health.RESENT, "0 lost · 0 incomplete · 5.0% resent"),
        ({"packets_resent": 3}, Health.WHOLE, "0 lost · 0 incomplete · 3 resent"),
        ({"incomplete": 1}, Health.LOSING, "0 lost · 1 incomplete"),
        ({"lost": 2, "underruns": 3}, Health.LOSING, "5 lost · 0 incomplete"),
        ({"overruns": 1, "incomplete": 9}, Health.OVERRUN, "more arrives than this computer can take"),
    ],
)
def test_what_happens_now_decides(changes, health, text):
    found = judged(BEFORE, NOW | changes)
    assert (found.health, found.text) == (health, text)


def test_what_was_lost_before_is_counted_but_no_longer_coloured():
    meter, lost = HealthMeter(), NOW | {"lost": 2}
    assert judged(BEFORE, lost, meter).health is Health.LOSING
    later = meter.judge(1.5 + WINDOW, StreamStatistics(**lost))
    assert (later.health, later.text) == (Health.WHOLE, "2 lost · 0 incomplete")


def test_a_stream_that_begins_again_counts_from_nothing():
    meter = HealthMeter()
    judged(BEFORE, NOW | {"lost": 7}, meter)
    assert meter.judge(2.0, StreamStatistics(frames=1, packets=10)).health is Health.WHOLE


def test_every_counter_is_in_the_details():
    found = judged(BEFORE, NOW | {"lost": 1, "incomplete": 2, "underruns": 3, "packets_resent": 4,
                                  "packets_missing": 5, "overruns": 6})  # fmt: skip
    for words in ("200, lost 1, incomplete 2", "dropped because nobody took them in time: 3",
                  "resent 4, never arrived 5", "discarded: 6×"):  # fmt: skip
        assert words in found.detail
