"""Text in the YAML of camera_info files; whole files are read in test_camera_info.py."""

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from every_case import every_case
from grabbergui.calibration import camera_info
from grabbergui.calibration.opencv_yaml import read_yaml, write_yaml
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import UsageError
from patience import attempts

NAMES = [
    "cam #2", "Bob's", 'the "left" one', r"C:\new", "two  blanks", "", " ", "on", "No", "12", "-", "é[1]",
]  # fmt: skip


@every_case("name", NAMES)
def test_a_name_survives_the_way_there_and_back(name):
    text = camera_info.dump(Calibration.from_field_of_view(64, 48)).replace("camera_name: camera\n", "")
    text += write_yaml({"camera_name": name})
    assert camera_info.parse(text).camera_name == name


@given(st.text(alphabet=st.characters(codec="utf-8", exclude_categories=["Cc", "Zl", "Zp"]), max_size=40))
def test_any_text_survives_the_way_there_and_back(text):
    assert read_yaml(write_yaml({"name": text}), "test") == {"name": text}


def test_a_line_cannot_end_within_a_name():
    text = write_yaml({"name": "left\nimage_width: 7", "image_width": 640})
    assert read_yaml(text, "test") == {"name": "left\nimage_width: 7", "image_width": 640}


@pytest.mark.parametrize(
    ("line", "value"),
    [
        ("name: 'Bob''s # 2' # a comment", "Bob's # 2"),
        (r'name: "a \"b\" \\ c\td"', 'a "b" \\ c\td'),
        ("name: Bob's camera # a comment", "Bob's camera"),
        ("name: cam#2", "cam#2"),
    ],
)
def test_quotes_and_comments_as_yaml_has_them(line, value):
    assert read_yaml(line, "test") == {"name": value}


def test_comments_may_stand_behind_everything():
    text = (
        "---  # begin\ndata:  # below\n  rows: 1 # one\n  data: [1, # first\n  2] # last\n"
        "list: # dashes\n- 3 # three\n"
    )
    assert read_yaml(text, "test") == {"data": {"rows": 1, "data": [1, 2]}, "list": [3]}


def test_a_number_of_rows_that_is_huge_by_aliases_is_not_written_out():
    huge = "a0: &a0 [0, 0]\n" + "".join(f"a{n}: &a{n} [{f'*a{n - 1}, ' * 8}]\n" for n in range(1, 7))
    text = huge + camera_info.dump(Calibration.from_field_of_view(64, 48)).replace("rows: 3", "rows: *a6", 1)
    with pytest.raises(UsageError, match="9 numbers for a list rows and 3 columns") as refused:
        camera_info.parse(text)
    assert len(str(refused.value)) < 200


@pytest.mark.parametrize("value", ["", " [1, 2]", " 5", "\n  inner: 1"])
def test_a_model_that_is_no_name_is_refused(value):
    text = camera_info.dump(Calibration.from_field_of_view(64, 48))
    assert "distortion_model: plumb_bob" in text
    with pytest.raises(UsageError, match="is not known"):
        camera_info.parse(text.replace("distortion_model: plumb_bob", f"distortion_model:{value}"))


FLOW = """\
{image_width: 640, image_height: 480, camera_name: left, distortion_model: plumb_bob,
 camera_matrix: {rows: 3, cols: 3, data: [430, 0, 306, 0, 430, 227, 0, 0, 1]},
 distortion_coefficients: {rows: 1, cols: 5, data: [-0.3, 1e-3, 0, 0, 0]}}
"""


def test_flow_style_is_read_as_any_other():
    calibration = camera_info.parse(FLOW)
    assert (calibration.width, calibration.camera_name) == (640, "left")
    assert calibration.distortion.tolist() == [-0.3, 1e-3, 0, 0, 0]


def test_a_file_of_opencv_is_read(tmp_path):
    cv2 = pytest.importorskip("cv2")
    path = tmp_path / "left.yaml"
    file = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    file.write("image_width", 640)
    file.write("image_height", 480)
    file.write("camera_matrix", np.array([[430.5, 0, 306], [0, 430, 227], [0, 0, 1]]))
    file.write("distortion_coefficients", np.array([[-0.3, 1e-9, 0, 0, 0]]))
    file.release()
    assert path.read_text().startswith("%YAML:1.0")
    calibration = camera_info.load(path)
    assert calibration.matrix[0, 0] == 430.5 and calibration.distortion[1] == 1e-9


