"""A calibration follows when the camera bins or selects a region."""

from dataclasses import replace

import cv2
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
from grabbergui.core.image_geometry import ImageGeometry
from grabbergui.core.pfnc import by_name

MATRIX = np.array([[500.0, 0, 319.5], [0, 500.0, 239.5], [0, 0, 1]])
PLAIN = Calibration(640, 480, MATRIX, np.zeros(5))
"As ROS's tools write it: it does not say of which part of the sensor."
WHOLE = replace(PLAIN, geometry=ImageGeometry((640, 480)))


def frame(width, height, x=0, y=0):
    return Frame(np.zeros(1, np.uint8), width, height, by_name("Mono8"), offset_x=x, offset_y=y)


def camera(width, height, **region):
    sizes = {"WidthMax": width, "HeightMax": height, **region}
    return ScriptedGrabber(
        Feature(
            name=name,
            kind=FeatureKind.BOOLEAN if isinstance(value, bool) else FeatureKind.INTEGER,
            access=AccessMode.READ_WRITE,
            value=value,
        )
        for name, value in sizes.items()
    )


def intrinsics(calibration):
    matrix = calibration.matrix
    return (matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2])


def at(*whole, **geometry):
    return ImageGeometry(whole, **geometry)


def test_a_region_moves_the_centre_and_keeps_the_focal_length():
    region = fitted(WHOLE, (160, 120), at(640, 480, offset=(64, 32)))

    assert intrinsics(region) == (500, 500, 319.5 - 64, 239.5 - 32)
    assert (region.width, region.height) == (160, 120)


def test_a_region_may_have_another_aspect_ratio():
    assert intrinsics(fitted(WHOLE, (160, 200), at(640, 480, offset=(8, 0)))) == (500, 500, 311.5, 239.5)


def test_binning_shrinks_the_focal_length():
    assert intrinsics(fitted(WHOLE, (320, 240), at(320, 240, binning=(2, 2)))) == (250, 250, 159.5, 119.5)


def test_binning_and_a_region_together():
    small = at(320, 240, offset=(16, 8), binning=(2, 2))
    assert intrinsics(fitted(WHOLE, (64, 48), small)) == (250, 250, 143.5, 111.5)


def test_a_calibration_of_the_same_images_is_returned_unchanged():
    region = replace(WHOLE, geometry=at(2448, 2048, offset=(100, 100)))
    assert fitted(region, (640, 480), at(2448, 2048, offset=(100, 100))) is region


SENSOR = (1608, 1212)
"Whole numbers of pixels with each binning."


