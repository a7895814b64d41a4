"""What drivers say in words of the values a parameter may have; without ROS."""

from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grabbergui.net.ros2.parameter_features import choices


def descriptor(constraints="", description=""):
    return SimpleNamespace(additional_constraints=constraints, description=description)


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
def test_lists(text, listed):
    assert choices(descriptor(text)) == listed
    assert choices(descriptor(description=text)) == listed


@pytest.mark.parametrize(
    "text",
    ["", "how bright", "one of the best features", "one of [alone]", "one of , ,", "0 … 24 dB, step 1"],
)
def test_other_words(text):
    assert choices(descriptor(text)) == ()


def test_too_long_a_list_is_none():
    assert choices(descriptor("one of " + ", ".join(map(str, range(100))))) == ()


@given(st.text(max_size=5000))
def test_any_text(text):
    assert all(choices(descriptor(text))) or not choices(descriptor(text))
