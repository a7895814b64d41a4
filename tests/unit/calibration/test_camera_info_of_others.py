"""Calibrations that other programs wrote: a fisheye lens, ost.ini, several YAML documents."""

import cv2
import numpy as np
import pytest

from fakes import ScriptedGrabber
from grabbergui.calibration import camera_info
from grabbergui.calibration.calibration_choice import CalibrationChoice
from grabbergui.calibration.marker_pose import located
from grabbergui.core.calibration import FrameCalibration
from grabbergui.core.errors import UsageError
from grabbergui.models.image.rendering import Region
from grabbergui.models.image.undistortion import distorted_pixel, undistorted
from grabbergui.net.yarp.grabber_values import intrinsics

FISHEYE = """image_width: 640
image_height: 480
camera_name: dome
camera_matrix: {rows: 3, cols: 3, data: [220.5, 0, 321.25, 0, 221.5, 239.5, 0, 0, 1]}
distortion_model: equidistant
distortion_coefficients: {rows: 1, cols: 4, data: [-0.021, 0.004, -0.003, 0.0005]}
rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}
projection_matrix: {rows: 3, cols: 4, data: [220.5, 0, 321.25, 0, 0, 221.5, 239.5, 0, 0, 0, 1, 0]}
"""
"The form of camera_calibration's `--fisheye` (ROS 2)."

OST = """# oST version 5.0 parameters


[image]

width
640

height
480

[narrow_stereo]

camera matrix
369.344588 0.000000 320.739078
0.000000 367.154330 203.592450
0.000000 0.000000 1.000000

distortion
0.189544 -0.018229 -0.000630 0.000054 0.000000

rectification
1.000000 0.000000 0.000000
0.000000 1.000000 0.000000
0.000000 0.000000 1.000000

projection
383.062256 0.000000 320.515320 0.000000
0.000000 380.622833 202.791104 0.000000
0.000000 0.000000 1.000000 0.000000

"""


def test_a_fisheye_lens_is_read_and_written():
    calibration = camera_info.parse(FISHEYE)
    assert calibration.fisheye and calibration.distortion_model == "equidistant"
    assert calibration.distortion.tolist() == [-0.021, 0.004, -0.003, 0.0005]
    again = camera_info.parse(camera_info.dump(calibration))
    assert again.fisheye and np.array_equal(again.distortion, calibration.distortion)
    assert camera_info.parse(FISHEYE.replace("equidistant", "fisheye")).fisheye


def test_a_fisheye_lens_is_served_on_both_networks():
    calibration = camera_info.parse(FISHEYE)
    served = intrinsics(calibration, 0.0)
    assert served["distortionModel"] == "equidistant"
    assert [served[f"k{number}"] for number in (1, 2, 3, 4)] == [-0.021, 0.004, -0.003, 0.0005]
    assert "t1" not in served

    messages = pytest.importorskip("grabbergui.core.camera_info_message")
    message = type(
        "CameraInfo", (), {"roi": type("Roi", (), {"width": 0, "height": 0}), "binning_x": 0, "binning_y": 0}
    )
    messages.fill_camera_info(message, FrameCalibration(calibration, calibration))
    assert (message.distortion_model, message.d) == ("equidistant", [-0.021, 0.004, -0.003, 0.0005])
    assert messages.read_camera_info(message, "dome").fisheye


def test_the_undistorted_view_of_a_fisheye_lens_is_opencvs():
    calibration = camera_info.parse(FISHEYE)
    ray = np.array([[[(600 - 321.25) / 220.5, (400 - 239.5) / 221.5]]])
    (column, line) = cv2.fisheye.distortPoints(ray, calibration.matrix, calibration.distortion)[0, 0]
    assert distorted_pixel(calibration, 600, 400) == (round(column), round(line))

    image = np.zeros((480, 640), np.uint8)
    image[round(line) - 2 : round(line) + 3, round(column) - 2 : round(column) + 3] = 255
    shown = undistorted(image, calibration, Region(0, 0, 640, 480), (640, 480))
    assert shown[400, 600] == 255 and shown[:, :500].max() == 0


def test_servoing_refuses_a_fisheye_lens_with_the_reason(tmp_path):
    (path := tmp_path / "dome.yaml").write_text(FISHEYE)
    with pytest.raises(
        UsageError, match=rf"{path}: .* fisheye lens \(equidistant\); poses and servoing need plumb"
    ):
        CalibrationChoice.file(path, ScriptedGrabber())


def test_no_pose_is_found_with_a_fisheye_lens(tmp_path):
    square = np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]]) * 0.05
    with pytest.raises(UsageError, match="fisheye"):
        located(None, square, square[:, :2] * 1000 + 300, camera_info.parse(FISHEYE))


@pytest.mark.parametrize(
    "text", [OST, OST.replace("\n", "\r\n"), OST.replace("# oST version 5.0 parameters", "")]
)
def test_ost_ini_is_read(tmp_path, text):
    (path := tmp_path / "ost.ini").write_text(text)
    calibration = camera_info.load(path)
    assert (calibration.width, calibration.height, calibration.camera_name) == (640, 480, "narrow_stereo")
    assert calibration.matrix.tolist() == [[369.344588, 0, 320.739078], [0, 367.15433, 203.59245], [0, 0, 1]]
    assert calibration.distortion.tolist() == [0.189544, -0.018229, -0.00063, 0.000054, 0]
    assert calibration.projection[0].tolist() == [383.062256, 0, 320.51532, 0]


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("369.344588", "wide", "ost.ini: 'wide' is neither a number nor a name of ost.ini"),
        ("369.344588", "inf", "not finite"),
        ("width\n640", "width", "ost.ini: a calibration for images of 0×480"),
        ("distortion\n", "", "distortion_coefficients is missing"),
        ("0.000000 0.000000 1.000000\n\ndistortion", "distortion", "camera_matrix is \\(3, 2\\)|6 numbers"),
        ("projection\n", "[right]\nprojection\n", "narrow_stereo and right; save each in a file"),
    ],
)
def test_a_broken_ost_ini_says_what_is_wrong(old, new, expected):
    with pytest.raises(UsageError, match=expected):
        camera_info.parse(OST.replace(old, new, 1), "ost.ini")


def test_of_several_documents_the_calibration_is_read():
    text = f"%YAML 1.2\n---\nnote: made on Monday\n---\n{FISHEYE}\n---\n"
    assert camera_info.parse(text).camera_name == "dome"
    assert camera_info.parse(f"---\n{FISHEYE}...\n").camera_name == "dome"


def test_several_calibrations_are_refused_by_their_names():
    text = f"{FISHEYE}---\n{FISHEYE.replace('dome', 'left')}"
    with pytest.raises(UsageError, match=r"stereo.yaml has 2 calibrations \(dome, left\); save the camera's"):
        camera_info.parse(text, "stereo.yaml")
