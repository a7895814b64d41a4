"""A camera that sends several images in a frame: each can be looked at, distances in millimetres."""

from contextlib import closing

import numpy as np
from PyQt5.QtCore import QEvent, QPointF, Qt
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtWidgets import QApplication

from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige.server import GigeCamera
from grabbergui.models.picture.quantities import PolarisedView
from patience import PATIENCE


def send_components(grabber, *names):
    for name in names:
        grabber.write_feature("ComponentSelector", name)
        grabber.write_feature("ComponentEnable", True)


def tabs_of(desk):
    tabs = desk.window.picture.componentTabs
    return [tabs.tabText(index) for index in range(tabs.count())]


def point_at(desk, x, y):
    canvas = desk.window.picture.canvas
    place = QPointF(canvas.frameToView(x + 0.5, y + 0.5))
    event = QMouseEvent(QEvent.MouseMove, place, Qt.NoButton, Qt.NoButton, Qt.NoModifier)
    QApplication.sendEvent(canvas.viewport(), event)


def test_components_are_tabs_and_the_range_is_read_in_millimetres(window_desk):
    desk, picture = window_desk, window_desk.window.picture
    desk.connect("sim:")
    for name, value in (("Width", 320), ("Height", 240)):
        desk.grabber.write_feature(name, value)
    desk.watch(1)
    assert not picture.componentTabs.isVisible() and not picture.scaleBar.isVisible()

    send_components(desk.grabber, "Range", "Confidence")
    desk.until(lambda: tabs_of(desk) == ["Intensity", "Range", "Confidence"])
    assert picture.componentTabs.isVisible() and picture.componentTabs.currentIndex() == 0
    assert not picture.scaleBar.isVisible()

    picture.componentTabs.setCurrentIndex(1)
    desk.until(lambda: picture.scaleBar.scale is not None and picture.scaleBar.scale.unit == "mm")
    scale = picture.scaleBar.scale
    assert scale.low <= 650 and 1200 <= scale.high <= 1400
    assert desk.program.picture.shown.pixel_format.name == "Coord3D_C16"
    point_at(desk, 300, 5)
    desk.until(lambda: " mm  (" in picture.cursorLabel.text())

    desk.window.actionPointCloud.trigger()
    folder = desk.preferences.snapshot_folder
    desk.until(lambda: [path for path in folder.glob("*.ply") if path.stat().st_size > 1000])

    picture.componentTabs.setCurrentIndex(2)
    desk.until(lambda: picture.scaleBar.scale is None)
    assert desk.program.picture.shown.pixel_format.name == "Confidence8"

    send = desk.grabber.write_feature
    for name in ("Range", "Confidence"):
        send("ComponentSelector", name)
        send("ComponentEnable", False)
    desk.until(lambda: tabs_of(desk) == [])
    assert not picture.componentTabs.isVisible()
    assert desk.program.picture.shown.pixel_format.name == "Mono8"


def test_a_polarised_mosaic_is_shown_as_its_degree_and_another_camera_as_it_is_sent(window_desk):
    desk, window = window_desk, window_desk.window
    desk.connect("sim:")
    degree = next(a for a in window.menuPolarised.actions() if a.data() is PolarisedView.DEGREE)
    assert not degree.isEnabled(), "nothing says that the sensor is polarised"
    window.actionPolarised.trigger()
    degree.trigger()
    desk.until(lambda: window.picture.scaleBar.scale is not None)
    assert (window.picture.scaleBar.scale.low, window.picture.scaleBar.scale.high) == (0.0, 1.0)

    desk.connect("sim:colour")
    desk.until(lambda: window.picture.scaleBar.scale is None)
    desk.until(lambda: not window.actionPolarised.isChecked())
    assert not degree.isChecked() and not degree.isEnabled()
    assert desk.program.picture.settings.polarised is PolarisedView.MOSAIC


def test_the_point_cloud_is_drawn_and_turned_in_a_window_of_its_own(window_desk):
    desk, points = window_desk, window_desk.program.points
    desk.connect("sim:?width=160&height=120")
    desk.window.actionShowPoints.trigger()
    desk.until(lambda: "no range image" in points.dialog.view.problem)

    send_components(desk.grabber, "Range")
    desk.until(lambda: points.model.image is not None and not points.dialog.view.problem)
    before = points.model.image.pixels
    assert len(np.unique(before.reshape(-1, 3), axis=0)) > 10
    points.dialog.view.turned.emit(60.0, 20.0)
    desk.until(lambda: not np.array_equal(points.model.image.pixels, before))
    points.dialog.close()
    desk.until(lambda: points.model.stop(0.1))


def test_the_channels_of_a_camera_are_tabs_and_not_one_image_that_alternates(window_desk):
    desk = window_desk
    small = {reg.WIDTH: 256, reg.HEIGHT: 128, reg.FRAME_RATE: 20.0}
    with closing(GigeCamera("127.65.0.7", power_on=small)):
        desk.connect("gige:127.65.0.7?stream_channel=all")
        desk.until(lambda: tabs_of(desk) == ["Intensity, source 0", "Intensity, source 1"])
        shown = []
        desk.program.picture.ready.connect(
            lambda: shown.append(desk.program.picture.latest.frame.stream_channel)
        )
        desk.watch(8)
        assert set(shown) == {0}
        desk.program.connection.close_all()
        assert desk.program.connection.wait_closed(PATIENCE)
