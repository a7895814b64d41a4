"""Calibrations as messages and back; without ROS."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from grabbergui.calibration import camera_info
from grabbergui.calibration.fitting import fitted
from grabbergui.core.calibration import Calibration, FrameCalibration
from grabbergui.core.camera_info_message import fill_camera_info, read_camera_info
from grabbergui.core.errors import UsageError
from grabbergui.core.image_geometry import ImageGeometry

MATRIX = np.array([[500.0, 0, 319.5], [0, 500.0, 239.5], [0, 0, 1]])
WHOLE = Calibration(640, 480, MATRIX, np.zeros(5))


def intrinsics(calibration):
    matrix = calibration.matrix
    return (matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2])


def message(**changes):
    whole = {"x_offset": 0, "y_offset": 0, "width": 0, "height": 0}
    fields = {
        "width": 640,
        "height": 480,
        "distortion_model": "plumb_bob",
        "k": MATRIX.ravel().tolist(),
        "d": [0.1] * 5,
        "r": [0.0] * 9,
        "p": [0.0] * 12,
        "binning_x": 0,
        "binning_y": 0,
        "roi": SimpleNamespace(**whole),
    }
    return SimpleNamespace(**{**fields, **changes})


def region(x, y, width, height):
    return SimpleNamespace(x_offset=x, y_offset=y, width=width, height=height)


def test_a_message_of_the_whole_sensor():
    calibration = read_camera_info(message(), "left")

    assert intrinsics(calibration) == (500, 500, 319.5, 239.5) and calibration.camera_name == "left"
    assert calibration.distortion.tolist() == [0.1] * 5


def test_a_messages_region_and_binning():
    calibration = read_camera_info(message(roi=region(64, 32, 320, 240), binning_x=2, binning_y=2), "left")

    assert (calibration.width, calibration.height) == (160, 120)
    assert intrinsics(calibration) == (250, 250, (319.5 - 64 + 0.5) / 2 - 0.5, (239.5 - 32 + 0.5) / 2 - 0.5)


def test_a_stereo_pairs_rectification_and_baseline_are_kept_through_binning_and_region():
    turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    projection = np.array([[480.0, 0, 300.5, -48], [0, 480, 230.5, 0], [0, 0, 1, 0]])
    given = message(r=turn.ravel().tolist(), p=projection.ravel().tolist())

    kept = camera_info.parse(camera_info.dump(read_camera_info(given, "right")))
    reported = SimpleNamespace()
    whole = replace(kept, geometry=ImageGeometry((640, 480)))
    small = fitted(whole, (64, 48), ImageGeometry((320, 240), (16, 8), (2, 2)))
    fill_camera_info(reported, FrameCalibration(small, small))

    assert reported.r == turn.ravel().tolist()
    assert reported.p == [240, 0, 301 / 2 - 0.5 - 16, -24, 0, 240, 231 / 2 - 0.5 - 8, 0, 0, 0, 1, 0]
    assert reported.k[2] == 320 / 2 - 0.5 - 16


def test_an_image_binned_in_one_direction_has_its_own_focal_lengths():
    binned = read_camera_info(message(binning_x=2), "left")
    assert (binned.width, binned.height) == (320, 480)
    assert binned.matrix.tolist() == [[250, 0, 319.5 / 2 - 0.25], [0, 500, 239.5], [0, 0, 1]]


def test_without_a_rectification_it_is_the_cameras_own():
    reported = SimpleNamespace()
    calibration = read_camera_info(message(), "left")
    fill_camera_info(reported, FrameCalibration(calibration, calibration))

    assert reported.r == np.eye(3).ravel().tolist()
    assert reported.p == [500, 0, 319.5, 0, 0, 500, 239.5, 0, 0, 0, 1, 0]


@pytest.mark.parametrize(("given", "expected"), [([], 5), ([0.1, 0.2], 5), ([0.1, 0.2, 0.3, 0.4], 5)])
def test_coefficients_left_out_are_zero(given, expected):
    distortion = read_camera_info(message(d=given), "left").distortion

    assert distortion.tolist() == given + [0.0] * (expected - len(given))


def test_a_rational_polynomial_keeps_its_eight_coefficients():
    model = read_camera_info(message(d=[0.1] * 8, distortion_model="rational_polynomial"), "left")

    assert model.distortion.shape == (8,)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"k": [0.0] * 9}, "holds no calibration"),
        ({"width": 0}, "holds no calibration"),
        ({"k": [float("nan")] * 9}, "holds no calibration"),
        ({"d": [0.1] * 6}, "too many for plumb_bob"),
        ({"d": [float("inf")] * 5}, "not finite"),
        ({"p": [float("nan")] * 12}, "not finite"),
        ({"r": [float("inf")] * 9}, "not finite"),
        ({"distortion_model": "double_sphere", "d": [0.1] * 4}, "'double_sphere'"),
        (
            {"binning_x": 2, "binning_y": 1000},
            "images of 640×480 pixels are too small for a binning of 2×1000",
        ),
    ],
)
def test_what_cannot_be_used_is_refused(changes, words):
    with pytest.raises(UsageError, match=words):
        read_camera_info(message(**changes), "left")
