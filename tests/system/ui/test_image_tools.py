"""The tools for seeing, used as a person would, on the simulated camera."""

import logging
import re

import numpy as np
import pytest
from PyQt5.QtCore import QEvent, QPoint, QPointF, QRectF, Qt
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtWidgets import QApplication, QLabel

from grabbergui.core.pixels import Region
from grabbergui.models.open_source import LinkState
from grabbergui.ui.views.help_views import ShortcutsDialog
from grabbergui.ui.widgets.drawing_tool import Purpose
from grabbergui.ui.widgets.image_overlays import Mark, size_text


@pytest.fixture
def app(make_app):
    app = make_app()
    app.connect()
    app.watch()
    return app


def settle(app):
    """Wait until panels that were opened have their place and the image its own."""
    canvas, before = app.window.image.canvas, []

    def settled():
        before.append((canvas.size(), canvas.zoom))
        return len(before) > 5 and len({str(place) for place in before[-5:]}) == 1

    app.until(settled)


def drag(app, first, last):
    """A stroke of the left button between two pixels of the image as it is seen."""
    canvas = app.window.image.canvas
    settle(app)
    start, end = (canvas.frameToView(*point).toPoint() for point in (first, last))
    target = canvas.viewport()
    app.qtbot.mousePress(target, Qt.LeftButton, pos=start)
    app.qtbot.mouseMove(target, (start + end) / 2)
    app.qtbot.mouseMove(target, end)
    app.qtbot.mouseRelease(target, Qt.LeftButton, pos=end)


def screen(app):
    """The image's middle, (lines, bytes of a line); the background round it depends on the panels."""
    canvas = app.window.image.canvas
    image = canvas.grab().toImage().convertToFormat(13)  # RGB888
    aside, above = image.width() // 4, image.height() // 4
    image = image.copy(image.rect().adjusted(aside, above, -aside, -above))
    bits = image.constBits()
    bits.setsize(image.sizeInBytes())
    return (
        np.frombuffer(bits, np.uint8)
        .reshape(image.height(), image.bytesPerLine())[:, : image.width() * 3]
        .copy()
    )


def test_the_histogram_is_measured_only_while_it_is_seen_and_is_of_the_whole_frame(app):
    program, window = app.program, app.window
    assert not program.image_controls.measuring.wanted.anything
    window.histogramDock.show()
    app.until(lambda: window.histogram.plot.values("grey") is not None)
    assert program.image_controls.measuring.wanted.histogram
    total = window.histogram._histogram.channels["grey"].sum()
    assert total == app.grabber.feature("Width").value * app.grabber.feature("Height").value
    assert "Mean grey" in window.histogram.figuresLabel.text()
    linear = window.histogram.plot.values("grey").max()
    window.histogram.logBox.click()
    assert window.histogram.plot.values("grey").max() == pytest.approx(np.log10(linear + 1), rel=0.2)
    window.focusDock.show()
    window.focusDock.raise_()
    app.until(
        lambda: (
            program.image_controls.measuring.wanted.focus
            and not program.image_controls.measuring.wanted.histogram
        )
    )
    window.focusDock.close()
    window.histogramDock.close()
    app.until(lambda: not program.image_controls.measuring.wanted.anything)


def test_a_colour_cameras_histogram_has_three_channels(make_app):
    app = make_app()
    app.connect("sim:?pixel_format=BayerRG12p")
    app.window.histogramDock.show()
    panel = app.window.histogram
    app.until(lambda: panel.plot.values("B") is not None)
    assert panel._histogram.depth == 12 and list(panel._histogram.channels) == ["R", "G", "B"]


def test_dragged_levels_change_what_is_shown_and_not_what_is_measured(app):
    window = app.window
    window.histogramDock.show()
    app.until(lambda: window.histogram.plot.values("grey") is not None)
    before = window.histogram._histogram.mean("grey")
    window.histogram.levels.setRegion((0, 64))
    assert app.program.image.settings.levels.white == pytest.approx(0.25)
    app.until(lambda: screen(app).mean() > 1.5 * before)
    app.until(lambda: window.histogram._histogram.mean("grey") == pytest.approx(before, rel=0.2))
    app.qtbot.mouseClick(window.histogram.resetButton, Qt.LeftButton)
    assert app.program.image.settings.levels.neutral
    assert window.histogram.levels.getRegion() == (0, 256)


