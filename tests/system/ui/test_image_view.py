"""The image: fit, 1:1, zoom about the cursor, sharp pixels, and the value under the cursor."""

import time

import numpy as np
import pytest
from PyQt5.QtCore import QEvent, QPoint, QPointF, Qt
from PyQt5.QtGui import QImage, QMouseEvent, QPainter, QWheelEvent
from PyQt5.QtWidgets import QApplication

from grabbergui.core.pixels import DisplayImage, Region
from grabbergui.models.image.live_image import PAINT_WAIT
from grabbergui.models.image.pixel_text import TintedPart
from grabbergui.models.open_source import LinkState
from grabbergui.ui.views.image_view import ImageView
from grabbergui.ui.widgets.drawing_tool import Purpose
from grabbergui.ui.widgets.image_overlays import PixelValues

WIDTH, HEIGHT = 1600, 1200


@pytest.fixture
def view(qtbot):
    view = ImageView()
    qtbot.addWidget(view)
    view.resize(800, 640)
    view.show()
    qtbot.waitExposed(view)
    return view


def whole(width=WIDTH, height=HEIGHT, scale=4):
    pixels = np.zeros((height // scale, width // scale), np.uint8)
    return DisplayImage(pixels, Region(0, 0, width, height))


def shown(view):
    """The image's place on the widget: left, top, right, bottom."""
    first, last = view.canvas.frameToView(0, 0), view.canvas.frameToView(WIDTH, HEIGHT)
    return first.x(), first.y(), last.x(), last.y()


def test_an_image_is_fitted_whole_and_its_proportions_are_kept(view):
    view.setImage(whole(), WIDTH, HEIGHT)
    left, top, right, bottom = shown(view)
    assert left >= -1 and top >= -1
    assert right <= view.canvas.width() + 1 and bottom <= view.canvas.height() + 1
    assert (right - left) / (bottom - top) == pytest.approx(WIDTH / HEIGHT, rel=0.01)
    assert max((right - left) / view.canvas.width(), (bottom - top) / view.canvas.height()) > 0.99
    assert view.canvas.fitted


def test_it_stays_fitted_when_the_window_changes_its_size(view, qtbot):
    view.setImage(whole(), WIDTH, HEIGHT)
    view.resize(500, 700)
    qtbot.waitUntil(lambda: view.canvas.width() == 500)
    left, _, right, _ = shown(view)
    assert (left, right) == (pytest.approx(0, abs=1.5), pytest.approx(500, abs=1.5))


def test_one_to_one_shows_a_screen_pixel_for_each_of_the_frame(view, qtbot):
    asked = []
    view.setImage(whole(), WIDTH, HEIGHT)
    view.viewChanged.connect(lambda region, size: asked.append((region, size)))
    view.canvas.oneToOne()
    assert view.canvas.zoom == pytest.approx(1.0, abs=1e-6)
    region, size = asked[-1]
    assert size == (region.width, region.height)
    assert region.width == pytest.approx(view.canvas.width(), abs=2)
    assert not view.canvas.fitted


def test_at_one_to_one_the_screen_shows_the_very_pixels(view, qtbot):
    view.setImage(whole(), WIDTH, HEIGHT)
    asked = []
    view.viewChanged.connect(lambda region, size: asked.append(region))
    view.canvas.oneToOne()
    region = asked[-1].clipped(WIDTH, HEIGHT)
    pixels = np.random.default_rng(3).integers(0, 256, (region.height, region.width), np.uint8)
    view.setImage(DisplayImage(pixels, region), WIDTH, HEIGHT)
    image = view.canvas.grab().toImage()
    corner = view.canvas.frameToView(region.x, region.y)
    for x, y in ((0, 0), (100, 50), (301, 203), (region.width - 2, region.height - 2)):
        at = QPoint(round(corner.x()) + x, round(corner.y()) + y)
        assert image.pixelColor(at).red() == pixels[y, x]


def test_enlarged_pixels_are_sharp_squares(view):
    view.setImage(whole(), WIDTH, HEIGHT)
    asked = []
    view.viewChanged.connect(lambda region, size: asked.append(region))
    view.canvas.zoomBy(16 / view.canvas.zoom)
    region = asked[-1].clipped(WIDTH, HEIGHT)
    board = (np.indices((region.height, region.width)).sum(axis=0) % 2 * 255).astype(np.uint8)
    view.setImage(DisplayImage(board, region), WIDTH, HEIGHT)
    image = view.canvas.grab().toImage()
    values = {image.pixelColor(x, 300).red() for x in range(100, 700)}
    assert values == {0, 255}


def test_the_wheel_zooms_about_the_cursor_and_lets_go_of_the_fit(view, qtbot):
    view.setImage(whole(), WIDTH, HEIGHT)
    at = view.canvas.frameToView(400, 300)
    zoom = view.canvas.zoom
    event = QWheelEvent(
        at, QPointF(view.canvas.mapToGlobal(at.toPoint())), QPoint(), QPoint(0, 240), Qt.NoButton,
        Qt.NoModifier, Qt.NoScrollPhase, False,
    )  # fmt: skip
    QApplication.sendEvent(view.canvas.viewport(), event)
    assert view.canvas.zoom > zoom * 1.05
    assert not view.canvas.fitted
    after = view.canvas.frameToView(400, 300)
    assert (after.x(), after.y()) == (pytest.approx(at.x(), abs=2), pytest.approx(at.y(), abs=2))


def test_zoom_has_bounds(view):
    view.setImage(whole(), WIDTH, HEIGHT)
    for _ in range(40):
        view.canvas.zoomBy(2)
    assert view.canvas.zoom <= 64.5
    for _ in range(40):
        view.canvas.zoomBy(0.5)
    assert view.canvas.zoom > 0.05


@pytest.mark.parametrize("ratio", [1.0, 1.5, 2.0, 3.0])
def test_pixels_become_large_enough_for_their_values_on_every_screen(app, monkeypatch, ratio):
    canvas = app.window.image.canvas
    monkeypatch.setattr(canvas, "devicePixelRatioF", lambda: ratio)
    app.connect("sim:?width=320&height=240")
    app.watch()
    canvas.zoomBy(1000)
    app.until(lambda: canvas.values.texts)


def test_painted_is_emitted_once_for_each_image(view, qtbot):
    reported = []
    view.painted.connect(lambda: reported.append(1))
    for number in range(1, 4):
        view.setImage(whole(), WIDTH, HEIGHT)
        qtbot.waitUntil(lambda number=number: len(reported) == number)
    view.canvas.viewport().repaint()
    assert len(reported) == 3


@pytest.mark.parametrize("purpose", Purpose)
@pytest.mark.parametrize("width", [382, 638, 1000])
def test_a_hint_says_how_to_cancel_however_narrow_the_window_is(view, qtbot, purpose, width):
    view.resize(width, 640)
    view.setCursorText([TintedPart("x 1523  y 1044   R 254  G 254  B 253   " * 3)])
    view.draw(purpose)
    qtbot.waitUntil(lambda: view.readout.width() <= width and "Esc cancels." in view.hintLabel.shown)
    assert view.cursorLabel.isVisible() and view.paneArea.geometry().contains(view.readout.geometry())
    if width == 1000:
        assert view.hintLabel.shown == view.hintLabel.text()


def test_the_value_under_the_cursor_is_the_sensors(app):
    app.connect()
    app.watch()
    app.window.actionStop.trigger()
    app.until(lambda: app.program.open_sources.state is LinkState.OPEN)
    view, frame = app.window.image, app.program.image.frame
    view.canvas.zoomBy(8 / view.canvas.zoom)
    middle_x, middle_y = frame.width // 2, frame.height // 2
    for x, y in ((middle_x, middle_y), (middle_x - 31, middle_y + 12), (middle_x + 17, middle_y - 25)):
        at = view.canvas.frameToView(x + 0.5, y + 0.5)
        move = QMouseEvent(QEvent.MouseMove, at, Qt.NoButton, Qt.NoButton, Qt.NoModifier)
        QApplication.sendEvent(view.canvas.viewport(), move)
        app.until(lambda x=x, y=y: f"x {x}  y {y} " in view.cursorLabel.text())
        assert view.cursorLabel.text().split()[-1] == str(frame.raw()[y, x])
    QApplication.sendEvent(view.canvas, QEvent(QEvent.Leave))
    assert view.cursorLabel.text() == ""


def test_zoomed_in_only_the_visible_part_is_converted(app):
    app.connect()
    app.watch()
    app.window.image.canvas.zoomBy(10)
    app.watch(3)
    taken = app.window.image.canvas._item._target
    frame = app.program.image.frame
    assert taken.width() < frame.width / 2


@pytest.mark.parametrize("zoom", [40, 64])
@pytest.mark.parametrize("text", ["255", "1234.5\nmm", "0.000123457", "4095\n4095\n4095\n4095", "-1234.57"])
def test_the_value_on_a_pixel_leaves_its_neighbours_theirs(qtbot, text, zoom):
    values = PixelValues()
    lines = tuple(map(TintedPart, text.split("\n")))
    values.setTexts({(x, y): lines for x in range(3) for y in range(3)})
    image = QImage(3 * zoom, 3 * zoom, QImage.Format_RGB32)
    image.fill(Qt.white)
    painter = QPainter(image)
    painter.scale(zoom, zoom)
    values.paint(painter, None)
    painter.end()
    drawn = image.pixelColor(zoom + zoom // 2, zoom + zoom // 2) != Qt.white
    assert drawn or (zoom == 40 and len(text) > 10)
    between = [zoom, 2 * zoom]
    assert all(image.pixelColor(x, y) == Qt.white for x in between for y in range(3 * zoom))
    assert all(image.pixelColor(x, y) == Qt.white for y in between for x in range(3 * zoom))


def hover(view, x, y):
    """Move the mouse to a place of the widget."""
    at = QPointF(x, y)
    move = QMouseEvent(QEvent.MouseMove, at, Qt.NoButton, Qt.NoButton, Qt.NoModifier)
    QApplication.sendEvent(view.canvas.viewport(), move)


def pixel_at(view, x, y):
    point = view.canvas.viewToFrame(QPointF(x, y))
    return int(point.x()), int(point.y())


@pytest.mark.parametrize("act", ["oneToOne", "fit", "zoomBy", "size", "resize"])
def test_the_readout_is_that_of_the_pixel_under_a_mouse_that_rests(view, act):
    view.setImage(whole(), WIDTH, HEIGHT)
    if act == "fit":
        view.canvas.zoomBy(4)
    hover(view, 200, 300)
    before = view.canvas.cursorPixel
    assert before == pixel_at(view, 200, 300)
    if act == "size":
        view.setImage(whole(1200, 1600), 1200, 1600)
    elif act == "resize":
        view.resize(600, 640)
    else:
        getattr(view.canvas, act)(*[4.0] * (act == "zoomBy"))
    assert view.canvas.cursorPixel == pixel_at(view, 200, 300) != before
    QApplication.sendEvent(view.canvas, QEvent(QEvent.Leave))
    view.canvas.fit()
    assert view.canvas.cursorPixel is None


def test_the_readout_follows_the_mouse_while_something_is_drawn(view, qtbot):
    view.setImage(whole(), WIDTH, HEIGHT)
    view.drawing.begin(Purpose.PROFILE_LINE)
    target = view.canvas.viewport()
    qtbot.mousePress(target, Qt.LeftButton, pos=QPoint(200, 200))
    hover(view, 300, 250)
    assert view.canvas.cursorPixel == pixel_at(view, 300, 250)
    qtbot.mouseRelease(target, Qt.LeftButton, pos=QPoint(320, 260))
    assert view.canvas.cursorPixel == pixel_at(view, 320, 260)


def test_an_image_of_another_size_is_in_sight_at_the_same_zoom(view):
    view.setImage(whole(), WIDTH, HEIGHT)
    view.canvas.zoomBy(8)
    view.canvas.centreOn(QPointF(0.95, 0.1))
    zoom = view.canvas.zoom
    view.setImage(whole(320, 240, 1), 320, 240)
    centre = view.canvas.seen.center()
    assert (centre.x(), centre.y()) == pytest.approx((0.95, 0.1), abs=0.01)
    assert view.canvas.zoom == pytest.approx(zoom)


@pytest.mark.parametrize(
    ("turn", "back"),
    [("TurnRight", "TurnLeft"), ("TurnLeft", "TurnRight"), ("MirrorX", "MirrorX"), ("MirrorY", "MirrorY")],
)
def test_what_is_in_the_middle_stays_there_when_the_image_is_turned_or_mirrored(app, turn, back):
    canvas, image = app.window.image.canvas, app.program.image
    app.connect("sim:?width=640&height=480")
    app.watch()
    canvas.zoomBy(8)
    canvas.centreOn(QPointF(0.8, 0.1))

    def middle():
        centre, (width, height) = canvas.seen.center(), canvas.imageSize
        frame = image.frame
        x, y = int(centre.x() * width), int(centre.y() * height)
        return image.settings.orientation.pixel(x, y, frame.width, frame.height)

    before, size = middle(), canvas.imageSize
    turned = size[::-1] if turn.startswith("Turn") else size
    for action in (turn, back):
        getattr(app.window, f"action{action}").trigger()
        wanted = turned if action == turn else size
        app.until(lambda wanted=wanted: canvas.imageSize == wanted)
        assert np.abs(np.subtract(middle(), before)).max() <= 3


def test_a_minimised_window_converts_few_frames_and_shows_the_newest_when_it_is_back(app):
    window, image = app.window, app.program.image
    app.connect("sim:?width=64&height=48&fps=60")
    app.watch()
    window.showMinimized()
    app.until(window.isMinimized)
    converted, received, begun = image.converted, image.received, time.monotonic()
    app.until(lambda: image.received >= received + 90)
    assert image.converted - converted <= (time.monotonic() - begun) / PAINT_WAIT + 2
    app.program.opener.stream.stop()
    app.until(lambda: app.program.open_sources.state is LinkState.OPEN)
    painted = []
    window.image.painted.connect(lambda: painted.append(1))
    window.showNormal()
    app.until(lambda: painted)


def test_the_menu_on_the_image_has_what_concerns_it_and_copies_what_is_shown(app):
    app.connect("sim:?width=64&height=48&fps=15")
    app.watch()
    window, canvas = app.window, app.window.image.canvas
    assert canvas.contextMenuPolicy() == Qt.ActionsContextMenu
    offered = canvas.actions()
    for action in (window.actionFit, window.actionOneToOne, window.actionSnapshot, window.actionRegion,
                   window.menuOrientation.menuAction()):  # fmt: skip
        assert action in offered
    window.actionCopyImage.trigger()
    copied = QApplication.clipboard().image()
    assert copied.width() / copied.height() == pytest.approx(64 / 48, rel=0.02)
    assert copied.width() > canvas.width() / 2
