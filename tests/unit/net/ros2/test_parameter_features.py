"""Choices that drivers list in a parameter's description; without ROS."""

import time
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grabbergui.net.ros2.parameter_features import choices
from grabbergui.net.ros2.parameter_values import BOOL, DOUBLE, INTEGER, STRING


def descriptor(constraints="", description="", kind=STRING):
    return SimpleNamespace(additional_constraints=constraints, description=description, type=kind)


@pytest.mark.parametrize(
    ("text", "listed"),
    [
        ("one of Off, Once, Continuous", ("Off", "Once", "Continuous")),
        ("One of: [off, auto]", ("off", "auto")),
        ("Must be one of {mono8, rgb8}.", ("mono8", "rgb8")),
        ("one of ('a b', \"c\")", ("a b", "c")),
        ("Valid values: 1, 2 or 4; see the manual", ("1", "2", "4")),
        ("valid values are 50, or 60", ("50", "60")),
        ("Available options: low|high", ("low", "high")),
        ("choices: x, x, y", ("x", "y")),
        ("one of [rggb8, 16UC1]. Default: rggb8", ("rggb8", "16UC1")),
    ],
)
def test_a_list_of_values_in_a_description_gives_the_choices(text, listed):
    assert (
        choices(descriptor(text)) == choices(descriptor(description=text)) == {name: name for name in listed}
    )


@pytest.mark.parametrize(
    ("text", "menu"),
    [
        ("0: Disabled, 1: 50 Hz", {"Disabled": 0, "50 Hz": 1}),
        ("Power line frequency (0: Disabled, 1: 50 Hz, 2: 60 Hz)", {"Disabled": 0, "50 Hz": 1, "60 Hz": 2}),
        ("0=Auto; 1=Manual; 3=Aperture priority", {"Auto": 0, "Manual": 1, "Aperture priority": 3}),
        ("Mode: -1: off | 1: on. Default: 1", {"off": -1, "on": 1}),
        ("menu [0: none, 1: 0.5 s, 2: 1.5 s].", {"none": 0, "0.5 s": 1, "1.5 s": 2}),
        ("0: Off\n1: On", {"Off": 0, "On": 1}),
        ("valid values are 50, or 60", {"50": 50, "60": 60}),
    ],
)
def test_a_menu_of_integers_in_a_description_gives_names_and_values(text, menu):
    assert choices(descriptor(text, kind=INTEGER)) == choices(descriptor("", text, INTEGER)) == menu


@pytest.mark.parametrize(
    "text",
    [
        "ratio 1:2, 3:4",
        "from 10:30 to 11:45",
        "0: alone",
        "0: same, 1: same",
        "0: one, 0: other",
        "v1.0: a, 2: b",
    ],
)
def test_texts_that_are_no_menus(text):
    assert choices(descriptor(text, kind=INTEGER)) == {}


def test_a_list_has_values_of_the_parameters_type():
    assert choices(descriptor("one of [0.5, 1, 2]", kind=DOUBLE)) == {"0.5": 0.5, "1": 1.0, "2": 2.0}
    assert choices(descriptor("one of low, high", kind=INTEGER)) == {}
    assert choices(descriptor("one of true, false", kind=BOOL)) == {}
    assert choices(descriptor("0: Disabled, 1: 50 Hz", kind=STRING)) == {}


@pytest.mark.parametrize(
    "text",
    ["", "how bright", "one of the best features", "one of [alone]", "one of , ,", "0 … 24 dB, step 1"],
)
def test_other_words_are_no_choices(text):
    assert choices(descriptor(text)) == {}


def test_too_long_a_list_gives_no_choices():
    assert choices(descriptor("one of " + ", ".join(map(str, range(100))))) == {}


@pytest.mark.parametrize("text", ["1:a{}b", "one of a{}b", "0: a{0}, 1: b{0}", "one of a,{}b or{}c"])
def test_long_blanks_cost_no_time(text):
    """Any node may describe its parameters so, and the client reads the descriptions of all of them."""
    text = text.format(" " * 2000, " " * 2000)
    begun = time.thread_time()
    for kind in (INTEGER, STRING):
        for _ in range(20):
            choices(descriptor(text, kind=kind))
    assert time.thread_time() - begun < 1


@given(st.text(max_size=5000), st.sampled_from([INTEGER, STRING, DOUBLE]))
def test_any_description_gives_choices_with_names_or_none(text, kind):
    assert all(choices(descriptor(text, kind=kind)))
