import pytest
from hypothesis import given
from hypothesis import strategies as st

from every_case import every_case
from grabbergui.core.errors import FeatureAccessError, FeatureValueError
from grabbergui.core.features import (
    AccessMode,
    Category,
    EnumEntry,
    Feature,
    FeatureDescription,
    FeatureKind,
    Representation,
    coded_text,
    format_number,
    format_value,
)


def feature(kind, **fields):
    return Feature(**{"name": "Knob", "kind": kind, "access": AccessMode.READ_WRITE, **fields})


WIDTH = feature(FeatureKind.INTEGER, minimum=16, maximum=2448, increment=16)
EXPOSURE = feature(FeatureKind.FLOAT, minimum=10.0, maximum=1e6, unit="us")
MODE = feature(FeatureKind.ENUMERATION, entries=(EnumEntry("Off"), EnumEntry("Once", available=False)))


@every_case(
    ("knob", "given_value", "value"),
    [
        (WIDTH, 640, 640),
        (WIDTH, "0x40", 64),
        (WIDTH, " 64 ", 64),
        (WIDTH, "6.4e2", 640),
        (WIDTH, 640.0, 640),
        (EXPOSURE, "2.5e4", 25000.0),
        (EXPOSURE, 10, 10.0),
        (feature(FeatureKind.BOOLEAN), "on", True),
        (feature(FeatureKind.BOOLEAN), "False", False),
        (feature(FeatureKind.BOOLEAN), 1, True),
        (MODE, "Off", "Off"),
        (feature(FeatureKind.STRING), "blue camera", "blue camera"),
    ],
)
def test_values_and_text_are_converted_to_the_features_type(knob, given_value, value):
    taken = knob.validated(given_value)
    assert taken == value and type(taken) is type(value)


@every_case(
    ("knob", "value", "message"),
    [
        (WIDTH, 8, "Knob=8: out of range; allowed: 16 … 2448, step 16"),
        (WIDTH, 2464, "out of range"),
        (EXPOSURE, 2e8, "Knob=200000000: out of range; allowed: 10 … 1000000 us"),
        (WIDTH, 650, "nearest is 640 or 656"),
        (WIDTH, "wide", "not a whole number"),
        (WIDTH, 16.5, "not a whole number"),
        (WIDTH, float("nan"), "not a whole number"),
        (WIDTH, "inf", "not a whole number"),
        (EXPOSURE, "9.99", "10 … 1000000 us"),
        (EXPOSURE, "nan", "not a finite number"),
        (EXPOSURE, "long", "not a number"),
        (feature(FeatureKind.BOOLEAN), "maybe", "allowed: true or false"),
        (MODE, "Once", "not available at the moment; allowed: one of Off"),
        (MODE, "Twice", "no such entry; allowed: one of Off"),
        (feature(FeatureKind.STRING, maximum_length=3), "four", "3"),
        (feature(FeatureKind.COMMAND), 1, "takes no value"),
    ],
)
def test_errors_name_the_allowed_values(knob, value, message):
    with pytest.raises(FeatureValueError, match=message) as caught:
        knob.validated(value)
    assert caught.value.feature == "Knob"


@pytest.mark.parametrize("access", [m for m in AccessMode if not m.writable])
def test_a_feature_that_cannot_be_written_refuses_every_value(access):
    with pytest.raises(FeatureAccessError, match=r"^Knob is "):
        feature(FeatureKind.FLOAT, access=access).validated(1.0)


@given(st.integers(-(2**63), 2**63 - 1))
def test_64_bit_integers_keep_every_bit(number):
    knob = feature(FeatureKind.INTEGER, minimum=-(2**63), maximum=2**63 - 1, increment=1)
    assert knob.validated(number) == number
    assert knob.validated(format_value(number)) == number
    assert knob.validated(hex(number)) == number


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_fractions_keep_every_bit(number):
    assert feature(FeatureKind.FLOAT).validated(format_value(number)) == number


def test_a_refused_text_is_quoted_only_in_part():
    """As one of a remote peer, who may send megabytes."""
    with pytest.raises(FeatureValueError, match=r"^Knob=x{60}: not a whole number; allowed"):
        WIDTH.validated("x" * 1_000_000)


@given(st.one_of(st.text(), st.integers(), st.floats(), st.booleans()), st.sampled_from(FeatureKind))
def test_any_value_is_accepted_or_refused(value, kind):
    knob = feature(kind, minimum=0, maximum=100, increment=3, entries=(EnumEntry("Off"),))
    try:
        taken = knob.validated(value)
    except FeatureValueError:
        return
    if kind is FeatureKind.INTEGER:
        assert isinstance(taken, int) and taken in range(0, 101, 3)
    elif kind is FeatureKind.FLOAT:
        assert isinstance(taken, float) and 0 <= taken <= 100


@pytest.mark.parametrize(
    ("fields", "logarithmic"),
    [
        ({"minimum": 1, "maximum": 101}, True),
        ({"minimum": 1, "maximum": 100}, False),
        ({"minimum": 0, "maximum": 1e9}, False),
        ({"minimum": -1, "maximum": 1e9, "representation": Representation.LOGARITHMIC}, False),
        ({"minimum": 0, "maximum": 10, "representation": Representation.LOGARITHMIC}, True),
        ({"minimum": 1, "maximum": 1e9, "representation": Representation.HEX_NUMBER}, False),
        ({}, False),
    ],
)
def test_sliders_over_more_than_two_decades_are_logarithmic(fields, logarithmic):
    assert feature(FeatureKind.FLOAT, **fields).logarithmic is logarithmic


