"""The fitted clock contains the true time within its stated uncertainty, whatever delays and drifts are."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grabbergui.rig.clock_fit import MOST_DRIFT, ClockFit

SECOND = 1_000_000_000
OFFSETS = st.integers(-(10**18), 10**18)
DRIFTS = st.floats(-50e-6, 50e-6)


def device_time(host, offset, drift):
    """Return a device's time at a host's time (from 0)."""
    return round(host * (1 + drift)) + offset


def error(fit, host, offset, drift):
    """Return the error of the estimate at a host's time, and what is stated of it."""
    estimate = fit.estimate()
    assert estimate is not None
    found = estimate.host_time(device_time(host, offset, drift))
    return abs(found.time_ns - host), found.uncertainty_ns


@given(OFFSETS, DRIFTS, st.lists(st.tuples(st.integers(0, SECOND), st.integers(0, SECOND)), min_size=1))
def test_readings_bound_the_true_time_whatever_the_network_does(offset, drift, delays):
    fit = ClockFit()
    for second, (to, back) in enumerate(delays, 1):
        host = second * SECOND
        fit.add_reading(device_time(host, offset, drift), host - to, host + back)
    last = len(delays) * SECOND
    for host in (last, last + SECOND, last - SECOND // 2):
        wrong, stated = error(fit, host, offset, drift)
        assert wrong <= stated
    assert error(fit, last, offset, drift)[1] <= sum(delays[-1]) / 2 + 1000 + WANDER_OF_A_MINUTE


WANDER_OF_A_MINUTE = 18_000
"Nanoseconds by which the limits are loosened."


@settings(max_examples=25)
@given(OFFSETS, DRIFTS, st.integers(0, 2**32), st.sampled_from(["exponential", "uniform"]))
def test_arrivals_bound_the_true_time_by_their_fastest(offset, drift, seed, law):
    random = np.random.default_rng(seed)
    least = int(random.integers(0, 20_000_000))
    fit = ClockFit(least_delay_ns=(least, least))
    jitter = random.exponential(300_000, 1800) if law == "exponential" else random.uniform(0, 2e6, 1800)
    for number, late in enumerate(jitter):
        host = round(number * SECOND / 30)
        fit.add_arrival(device_time(host, offset, drift), host + least + int(late))
    estimate = fit.estimate()
    assert abs(1 / (1 + drift) - 1 - estimate.drift) <= estimate.drift_uncertainty < 2e-5
    for host in (0, 30 * SECOND, 60 * SECOND):
        wrong, stated = error(fit, host, offset, drift)
        assert wrong <= stated < 600_000


def test_an_unknown_delay_is_part_of_the_uncertainty():
    fit = ClockFit(least_delay_ns=(0, 5_000_000))
    for number in range(200):
        fit.add_arrival(number * SECOND // 30 + 77, number * SECOND // 30 + 4_000_000)
    found = fit.estimate().host_time(100 * SECOND // 30 + 77)
    assert abs(found.time_ns - 100 * SECOND // 30) <= found.uncertainty_ns < 2_600_000


def test_drift_is_followed_while_a_camera_warms_up():
    fit = ClockFit()
    device = 0.0
    for second in range(600):
        drift = 20e-6 - 8e-9 * max(0, second - 100)
        fit.add_reading(round(device), second * SECOND - 200_000, second * SECOND + 200_000)
        if second % 10 == 9:
            found = fit.estimate().host_time(round(device))
            assert abs(found.time_ns - second * SECOND) <= found.uncertainty_ns < 201_000 + WANDER_OF_A_MINUTE
        device += SECOND * (1 + drift)
    assert fit.estimate().drift == pytest.approx(-16e-6, abs=7e-6)


def test_a_clock_that_was_set_is_fitted_anew():
    fit = ClockFit()
    for second in range(60):
        fit.add_reading(second * SECOND, second * SECOND, second * SECOND + 1000)
    for second in range(60, 66):  # forwards
        fit.add_reading((second + 7) * SECOND, second * SECOND, second * SECOND + 1000)
    assert abs(fit.estimate().host_time(72 * SECOND).time_ns - 65 * SECOND) <= 20_000
    fit.add_reading(5, 66 * SECOND, 66 * SECOND + 1000)  # backwards, as after a reset
    assert abs(fit.estimate().host_time(5).time_ns - 66 * SECOND) <= 1000


def test_a_clock_that_is_not_bounded_has_no_estimate():
    fit = ClockFit()
    assert fit.estimate() is None
    for number in range(39):  # too few to tell how fast the fastest is
        fit.add_arrival(number * SECOND, number * SECOND)
        assert fit.estimate() is None
    fit.add_arrival(39 * SECOND, 39 * SECOND)
    assert fit.estimate() is not None
    fit.forget()
    assert fit.estimate() is None


def test_the_uncertainty_grows_where_nothing_was_observed():
    fit = ClockFit()
    fit.add_reading(0, -500, 500)
    estimate = fit.estimate()
    assert estimate.host_time(0).uncertainty_ns == pytest.approx(500, abs=2)
    assert estimate.host_time(10 * SECOND).uncertainty_ns == pytest.approx(MOST_DRIFT * 10e9, rel=0.01)