def test_levels_are_fitted_to_a_dark_image_of_twelve_bits(make_app):
    app = make_app()
    app.connect("sim:?pixel_format=Mono12&width=320&height=240")
    window = app.window
    app.grabber.write_feature("ExposureTime", 1000)
    window.histogramDock.show()
    app.watch(10)
    panel = window.histogram
    app.until(lambda: panel._histogram is not None and panel._histogram.mean("grey") < 400)
    before = screen(app).mean()
    app.qtbot.mouseClick(panel.fitButton, Qt.LeftButton)
    levels = app.program.image.settings.levels
    assert 0 <= levels.black < levels.white < 0.5
    app.watch(5)
    assert screen(app).mean() > 1.1 * before, "margins included"
    app.qtbot.mouseClick(panel.resetButton, Qt.LeftButton)
    assert app.program.image.settings.levels.neutral


def test_a_line_can_be_drawn_as_soon_as_the_profile_is_opened_and_until_it_is_closed(make_app):
    """ "Draw a line" was the hint, and a drag moved the image; later it stayed without the panel."""
    app = make_app()
    app.connect("sim:?width=320&height=240")
    app.watch()
    app.window.profileDock.show()
    app.window.profileDock.raise_()
    app.until(lambda: app.window.image.drawing.purpose is Purpose.PROFILE_LINE)
    app.window.profileDock.hide()
    app.until(lambda: app.window.image.drawing.purpose is None)


def test_pause_is_grey_while_the_camera_is_stopped(make_app):
    app = make_app()
    app.connect("sim:?width=320&height=240")
    app.window.actionStop.trigger()
    app.until(lambda: not app.window.actionPause.isEnabled())
    app.window.actionStart.trigger()
    app.until(app.window.actionPause.isEnabled)


def test_the_profile_of_a_mosaic_has_its_colours_or_its_raw_values(make_app):
    app = make_app()
    app.connect("sim:?pixel_format=BayerRG12&width=320&height=240")
    app.watch()
    window = app.window
    window.profileDock.show()
    settle(app)
    app.qtbot.mouseClick(window.profile.lineButton, Qt.LeftButton)
    drag(app, (20, 100), (300, 100))
    plot = window.profile.plot
    app.until(lambda: plot.values("B") is not None)
    assert plot.values("R").max() <= 255
    app.qtbot.mouseClick(window.profile.rawBox, Qt.LeftButton)
    app.until(lambda: plot.values("G") is not None and plot.values("G").max() > 255)
    samples = app.program.image_controls.measuring.wanted.line.samples
    assert len(plot.values("G")) == pytest.approx(samples / 2, abs=1), "every other pixel is green"


def test_clipping_is_marked_and_counted(app):
    window = app.window
    window.actionClipping.trigger()
    app.until(lambda: "saturated" in window.status.clippingButton.text())
    app.grabber.write_feature("ExposureTime", 1e5)
    app.until(lambda: float(window.status.clippingButton.text().split("%")[0]) > 50)
    app.watch(3)
    pixels = screen(app).reshape(-1, 3)
    assert np.mean((pixels[:, 0] > 200) & (pixels[:, 2] < 100)) > 0.3
    window.actionClipping.trigger()
    app.until(lambda: re.fullmatch(r"\d+% saturated", window.status.clippingButton.text()))
    app.grabber.write_feature("ExposureTime", 10.0)
    app.until(lambda: window.status.clippingButton.text() == "Clipping")


