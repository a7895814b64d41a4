"""The camera's region on the image: handles move and enlarge it, in the camera's steps."""

import threading

import pytest
from PyQt5.QtCore import QEvent, QPointF, Qt
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtWidgets import QApplication

from grabbergui.core.pixels import Region
from grabbergui.models.features import sensor_region


@pytest.fixture
def app(make_app):
    app = make_app()
    app.connect("sim:?fps=20")
    app.until(app.window.actionRegion.isEnabled)
    app.watch()
    return app


def region(app):
    return sensor_region.place_of(app.grabber)[0]


def drag(app, start, end):
    """Drag the left mouse button between two places of the sensor."""
    tool, canvas = app.window.image.regionTool, app.window.image.canvas
    shown = app.program.image.frame
    places = [canvas.frameToView(x - shown.offset_x, y - shown.offset_y) for x, y in (start, end)]
    left, none = Qt.LeftButton, Qt.NoButton
    for kind, place, button, held in (
        (QEvent.MouseButtonPress, places[0], left, left),
        (QEvent.MouseMove, (places[0] + places[1]) / 2, none, left),
        (QEvent.MouseMove, places[1], none, left),
        (QEvent.MouseButtonRelease, places[1], left, none),
    ):
        event = QMouseEvent(kind, QPointF(place.toPoint()), button, held, Qt.NoModifier)
        QApplication.sendEvent(canvas.viewport(), event)
    return tool.region


def test_a_part_of_the_sensor_is_moved_enlarged_and_undone(app):
    window, tool = app.window, app.window.image.regionTool
    sensor_region.apply_on_sensor(app.grabber, Region(400, 300, 400, 320))
    app.until(lambda: (app.program.image.frame.width, app.program.image.frame.offset_x) == (400, 400))
    before = region(app)
    window.actionRegion.trigger()
    app.until(lambda: tool.active)
    assert "handles" in window.image.hintLabel.text()
    app.until(lambda: window.image.canvas.seen.width() > 1)
    moved = drag(app, (600, 460), (700, 420))
    assert (moved.width, moved.height) == (before.width, before.height)
    assert moved.x == pytest.approx(500, abs=16) and moved.y == pytest.approx(260, abs=8)
    app.until(lambda: region(app) == moved)
    app.until(lambda: app.program.image.frame.offset_x == moved.x and tool._frame == moved)
    larger = drag(app, (moved.right, moved.bottom), (moved.right + 160, moved.bottom + 96))
    assert larger.width == pytest.approx(560, abs=16) and larger.height == pytest.approx(416, abs=8)
    app.until(lambda: region(app) == larger)
    app.qtbot.keyClick(window.image.canvas, Qt.Key_Escape)
    assert not tool.active and window.image.canvas.fitted and not window.image.hintLabel.text()
    window.actionUndo.trigger()
    app.until(lambda: region(app) == moved)


def test_of_the_whole_sensor_a_part_is_drawn_and_nothing_has_handles(app):
    sensor_region.apply_full(app.grabber)
    app.until(lambda: app.program.image.frame.offset_x == 0)
    done = threading.Event()
    app.window.actionRegion.trigger()
    app.program.open_sources.current.worker.submit(done.set)
    app.until(done.is_set)
    QApplication.processEvents()
    assert app.window.image.drawing.purpose is not None and not app.window.image.regionTool.active


@pytest.mark.parametrize("turns", [1, 2])
def test_a_turned_image_is_dragged_as_it_is_seen(app, turns):
    window, tool = app.window, app.window.image.regionTool
    sensor_region.apply_on_sensor(app.grabber, Region(400, 300, 400, 320))
    for _ in range(turns):
        window.actionTurnRight.trigger()
    app.until(lambda: app.program.image.frame.width == 400)
    app.watch()
    window.actionRegion.trigger()
    app.until(lambda: tool.active)
    place = tool._to_view(Region(600, 460, 1, 1)).center()
    at = tool._to_sensor(QPointF(window.image.canvas.frameToView(place.x(), place.y())))
    assert (at.x(), at.y()) == (pytest.approx(600.5, abs=3), pytest.approx(460.5, abs=3))
