"""Calibrations of changed images, and whose they are."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from numpy.testing import assert_allclose

from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import UsageError
from grabbergui.core.identity import DeviceInfo

MATRIX = np.array([[600.0, 2.0, 310.0], [0, 500.0, 250.0], [0, 0, 1]])
PINHOLE = Calibration(640, 480, MATRIX, np.array([-0.2, 0.05, 0.01, -0.02, 0.003]))
FISHEYE = Calibration(640, 480, MATRIX, np.array([0.1, -0.02, 0.003, 0.001]))
DIRECTIONS = np.array([[0.1, 0.2, 1.0], [-0.3, 0.05, 1.0], [0.0, -0.25, 1.0]])


def seen(calibration, directions):
    """Return the pixels (n, 2) at which directions (n, 3) are seen, distorted by OpenCV."""
    project = cv2.fisheye.projectPoints if calibration.fisheye else cv2.projectPoints
    still = np.zeros(3)
    plane, _ = project(directions[:, None], still, still, np.eye(3), calibration.distortion)
    return plane[:, 0] @ calibration.matrix[:2, :2].T + calibration.matrix[:2, 2]


@pytest.mark.parametrize("along", [(True, False), (False, True), (True, True), (False, False)])
@pytest.mark.parametrize("calibration", [PINHOLE, FISHEYE], ids=["pinhole", "fisheye"])
def test_mirrored_images_show_the_mirrored_world(calibration, along):
    signs = [-1 if each else 1 for each in along]
    mirrored = calibration.mirrored(along, (640, 480))
    ends = np.array((640, 480)) - 1
    expected = np.where(along, ends - seen(calibration, DIRECTIONS), seen(calibration, DIRECTIONS))
    assert_allclose(seen(mirrored, DIRECTIONS * [*signs, 1]), expected, atol=1e-9)
    assert mirrored.geometry is None and (mirrored.width, mirrored.height) == (640, 480)


def test_a_mirrored_stereo_camera_is_rectified_as_before():
    turn, _ = cv2.Rodrigues(np.array([0.02, -0.05, 0.01]))
    projection = np.array([[450.0, 0, 300, -45], [0, 450, 240, 9], [0, 0, 1, 0]])
    calibration = replace(PINHOLE, rectification=turn, rectified=projection)
    mirrored = calibration.mirrored((True, False), (640, 480))
    for direction in DIRECTIONS:
        x, y, depth = projection @ [*(turn @ direction), 1]
        across, down, far = mirrored.projection @ [*(mirrored.rectification @ (direction * [-1, 1, 1])), 1]
        assert_allclose((across / far, down / far), (639 - x / depth, y / depth))
    assert calibration.mirrored((False, True), (640, 480)).projection[1, 3] == -9


def test_a_calibration_is_scaled_with_its_images():
    assert PINHOLE.scaled_to(640, 480) is PINHOLE
    half = PINHOLE.scaled_to(320, 240)
    assert (half.width, half.height) == (320, 240)
    assert_allclose(half.matrix, [[300, 1, 154.75], [0, 250, 124.75], [0, 0, 1]])
    assert PINHOLE.scaled_to(642, 480).width == 642  # rounded by less than a hundredth
    for size in ((650, 480), (640, 400)):
        with pytest.raises(UsageError, match=f"of 640×480 images, the camera sends {size[0]}×{size[1]}"):
            PINHOLE.scaled_to(*size)


def test_the_field_of_view_is_that_of_all_pixels():
    square = Calibration.from_field_of_view(640, 480, 90)
    assert square.field_of_view == pytest.approx((90.0, 73.7398), abs=1e-3)
    left = replace(square, matrix=square.matrix + np.array([[0, 0, -319.5], [0, 0, 0], [0, 0, 0]]))
    assert left.field_of_view[0] == pytest.approx(np.degrees(np.arctan(639.5 / 320) + np.arctan(0.5 / 320)))


def test_a_calibration_knows_its_camera_by_model_and_serial_number():
    made = PINHOLE.made_with(DeviceInfo("gige:1", model="One", serial="7"))
    assert (made.camera_model, made.camera_serial) == ("One", "7")
    assert not made.is_of_another(DeviceInfo("gige:2", model="One", serial="7"))
    assert made.is_of_another(DeviceInfo("gige:1", model="One", serial="8"))
    assert made.is_of_another(DeviceInfo("gige:1", model="Two", serial="7"))
    assert not made.is_of_another(DeviceInfo("gige:1", model="Two"))
    assert not PINHOLE.is_of_another(DeviceInfo("gige:1", model="One", serial="8"))


def test_the_nominal_camera_looks_through_the_middle_of_the_image():
    camera = Calibration.from_field_of_view(640, 480, 90)
    assert camera.matrix.tolist() == [
        [pytest.approx(320), 0, 319.5],
        [0, pytest.approx(320), 239.5],
        [0, 0, 1],
    ]
    assert camera.nominal and not camera.distortion.any()
    for degrees in (0.9, 171):
        with pytest.raises(UsageError, match="allowed: 1 to 170"):
            Calibration.from_field_of_view(640, 480, degrees)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"width": 0}, "of 0×480 pixels is impossible"),
        ({"distortion": np.zeros(6)}, "4, 5 or 8 distortion coefficients"),
        ({"matrix": np.eye(4)}, "3×3 camera matrix"),
        ({"rectified": np.eye(3)}, "3×4 projection"),
        ({"distortion": np.array([np.nan, 0, 0, 0, 0])}, "not finite"),
        ({"distortion": np.array([2e9, 0, 0, 0, 0])}, "its numbers are at most 1e"),
        ({"matrix": np.diag([4.0, 500, 1])}, "focal lengths of 4 and 500 pixels are impossible"),
        ({"matrix": np.diag([500.0, 7e7, 1])}, "4.8 to 6.4e"),
    ],
)
def test_an_impossible_calibration_is_refused(change, reason):
    with pytest.raises(UsageError, match=reason):
        replace(PINHOLE, **change)


def test_extreme_numbers_are_allowed():
    assert replace(PINHOLE, distortion=np.array([0, 0, 0, 0, 1e9])).distortion[4] == 1e9
    assert replace(PINHOLE, matrix=np.diag([4.8, 6.4e7, 1])).matrix[0, 0] == 4.8
