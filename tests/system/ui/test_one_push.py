"""One-push exposure and white balance as a person asks for them."""

import cv2
import numpy as np
import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QApplication

from grabbergui.core.pixels import Region
from grabbergui.models.light import measure_light


@pytest.fixture
def app(make_app):
    app = make_app()
    app.connect("sim:?width=640&height=480&fps=20&pixel_format=RGB8&exposure=400")
    app.watch()
    QApplication.setActiveWindow(app.window)  # shortcuts are an active window's
    return app


def value(app, name):
    return app.grabber.feature(name).value


def draw(app, *corners):
    """A stroke of the mouse from one pixel of the image to another."""
    canvas = app.window.image.canvas
    start, end = (canvas.frameToView(*corner).toPoint() for corner in corners)
    viewport = canvas.viewport()
    app.qtbot.mousePress(viewport, Qt.LeftButton, pos=start)
    app.qtbot.mouseMove(viewport, pos=(start + end) / 2)
    app.qtbot.mouseMove(viewport, pos=end)
    app.qtbot.mouseRelease(viewport, Qt.LeftButton, pos=end)


def said(app, text):
    return any(text in message for message in app.errors)


def test_a_region_is_drawn_and_exposed_and_undone_in_one_press(app):
    window = app.window
    app.qtbot.keyClick(window.image.canvas, Qt.Key_E, Qt.ShiftModifier)
    assert "brightness counts" in window.image.hintLabel.text()
    draw(app, (50, 50), (250, 200))
    app.until(lambda: window.image.tasks.rows)
    assert window.image.tasks.rows[0].titleLabel.text() == "Exposure on a region"
    assert not window.actionExpose.isEnabled()
    app.until(lambda: said(app, "Exposed: "))
    light = measure_light(app.program.image.frame, Region(50, 50, 200, 150))
    assert light.mean == pytest.approx(0.5, abs=0.05)
    app.until(lambda: not window.image.tasks.rows and window.actionExpose.isEnabled())
    assert window.actionUndo.text() == "&Undo Exposure on a region"
    window.actionUndo.trigger()
    app.until(lambda: value(app, "ExposureTime") == 400)


def test_white_balance_by_the_whole_image_is_the_cameras_own(app):
    app.grabber.write_feature("ExposureTime", 8000.0)
    app.qtbot.keyClick(app.window.image.canvas, Qt.Key_W)
    app.until(lambda: said(app, "White balance set by the camera"))
    assert value(app, "BalanceWhiteAuto") == "Off"


def test_white_balance_on_a_region(app):
    app.grabber.write_feature("ExposureTime", 8000.0)
    app.grabber.write_feature("BalanceRatioSelector", "Red")
    app.grabber.write_feature("BalanceRatio", 1.0)
    app.window.actionBalanceRegion.trigger()
    draw(app, (50, 50), (250, 200))
    app.until(lambda: said(app, "Balanced: red"))
    assert value(app, "BalanceRatio") == pytest.approx(1.6, rel=0.05)


def test_it_can_be_cancelled_and_leaves_everything_as_it_was(app, monkeypatch):
    monkeypatch.setattr("grabbergui.models.one_push.EXPOSURE_TOLERANCE", -1.0)  # never there
    app.window.actionExposeRegion.trigger()
    draw(app, (50, 50), (250, 200))
    app.until(lambda: app.window.image.tasks.rows and app.window.image.tasks.rows[0].textLabel.text())
    app.until(lambda: value(app, "ExposureTime") != 400)
    app.qtbot.mouseClick(app.window.image.tasks.rows[0].cancelButton, Qt.LeftButton)
    app.until(lambda: said(app, "Exposure on a region: cancelled"))
    assert value(app, "ExposureTime") == 400
    assert not app.window.image.tasks.isVisible()


def test_a_region_that_is_too_dark_is_reported(app):
    app.window.actionBalanceRegion.trigger()
    before = value(app, "BalanceRatio")
    draw(app, (50, 50), (250, 200))
    app.until(lambda: said(app, "too dark"))
    assert value(app, "BalanceRatio") == before
    assert not app.window.actionUndo.isEnabled()


def test_only_where_there_is_an_image(app):
    window = app.window
    window.actionStop.trigger()
    app.until(lambda: not window.actionExpose.isEnabled())
    window.actionStart.trigger()
    app.until(window.actionExpose.isEnabled)


def test_closing_the_camera_ends_it(app):
    app.window.actionExposeRegion.trigger()
    draw(app, (50, 50), (250, 200))
    app.until(lambda: app.window.image.tasks.rows)
    app.program.open_sources.close_current()
    app.until(lambda: not app.window.image.tasks.rows)


def test_not_for_a_recording(app, tmp_path):
    folder = tmp_path / "recording"
    folder.mkdir()
    for index in range(3):
        cv2.imwrite(str(folder / f"{index}.png"), np.full((48, 64), 40 * index, np.uint8))
    app.until(app.window.actionExpose.isEnabled)
    app.connect(f"file:{folder}")
    app.until(lambda: not app.window.actionExpose.isEnabled())
    app.until(lambda: app.window.actionStop.isEnabled())
    app.qtbot.wait(200)
    for name in ("actionExpose", "actionBalance", "actionExposeRegion", "actionBalanceRegion"):
        assert not getattr(app.window, name).isEnabled()
    assert "neither exposure time nor gain" in app.window.actionExpose.toolTip()
    assert "no white balance" in app.window.actionBalanceRegion.toolTip()
    assert app.window.menuView.toolTipsVisible()
