import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from grabbergui.core.features import AccessMode, Feature, FeatureKind, Representation
from grabbergui.models.features.number_steps import StepSize, natural_step, stepped
from grabbergui.models.features.slider_scale import SLIDER_STEPS, SliderScale, nearest_allowed


def feature(minimum, maximum, value=None, kind=None, **more):
    kind = kind or (FeatureKind.INTEGER if isinstance(minimum, int) else FeatureKind.FLOAT)
    return Feature(
        name="F",
        kind=kind,
        access=AccessMode.READ_WRITE,
        minimum=minimum,
        maximum=maximum,
        value=minimum if value is None else value,
        **more,
    )


LOG = Representation.LOGARITHMIC


@st.composite
def scales(draw):
    integer = draw(st.booleans())
    if integer:
        low = draw(st.integers(-(10**6), 10**6))
        span = draw(st.integers(1, 10**8))
        step = draw(st.integers(1, max(1, span // 2)))
        made = feature(low, low + span, increment=step, representation=draw(st.sampled_from([LOG])))
    else:
        low = draw(st.floats(-1e6, 1e6))
        span = draw(st.floats(1e-3, 1e8))
        made = feature(low, low + span, representation=draw(st.sampled_from(list(Representation)[:2])))
    scale = SliderScale.of(made)
    return made, scale


@given(scales())
@example((feature(5e-324, 1.0), SliderScale.of(feature(5e-324, 1.0))))
def test_the_ends_are_exact_and_positions_grow_with_values(pair):
    made, scale = pair
    assert scale.to_value(0) == made.minimum
    assert scale.to_value(scale.steps) == scale.maximum
    assert scale.to_position(made.minimum) == 0
    assert scale.to_position(made.maximum) == scale.steps
    values = [scale.to_value(position) for position in range(0, scale.steps + 1, 7)]
    assert values == sorted(values)


@given(scales(), st.integers(0, SLIDER_STEPS))
def test_a_position_survives_the_way_to_a_value_and_back(pair, position):
    made, scale = pair
    position = min(position, scale.steps)
    value = scale.to_value(position)
    assert made.minimum <= value <= made.maximum
    back = scale.to_value(scale.to_position(value))
    if scale.integer:
        assert isinstance(value, int)
        assert (value - made.minimum) % scale.increment == 0
        # Several positions share a value, or values a position; the way back stays within a position.
        low, high = scale.to_value(position - 1), scale.to_value(position + 1)
        assert min(low, value) <= back <= max(high, value)
    else:
        assert abs(scale.to_position(value) - position) <= 1


@given(st.floats(1e-3, 1e3), st.floats(1e-3, 1.0), st.floats(4, 8))
def test_a_logarithmic_slider_is_as_fine_everywhere(low, fraction, decades):
    scale = SliderScale(low, low * 10**decades, logarithmic=True)
    value = low * 10 ** (decades * fraction)
    assert math.isclose(scale.to_value(scale.to_position(value)), value, rel_tol=0.02)


def test_zero_has_a_place_of_its_own_on_a_logarithmic_slider():
    scale = SliderScale.of(feature(0.0, 1000.0, representation=LOG))
    assert scale.logarithmic
    assert scale.to_value(0) == 0
    assert scale.to_value(1) == pytest.approx(0.001)
    assert scale.to_position(0.0) == 0
    assert scale.to_position(1e-9) == 1
    integers = SliderScale.of(feature(0, 65535, representation=LOG))
    assert [integers.to_value(0), integers.to_value(1), integers.to_value(SLIDER_STEPS)] == [0, 1, 65535]


def test_a_minimum_that_is_as_good_as_zero_is_taken_for_zero():
    scale = SliderScale.of(feature(2.2e-311, 1000.0))
    assert scale.logarithmic
    assert [scale.to_value(0), scale.to_value(1)] == [2.2e-311, pytest.approx(0.001)]


def test_more_than_two_decades_are_logarithmic_and_three_of_integers():
    assert SliderScale.of(feature(1.0, 600.0)).logarithmic
    assert not SliderScale.of(feature(1.0, 100.0)).logarithmic
    assert SliderScale.of(feature(1, 10000)).logarithmic
    assert not SliderScale.of(feature(16, 4096)).logarithmic


def test_an_integer_with_few_values_has_as_many_positions():
    scale = SliderScale.of(feature(16, 2448, increment=16))
    assert scale.steps == 152
    assert [scale.to_value(position) for position in (0, 1, 152)] == [16, 32, 2448]


def test_the_highest_position_is_on_a_step():
    assert SliderScale.of(feature(1, 10, increment=4)).to_value(10) == 9


@pytest.mark.parametrize(
    "made",
    [
        feature(0, 2**63 - 1),
        feature(-1.7e308, 1.7e308),
        feature(0.0, math.inf),
        feature(5, 5),
        feature(3, 4, increment=16),
        feature(0, 255, representation=Representation.HEX_NUMBER),
        feature(0, 255, representation=Representation.PURE_NUMBER),
        Feature(name="F", kind=FeatureKind.INTEGER, access=AccessMode.READ_WRITE, value=1),
    ],
)
def test_no_slider_without_a_real_range(made):
    assert SliderScale.of(made) is None


def test_nearest_allowed():
    width = feature(16, 2450, increment=16)
    assert nearest_allowed(width, 100) == 96
    assert nearest_allowed(width, 104) == 112
    assert nearest_allowed(width, 9999) == 2448
    assert nearest_allowed(width, -5) == 16
    assert nearest_allowed(feature(0.0, 48.0), 12.3456789) == 12.3456789
    assert nearest_allowed(feature(0.0, 48.0), 50) == 48.0


@given(st.integers(-(2**63), 2**63 - 1))
def test_64_bit_integers_stay_exact(value):
    wide = feature(-(2**63), 2**63 - 1, value)
    assert nearest_allowed(wide, value) == value
    assert stepped(wide, 1) == min(value + 1, 2**63 - 1)


def test_a_track_shows_the_part_of_a_wide_range_in_which_each_pixel_can_be_aimed_at():
    whole = SliderScale.of(feature(10.0, 1e6))
    part = whole.around(10000.0, 100)
    assert part.to_position(10000.0) == pytest.approx(part.steps / 2, abs=1)
    pixel = (part.maximum / part.minimum) ** (1 / 100)
    assert 1.02 < pixel < 1.026
    assert whole.around(12.0, 100).minimum == 10.0
    assert whole.around(9e5, 100).maximum == 1e6
    assert whole.around(10000.0, 2000) is whole, "a track that is long enough shows everything"
    assert SliderScale.of(feature(0.0, 48.0)).around(10.0, 100).maximum == 48.0


@given(st.integers(1, 10**8), st.integers(1, 97), st.floats(0, 1))
def test_a_part_of_a_range_has_the_numbers_of_the_whole(number, increment, share):
    whole = SliderScale.of(feature(0, 10**8, increment=increment, representation=LOG))
    part = whole.around(number, 120, share)
    assert part.minimum % increment == part.maximum % increment == 0
    nearest = part.to_value(part.to_position(number))
    assert nearest % increment == 0
    assert abs(nearest - number) <= max(increment, 0.02 * number)


@pytest.mark.parametrize(
    ("shown", "fine", "usual", "coarse"),
    [
        (feature(10.0, 1e6, value=20000.0), 20, 200, 2000),
        (feature(0.0, 48.0), 0.05, 0.5, 5),
        (feature(0.0, 48.0, increment=0.1), 0.1, 0.1, 1.0),
        (feature(0.0, 48.0, increment=1e-6), 0.05, 0.5, 5),
        (feature(16, 2448, increment=16), 16, 16, 160),
        (feature(0, 2**63 - 1, 2**62), 1, 1, 10),
    ],
)
def test_fine_and_coarse_steps(shown, fine, usual, coarse):
    steps = [natural_step(shown, pace) for pace in (StepSize.FINE, StepSize.USUAL, StepSize.COARSE)]
    assert steps == [pytest.approx(step) for step in (fine, usual, coarse)]


def test_steps_suit_the_range_and_the_value():
    assert natural_step(feature(0.0, 48.0)) == 0.5
    assert natural_step(feature(16, 2448, increment=16)) == 16
    assert natural_step(feature(10.0, 1e6, value=20000.0)) == 200
    assert natural_step(feature(1, 10**8, value=20000, representation=LOG)) == 200
    assert natural_step(feature(1, 10**8, value=5, representation=LOG)) == 1
    assert stepped(feature(0.0, 48.0, 0.2), 1) == 0.7
    assert stepped(feature(0.0, 48.0, 47.99), 1) == 48.0
    assert stepped(feature(0.0, 1.0, 0.5, increment=0.25), 1) == 0.75
    assert stepped(feature(0.0, math.inf, 0.0), 1) == 1.0


EXTREMES = st.sampled_from([0.0, 5e-324, 1e-310, -1.0, 3.0, 1e8, 1e300, -1e300, math.inf, math.nan])


@given(EXTREMES, EXTREMES, EXTREMES, st.none() | EXTREMES, st.sampled_from(Representation))
def test_no_number_of_a_remote_camera_breaks_a_control(value, low, high, increment, representation):
    made = feature(low, high, value, increment=increment, representation=representation)
    scale = SliderScale.of(made)
    if scale is not None:
        for position in (0, 1, scale.steps // 2, scale.steps):
            assert low <= scale.to_value(position) <= high
        assert 0 <= scale.to_position(3.0) <= scale.steps
        assert scale.around(3.0, 300).steps == scale.steps
    for pace in StepSize:
        assert natural_step(made, pace) > 0
        stepped(made, 3, pace)
    nearest_allowed(made, 3.0)


@pytest.mark.parametrize("increment", [math.nan, math.inf, -5.0, 0.5])
def test_an_integer_with_an_unusable_increment_counts_by_one(increment):
    made = feature(0, 10, 5, increment=increment)
    assert (SliderScale.of(made).steps, natural_step(made), nearest_allowed(made, 6.7)) == (10, 1, 7)
