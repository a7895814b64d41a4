"""Arrays of other people's parameters, as text and back."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from every_case import every_case

pytest.importorskip("rcl_interfaces", reason="ROS 2 is not installed: make setup-ros2")
pytestmark = pytest.mark.ros2

from grabbergui.core.errors import FeatureValueError  # noqa: E402
from grabbergui.net.ros2.array_text import (  # noqa: E402
    ARRAYS,
    BOOL_ARRAY,
    BYTE_ARRAY,
    DOUBLE_ARRAY,
    INTEGER_ARRAY,
    STRING_ARRAY,
    message_of_text,
    text_of,
)

ELEMENTS = {
    BYTE_ARRAY: st.integers(0, 255),
    BOOL_ARRAY: st.booleans(),
    INTEGER_ARRAY: st.integers(-(2**63), 2**63 - 1),
    DOUBLE_ARRAY: st.floats(allow_nan=False, allow_infinity=False),
    STRING_ARRAY: st.text(st.characters(exclude_categories=["Cs"])),
}


@given(st.data(), st.sampled_from(sorted(ARRAYS)))
def test_what_is_read_can_be_written(data, kind):
    elements = data.draw(st.lists(ELEMENTS[kind], max_size=8))

    text = text_of(message_of_text("list", kind, json.dumps(elements)))

    assert json.loads(text) == elements
    assert text_of(message_of_text("list", kind, text[1:-1])) == text


@every_case(
    ("kind", "text", "words"),
    [
        (DOUBLE_ARRAY, "[1, two]", r"that is no list; write a list as \[0.5, 1e-3, 2\]"),
        (DOUBLE_ARRAY, "[1, NaN]", "nan, at place 2, does not fit"),
        (DOUBLE_ARRAY, f"[1{'0' * 400}]", "at place 1, does not fit"),
        (DOUBLE_ARRAY, "[true]", "true, at place 1, does not fit"),
        (INTEGER_ARRAY, "1, 2.5", "2.5, at place 2, does not fit"),
        (INTEGER_ARRAY, str(2**63), "does not fit"),
        (BOOL_ARRAY, "[0]", r"write a list as \[true, false\]"),
        (BYTE_ARRAY, "[256]", "256, at place 1"),
        (STRING_ARRAY, "left, right", "that is no list"),
        (STRING_ARRAY, "[1]", "1, at place 1"),
        (STRING_ARRAY, "[" * 100_000, "that is no list"),
        (STRING_ARRAY, " " + "x" * 2_000_000, "2000000 characters are too many"),
        (INTEGER_ARRAY, "1], [2", "that is no list"),
    ],
)
def test_a_malformed_list_is_refused_with_the_reason(kind, text, words):
    with pytest.raises(FeatureValueError, match=words):
        message_of_text("list", kind, text)


@given(st.text(), st.sampled_from(sorted(ARRAYS)))
def test_any_text_is_an_array_or_refused(text, kind):
    try:
        message_of_text("list", kind, text)
    except FeatureValueError as error:
        assert error.feature == "list"
