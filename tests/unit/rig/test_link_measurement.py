"""The search for the highest rate that a link carries. Rates are numbers."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grabbergui.rig.link_measurement import EXACT, LinkTrial, RateSearch

PACKETS = 10_000


def searched(carries: float, most: float, cameras_reach: float = 1e12) -> tuple[RateSearch, int]:
    """Return a search on a link, and the number of its trials."""
    search, trials = RateSearch(most), 0
    while search.rate is not None:
        trials += 1
        sent = min(search.rate, cameras_reach)
        lost = round(PACKETS * max(0.0, 1 - carries / sent))
        search.note(LinkTrial(search.rate, min(sent, carries), PACKETS - lost, lost))
    return search, trials


@given(st.floats(1e5, 1.2e9))
def test_the_rate_of_any_link_is_found_in_a_few_trials(carries: float) -> None:
    search, trials = searched(carries, 125e6)
    assert trials <= 28
    assert search.carried <= carries * 1.002  # a thousandth of the packets may be lost on any network
    assert search.carried >= min(carries, 125e6) / EXACT / 1.002
    assert search.limited is (carries < 125e6 * 0.998) or carries == pytest.approx(125e6, rel=0.003)


def test_cameras_that_send_less_than_the_link_carries_end_the_search() -> None:
    search, _ = searched(125e6, 125e6, cameras_reach=30e6)
    assert search.carried == pytest.approx(30e6) and not search.limited


def test_a_link_that_always_loses_carries_nothing() -> None:
    search, trials = searched(1e3, 125e6)
    assert (search.carried, search.limited) == (0.0, True) and trials < 24


def test_a_moment_of_loss_does_not_end_the_search() -> None:
    search = RateSearch(16e6)
    for lost in (0, 50, 0, 0):
        assert search.rate is not None
        search.note(LinkTrial(search.rate, search.rate, 1000, lost))
    assert search.rate is not None and search.rate > 1e6 and not search.limited


def test_a_trial_says_what_came_of_it() -> None:
    assert str(LinkTrial(5e6, 4.4e6, 900, 100)) == "4.40 MB/s arrived, 10.0% of the packets were lost"
    assert LinkTrial(5e6, 4.4e6, 9999, 1).clean and not LinkTrial(5e6, 4.4e6, 999, 2).clean
