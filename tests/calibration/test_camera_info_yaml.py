"""Text in the YAML of camera_info files; whole files are read in tests/servo/test_calibration.py."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grabbergui.calibration import camera_info
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import UsageError

NAMES = [
    "cam #2", "Bob's", 'the "left" one', r"C:\new", "two  blanks", "", " ", "on", "No", "12", "-", "é[1]",
]  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_a_name_survives_the_way_there_and_back(name):
    text = camera_info.dump(Calibration.from_field_of_view(64, 48)).replace("camera_name: camera\n", "")
    text += camera_info.write({"camera_name": name})
    assert camera_info.parse(text).camera_name == name


@given(st.text(alphabet=st.characters(codec="utf-8", exclude_categories=["Cc", "Zl", "Zp"]), max_size=40))
def test_any_text_survives_the_way_there_and_back(text):
    assert camera_info.read(camera_info.write({"name": text}), "test") == {"name": text}


def test_a_line_cannot_end_within_a_name():
    text = camera_info.write({"name": "left\nimage_width: 7", "image_width": 640})
    assert camera_info.read(text, "test") == {"name": "left image_width: 7", "image_width": 640}


@pytest.mark.parametrize(
    ("line", "value"),
    [
        ("name: 'Bob''s # 2' # a comment", "Bob's # 2"),
        (r'name: "a \"b\" \\ c\td"', 'a "b" \\ c\td'),
        ("name: Bob's camera # a comment", "Bob's camera"),
        ("name: cam#2", "cam#2"),
        ("name: 'left' and right", "'left' and right"),
    ],
)
def test_quotes_and_comments_as_yaml_has_them(line, value):
    assert camera_info.read(line, "test") == {"name": value}


def test_comments_may_stand_behind_everything():
    text = (
        "---  # begin\ndata:  # below\n  rows: 1 # one\n  data: [1, # first\n  2] # last\n"
        "list: # dashes\n- 3 # three\n"
    )
    assert camera_info.read(text, "test") == {"data": {"rows": 1, "data": [1, 2]}, "list": [3]}


@pytest.mark.parametrize("value", ["", " [1, 2]", " 5", "\n  inner: 1"])
def test_a_model_that_is_no_name_is_refused(value):
    text = camera_info.dump(Calibration.from_field_of_view(64, 48))
    assert "distortion_model: plumb_bob" in text
    with pytest.raises(UsageError, match="is not known"):
        camera_info.parse(text.replace("distortion_model: plumb_bob", f"distortion_model:{value}"))
