"""The search for the value of a tuning parameter, whatever law the camera follows."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grabbergui.models.parameter_search import Law, ParameterSearch, light_factor


@given(
    truth=st.floats(0.01, 1e4),
    start=st.floats(1, 1e6),
    gamma=st.floats(0.4, 1.6),
    black=st.floats(0, 0.1),
    target=st.floats(0.2, 0.8),
)
def test_a_proportional_knob_gets_there_through_gamma_black_level_and_saturation(
    truth, start, gamma, black, target
):
    def seen(value):
        light = (value / 1e4 * truth) ** gamma
        return min(1.0, black + light), float(black + light >= 1)

    search = ParameterSearch(start, 1.0, 1e6, Law.PROPORTIONAL)
    for _ in range(60):
        mean, saturated = seen(search.value)
        if abs(mean - target) <= 0.02:
            return
        if search.propose(light_factor(mean, saturated, target)) is None:
            # The end of the range: nothing beyond it would have been allowed.
            assert search.value in (1.0, 1e6)
            return
    pytest.fail(f"stands at {search.value} with {seen(search.value)}")


@given(start=st.floats(0, 48), wanted=st.floats(0, 48), law=st.sampled_from([Law.DECIBEL, Law.UNKNOWN]))
def test_a_gain_reaches_its_target_under_any_law(start, wanted, law):
    search = ParameterSearch(start, 0.0, 48.0, law)
    for _ in range(40):
        ratio = 10 ** ((wanted - search.value) / 20)
        if abs(ratio - 1) < 0.02 or search.propose(ratio) is None:
            break
    assert search.value == pytest.approx(wanted, abs=0.2)


def test_bounds_that_the_scene_has_outlived_are_forgotten():
    search = ParameterSearch(100.0, 1.0, 1e6, Law.PROPORTIONAL)
    search.propose(2.0)
    search.propose(0.5)
    for _ in range(60):
        search.propose(1.5)
    assert search.value > 1000
