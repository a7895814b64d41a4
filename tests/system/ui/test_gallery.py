"""Several cameras in one window: tiles to look at them, a click to tune one of them."""

import gc
import threading
import weakref

import pytest
from PyQt5.QtCore import QRectF, Qt

from grabbergui.models.open_source import LinkState
from grabbergui.ui.widgets.source_cards import SOURCE_ROLE
from patience import PATIENCE

GREY = "sim:?width=320&height=240"
COLOUR = "sim:colour?width=320&height=240"


def two_cameras(app):
    """The grey camera is current; the one in colour was opened in the background, as a user does."""
    app.connect(GREY)
    app.watch()
    view = app.window.sources
    app.qtbot.keyClicks(view.addressEdit, COLOUR)
    app.until(view.besideButton.isVisible)
    app.qtbot.mouseClick(view.besideButton, Qt.LeftButton)
    app.until(lambda: len(app.window.gallery.tiles) == 2)
    app.until(lambda: all(s.state is LinkState.STREAMING for s in app.program.open_sources.all))
    app.until(lambda: all(tile.thumbnail.image for tile in app.window.gallery.tiles))
    return app.window.gallery.tiles


def test_a_second_camera_opens_in_a_tile_and_the_first_stays_current(app):
    first, second = two_cameras(app)
    assert str(app.program.open_sources.current.uri) == GREY
    assert app.window.gallery.isVisible()
    assert first.property("current") and not second.property("current")
    assert second.titleLabel.shown in ("Simulated colour camera SIM002", "SIM002")
    assert second.titleLabel.toolTip() == "grabbergui Simulated colour camera SIM002"
    app.until(lambda: "fps" in second.stateLabel.text())
    assert not second.thumbnail.image.isGrayscale() and first.thumbnail.image.isGrayscale()
    view = app.window.sources.sourceList
    app.until(lambda: all(view.item(r).data(SOURCE_ROLE).connected for r in range(view.count())))
    assert not app.errors


def test_late_signals_with_older_sources_change_nothing(app):
    two_cameras(app)
    view, program = app.window.sources.sourceList, app.program

    def connected():
        return [view.item(row).data(SOURCE_ROLE).connected for row in range(view.count())]

    app.until(lambda: connected() == [True, True])
    program.open_sources.changed.emit(())
    program.source_controls.source_list.changed.emit(())
    assert connected() == [True, True] and len(app.window.gallery.tiles) == 2


def test_the_tile_clicked_is_the_camera_that_is_tuned(app):
    first, second = two_cameras(app)
    window, status = app.window, app.window.status
    grey = app.grabber
    app.until(lambda: status.formatLabel.text().endswith("Mono8"))
    app.qtbot.mouseClick(second, Qt.LeftButton)
    app.until(lambda: status.formatLabel.text().endswith("BayerRG8"))
    app.until(lambda: "Live" in status.stateLabel.text())
    app.until(lambda: second.property("current") and not first.property("current"))
    assert "colour" in window.windowTitle()
    colour = app.grabber
    rows = window.favourites.rows
    app.until(lambda: rows.rows("Gain") and rows.rows("Gain")[0].editor is not None)
    slider = rows.rows("Gain")[0].editor.slider()
    app.until(slider.isEnabled)
    app.qtbot.keyClick(slider, Qt.Key_PageUp)
    app.until(lambda: colour.feature("Gain").value > 0)
    assert grey.feature("Gain").value == 0 and grey.streaming


def test_values_changed_meanwhile_are_shown_when_it_becomes_current_again(app):
    _, second = two_cameras(app)
    rows = app.window.favourites.rows
    grey = app.grabber
    app.until(lambda: rows.rows("Gain") and rows.rows("Gain")[0].editor is not None)
    app.qtbot.keyClick(second, Qt.Key_Return)
    app.until(lambda: app.grabber is not grey)
    grey.write_feature("Gain", 7)
    app.window.actionNextSource.trigger()
    app.until(lambda: app.grabber is grey)

    def text(name):
        """Return the text that is shown for a pinned control, whose row may just be made."""
        editors = [row.editor for row in rows.rows(name) if row.editor is not None]
        return editors[0].field.text() if editors else ""

    app.until(lambda: text("Gain") == "7 dB" and text("ExposureTime") == "10 ms")


def test_a_tile_closed_takes_its_camera_threads_and_memory_with_it(app):
    _, second = two_cameras(app)
    source = app.program.open_sources.all[1]
    tile = app.program.source_controls.gallery.tiles[1]
    gone = [weakref.ref(thing) for thing in (source, source.grabber, tile, tile.image)]
    del source, tile

    def threads():
        names = [thread.name for thread in threading.enumerate()]
        return len([name for name in names if "colour" in name]), names.count("display")

    of_colour, displays = threads()
    assert of_colour
    app.qtbot.mouseClick(second.closeButton, Qt.LeftButton)
    app.until(lambda: not app.window.gallery.isVisible())
    assert app.program.open_sources.wait_closed(PATIENCE)
    app.watch()
    app.until(lambda: threads() == (0, displays - 2))  # one camera needs no tiles

    def released():
        gc.collect()
        return not any(ref() for ref in gone)

    app.until(released)


