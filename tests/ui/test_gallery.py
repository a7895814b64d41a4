"""Several cameras in one window: tiles to look at them, a click to tune one of them."""

import gc
import threading
import weakref

from PyQt5.QtCore import Qt

from grabbergui.models.open_source import LinkState
from grabbergui.ui.widgets.source_delegate import SOURCE_ROLE
from patience import PATIENCE

GREY = "sim:?width=320&height=240"
COLOUR = "sim:colour?width=320&height=240"


def two_cameras(desk):
    """The grey one at hand, the one in colour opened beside it as a person does."""
    desk.connect(GREY)
    desk.watch()
    view = desk.window.sources
    desk.qtbot.keyClicks(view.addressEdit, COLOUR)
    desk.until(view.besideButton.isVisible)
    desk.qtbot.mouseClick(view.besideButton, Qt.LeftButton)
    desk.until(lambda: len(desk.window.gallery.tiles) == 2)
    desk.until(lambda: all(s.state is LinkState.STREAMING for s in desk.program.connection.sources))
    desk.until(lambda: all(tile.thumbnail.image for tile in desk.window.gallery.tiles))
    return desk.window.gallery.tiles


def test_a_second_camera_opens_in_a_tile_and_the_first_stays_current(window_desk):
    first, second = two_cameras(window_desk)
    assert str(window_desk.program.connection.source.uri) == GREY
    assert window_desk.window.gallery.isVisible()
    assert first.property("current") and not second.property("current")
    assert second.titleLabel.shown in ("Simulated colour camera SIM002", "SIM002")
    assert second.titleLabel.toolTip() == "grabbergui Simulated colour camera SIM002"
    window_desk.until(lambda: "fps" in second.stateLabel.text())
    assert not second.thumbnail.image.isGrayscale() and first.thumbnail.image.isGrayscale()
    view = window_desk.window.sources.sourceList
    window_desk.until(lambda: all(view.item(r).data(SOURCE_ROLE).connected for r in range(view.count())))
    assert not window_desk.errors


def test_the_tile_clicked_is_the_camera_that_is_tuned(window_desk):
    first, second = two_cameras(window_desk)
    window, status = window_desk.window, window_desk.window.status
    grey = window_desk.grabber
    window_desk.until(lambda: status.formatLabel.text().endswith("Mono8"))
    window_desk.qtbot.mouseClick(second, Qt.LeftButton)
    window_desk.until(lambda: status.formatLabel.text().endswith("BayerRG8"))
    window_desk.until(lambda: "Live" in status.stateLabel.text())
    window_desk.until(lambda: second.property("current") and not first.property("current"))
    assert "colour" in window.windowTitle()
    colour = window_desk.grabber
    rows = window.favourites.rows
    window_desk.until(lambda: rows.rows("Gain") and rows.rows("Gain")[0].editor is not None)
    slider = rows.rows("Gain")[0].editor.slider()
    window_desk.until(slider.isEnabled)
    window_desk.qtbot.keyClick(slider, Qt.Key_PageUp)
    window_desk.until(lambda: colour.feature("Gain").value > 0)
    assert grey.feature("Gain").value == 0 and grey.streaming


def test_values_changed_meanwhile_are_shown_when_it_becomes_current_again(window_desk):
    _, second = two_cameras(window_desk)
    rows = window_desk.window.favourites.rows
    grey = window_desk.grabber
    window_desk.until(lambda: rows.rows("Gain") and rows.rows("Gain")[0].editor is not None)
    window_desk.qtbot.keyClick(second, Qt.Key_Return)
    window_desk.until(lambda: window_desk.grabber is not grey)
    grey.write_feature("Gain", 7)
    window_desk.window.actionNextSource.trigger()
    window_desk.until(lambda: window_desk.grabber is grey)

    def text(name):
        """What is shown of a favourite, whose row may just be made."""
        editors = [row.editor for row in rows.rows(name) if row.editor is not None]
        return editors[0].field.text() if editors else ""

    window_desk.until(lambda: text("Gain") == "7 dB" and text("ExposureTime") == "10 ms")


