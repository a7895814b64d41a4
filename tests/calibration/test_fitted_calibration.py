"""A calibration follows when the camera bins or selects a region."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fakes import ScriptedGrabber
from grabbergui.calibration import camera_info
from grabbergui.calibration.fitting import FittedCalibration, fitted
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import FeatureNotFoundError, UsageError
from grabbergui.core.features import AccessMode, Feature, FeatureKind
from grabbergui.core.frame import Frame
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.pfnc import by_name

MATRIX = np.array([[500.0, 0, 319.5], [0, 500.0, 239.5], [0, 0, 1]])
WHOLE = Calibration(640, 480, MATRIX, np.zeros(5))


def frame(width, height, x=0, y=0):
    return Frame(np.zeros(1, np.uint8), width, height, by_name("Mono8"), offset_x=x, offset_y=y)


def camera(width, height, **region):
    sizes = {"WidthMax": width, "HeightMax": height, **region}
    return ScriptedGrabber(
        Feature(name=name, kind=FeatureKind.INTEGER, access=AccessMode.READ_ONLY, value=value)
        for name, value in sizes.items()
    )


def intrinsics(calibration):
    matrix = calibration.matrix
    return (matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2])


def test_a_region_moves_the_centre_and_keeps_the_focal_length():
    region = fitted(WHOLE, (160, 120), (64, 32), (640, 480))

    assert intrinsics(region) == (500, 500, 319.5 - 64, 239.5 - 32)
    assert (region.width, region.height) == (160, 120)


def test_a_region_may_have_another_aspect_ratio():
    assert intrinsics(fitted(WHOLE, (160, 200), (8, 0), (640, 480))) == (500, 500, 311.5, 239.5)


def test_binning_shrinks_the_focal_length():
    assert intrinsics(fitted(WHOLE, (320, 240), (0, 0), (320, 240))) == (250, 250, 159.5, 119.5)


def test_binning_and_a_region_together():
    assert intrinsics(fitted(WHOLE, (64, 48), (16, 8), (320, 240))) == (250, 250, 143.5, 111.5)


def test_a_calibration_of_the_same_size_is_returned_unchanged():
    assert fitted(WHOLE, (640, 480), (100, 100), (2448, 2048)) is WHOLE


def test_a_file_of_another_camera_is_reported_and_used(tmp_path, caplog):
    file = tmp_path / "camera.yaml"
    mine = camera(640, 480)
    mine.info = DeviceInfo("gige:1234", "Acme", "One", "1234")
    FittedCalibration(mine, file).keep(WHOLE)
    assert FittedCalibration(mine, file).calibration.camera_serial == "1234"
    assert not caplog.messages

    other = camera(640, 480)
    other.info = DeviceInfo("gige:77", "Acme", "One", "77")
    assert intrinsics(FittedCalibration(other, file).of(frame(640, 480))) == (500, 500, 319.5, 239.5)
    assert caplog.messages == [
        f"{file} was made with another camera, One 1234; this one is Acme One (serial 77): "
        "calibrate it as well"
    ]


def test_a_calibration_of_another_region_is_refused():
    with pytest.raises(UsageError, match="another crop"):
        fitted(WHOLE, (1224, 1024), (0, 0), (2448, 2048))


def test_an_unknown_crop_causes_one_warning(caplog):
    calibrations = FittedCalibration(camera(2448, 2048))
    calibrations.calibration = WHOLE

    assert [calibrations.of(frame(1224, 1024)) for _ in range(3)] == [None] * 3
    assert len([record for record in caplog.records if "without a calibration" in record.message]) == 1


def test_binning_at_the_same_frame_size_is_noticed():
    grabber = camera(640, 480)
    calibrations = FittedCalibration(grabber)
    calibrations.calibration = WHOLE
    assert intrinsics(calibrations.of(frame(64, 48)))[0] == 500

    grabber.set("WidthMax", 320)
    grabber.set("HeightMax", 240)

    assert intrinsics(calibrations.of(frame(64, 48)))[0] == 250
    calibrations.close()
    calibrations.close()


def test_binning_that_changes_while_a_calibration_is_fitted_takes_effect_at_the_next_frame():
    grabber = camera(640, 480)
    calibrations = FittedCalibration(grabber)
    calibrations.calibration = WHOLE
    calibrations.of(frame(32, 24))  # listens to the camera from now on
    read = grabber.feature

    def read_before_a_change(name):
        feature = read(name)
        if name == "HeightMax":
            grabber.feature = read
            grabber.set("WidthMax", 320)
            grabber.set("HeightMax", 240)
        return feature

    grabber.feature = read_before_a_change
    calibrations.of(frame(64, 48))

    assert intrinsics(calibrations.of(frame(64, 48)))[0] == 250
    calibrations.close()


@pytest.mark.parametrize("full_size", [(640, 480), (0, 0)])
def test_frames_without_an_image_have_no_calibration(full_size):
    calibrations = FittedCalibration(camera(*full_size))
    calibrations.calibration = WHOLE

    assert calibrations.of(frame(0, 0)) is None
    calibrations.close()


def test_another_calibration_takes_effect_and_none_is_none():
    calibrations = FittedCalibration(camera(640, 480))
    assert calibrations.of(frame(640, 480)) is None
    calibrations.calibration = WHOLE
    assert calibrations.of(frame(640, 480)) is WHOLE
    calibrations.calibration = None
    assert calibrations.of(frame(640, 480)) is None


def test_without_a_frame_it_is_fitted_to_the_region_that_is_set():
    calibrations = FittedCalibration(camera(640, 480, Width=160, Height=120, OffsetX=64, OffsetY=32))
    calibrations.calibration = WHOLE

    assert intrinsics(calibrations.now()) == (500, 500, 319.5 - 64, 239.5 - 32)


def test_without_any_calibration_there_is_none_now():
    with pytest.raises(FeatureNotFoundError, match="--calibration FILE"):
        FittedCalibration(camera(640, 480, Width=640, Height=480)).now()


def test_a_file_is_loaded_and_written(tmp_path):
    file = tmp_path / "camera.yaml"
    grabber = camera(640, 480, Width=640, Height=480)

    assert FittedCalibration(grabber, file).keep(WHOLE) == file
    assert intrinsics(FittedCalibration(grabber, file).now()) == intrinsics(WHOLE)


def test_a_folder_stops_no_camera(tmp_path, caplog):
    grabber = camera(640, 480, Width=640, Height=480)
    assert FittedCalibration(grabber, tmp_path).of(frame(640, 480)) is None
    assert f"{tmp_path}" in caplog.text and "images are sent without this calibration" in caplog.text


def test_a_camera_is_not_polled_before_a_frame_needs_a_calibration():
    grabber = camera(640, 480, Width=640, Height=480)
    calibrations = FittedCalibration(grabber)
    calibrations.calibration = WHOLE
    calibrations.now()
    assert len(grabber.features_changed) == 0

    calibrations.of(frame(640, 480))
    assert len(grabber.features_changed) == 1
    calibrations.close()
    assert len(grabber.features_changed) == 0


def test_a_file_that_holds_no_calibration_stops_no_camera_and_is_kept(tmp_path, caplog):
    file = tmp_path / "cam.yaml"
    file.write_text("camera_matrix: nonsense\n")
    calibrations = FittedCalibration(camera(640, 480), file)
    assert calibrations.calibration is None and calibrations.file == file
    assert f"{file}: distortion_coefficients is missing" in caplog.text

    with pytest.raises(UsageError, match=r"cam\.yaml is kept, .* rename or remove it"):
        calibrations.keep(WHOLE)
    assert file.read_text() == "camera_matrix: nonsense\n"
    file.unlink()
    assert calibrations.keep(WHOLE) == file
    assert FittedCalibration(camera(640, 480), file).calibration is not None


NUMBERS = st.floats(allow_nan=True, allow_infinity=True) | st.floats(-2e9, 2e9)


@given(
    st.integers(-1, 2**33) | st.integers(1, 5000),
    st.integers(-1, 2**33) | st.integers(1, 5000),
    st.lists(NUMBERS, min_size=4, max_size=8),
    st.lists(NUMBERS, min_size=12, max_size=12),
    st.text(max_size=50),
)
def test_every_calibration_that_is_accepted_is_loaded_again(width, height, distortion, projection, name):
    """What `set_camera_info` accepts must not stop the next start: one validator for both ways."""
    try:
        accepted = Calibration(
            width,
            height,
            WHOLE.matrix,
            np.array(distortion),
            name,
            rectified=np.array(projection).reshape(3, 4),
        )
        text = camera_info.dump(accepted)
    except UsageError:
        return
    again = camera_info.parse(text)
    assert (again.width, again.height, again.camera_name) == (width, height, name)
    assert np.array_equal(again.distortion, accepted.distortion)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"width": 4_000_000_000}, "a side has 1 to 65535"),
        ({"height": 65536}, "a side has 1 to 65535"),
        ({"distortion": np.array([1e308, 0, 0, 0, 0])}, "1e[+]308; its numbers are at most 1e[+]09"),
        ({"distortion": np.array([0, -1e10, 0, 0, 0])}, "1e[+]10; its numbers"),
        ({"rectified": np.full((3, 4), 1e300)}, "1e[+]300"),
    ],
)
def test_impossible_numbers_make_no_calibration(change, said):
    with pytest.raises(UsageError, match=said):
        replace(WHOLE, **change)


def test_a_calibration_too_long_to_be_read_is_not_written(tmp_path):
    file = tmp_path / "cam.yaml"
    with pytest.raises(UsageError, match="too long"):
        camera_info.save(replace(WHOLE, camera_name="n" * 70_000), file)
    assert not file.exists()
