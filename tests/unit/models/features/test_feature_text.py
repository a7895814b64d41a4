from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from every_case import every_case
from grabbergui.core.features import (
    AccessCondition,
    AccessMode,
    EnumEntry,
    Feature,
    FeatureKind,
    Representation,
    coded_text,
    parse_coded,
)
from grabbergui.models.features.feature_text import (
    access_text,
    breakable,
    limit_text,
    tooltip,
    value_text,
)
from grabbergui.models.features.number_input import parse_number, typed_unit
from grabbergui.models.features.number_text import number_text, quantity_text, shown_unit

HEX, IPV4, MAC = Representation.HEX_NUMBER, Representation.IPV4_ADDRESS, Representation.MAC_ADDRESS
FLOAT = Feature(name="T", kind=FeatureKind.FLOAT, access=AccessMode.READ_WRITE, unit="us", value=1.0)
INTEGER = Feature(name="N", kind=FeatureKind.INTEGER, access=AccessMode.READ_WRITE, value=1)


@every_case(
    ("number", "text"),
    [
        (0.0, "0"),
        (0.1, "0.1"),
        (0.10000000149011612, "0.1"),
        (33.333333333, "33.33333"),
        (10000.0, "10000"),
        (1234567.0, "1234567"),
        (12345678.9, "12345679"),
        (-0.25, "-0.25"),
        (1e-9, "1e-09"),
        (1.7e308, "1.7e+308"),
        (float("inf"), "inf"),
        (2**63 - 1, "9223372036854775807"),
    ],
)
def test_numbers_to_look_at(number, text):
    assert number_text(number) == text


def test_fewer_digits_where_there_is_less_room():
    assert [number_text(11276.6321, digits) for digits in (7, 6, 5, 4)] == [
        "11276.63",
        "11276.6",
        "11277",
        "11277",
    ]
    assert number_text(0.0123456, 4) == "0.01235"
    assert number_text(123456789, 4) == "123456789"


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_fraction_shown_is_the_fraction_to_seven_digits(number):
    assert float(number_text(number)) == pytest.approx(number, rel=1e-6, abs=0)


@pytest.mark.parametrize(
    ("text", "number"),
    [("5", 5.0), ("2.5e4", 25000.0), (" 10000 µs ", 10000.0), ("10us", 10.0), ("0,5", 0.5)],
)
def test_typed_fractions(text, number):
    assert parse_number(text, FLOAT) == number


@pytest.mark.parametrize(
    ("text", "unit", "number"),
    [
        ("12,5 ms", "us", 12500.0),
        ("0.02 s", "us", 20000.0),
        ("500ns", "us", 0.5),
        ("5 ms", "s", 0.005),
        ("3 s", "s", 3.0),
        ("2 kHz", "Hz", 2000.0),
        ("1 MHz", "kHz", 1000.0),
        ("1.5 dB", "dB", 1.5),
    ],
)
def test_typed_in_another_unit(text, unit, number):
    assert parse_number(text, replace(FLOAT, unit=unit)) == number
    whole = parse_number(text, replace(INTEGER, unit=unit))
    assert (whole, type(whole)) == (round(number), int)


@pytest.mark.parametrize(("text", "unit"), [("5 ms", "Hz"), ("5 kHz", "us"), ("ms", "us"), ("5 ms", "")])
def test_a_unit_of_something_else_is_nonsense(text, unit):
    with pytest.raises(ValueError, match=r".*"):
        parse_number(text, replace(FLOAT, unit=unit))


@pytest.mark.parametrize(
    ("text", "number"), [("9223372036854775807", 2**63 - 1), ("0x1F", 31), ("1e3", 1000), ("2.6", 3)]
)
def test_typed_integers(text, number):
    assert parse_number(text, INTEGER) == number


@pytest.mark.parametrize("text", ["", "abc", "nan", "1 2", "--1", "inf ns"])
def test_nonsense_is_a_value_error(text):
    for feature in (FLOAT, INTEGER):
        with pytest.raises(ValueError, match=r".*"):
            parse_number(text, feature)


