"""A calibration is loaded, and the picture shown without the lens's distortion."""

import numpy as np
import pytest

from grabbergui.calibration import camera_info
from grabbergui.core.calibration import Calibration


@pytest.fixture
def desk(window_desk):
    window_desk.connect("sim:?width=320&height=240&fps=30")
    window_desk.watch()
    return window_desk


def barrel(width=320, height=240):
    matrix = np.array([[260.0, 0, width / 2], [0, 260.0, height / 2], [0, 0, 1]])
    return Calibration(width, height, matrix, np.array([-0.3, 0.08, 0, 0, 0]))


def shown(desk):
    return desk.program.picture.settings.calibration


def test_a_calibration_is_loaded_shown_and_put_away(desk, tmp_path):
    window = desk.window
    assert window.actionLoadCalibration.isEnabled() and not window.actionShowCalibration.isEnabled()
    camera_info.save(barrel(), tmp_path / "lens.yaml")
    desk.program.calibration.load(tmp_path / "lens.yaml")
    assert window.actionShowCalibration.isChecked()
    assert np.allclose(shown(desk).distortion, barrel().distortion)
    assert any("undistorted" in text for text in desk.errors)
    desk.watch()
    window.actionShowCalibration.trigger()
    assert shown(desk) is None
    window.actionShowCalibration.trigger()
    assert shown(desk) is not None


def test_a_calibration_of_another_crop_is_refused_with_a_message(desk, tmp_path):
    camera_info.save(barrel(width=640), tmp_path / "wide.yaml")
    desk.program.calibration.load(tmp_path / "wide.yaml")
    assert shown(desk) is None and not desk.window.actionShowCalibration.isChecked()
    assert any("another crop" in text for text in desk.errors)
    (tmp_path / "odd.yaml").write_text("nonsense")
    desk.program.calibration.load(tmp_path / "odd.yaml")
    assert any("odd.yaml" in text for text in desk.errors)


def test_it_is_given_up_where_the_frames_become_another_crop(desk, tmp_path):
    camera_info.save(barrel(), tmp_path / "lens.yaml")
    desk.program.calibration.load(tmp_path / "lens.yaml")
    desk.grabber.write_feature("Height", 120)
    desk.until(lambda: not desk.window.actionShowCalibration.isChecked())
    assert shown(desk) is None