def test_a_drawn_region_is_scored_for_focus(app):
    window = app.window
    window.focusDock.show()
    app.until(lambda: "best" in window.focus.scoreLabel.text())
    app.qtbot.mouseClick(window.focus.regionButton, Qt.LeftButton)
    assert "into focus" in window.image.hintLabel.text()
    drag(app, (200, 200), (500, 400))
    assert not window.image.hintLabel.text()
    region = app.program.image_controls.measuring.wanted.focus_region
    assert abs(region.x - 200) < 6 and abs(region.y - 200) < 6
    assert abs(region.width - 300) < 8 and abs(region.height - 200) < 8
    assert window.image.canvas.marks._shapes.get(Mark.FOCUS) is not None
    app.until(lambda: "best" in window.focus.scoreLabel.text())
    app.qtbot.mouseClick(window.focus.wholeButton, Qt.LeftButton)
    assert app.program.image_controls.measuring.wanted.focus_region is None
    app.qtbot.mouseClick(window.focus.regionButton, Qt.LeftButton)
    drag(app, (200, 200), (500, 400))
    assert app.program.image_controls.measuring.wanted.focus_region is not None
    app.until(window.actionFullSensor.isEnabled)
    window.actionFullSensor.trigger()
    app.until(lambda: app.program.image_controls.measuring.wanted.focus_region is None)
    assert window.image.canvas.marks._shapes.get(Mark.FOCUS) is None


def test_a_drawn_line_shows_its_values_also_where_the_view_is_turned(app):
    window = app.window
    window.profileDock.show()
    window.actionTurnRight.trigger()
    app.until(lambda: window.image.canvas.imageSize == (1024, 1224))
    app.watch()
    app.qtbot.mouseClick(window.profile.lineButton, Qt.LeftButton)
    drag(app, (100, 300), (700, 300))
    app.until(lambda: window.profile.plot.values("grey") is not None)
    line = app.program.image_controls.measuring.wanted.line
    assert abs(line.x0 - 300) < 6 and abs(line.x1 - 300) < 6, "along a column of the frame"
    assert line.y0 - line.y1 == pytest.approx(600, abs=8), "from below to above"
    assert len(window.profile.plot.values("grey")) == line.samples


def test_escape_gives_up_drawing(app):
    window = app.window
    window.actionRegion.trigger()
    assert window.image.drawing.purpose is Purpose.SENSOR_REGION
    app.qtbot.keyClick(window.image.canvas, Qt.Key_Escape)
    assert window.image.drawing.purpose is None and not window.image.hintLabel.text()
    before = app.grabber.feature("Width").value
    drag(app, (100, 100), (400, 300))
    assert app.grabber.feature("Width").value == before
    app.watch()


def test_while_a_region_is_drawn_all_else_steps_back(app):
    app.until(app.window.actionRegion.isEnabled)
    canvas = app.window.image.canvas

    def light(x, y):
        place = canvas.frameToView(x, y).toPoint()
        return canvas.grab().toImage().pixelColor(place).value()

    def at_rest():
        """Outside and inside of the region, once frames that were on their way are painted, too."""
        seen = []

        def still():
            seen.append((light(100, 100), light(700, 500)))
            return len(seen) > 5 and len(set(seen[-5:])) == 1

        settle(app)
        app.until(still)
        return seen[-1]

    app.window.actionPause.trigger()
    fitted = at_rest()
    app.window.actionRegion.trigger()
    before = at_rest()  # with a margin around the sensor, so that other pixels of the image are painted
    begin, end = (canvas.frameToView(*point).toPoint() for point in ((300, 200), (900, 800)))
    app.qtbot.mousePress(canvas.viewport(), Qt.LeftButton, pos=begin)
    moved = QMouseEvent(QEvent.MouseMove, QPointF(end), Qt.NoButton, Qt.LeftButton, Qt.NoModifier)
    QApplication.sendEvent(canvas.viewport(), moved)
    app.until(lambda: light(100, 100) < 0.7 * before[0])
    assert light(700, 500) == before[1]
    app.qtbot.keyClick(canvas, Qt.Key_Escape)
    app.until(lambda: (light(100, 100), light(700, 500)) == fitted)


def test_the_reported_size_counts_every_touched_pixel():
    assert size_text(QRectF(10.2, 20.0, 5.0, 3.0)) == "10, 20   6 × 3"