@st.composite
def settings_of_a_camera(draw):
    """The settings of a camera: binning times decimation, mirroring, and a region, with its size."""
    binning = draw(st.sampled_from([1, 2, 3, 4])), draw(st.sampled_from([1, 2, 4]))
    whole = SENSOR[0] // binning[0], SENSOR[1] // binning[1]
    offset = draw(st.integers(0, whole[0] // 2)), draw(st.integers(0, whole[1] // 2))
    size = (
        draw(st.integers(whole[0] // 4, whole[0] - offset[0])),
        draw(st.integers(whole[1] // 4, whole[1] - offset[1])),
    )
    mirrored = draw(st.booleans()), draw(st.booleans())
    return ImageGeometry(whole, offset, binning, mirrored), size


def seen_at(point, calibration, geometry):
    """Return where an image has what the sensor sees at a point, pixel by pixel of the sensor."""
    places = []
    for axis in (0, 1):
        place = point[axis]
        if geometry.reversed[axis]:
            place = SENSOR[axis] - 1 - place
        # The pixel that combines `binning` of the sensor's has its centre in the middle of theirs.
        places.append((place - (geometry.binning[axis] - 1) / 2) / geometry.binning[axis])
    return [place - start for place, start in zip(places, geometry.offset, strict=True)]


@given(settings_of_a_camera(), settings_of_a_camera(), st.floats(-0.5, 0.5), st.floats(-0.4, 0.4))
def test_a_calibration_of_any_settings_fits_any_others(made, used, x, y):
    """OpenCV projects with the fitted calibration what the sensor saw, counted in the sensor's pixels."""
    lens = np.array([-0.21, 0.08, 0.004, -0.003, 0.01])
    matrix = np.array([[1300.0, 0, 790.25], [0, 1310.0, 611.5], [0, 0, 1]])
    whole = replace(Calibration(*SENSOR, matrix, lens), geometry=ImageGeometry(SENSOR))
    (geometry, size), (other, other_size) = made, used

    calibrated = fitted(whole, size, geometry)
    result = fitted(calibrated, other_size, other)

    nothing = np.zeros(3)
    ray = np.array([[[x, y, 1.0]]])
    on_sensor = cv2.projectPoints(ray, nothing, nothing, matrix, lens)[0].ravel()
    # An image that is mirrored is that of a mirrored world.
    mirror = np.array([-1 if each else 1 for each in other.reversed] + [1])
    projected = cv2.projectPoints(ray * mirror, nothing, nothing, result.matrix, result.distortion)[0].ravel()
    assert projected == pytest.approx(seen_at(on_sensor, result, other), abs=1e-6)


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


def test_a_calibration_of_an_unknown_region_is_refused_and_the_size_of_the_images_named():
    calibrations = FittedCalibration(camera(4096, 2160, Width=1224, Height=1024))
    calibrations.calibration = PLAIN
    with pytest.raises(
        UsageError, match="is of 640×480 images, the camera sends 1224×1024, which is another"
    ):
        calibrations.now()


def test_an_unknown_crop_causes_one_warning(caplog):
    calibrations = FittedCalibration(camera(2448, 2048))
    calibrations.calibration = PLAIN

    assert [calibrations.of(frame(1224, 1024)) for _ in range(3)] == [None] * 3
    assert len([record for record in caplog.records if "without a calibration" in record.message]) == 1


@pytest.mark.parametrize("kept", [True, False])
def test_a_region_that_was_calibrated_stays_right_when_the_camera_bins_moves_and_mirrors(kept, caplog):
    """The image has the size of the calibration throughout."""
    settings = {"BinningHorizontal": 1, "BinningVertical": 1, "ReverseX": False, "DecimationVertical": 1}
    grabber = camera(2448, 2048, Width=640, Height=480, OffsetX=900, OffsetY=700, **settings)
    calibrations = FittedCalibration(grabber)
    if kept:
        calibrations.keep(PLAIN)  # as `set_camera_info` does, while these images are sent
    else:
        calibrations.calibration = PLAIN
    assert intrinsics(calibrations.of(frame(640, 480, 900, 700))) == (500, 500, 319.5, 239.5)

    assert intrinsics(calibrations.of(frame(640, 480, 910, 690))) == (500, 500, 309.5, 249.5)

    for name, value in {"BinningHorizontal": 2, "WidthMax": 1224, "DecimationVertical": 2}.items():
        grabber.set(name, value)
    grabber.set("HeightMax", 1024)
    binned = calibrations.of(frame(640, 480, 292, 272))
    assert intrinsics(binned) == (250, 250, 609.5 - 292, 469.5 - 272)

    grabber.set("ReverseX", True)
    mirrored = calibrations.of(frame(640, 480, 292, 272))
    assert intrinsics(mirrored) == (250, 250, 1223 - 609.5 - 292, 469.5 - 272)
    assert not caplog.messages
    calibrations.close()


def test_a_camera_whose_largest_size_ignores_binning():
    grabber = camera(2448, 2048, SensorWidth=2448, SensorHeight=2048, BinningHorizontal=2, BinningVertical=2)
    calibrations = FittedCalibration(grabber)
    calibrations.calibration = replace(PLAIN, geometry=ImageGeometry((2448, 2048)))
    assert intrinsics(calibrations.of(frame(320, 240))) == (250, 250, 159.5, 119.5)
    calibrations.close()


def test_impossible_features_of_a_camera_are_no_geometry(caplog):
    calibrations = FittedCalibration(camera(640, 0, BinningHorizontal=-3))
    calibrations.calibration = PLAIN
    assert intrinsics(calibrations.of(frame(640, 480))) == intrinsics(PLAIN)
    calibrations.close()


def test_the_file_records_the_geometry(tmp_path):
    file = tmp_path / "camera.yaml"
    grabber = camera(
        1224, 1024, Width=640, Height=480, OffsetX=8, OffsetY=4, BinningHorizontal=2, ReverseY=True
    )
    FittedCalibration(grabber, file).keep(PLAIN)
    assert camera_info.load(file).geometry == ImageGeometry((1224, 1024), (8, 4), (2, 1), (False, True))

    text = file.read_text()
    for fault in ("width_max: 0", "width_max: many"):
        with pytest.raises(UsageError, match=r"camera\.yaml: "):
            camera_info.parse(text.replace("width_max: 1224", fault), "camera.yaml")


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
    grabber.set("HeightMax", 480)  # so that the features are read again
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
    calibrations.calibration = PLAIN
    assert intrinsics(calibrations.of(frame(640, 480))) == intrinsics(PLAIN)
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
    ("change", "expected"),
    [
        ({"width": 4_000_000_000}, "a side has 1 to 65535"),
        ({"height": 65536}, "a side has 1 to 65535"),
        ({"distortion": np.array([1e308, 0, 0, 0, 0])}, "1e[+]308; its numbers are at most 1e[+]09"),
        ({"distortion": np.array([0, -1e10, 0, 0, 0])}, "1e[+]10; its numbers"),
        ({"rectified": np.full((3, 4), 1e300)}, "1e[+]300"),
    ],
)
def test_impossible_numbers_make_no_calibration(change, expected):
    with pytest.raises(UsageError, match=expected):
        replace(WHOLE, **change)


def test_a_calibration_too_long_to_be_read_is_not_written(tmp_path):
    file = tmp_path / "cam.yaml"
    with pytest.raises(UsageError, match="too long"):
        camera_info.save(replace(WHOLE, camera_name="n" * 70_000), file)
    assert not file.exists()
