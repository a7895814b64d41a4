"""One-push exposure and white balance as a person asks for them."""

import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QApplication

from grabbergui.core.pixels import Region
from grabbergui.models.tuning.run import measure_light


@pytest.fixture
def desk(window_desk):
    window_desk.connect("sim:?width=640&height=480&fps=60&pixel_format=RGB8&exposure=400")
    window_desk.watch()
    QApplication.setActiveWindow(window_desk.window)  # shortcuts are an active window's
    return window_desk


def value(desk, name):
    return desk.grabber.feature(name).value


def draw(desk, *corners):
    """A stroke of the mouse from one pixel of the picture to another."""
    canvas = desk.window.picture.canvas
    start, end = (canvas.frameToView(*corner).toPoint() for corner in corners)
    viewport = canvas.viewport()
    desk.qtbot.mousePress(viewport, Qt.LeftButton, pos=start)
    desk.qtbot.mouseMove(viewport, pos=(start + end) / 2)
    desk.qtbot.mouseMove(viewport, pos=end)
    desk.qtbot.mouseRelease(viewport, Qt.LeftButton, pos=end)


def said(desk, text):
    return any(text in message for message in desk.errors)


def test_a_region_is_drawn_and_exposed_and_undone_in_one_press(desk):
    window = desk.window
    desk.qtbot.keyClick(window.picture.canvas, Qt.Key_E, Qt.ShiftModifier)
    assert "brightness counts" in window.picture.hintLabel.text()
    draw(desk, (50, 50), (250, 200))
    desk.until(lambda: window.picture.tasks.rows)
    assert window.picture.tasks.rows[0].titleLabel.text() == "Exposure on a region"
    assert not window.actionExpose.isEnabled()
    desk.until(lambda: said(desk, "Exposed: "))
    light = measure_light(desk.program.picture.frame, Region(50, 50, 200, 150))
    assert light.mean == pytest.approx(0.5, abs=0.05)
    desk.until(lambda: not window.picture.tasks.rows and window.actionExpose.isEnabled())
    assert window.actionUndo.text() == "&Undo Exposure on a region"
    window.actionUndo.trigger()
    desk.until(lambda: value(desk, "ExposureTime") == 400)


def test_white_balance_by_the_whole_image_is_the_cameras_own(desk):
    desk.grabber.write_feature("ExposureTime", 8000.0)
    desk.qtbot.keyClick(desk.window.picture.canvas, Qt.Key_W)
    desk.until(lambda: said(desk, "White balance set by the camera"))
    assert value(desk, "BalanceWhiteAuto") == "Off"


def test_white_balance_on_a_region(desk):
    desk.grabber.write_feature("ExposureTime", 8000.0)
    desk.grabber.write_feature("BalanceRatioSelector", "Red")
    desk.grabber.write_feature("BalanceRatio", 1.0)
    desk.window.actionBalanceRegion.trigger()
    draw(desk, (50, 50), (250, 200))
    desk.until(lambda: said(desk, "Balanced: red"))
    assert value(desk, "BalanceRatio") == pytest.approx(1.6, rel=0.05)


def test_it_can_be_cancelled_and_leaves_everything_as_it_was(desk, monkeypatch):
    monkeypatch.setattr("grabbergui.models.tuning.one_push.EXPOSURE_TOLERANCE", -1.0)  # never there
    desk.window.actionExposeRegion.trigger()
    draw(desk, (50, 50), (250, 200))
    desk.until(lambda: desk.window.picture.tasks.rows and desk.window.picture.tasks.rows[0].textLabel.text())
    desk.until(lambda: value(desk, "ExposureTime") != 400)
    desk.qtbot.mouseClick(desk.window.picture.tasks.rows[0].cancelButton, Qt.LeftButton)
    desk.until(lambda: said(desk, "Exposure on a region: cancelled"))
    assert value(desk, "ExposureTime") == 400
    assert not desk.window.picture.tasks.isVisible()


def test_a_region_that_is_too_dark_is_reported(desk):
    desk.window.actionBalanceRegion.trigger()
    before = value(desk, "BalanceRatio")
    draw(desk, (50, 50), (250, 200))
    desk.until(lambda: said(desk, "too dark"))
    assert value(desk, "BalanceRatio") == before
    assert not desk.window.actionUndo.isEnabled()


def test_only_where_there_is_an_image(desk):
    window = desk.window
    window.actionStop.trigger()
    desk.until(lambda: not window.actionExpose.isEnabled())
    window.actionStart.trigger()
    desk.until(window.actionExpose.isEnabled)


def test_closing_the_camera_ends_it(desk):
    desk.window.actionExposeRegion.trigger()
    draw(desk, (50, 50), (250, 200))
    desk.until(lambda: desk.window.picture.tasks.rows)
    desk.program.connection.disconnect()
    desk.until(lambda: not desk.window.picture.tasks.rows)