def test_a_region_drawn_is_what_the_camera_sends_and_the_full_sensor_undoes_it(app):
    window = app.window
    app.until(window.actionRegion.isEnabled)
    left, top = (app.grabber.feature(n).value for n in ("OffsetX", "OffsetY"))
    window.actionRegion.trigger()
    drag(app, (200, 100), (840, 580))
    app.until(lambda: window.image.canvas.imageSize[0] < 700)
    x, y, width, height = (app.grabber.feature(n).value for n in ("OffsetX", "OffsetY", "Width", "Height"))
    assert (abs(width - 640) < 20, abs(height - 480) < 20) == (True, True)
    assert (abs(x - left - 200) < 20, abs(y - top - 100) < 20) == (True, True)
    assert app.program.open_sources.state is LinkState.STREAMING
    window.actionFullSensor.trigger()
    app.until(lambda: window.image.canvas.imageSize == (4096, 2160))
    assert window.image.canvas.fitted and not app.errors


def test_paused_one_steps_back_through_the_last_frames_and_live_goes_on(app):
    window, image = app.window, app.program.image
    app.until(lambda: len(app.program.image_controls.history.frames) >= 5)
    window.actionPause.trigger()
    frames = app.program.image_controls.history.frames  # not all that the camera sent, on a busy machine
    count, newest = len(frames), image.frame.frame_id
    assert image.frame is frames[-1]
    app.until(lambda: "Paused" in window.status.stateLabel.text())
    assert (
        window.image.pauseBar.isVisible() and f"{count} of {count}" in window.image.pauseBar.placeLabel.text()
    )
    window.actionStepBack.trigger()
    window.actionStepBack.trigger()
    assert image.frame is frames[-3]
    assert f"{count - 2} of {count}" in window.image.pauseBar.placeLabel.text()
    window.image.pauseBar.slider.setValue(0)
    app.until(lambda: image.frame is app.program.image_controls.history.frames[0])
    app.watch(1)
    assert image.frame is app.program.image_controls.history.frames[0], "the live frames pass by"
    app.qtbot.mouseClick(window.image.pauseBar.liveButton, Qt.LeftButton)
    app.until(lambda: image.frame.frame_id > newest)
    assert not window.image.pauseBar.isVisible() and not window.actionPause.isChecked()


def test_in_a_rotated_view_the_cursor_reports_the_frames_pixel(app):
    window = app.window
    window.actionStop.trigger()
    app.until(lambda: app.program.open_sources.state is LinkState.OPEN)
    window.actionTurnRight.trigger()
    window.actionMirrorX.trigger()
    app.until(lambda: window.image.canvas.imageSize == (1024, 1224))
    canvas = window.image.canvas
    place = canvas.frameToView(300.5, 200.5).toPoint()
    app.qtbot.mouseMove(canvas.viewport(), QPoint(5, 5))
    app.qtbot.mouseMove(canvas.viewport(), place)
    app.until(lambda: window.image.cursorLabel.text().startswith("x "))
    column, line = canvas.cursorPixel
    frame = app.program.image.frame
    # Turned right and then mirrored, lines have become columns: the frame is transposed.
    assert f"x {line}  y {column} " in window.image.cursorLabel.text()
    assert window.image.cursorLabel.text().endswith(str(frame.raw()[column, line]))
    window.actionUpright.trigger()
    app.until(lambda: window.image.canvas.imageSize == (1224, 1024))


def test_grey_is_shown_in_colours_where_somebody_wants_it(app):
    action = next(a for a in app.window.menuColours.actions() if a.data() == "Inferno")
    action.trigger()
    app.watch(5)
    pixels = screen(app).reshape(-1, 3).astype(int)
    assert np.mean(np.abs(pixels[:, 0] - pixels[:, 2]) > 30) > 0.3
    app.window.menuColours.actions()[0].trigger()
    assert not app.program.image.settings.colour_map


def test_crosshair_and_grid_lie_over_the_image(app):
    app.window.actionStop.trigger()
    app.until(lambda: app.program.open_sources.state is LinkState.OPEN)
    before = screen(app)
    for action in (app.window.actionCrosshair, app.window.actionGrid):
        action.trigger()
        after = screen(app)
        assert 0.001 < np.mean(after != before) < 0.1
        before = after


