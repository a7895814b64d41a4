"""A camera that sends several images in a frame: each can be looked at, distances in millimetres."""

from contextlib import closing

import numpy as np
from PyQt5.QtCore import QEvent, QPointF, Qt
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtWidgets import QApplication

from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige.server import GigeCamera
from grabbergui.models.image.quantities import PolarisedView
from patience import PATIENCE


def send_components(grabber, *names):
    for name in names:
        grabber.write_feature("ComponentSelector", name)
        grabber.write_feature("ComponentEnable", True)


def tabs_of(app):
    tabs = app.window.image.componentTabs
    return [tabs.tabText(index) for index in range(tabs.count())]


def point_at(app, x, y):
    canvas = app.window.image.canvas
    place = QPointF(canvas.frameToView(x + 0.5, y + 0.5))
    event = QMouseEvent(QEvent.MouseMove, place, Qt.NoButton, Qt.NoButton, Qt.NoModifier)
    QApplication.sendEvent(canvas.viewport(), event)


def test_components_are_tabs_and_the_range_is_read_in_millimetres(app):
    app, image = app, app.window.image
    save_points = app.window.actionPointCloud
    assert not save_points.isEnabled() and "start the camera" in save_points.toolTip()
    app.connect()
    for name, value in (("Width", 320), ("Height", 240)):
        app.grabber.write_feature(name, value)
    app.watch(1)
    assert not save_points.isEnabled() and "no range image" in save_points.toolTip()
    assert not image.componentTabs.isVisible() and not image.scaleBar.isVisible()

    send_components(app.grabber, "Range", "Confidence")
    app.until(lambda: tabs_of(app) == ["Intensity", "Range", "Confidence"])
    assert image.componentTabs.isVisible() and image.componentTabs.currentIndex() == 0
    assert not image.scaleBar.isVisible()

    image.componentTabs.setCurrentIndex(1)
    app.until(lambda: image.scaleBar.scale is not None and image.scaleBar.scale.unit == "mm")
    scale = image.scaleBar.scale
    assert scale.low <= 650 and 1200 <= scale.high <= 1400
    assert app.program.image.shown.pixel_format.name == "Coord3D_C16"
    point_at(app, 300, 5)
    app.until(lambda: " mm  (" in image.cursorLabel.text())

    assert save_points.isEnabled() and "no range" not in save_points.toolTip()
    save_points.trigger()
    folder = app.preferences.snapshot_folder
    app.until(lambda: [path for path in folder.glob("*.ply") if path.stat().st_size > 1000])

    image.componentTabs.setCurrentIndex(2)
    app.until(lambda: image.scaleBar.scale is None)
    assert app.program.image.shown.pixel_format.name == "Confidence8"

    send = app.grabber.write_feature
    for name in ("Range", "Confidence"):
        send("ComponentSelector", name)
        send("ComponentEnable", False)
    app.until(lambda: tabs_of(app) == [])
    assert not image.componentTabs.isVisible()
    assert app.program.image.shown.pixel_format.name == "Mono8"


def test_a_polarised_mosaic_is_shown_as_its_degree_and_another_camera_as_it_is_sent(app):
    app, window = app, app.window
    app.connect()
    degree = next(a for a in window.menuPolarised.actions() if a.data() is PolarisedView.DEGREE)
    assert not degree.isEnabled(), "nothing says that the sensor is polarised"
    window.actionPolarised.trigger()
    degree.trigger()
    app.until(lambda: window.image.scaleBar.scale is not None)
    assert (window.image.scaleBar.scale.low, window.image.scaleBar.scale.high) == (0.0, 1.0)

    app.connect("sim:colour")
    app.until(lambda: window.image.scaleBar.scale is None)
    app.until(lambda: not window.actionPolarised.isChecked())
    assert not degree.isChecked() and not degree.isEnabled()
    assert app.program.image.settings.polarised is PolarisedView.MOSAIC


def test_the_point_cloud_is_drawn_and_turned_in_a_window_of_its_own(app):
    app, points = app, app.program.image_controls.points
    app.connect("sim:?width=160&height=120")
    app.window.actionShowPoints.trigger()
    app.until(lambda: "no range image" in points.dialog.view.problem)

    send_components(app.grabber, "Range")
    app.until(lambda: points.model.image is not None and not points.dialog.view.problem)
    before = points.model.image.pixels
    assert len(np.unique(before.reshape(-1, 3), axis=0)) > 10
    points.dialog.view.turned.emit(60.0, 20.0)
    app.until(lambda: not np.array_equal(points.model.image.pixels, before))
    points.dialog.close()
    app.until(lambda: points.model.stop(0.1))


def test_the_channels_of_a_camera_are_tabs_and_not_one_image_that_alternates(app):
    app = app
    small = {reg.WIDTH: 256, reg.HEIGHT: 128, reg.FRAME_RATE: 20.0}
    with closing(GigeCamera("127.65.0.7", power_on=small)):
        app.connect("gige:127.65.0.7?stream_channel=all")
        app.until(lambda: tabs_of(app) == ["Intensity, source 0", "Intensity, source 1"])
        shown = []
        app.program.image.ready.connect(lambda: shown.append(app.program.image.latest.frame.stream_channel))
        app.watch(8)
        assert set(shown) == {0}
        app.program.open_sources.close_all()
        assert app.program.open_sources.wait_closed(PATIENCE)
