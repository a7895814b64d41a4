"""A calibration is loaded, and the image shown without the lens's distortion."""

from dataclasses import replace

import numpy as np
import pytest

from grabbergui.calibration import camera_info
from grabbergui.core.calibration import Calibration


@pytest.fixture
def app(make_app):
    app = make_app()
    app.connect("sim:?width=320&height=240&fps=15")
    app.watch()
    return app


def barrel(width=320, height=240):
    matrix = np.array([[260.0, 0, width / 2], [0, 260.0, height / 2], [0, 0, 1]])
    return Calibration(width, height, matrix, np.array([-0.3, 0.08, 0, 0, 0]))


def shown(app):
    return app.program.image.settings.calibration


def test_a_calibration_is_loaded_shown_and_put_away(app, tmp_path):
    window = app.window
    assert window.actionLoadCalibration.isEnabled() and not window.actionShowCalibration.isEnabled()
    camera_info.save(barrel(), tmp_path / "lens.yaml")
    app.program.calibration.load(tmp_path / "lens.yaml")
    assert window.actionShowCalibration.isChecked()
    assert np.allclose(shown(app).distortion, barrel().distortion)
    assert any("undistorted" in text for text in app.errors)
    app.watch()
    window.actionShowCalibration.trigger()
    assert shown(app) is None
    window.actionShowCalibration.trigger()
    assert shown(app) is not None


def test_a_calibration_of_another_crop_is_refused_with_a_message(app, tmp_path):
    camera_info.save(barrel(width=640), tmp_path / "wide.yaml")
    app.program.calibration.load(tmp_path / "wide.yaml")
    assert shown(app) is None and not app.window.actionShowCalibration.isChecked()
    assert any("another crop" in text for text in app.errors)
    (tmp_path / "odd.yaml").write_text("nonsense")
    app.program.calibration.load(tmp_path / "odd.yaml")
    assert any("odd.yaml" in text for text in app.errors)


def test_a_calibration_of_another_camera_is_shown_with_a_message(app, tmp_path):
    mine = app.grabber.info
    camera_info.save(barrel().made_with(mine), tmp_path / "lens.yaml")
    app.program.calibration.load(tmp_path / "lens.yaml")
    assert not any("another camera" in text for text in app.errors)
    camera_info.save(barrel().made_with(replace(mine, serial="4711")), tmp_path / "lens.yaml")
    app.program.calibration.load(tmp_path / "lens.yaml")
    assert shown(app) is not None
    assert any(f"another camera, {mine.model} 4711" in text for text in app.errors)


def test_it_is_given_up_where_the_frames_become_another_crop(app, tmp_path):
    camera_info.save(barrel(), tmp_path / "lens.yaml")
    app.program.calibration.load(tmp_path / "lens.yaml")
    app.grabber.write_feature("Height", 120)
    app.until(lambda: not app.window.actionShowCalibration.isChecked())
    assert shown(app) is None