@pytest.mark.parametrize(("count", "model"), [(4, "plumb_bob"), (5, "plumb_bob"), (8, "rational_polynomial")])
@pytest.mark.parametrize("zeros", [0, 6])
def test_the_number_of_coefficients_is_opencvs_model(count, model, zeros):
    numbers = [0.1 * (index + 1) for index in range(count)] + [0.0] * (zeros if count == 8 else 0)
    matrix = {"rows": 3, "cols": 3, "data": [600, 0, 320, 0, 600, 240, 0, 0, 1]}
    values = {"image_width": 640, "image_height": 480, "camera_matrix": matrix}
    values["distortion_coefficients"] = {"rows": len(numbers), "cols": 1, "data": numbers}
    calibration = camera_info.parse(write_yaml(values))
    assert calibration.distortion_model == model
    assert calibration.distortion[:count].tolist() == numbers[:count]
    values["distortion_coefficients"] = {"rows": 9, "cols": 1, "data": [0.1] * 9}
    with pytest.raises(UsageError, match="9 coefficients are too many for rational_polynomial"):
        camera_info.parse(write_yaml(values))


KALIBR = """cam0:
  camera_model: pinhole
  distortion_coeffs: [-0.28, 0.07, 0.0001, 0.00002]
  distortion_model: radtan
  intrinsics: [458.6, 457.3, 367.2, 248.4]
  resolution: [752, 480]
"""


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (
            KALIBR,
            "is no camera_info file: it lacks image_width, .* but has cam0; Kalibr and others use other",
        ),
        ("", "it lacks image_width, image_height, camera_matrix, distortion_coefficients; Kalibr"),
        ("a: \x12\n", "^c.yaml is no YAML of a calibration: unacceptable character #x0012: [a-z ]+$"),
    ],
)
def test_what_is_no_camera_info_is_told_from_a_broken_one(text, problem):
    with pytest.raises(UsageError, match=problem):
        camera_info.parse(text, "c.yaml")


@pytest.mark.parametrize("bracket", ["[", "{", "[1,", "- ", "? "])
def test_thousands_of_brackets_are_refused_at_once(bracket):
    """The window stood still for five seconds."""
    for watch in attempts(0.2):
        with watch, pytest.raises(UsageError, match="brackets are nested too deeply"):
            camera_info.parse(bracket * 20_000, "c.yaml")


@pytest.mark.skipif(not hasattr(yaml, "CSafeLoader"), reason="this PyYAML comes without libyaml")
@pytest.mark.parametrize("numbers", [f"[{'1,' * 32_000}]", "\n" + "- 1\n" * 16_000])
def test_the_longest_file_is_read_at_once(numbers):
    """The window stood still for seconds."""
    for watch in attempts(0.4):
        with watch:
            assert len(read_yaml(f"data: {numbers}", "c.yaml")["data"]) >= 16_000


def test_aliases_cannot_make_it_huge():
    bomb = "a: &a [x, x, x, x, x, x, x, x, x]\n"
    for name, before in zip("bcdefghij", "abcdefghi", strict=True):
        bomb += f"{name}: &{name} [{', '.join([f'*{before}'] * 9)}]\n"
    for key in ("camera_name", "distortion_model", "image_width", "camera_matrix"):
        text = bomb + f"{key}: *j\n" + "image_height: 480\n"
        with pytest.raises(UsageError) as caught:
            camera_info.parse(text)
        assert len(str(caught.value)) < 300


@pytest.mark.parametrize(
    "text",
    [
        "!!python/object:os.system {}",
        "a: !!timestamp x",
        "a: !!int x",
        "[" * 3000,
        "a: *b",
        "a: 'left' and right",
        "- 1",
        "%YAML 3",
    ],
)
def test_other_yaml_is_refused(text):
    with pytest.raises(UsageError, match="left"):
        camera_info.parse(text, "left.yaml")