@pytest.mark.parametrize(
    ("number", "representation", "text"),
    [
        (255, HEX, "0xFF"),
        (-1, HEX, "-0x1"),
        (0xC0A8000A, IPV4, "192.168.0.10"),
        (0x00111C012345, MAC, "00:11:1C:01:23:45"),
    ],
)
def test_coded_numbers_both_ways(number, representation, text):
    assert coded_text(number, representation) == text
    assert parse_coded(text, representation) == number


@given(st.integers(-(2**63), 2**63 - 1), st.sampled_from([HEX, IPV4, MAC]))
def test_every_integer_survives_its_text(number, representation):
    assert parse_coded(coded_text(number, representation), representation) == number


def test_coded_numbers_are_also_taken_plain():
    assert parse_coded("ff", HEX) == 255
    assert parse_coded("00-11-1c-1-23-45", MAC) == 0x00111C012345
    for text, representation in [("300.1.1.1", IPV4), ("zz", HEX), ("1:2:3", MAC)]:
        with pytest.raises(ValueError, match=r".*"):
            parse_coded(text, representation)


def test_values_of_read_only_rows():
    assert value_text(FLOAT) == "1 µs"
    mode = Feature(
        name="M",
        kind=FeatureKind.ENUMERATION,
        access=AccessMode.READ_ONLY,
        value="On",
        entries=(EnumEntry("On", "Switched on"),),
    )
    assert value_text(mode) == "Switched on"
    switch = Feature(name="B", kind=FeatureKind.BOOLEAN, access=AccessMode.READ_ONLY, value=True)
    assert value_text(switch) == "yes"
    command = Feature(name="C", kind=FeatureKind.COMMAND, access=AccessMode.NOT_AVAILABLE)
    assert value_text(command) == "–"


def test_a_tooltip_has_reason_help_and_range():
    locked = Feature(
        name="Width",
        kind=FeatureKind.INTEGER,
        access=AccessMode.READ_ONLY,
        value=64,
        minimum=16,
        maximum=2448,
        increment=16,
        unit="px",
        display_name="Image <Width>",
        tooltip="Of the image.",
        description="Of the image.",
        selectors=("RegionSelector",),
    )
    text = tooltip(locked)
    assert "Image &lt;Width&gt;" in text
    assert "is read-only; streaming" in text
    assert text.count("Of the image.") == 1
    assert "Value: 64 px" in text
    assert "Selected by: RegionSelector" in text
    assert "16 … 2448 px, step 16" in text
    assert "<code>Width</code>" in text


def test_a_tooltip_that_the_description_repeats_is_shown_once():
    shown = tooltip(replace(FLOAT, tooltip="Light falls in", description="Light falls in for so long."))
    assert "Light falls in<br>" not in shown and "Light falls in for so long." in shown


ON, SOFTWARE = (
    AccessCondition("TriggerMode", "Off", ("On",)),
    AccessCondition("TriggerSource", "Line1", ("Software", "Any")),
)


@pytest.mark.parametrize(
    ("access", "conditions", "why"),
    [
        (AccessMode.NOT_AVAILABLE, (ON,), "is not available while TriggerMode is Off; set TriggerMode to On"),
        (
            AccessMode.READ_ONLY,
            (ON, SOFTWARE),
            "is read-only while TriggerMode is Off and TriggerSource is Line1;"
            " set TriggerMode to On and TriggerSource to Software or Any",
        ),
        (
            AccessMode.NOT_AVAILABLE,
            (AccessCondition("Licence", "0"),),
            "is not available at the moment; it depends on other features: Licence is 0",
        ),
        (
            AccessMode.READ_ONLY,
            (AccessCondition("Licence", "0"),),
            "is read-only at the moment; it depends on other features: Licence is 0",
        ),
        (
            AccessMode.READ_ONLY,
            (AccessCondition("TLParamsLocked", "1", ("0",)),),
            "is read-only while the camera streams; stop it first",
        ),
        (
            AccessMode.NOT_AVAILABLE,
            (AccessCondition("TLParamsLocked", "1", ("0",)),),
            "is not available while the camera streams; stop it first",
        ),
    ],
)
def test_what_hides_or_locks_a_feature_is_named(access, conditions, why):
    feature = replace(INTEGER, access=access, value=None, conditions=conditions)
    assert feature.access_problem() == why
    assert access_text(feature) == why
    assert f"It {why}." in tooltip(feature)


