import contextlib
import resource
import string
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from every_case import every_case
from grabbergui.calibration import camera_info
from grabbergui.calibration.opencv_yaml import read_yaml, write_yaml
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import UsageError
from grabbergui.core.identity import DeviceInfo

# As camera_calibration writes it: lists over several lines, dashes, a name in quotes.
OTHERS = """\
image_width: 640
image_height: 480
camera_name: "head camera"   # as printed on it
camera_matrix:
  rows: 3
  cols: 3
  data: [ 430.21554970319971, 0.0, 306.6913434743704,
          0.0, 430.53169252696676, 227.22480030078816,
          0.0, 0.0, 1.0 ]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data:
    - -0.33758562758914146
    - 0.11161239414304096
    - -2.1819272592442094e-04
    - -3.029195446330518e-05
    - 0
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]
"""


def test_reads_what_ros_tools_write():
    calibration = camera_info.parse(OTHERS)
    assert (calibration.width, calibration.height) == (640, 480)
    assert calibration.camera_name == "head camera"
    assert calibration.matrix[0, 0] == 430.21554970319971
    assert calibration.distortion.tolist() == [
        -0.33758562758914146,
        0.11161239414304096,
        -2.1819272592442094e-04,
        -3.029195446330518e-05,
        0,
    ]
    assert calibration.distortion_model == "plumb_bob"


def test_what_is_saved_is_loaded_again(tmp_path):
    calibration = Calibration(
        808, 608, np.array([[601.5, 0, 403.2], [0, 602.25, 301], [0, 0, 1]]), np.linspace(-1e-7, 3, 8), "left"
    )
    path = tmp_path / "left.yaml"
    camera_info.save(calibration, path)
    loaded = camera_info.load(path)
    assert np.array_equal(loaded.matrix, calibration.matrix)
    assert np.array_equal(loaded.distortion, calibration.distortion)
    assert loaded.distortion_model == "rational_polynomial"
    assert loaded.camera_name == "left"


def test_the_file_names_the_camera_that_it_was_made_with(tmp_path):
    path, camera = tmp_path / "left.yaml", DeviceInfo("gige:1234", "Acme", "One", "1234")
    camera_info.save(Calibration.from_field_of_view(640, 480).made_with(camera), path)
    loaded = camera_info.load(path)
    assert (loaded.camera_model, loaded.camera_serial) == ("One", "1234")
    assert loaded.scaled_to(320, 240).camera_serial == "1234"
    assert not loaded.is_of_another(camera)
    assert loaded.is_of_another(replace(camera, serial="1235"))
    assert loaded.is_of_another(replace(camera, model="Two"))


def test_a_camera_that_is_not_known_is_no_other_one():
    camera = DeviceInfo("gige:1234", "Acme", "One", "1234")
    assert not camera_info.parse(OTHERS).is_of_another(camera)
    recorded = Calibration.from_field_of_view(640, 480).made_with(camera)
    assert not recorded.is_of_another(DeviceInfo("file:/tmp/recording", "Recording", "recording"))


def test_a_disk_that_is_full_costs_no_calibration(tmp_path):
    (path := tmp_path / "camera.yaml").write_text(OTHERS)
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, hard))
    try:
        with pytest.raises(OSError, match="File too large"):
            camera_info.save(Calibration.from_field_of_view(640, 480), path)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert camera_info.load(path).camera_name == "head camera"


@every_case(
    ("old", "new", "complaint"),
    [
        ("image_width: 640", "image_width: -3", "images of -3×480 pixels is impossible"),
        ("image_width: 640", "image_width: .nan", "not a number of pixels"),
        ("image_width: 640", "image_width: 4000000000", "a side has 1 to 65535"),
        ("plumb_bob", "stereographic", "distortion model 'stereographic'"),
        ("  rows: 3\n  cols: 3\n  data: [ 430", "  rows: 2\n  cols: 3\n  data: [ 430", "for 2 rows"),
        ("430.21554970319971", ".inf", "not finite"),
        ("430.21554970319971", "-430.2", "focal lengths"),
        ("430.21554970319971", "1e-300", "allowed for 640×480 images: 4.8 to 6.4e+07"),
        ("430.21554970319971", "4.7", "focal lengths of 4.7 and"),
        ("430.21554970319971", "1e9", "focal lengths"),
        ("430.21554970319971", "wide", "other than numbers"),
        ("camera_matrix:", "camera_metrics:", "camera_matrix is missing"),
        ("data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]", "data: [1, 0", "expected ',' or ']'"),
        ("image_height: 480", "&anchor *alias", "line 3: "),
    ],
)
def test_a_broken_file_is_refused_with_what_is_wrong(old, new, complaint):
    assert old in OTHERS
    with pytest.raises(UsageError, match=r"left\.yaml") as caught:
        camera_info.parse(OTHERS.replace(old, new, 1), "left.yaml")
    assert complaint in str(caught.value)
    assert str(caught.value).count("left.yaml") == 1


@given(st.text(alphabet=st.characters(codec="utf-8"), max_size=200))
def test_any_text_is_read_or_refused(text):
    for candidate in (text, OTHERS[: len(text) * 5] + text):
        with contextlib.suppress(UsageError):
            text = camera_info.dump(camera_info.parse(candidate))
            assert camera_info.dump(camera_info.parse(text)) == text


@given(
    st.dictionaries(
        st.text(string.ascii_lowercase + "_", min_size=1, max_size=8),
        st.one_of(
            st.integers(-(10**17), 10**17),
            st.floats(allow_nan=False, allow_infinity=False),
            st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=20),
        ),
        max_size=6,
    )
)
def test_numbers_survive_the_way_there_and_back(values):
    assert read_yaml(write_yaml(values), "test") == values


def test_a_field_of_view_gives_a_pinhole():
    calibration = Calibration.from_field_of_view(1000, 500, 90)
    assert calibration.matrix[0, 0] == pytest.approx(500)
    assert calibration.matrix[:2, 2].tolist() == [499.5, 249.5]
    assert calibration.nominal
    with pytest.raises(UsageError, match="200°"):
        Calibration.from_field_of_view(640, 480, 200)


def test_a_binned_image_has_the_same_directions():
    """A pixel's edges, not its centre, are what binning keeps."""
    full = Calibration(1280, 960, np.array([[900.0, 0, 611.3], [0, 910, 470.1], [0, 0, 1]]), np.zeros(5))
    half = full.scaled_to(640, 480)
    direction = np.array([0.2, -0.1, 1])
    pixel, binned = full.matrix @ direction, half.matrix @ direction
    assert (pixel[:2] + 0.5) / 2 - 0.5 == pytest.approx(binned[:2])
    with pytest.raises(UsageError, match="another crop"):
        full.scaled_to(640, 640)