def test_a_tile_closed_takes_its_camera_threads_and_memory_with_it(window_desk):
    _, second = two_cameras(window_desk)
    source = window_desk.program.connection.sources[1]
    tile = window_desk.program.gallery.tiles[1]
    gone = [weakref.ref(thing) for thing in (source, source.grabber, tile, tile.picture)]
    del source, tile

    def threads():
        names = [thread.name for thread in threading.enumerate()]
        return len([name for name in names if "colour" in name]), names.count("display")

    of_colour, displays = threads()
    assert of_colour
    window_desk.qtbot.mouseClick(second.closeButton, Qt.LeftButton)
    window_desk.until(lambda: not window_desk.window.gallery.isVisible())
    assert window_desk.program.connection.wait_closed(PATIENCE)
    window_desk.watch()
    window_desk.until(lambda: threads() == (0, displays - 2))  # one camera needs no tiles

    def released():
        gc.collect()
        return not any(ref() for ref in gone)

    window_desk.until(released)


def test_closing_the_current_camera_makes_the_other_current(window_desk):
    two_cameras(window_desk)
    window_desk.program.connection.disconnect()
    window_desk.until(lambda: "colour" in window_desk.window.windowTitle())
    window_desk.watch()
    assert not window_desk.window.gallery.isVisible() and not window_desk.errors


def test_a_recording_goes_on_while_another_camera_is_current(window_desk):
    tile, second = two_cameras(window_desk)
    recorded, recordings = window_desk.program.connection.source, window_desk.program.recordings
    bar = window_desk.window.recordingBar
    bar.recordButton.click()
    window_desk.until(lambda: "frames" in bar.progressLabel.text() and bar.recordButton.isChecked())
    window_desk.qtbot.mouseClick(second, Qt.LeftButton)
    window_desk.until(lambda: str(window_desk.program.connection.source.uri) == COLOUR)
    window_desk.watch()
    assert recordings.runs(recorded) and not bar.recordButton.isChecked()
    window_desk.qtbot.mouseClick(tile, Qt.LeftButton)
    window_desk.until(bar.recordButton.isChecked)
    bar.recordButton.click()
    window_desk.until(bar.playButton.isVisible)


def test_a_camera_that_cannot_be_opened_beside_leaves_no_tile(window_desk):
    window_desk.connect(GREY)
    view = window_desk.window.sources
    window_desk.qtbot.keyClicks(view.addressEdit, "sim:nonsense")
    window_desk.qtbot.mouseClick(view.besideButton, Qt.LeftButton)
    window_desk.until(lambda: window_desk.errors)
    assert "no simulated camera 'nonsense'" in window_desk.errors[0]
    window_desk.until(lambda: not window_desk.window.gallery.tiles)
    assert window_desk.program.connection.state is LinkState.STREAMING


def test_a_camera_that_comes_back_has_its_controls_as_they_were_and_true(window_desk):
    two_cameras(window_desk)
    desk, window, connection = window_desk, window_desk.window, window_desk.program.connection
    first, second = connection.sources
    panel, cards = window.features.rows, window.favourites.rows

    def gain():
        row = cards.rows("Gain")
        return row[0].editor.field.text() if row and row[0].editor is not None else None

    desk.until(lambda: gain() == "0 dB" and panel.rows("AcquisitionMode"))
    row, card = panel.rows("AcquisitionMode")[0], cards.rows("Gain")[0]
    window.features.section("ImageFormatControl").header.click()
    opened = window.features.section("ImageFormatControl").open
    connection.make_current(second)
    desk.until(lambda: cards.rows("Gain")[:1] not in ([], [card]) and gain() is not None)
    assert not card.isVisible()
    first.grabber.write_feature("Gain", 6.0)  # by somebody else, while it is in the background
    connection.make_current(first)
    desk.until(lambda: cards.rows("Gain")[:1] == [card] and gain() == "6 dB")
    assert panel.rows("AcquisitionMode")[0] is row
    assert card.isVisible() and window.features.section("ImageFormatControl").open is opened
    connection.close(second)
    desk.until(lambda: len(window.features._sections) == 1)
    assert not desk.errors