@pytest.mark.parametrize(
    ("typed", "taken", "why"),
    [
        (5.0, 2.0, "At most 2 µs"),
        (-1.0, 0.5, "At least 0.5 µs"),
        (1.0, 1.0, ""),
    ],
)
def test_a_number_moved_into_the_range_is_explained(typed, taken, why):
    assert limit_text(replace(FLOAT, minimum=0.5, maximum=2.0), typed, taken) == why


def test_a_step_is_explained_but_not_rounding():
    width = replace(INTEGER, minimum=16, maximum=640, increment=16)
    assert limit_text(width, 100, 96) == "Only in steps of 16"
    assert limit_text(width, 96.2, 96) == ""
    assert limit_text(replace(width, representation=HEX), 1000, 640) == "At most 0x280"


def test_camel_case_may_be_broken():
    assert breakable("ExposureTimeAbs").split("\u200b") == ["Exposure", "Time", "Abs"]


@every_case(
    ("number", "unit", "text"),
    [
        (1e6, "us", "1 s"),
        (1000000, "us", "1 s"),
        (10000.0, "us", "10 ms"),
        (1000.0, "us", "1 ms"),
        (999.0, "us", "999 µs"),
        (12345678, "us", "12.345678 s"),
        (125000000, "Bps", "125 MBps"),
        (30.0, "Hz", "30 Hz"),
        (25000.0, "Hz", "25 kHz"),
        (0.02, "s", "0.02 s"),
        (20000.0, "dB", "20000 dB"),
        (float("inf"), "us", "inf µs"),
    ],
)
def test_long_numbers_are_shown_in_a_larger_unit(number, unit, text):
    assert quantity_text(number, unit) == text


@every_case(
    ("number", "before", "unit"),
    [
        (5000.0, "ms", "ms"),
        (100.0, "ms", "ms"),
        (99.0, "ms", "us"),
        (0.0, "ms", "us"),
        (1_000_000.0, "ms", "s"),
        (5000.0, "s", "ms"),
        (500.0, "s", "us"),
        (200_000.0, "s", "s"),
        (20_000.0, "s", "ms"),
        (500.0, "us", "us"),
        (1000.0, "us", "ms"),
        (10_000.0, "us", "ms"),
        (500.0, "kHz", "us"),
        (500.0, "", "us"),
    ],
)
def test_the_unit_that_was_shown_is_kept_where_it_suits_the_number(number, before, unit):
    assert shown_unit(number, "us", before) == unit


@pytest.mark.parametrize(
    ("text", "unit", "typed"),
    [
        ("5 ms", "us", "ms"),
        ("5ms", "us", "ms"),
        ("5 s", "us", "s"),
        ("5", "us", ""),
        ("5 dB", "dB", ""),
        ("5 µs", "us", "µs"),
    ],
)
def test_the_unit_of_a_typed_text_is_recognised(text, unit, typed):
    assert typed_unit(text, unit) == typed


@pytest.mark.parametrize(
    ("text", "number"),
    [("1,000.5", 1000.5), ("1.000,5", 1000.5), ("-12,345,678.25", -12345678.25), ("1,5", 1.5), ("1.5", 1.5)],
)
def test_thousands_may_be_set_apart(text, number):
    assert parse_number(text, FLOAT) == number


@pytest.mark.parametrize("text", ["1,00.5", "1.000.5", "1,000,5", ",000.5", "1,0000.5"])
def test_separators_in_other_places_are_refused(text):
    with pytest.raises(ValueError):
        parse_number(text, FLOAT)
