"""All components of a frame side by side: each with its own colours, looked at together."""

from contextlib import ExitStack

import pytest
from PyQt5.QtCore import QEvent, QPoint, QPointF, Qt
from PyQt5.QtGui import QMouseEvent, QWheelEvent
from PyQt5.QtWidgets import QApplication, QWidget

from grabbergui import sources
from grabbergui.core.pixels import Region
from grabbergui.models.image.components import MOST_BESIDE, beside
from grabbergui.models.image.orientation import scaled_region
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.name_server import NameServer
from grabbergui.net.yarp.server import YarpGrabberServer
from grabbergui.ui.theme import Theme, dress
from grabbergui.ui.widgets.component_pane import _PAD, PaneCaption, columns_for


def send_components(grabber, *names):
    for name in names:
        grabber.write_feature("ComponentSelector", name)
        grabber.write_feature("ComponentEnable", True)


@pytest.fixture
def app(make_app):
    app = make_app()
    app.connect("sim:?width=320&height=240")
    send_components(app.grabber, "Range", "Confidence")
    image = app.window.image
    app.until(lambda: image.componentTabs.count() == 3)
    image.sideBySideBox.click()
    app.until(lambda: set(image.paneArea.panes) == {"Range", "Confidence"})
    app.settled(lambda: [each.geometry() for each in (image.canvas, *image.paneArea.panes.values())])
    return app


def send_mouse(widget, kind, place, button=Qt.NoButton):
    held = Qt.NoButton if kind == QEvent.MouseButtonRelease else button
    QApplication.sendEvent(widget.viewport(), QMouseEvent(kind, place, button, held, Qt.NoModifier))


def middle(widget):
    return QPointF(widget.width() / 2, widget.height() / 2)


def test_every_component_has_its_name_its_scale_and_a_place_of_its_own(app):
    area, canvas = app.window.image.paneArea, app.window.image.canvas
    panes = area.panes
    app.until(lambda: panes["Range"].scaleBar.scale is not None)
    assert panes["Range"].scaleBar.scale.unit == "mm" and panes["Confidence"].scaleBar.scale is None
    assert panes["Range"].caption.text.startswith("Range")
    assert area.caption.text.startswith("Intensity")
    places = [canvas.geometry(), *(pane.geometry() for pane in panes.values())]
    assert all(area.rect().contains(place) for place in places)
    assert not any(a.intersects(b) for a in places for b in places if a is not b)
    assert panes["Range"].accessibleName() == "Range"


def test_a_click_chooses_a_component_and_every_component_keeps_its_place_and_colours(app):
    image = app.window.image
    area, settings = image.paneArea, app.program.image
    colours = {action.data(): action for action in app.window.menuColours.actions()}
    colours["Inferno"].trigger()
    was, range_place = image.canvas.geometry(), area.panes["Range"].geometry()

    pane = area.panes["Range"]
    send_mouse(pane, QEvent.MouseButtonPress, middle(pane), Qt.LeftButton)
    send_mouse(pane, QEvent.MouseButtonRelease, middle(pane), Qt.LeftButton)
    app.until(lambda: set(area.panes) == {"Intensity", "Confidence"})
    assert image.componentTabs.currentIndex() == 1
    app.until(lambda: image.canvas.geometry() == range_place)
    app.until(lambda: area.panes["Intensity"].geometry() == was)
    assert colours[""].isChecked() and settings.settings.colour_map == ""
    assert settings.settings.of_other("Intensity").colour_map == "Inferno"

    colours["Viridis"].trigger()
    app.until(lambda: settings.latest.quantity is not None)
    app.until(lambda: settings.latest.quantity.scale.colour_map == "Viridis")
    image.componentTabs.setCurrentIndex(0)
    app.until(lambda: settings.latest.label == "Intensity" and settings.latest.others)
    assert colours["Inferno"].isChecked()
    others = {other.label: other for other in settings.latest.others}
    assert others["Range"].quantity.scale.colour_map == "Viridis"


def test_zoom_and_position_are_common_to_all(app):
    image = app.window.image
    canvas, pane = image.canvas, image.paneArea.panes["Confidence"]

    def wheel(widget):
        place = middle(widget)
        event = QWheelEvent(
            place, widget.mapToGlobal(place.toPoint()), QPoint(), QPoint(0, 240), Qt.NoButton,
            Qt.NoModifier, Qt.NoScrollPhase, False,
        )  # fmt: skip
        QApplication.sendEvent(widget.viewport(), event)

    def agree():
        seen = canvas.seen
        views = [other._box.viewRect() for other in image.paneArea.panes.values()]
        return all(abs(view.width() / 320 - seen.width()) < 0.02 for view in views) and all(
            abs(view.center().x() / 320 - seen.center().x()) < 0.02 for view in views
        )

    assert agree()
    whole = canvas.seen.width()
    wheel(pane)
    app.until(lambda: canvas.seen.width() < 0.9 * whole and agree())
    closer = canvas.seen.width()
    wheel(canvas)
    app.until(lambda: canvas.seen.width() < 0.95 * closer and agree())
    latest = app.program.image
    app.until(lambda: latest.latest.image.region.width < 320)
    app.until(lambda: all(other.image.region.width < 320 for other in latest.latest.others))
    app.window.actionFit.trigger()
    app.until(lambda: canvas.fitted and agree())


