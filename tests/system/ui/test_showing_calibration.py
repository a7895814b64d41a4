"""A calibration is loaded, and the image shown without the lens's distortion."""

from dataclasses import replace

import numpy as np
import pytest

from grabbergui.calibration import camera_info
from grabbergui.core.calibration import Calibration
from grabbergui.core.image_geometry import ImageGeometry


@pytest.fixture
def app(make_app):
    app = make_app()
    app.connect("sim:?width=320&height=240&fps=15")
    app.watch()
    return app


def barrel(width=320, height=240, **more):
    matrix = np.array([[260.0, 0, width / 2], [0, 260.0, height / 2], [0, 0, 1]])
    return Calibration(width, height, matrix, np.array([-0.3, 0.08, 0, 0, 0]), **more)


def shown(app):
    """The calibration with which the newest image is shown undistorted."""
    return app.program.image.latest.calibration


def load(app, path, calibration):
    camera_info.save(calibration, path)
    app.program.image_controls.calibration.load(path)


def test_a_calibration_is_loaded_shown_and_put_away(app, tmp_path):
    window = app.window
    assert window.actionLoadCalibration.isEnabled() and not window.actionShowCalibration.isEnabled()
    load(app, tmp_path / "lens.yaml", barrel())
    assert window.actionShowCalibration.isChecked()
    app.until(lambda: shown(app) is not None)
    assert np.allclose(shown(app).distortion, barrel().distortion)
    assert any("undistorted" in text for text in app.errors)
    app.watch()
    window.actionShowCalibration.trigger()
    app.until(lambda: shown(app) is None)
    window.actionShowCalibration.trigger()
    app.until(lambda: shown(app) is not None)


def test_a_calibration_of_another_crop_is_refused_with_a_message(app, tmp_path):
    load(app, tmp_path / "wide.yaml", barrel(width=640, geometry=ImageGeometry((640, 240))))
    app.until(lambda: any("another crop" in text for text in app.errors))
    assert not app.window.actionShowCalibration.isChecked() and shown(app) is None
    (tmp_path / "odd.yaml").write_text("nonsense")
    app.program.image_controls.calibration.load(tmp_path / "odd.yaml")
    assert any("odd.yaml" in text for text in app.errors)


def test_a_calibration_of_another_camera_is_shown_with_a_message(app, tmp_path):
    mine = app.grabber.info
    load(app, tmp_path / "lens.yaml", barrel().made_with(mine))
    assert not any("another camera" in text for text in app.errors)
    load(app, tmp_path / "lens.yaml", barrel().made_with(replace(mine, serial="4711")))
    app.until(lambda: shown(app) is not None)
    assert any(f"another camera, {mine.model} 4711" in text for text in app.errors)


def test_it_follows_binning_and_region(app, tmp_path):
    load(app, tmp_path / "lens.yaml", barrel())
    app.until(lambda: shown(app) is not None)
    column = app.grabber.feature("OffsetX").value + 160
    for name, value in (("BinningHorizontal", 2), ("BinningVertical", 2), ("Width", 160), ("Height", 120)):
        app.grabber.write_feature(name, value)
    app.until(lambda: shown(app) is not None and shown(app).width == 160)
    assert shown(app).matrix[0, 0] == pytest.approx(130), "twice the angle for each pixel"
    app.grabber.write_feature("OffsetX", 700)
    centre = (column + 0.5) / 2 - 0.5 - 700
    app.until(lambda: shown(app) is not None and shown(app).matrix[0, 2] == pytest.approx(centre))
    assert app.window.actionShowCalibration.isChecked()