def test_closing_the_current_camera_makes_the_other_current(app):
    two_cameras(app)
    app.program.open_sources.close_current()
    app.until(lambda: "colour" in app.window.windowTitle())
    app.watch()
    assert not app.window.gallery.isVisible() and not app.errors


def test_a_recording_goes_on_while_another_camera_is_current(app):
    tile, second = two_cameras(app)
    recorded, recordings = app.program.open_sources.current, app.program.source_controls.recordings
    bar = app.window.recordingBar
    bar.recordButton.click()
    app.until(lambda: "frames" in bar.progressLabel.text() and bar.recordButton.isChecked())
    app.qtbot.mouseClick(second, Qt.LeftButton)
    app.until(lambda: str(app.program.open_sources.current.uri) == COLOUR)
    app.watch()
    assert recordings.runs(recorded) and not bar.recordButton.isChecked()
    app.qtbot.mouseClick(tile, Qt.LeftButton)
    app.until(bar.recordButton.isChecked)
    bar.recordButton.click()
    app.until(bar.playButton.isVisible)


def test_a_camera_that_cannot_be_opened_beside_leaves_no_tile(app):
    app.connect(GREY)
    view = app.window.sources
    app.qtbot.keyClicks(view.addressEdit, "sim:nonsense")
    app.qtbot.mouseClick(view.besideButton, Qt.LeftButton)
    app.until(lambda: app.errors)
    assert "no simulated camera 'nonsense'" in app.errors[0]
    app.until(lambda: not app.window.gallery.tiles)
    assert app.program.open_sources.state is LinkState.STREAMING


def test_a_camera_that_comes_back_has_its_controls_as_they_were_and_true(app):
    two_cameras(app)
    app, window, connection = app, app.window, app.program.opener
    first, second = connection.open_sources.all
    panel, cards = window.features.rows, window.favourites.rows

    def gain():
        row = cards.rows("Gain")
        return row[0].editor.field.text() if row and row[0].editor is not None else None

    app.until(lambda: gain() == "0 dB" and panel.rows("AcquisitionMode"))
    row, card = panel.rows("AcquisitionMode")[0], cards.rows("Gain")[0]
    window.features.section("ImageFormatControl").header.click()
    opened = window.features.section("ImageFormatControl").open
    connection.open_sources.make_current(second)
    app.until(lambda: cards.rows("Gain")[:1] not in ([], [card]) and gain() is not None)
    assert not card.isVisible()
    first.grabber.write_feature("Gain", 6.0)  # by somebody else, while it is in the background
    connection.open_sources.make_current(first)
    app.until(lambda: cards.rows("Gain")[:1] == [card] and gain() == "6 dB")
    assert panel.rows("AcquisitionMode")[0] is row
    assert card.isVisible() and window.features.section("ImageFormatControl").open is opened
    connection.open_sources.close(second)
    app.until(lambda: len(window.features._sections) == 1)
    assert not app.errors


def test_panes_and_their_zoom_are_kept_and_each_camera_has_its_own(make_app):
    app = make_app()
    two_cameras(app)
    area, canvas, menu = app.window.image.paneArea, app.window.image.canvas, app.window.menuPanes
    next(action for action in menu.actions() if action.data() == 2).trigger()
    next(action for action in menu.actions() if "zoom" in action.text()).trigger()
    app.until(lambda: len(area.panes) == 1)
    ((_, pane),) = area.panes.items()
    app.watch()
    canvas.zoomBy(4)
    app.watch()
    app.until(lambda: canvas.seen.width() < 1)
    assert pane.seen.width() >= 1, "the other one shows all of its image still"
    pane.showPart(QRectF(0.25, 0.25, 0.5, 0.5))
    app.qtbot.mouseClick(pane.viewport(), Qt.LeftButton)
    app.until(lambda: str(app.program.open_sources.current.uri) == COLOUR)
    app.watch()
    app.until(lambda: canvas.seen.width() == pytest.approx(0.5, abs=0.02))
    app.until(lambda: [pane.seen.width() for pane in area.panes.values()] == [pytest.approx(0.25, abs=0.1)])
    preferences = app.program.preferences
    assert (preferences.panes, preferences.separate_zoom) == (2, True)


def test_cameras_side_by_side_share_the_zoom_and_a_click_makes_one_current(app):
    two_cameras(app)
    area, canvas = app.window.image.paneArea, app.window.image.canvas
    next(action for action in app.window.menuPanes.actions() if action.data() == 2).trigger()
    app.until(lambda: len(area.panes) == 1)
    ((name, pane),) = area.panes.items()
    assert "colour" in name and pane.isVisible() and canvas.isVisible()
    canvas.zoomBy(2)
    app.until(lambda: pane._box.viewRect().width() < 300)
    app.qtbot.mouseClick(pane.viewport(), Qt.LeftButton)
    app.until(lambda: str(app.program.open_sources.current.uri) == COLOUR)
    app.until(lambda: [name for name in area.panes if "colour" not in name])
    app.watch()
    assert not app.window.image.empty and not app.errors
    app.qtbot.mouseClick(app.window.gallery.tiles[0].closeButton, Qt.LeftButton)
    app.until(lambda: not area.panes)
    app.watch()