@pytest.mark.parametrize(("maximum", "logarithmic"), [(1001, True), (1000, False)])
def test_sliders_of_integers_over_more_than_three_decades_are_logarithmic(maximum, logarithmic):
    assert feature(FeatureKind.INTEGER, minimum=1, maximum=maximum).logarithmic is logarithmic


@pytest.mark.parametrize(
    ("number", "text"), [(None, ""), (5, "5"), (5.0, "5"), (0.1, "0.1"), (2**63, str(2**63)), (1e20, "1e+20")]
)
def test_a_number_is_written_as_short_as_it_can_be(number, text):
    assert format_number(number) == text


@pytest.mark.parametrize(("value", "text"), [(None, ""), (True, "true"), (0.1, "0.1"), (7, "7"), ("a", "a")])
def test_a_value_is_written_as_text(value, text):
    assert format_value(value) == text


def test_a_feature_in_two_categories_is_listed_once_depth_first():
    gain, width = (FeatureDescription(name=n, kind=FeatureKind.INTEGER) for n in ("Gain", "Width"))
    root = Category("Root", members=(Category("Analog", members=(gain, width)), width, gain))
    assert [description.name for description in root.descriptions()] == ["Gain", "Width"]
    assert root.title == "Root" and gain.title == "Gain"


@pytest.mark.parametrize("limit", [33333.333366666664, -33333.333366666664, 0.1 + 0.2, 1e6 / 3])
def test_a_limit_is_accepted_as_it_is_shown(limit):
    """People type what the range says, which has ten digits."""
    knob = feature(FeatureKind.FLOAT, minimum=min(limit, 0.0), maximum=max(limit, 0.0))
    assert knob.validated(format_number(limit)) in (limit, float(format_number(limit)))
    assert knob.minimum <= knob.validated(format_number(limit)) <= knob.maximum
    with pytest.raises(FeatureValueError, match="out of range"):
        knob.validated(limit * (1 + 1e-8))


@pytest.mark.parametrize("limits", [(10, 5), (float("nan"), 5.0), (0.0, float("nan"))])
def test_limits_that_contradict_each_other_restrict_nothing(limits):
    """A remote camera's editor offered only the minimum, which the range above it refused."""
    low, high = limits
    knob = feature(FeatureKind.FLOAT, minimum=low, maximum=high)
    assert (knob.minimum, knob.maximum) == (None, None)
    assert knob.validated(7) == 7.0


@pytest.mark.parametrize("kind", [FeatureKind.INTEGER, FeatureKind.FLOAT])
@pytest.mark.parametrize("switch", [True, False, "true", "off"])
def test_a_switch_is_no_number(kind, switch):
    """Python and YARP count true as 1."""
    with pytest.raises(FeatureValueError, match=r"not a (whole )?number"):
        feature(kind, minimum=0, maximum=5).validated(switch)


MAC_0, MAC_32_BITS = "00:00:00:00:00:00", "00:00:FF:FF:FF:FF"


@pytest.mark.parametrize(
    ("representation", "text", "number", "allowed"),
    [
        (Representation.IPV4_ADDRESS, "10.0.0.7", 0x0A000007, "0.0.0.0 … 255.255.255.255"),
        (
            Representation.MAC_ADDRESS,
            "00:00:0A:00:00:07",
            0x0A000007,
            "00:00:00:00:00:00 … 00:00:FF:FF:FF:FF",
        ),
        (Representation.HEX_NUMBER, "0xA000007", 0x0A000007, "0x0 … 0xFFFFFFFF"),
    ],
)
def test_coded_numbers_are_shown_and_read_in_their_own_spelling(representation, text, number, allowed):
    feature = Feature(
        name="Odd",
        kind=FeatureKind.INTEGER,
        access=AccessMode.READ_WRITE,
        value=number,
        minimum=0,
        maximum=2**32 - 1,
        representation=representation,
    )
    assert feature.text == text
    assert feature.validated(text) == feature.validated(number) == feature.validated(str(number)) == number
    assert feature.range_text() == allowed
    for bad in ("10.0.0.256", "1.2.3", "zz:00:00:00:00:00", "words"):
        with pytest.raises(FeatureValueError, match=f"allowed: {allowed}"):
            feature.validated(bad)


@pytest.mark.parametrize(
    ("number", "representation", "text"),
    [
        (31, Representation.HEX_NUMBER, "0x1F"),
        (-31, Representation.HEX_NUMBER, "-0x1F"),
        (0, Representation.HEX_NUMBER, "0x0"),
        (0xC0A8000A, Representation.IPV4_ADDRESS, "192.168.0.10"),
        ((1 << 32) - 1, Representation.IPV4_ADDRESS, "255.255.255.255"),
        (1 << 32, Representation.IPV4_ADDRESS, "0x100000000"),
        (0x00111CF00001, Representation.MAC_ADDRESS, "00:11:1C:F0:00:01"),
        (1 << 48, Representation.MAC_ADDRESS, "0x1000000000000"),
    ],
)
def test_a_coded_number_is_written_in_its_spelling_if_it_fits(number, representation, text):
    assert coded_text(number, representation) == text


@pytest.mark.parametrize(("value", "on"), [("1.0", True), (0.0, False), (" On ", True), ("no", False)])
def test_a_switch_takes_the_words_of_files(value, on):
    assert feature(FeatureKind.BOOLEAN).validated(value) is on