def test_the_values_under_the_cursor_are_shown_in_all_and_marked_in_the_others(app):
    image = app.window.image
    panes, canvas = image.paneArea.panes, image.canvas
    pane = panes["Confidence"]
    send_mouse(pane, QEvent.MouseMove, middle(pane))
    app.until(lambda: " mm" in panes["Range"].caption.text)
    assert image.cursorLabel.text().startswith("x 1")
    assert any(digit in image.paneArea.caption.text for digit in "0123456789")
    assert panes["Range"].mark.isVisible() and not pane.mark.isVisible()
    x, y = canvas.cursorPixel
    assert abs(x - 160) <= 2 and abs(y - 120) <= 2

    QApplication.sendEvent(pane, QEvent(QEvent.Leave))
    app.until(lambda: image.cursorLabel.text() == "" and image.paneArea.caption.text == "Intensity")
    assert not panes["Range"].mark.isVisible()


def test_a_caption_is_whole_where_the_pane_is_wide_enough(qtbot):
    parent = QWidget()
    qtbot.addWidget(parent)
    parent.resize(400, 300)
    caption, cut = PaneCaption(parent), []
    for value in range(100):
        caption.setParts("Range", f"{7 * value / 3:.1f} mm", f"{value} – 1300 mm")
        room = caption.width() - 2 * _PAD
        elided = [
            caption.fontMetrics().elidedText(line, Qt.ElideRight, room) for line in caption.text.split("\n")
        ]
        cut += [line for line in elided if not line.endswith("mm")]
    assert not cut


def test_one_image_again_leaves_nothing_behind(app):
    image = app.window.image
    before = app.program.image
    image.sideBySideBox.click()
    app.until(lambda: not image.paneArea.panes and not before.latest.others)
    assert not image.paneArea.caption.isVisible()
    app.until(lambda: image.canvas.size() == image.paneArea.size())

    image.sideBySideBox.click()
    app.until(lambda: len(image.paneArea.panes) == 2)
    app.connect("sim:colour?width=320&height=240")
    app.until(lambda: not image.paneArea.panes)
    assert before.settings.appearances == {} and image.sideBySideBox.isChecked()


@pytest.mark.parametrize("theme", [Theme.LIGHT, Theme.DARK])
def test_in_a_small_window_the_scale_is_text_and_the_images_are_seen(app, qapp, theme):
    app.window.resize(800, 600)
    dress(qapp, theme)
    try:
        image = app.window.image
        area = image.paneArea
        app.until(lambda: app.window.width() == 800)
        app.until(lambda: area.panes["Range"].scaleBar.scale is not None)
        panes = *area.panes.values(), image.canvas
        app.until(lambda: all(pane.width() >= 60 and pane.height() >= 40 for pane in panes))
        app.until(lambda: all(area.rect().contains(pane.geometry()) for pane in panes))
        pane = area.panes["Range"]
        app.until(lambda: pane.scaleBar.isVisible() != ("mm" in pane.caption.text))
    finally:
        dress(qapp, Theme.AUTO)


def test_panes_are_arranged_so_that_the_images_are_largest():
    assert columns_for(1, 800, 600, 4 / 3) == 1
    assert columns_for(2, 1600, 600, 4 / 3) == 2
    assert columns_for(2, 600, 1200, 4 / 3) == 1
    assert columns_for(4, 800, 600, 4 / 3) == 2
    assert columns_for(3, 1200, 300, 4 / 3) == 3


def test_the_part_seen_of_a_smaller_component_is_scaled_and_many_are_bounded():
    assert scaled_region(Region(10, 20, 31, 40), (320, 240), (160, 120)) == Region(5, 10, 16, 20)
    assert scaled_region(Region(1, 1, 5, 5), (320, 240), (320, 240)) == Region(1, 1, 5, 5)
    labels = tuple(str(number) for number in range(20))
    assert len(beside(labels, "7")) == MOST_BESIDE - 1 and "7" not in beside(labels, "7")


def test_a_remote_camera_shows_its_components_as_a_local_one(make_app):
    app = make_app()
    with ExitStack() as stack:
        names = NameServer("127.65.0.1", 0)
        names.open()
        stack.callback(names.close)
        camera = sources.create("sim:?width=160&height=120&fps=20")
        camera.open()
        stack.callback(camera.close)
        send_components(camera, "Range")
        address = f"127.65.0.1:{names.port_number}"
        stack.enter_context(YarpGrabberServer(camera, "/side", names=NameClient.find(address)))
        app.connect(f"yarp:/side?nameserver={address}")
        image = app.window.image
        app.until(lambda: image.componentTabs.count() == 2)
        image.componentTabs.setCurrentIndex(1)
        app.until(lambda: image.scaleBar.scale is not None and image.scaleBar.scale.unit == "mm")
        scale = image.scaleBar.scale
        assert scale.low <= 650 and 1200 <= scale.high <= 1400