def test_the_log_is_shown_by_level_and_can_be_cleared(make_app):
    app = make_app()
    panel = app.window.log
    logging.getLogger("grabbergui.test").info("a remark")
    logging.getLogger("grabbergui.test").warning("a warning")
    app.until(lambda: "a warning" in panel.text.toPlainText())
    assert "INFO     grabbergui.test: a remark" in panel.text.toPlainText()
    panel.levelBox.setCurrentIndex(1)
    assert "a remark" not in panel.text.toPlainText() and "a warning" in panel.text.toPlainText()
    app.qtbot.mouseClick(panel.clearButton, Qt.LeftButton)
    assert panel.text.toPlainText() == ""


def test_the_overview_has_every_shortcut(make_app):
    app = make_app()
    app.window.actionShortcuts.trigger()
    (dialog,) = app.window.findChildren(ShortcutsDialog)
    text = "".join(label.text() for label in dialog.findChildren(QLabel))
    for key in ("Ctrl+S", "F6", "P", "Ctrl+E", "F2", "F12", "F1"):
        assert f"<b>{key}</b>" in text
    dialog.accept()


def test_what_is_drawn_is_clipped_to_the_image(app):
    drawn = []
    drawing = app.window.image.drawing
    drawing.regionDrawn.connect(lambda purpose, region: drawn.append(region))
    drawing.begin(Purpose.FOCUS_REGION)
    drag(app, (1100, 900), (5000, 5000))
    (region,) = drawn
    assert region == Region(region.x, region.y, 1224 - region.x, 1024 - region.y)


@pytest.mark.parametrize(
    "stroke", [((-200, -90), (-150, 700)), ((300, 200), (300, 700)), ((1500, 9), (2000, 900))]
)
def test_a_stroke_beside_the_image_is_no_region(app, stroke):
    """The camera would be set to its smallest region at the edge."""
    drawn, ended = [], []
    drawing = app.window.image.drawing
    drawing.regionDrawn.connect(lambda purpose, region: drawn.append(region))
    drawing.ended.connect(lambda: ended.append(True))
    drawing.begin(Purpose.SENSOR_REGION)
    drag(app, *stroke)
    assert (drawn, ended) == ([], [True])


def test_single_pixels_show_their_values_once_they_are_large_enough(app):
    canvas = app.window.image.canvas
    app.watch()
    assert not canvas.values.texts
    app.window.actionStop.trigger()
    app.until(lambda: app.program.open_sources.state is LinkState.OPEN)
    canvas.zoomBy(1000)
    app.until(lambda: canvas.values.texts)
    frame = app.program.image.frame
    assert all(line.text == str(frame.raw()[y, x]) for (x, y), (line,) in canvas.values.texts.items())
    canvas.fit()
    app.until(lambda: not canvas.values.texts)


def test_a_pixel_format_is_chosen_while_it_streams(app):
    window = app.window
    app.until(lambda: window.features.watched)
    window.features.filterEdit.setText("PixelFormat")
    rows = window.features.rows
    app.until(lambda: rows.rows("PixelFormat") and rows.rows("PixelFormat")[0].editor is not None)
    row = rows.rows("PixelFormat")[0]
    assert row.editor.isEnabled()
    assert "pauses the stream for a moment" in row.toolTip()
    row.editor.combo.setCurrentIndex(row.editor.combo.findText("Mono12"))
    row.editor.combo.activated[int].emit(row.editor.combo.currentIndex())
    app.until(lambda: app.program.image.frame.pixel_format.name == "Mono12")
    assert app.grabber.streaming and not app.errors
    app.watch()
    window.actionUndo.trigger()
    app.until(lambda: app.program.image.frame.pixel_format.name == "Mono8")


def test_format_and_region_are_set_before_the_first_start(app):
    window, link = app.window, app.program.opener
    link.open_sources.close_current()
    app.until(lambda: link.open_sources.state is LinkState.CLOSED)
    window.sources.addressEdit.setText("sim:?width=320&height=240")
    window.actionConnectStill.trigger()
    app.until(lambda: link.open_sources.state is LinkState.OPEN)
    assert not app.grabber.streaming
    features = link.open_sources.current.features
    features.write("PixelFormat", "Mono16")
    features.write("Width", 160)
    window.actionStart.trigger()
    app.until(lambda: app.program.image.frame is not None and app.program.image.frame.width == 160)
    assert app.program.image.frame.pixel_format.name == "Mono16"
