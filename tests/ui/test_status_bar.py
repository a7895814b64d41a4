"""What the window says of a camera is what is so, once, and no longer than that."""

import numpy as np
import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QAbstractButton, QApplication

from grabbergui.core.grabber import ConnectionState
from grabbergui.models.messages import NOTICE_SECONDS
from grabbergui.models.open_source import LinkState
from grabbergui.ui.widgets.source_delegate import SOURCE_ROLE
from patience import PATIENCE

SMALL = "sim:?width=320&height=240"


@pytest.fixture
def desk(window_desk):
    window_desk.connect(SMALL)
    window_desk.watch()
    return window_desk


def state(desk):
    return desk.window.status.stateLabel.text().removeprefix("● ")


def offers(desk):
    return {b.text(): b for b in desk.window.messages.findChildren(QAbstractButton, "offerButton")
            if b.isVisible()}  # fmt: skip


def lose(desk):
    """The camera falls silent, and its driver says so."""
    desk.grabber.stop()
    desk.grabber.connection_changed.emit(ConnectionState.LOST, "the camera does not answer")


def return_(desk):
    desk.grabber.start()
    desk.grabber.connection_changed.emit(ConnectionState.OPEN, "set as before")


def test_a_lost_camera_is_shown_as_lost_everywhere_until_it_returns(desk):
    window, gain = desk.window, desk.window.favourites.rows
    desk.until(lambda: gain.rows("Gain") and gain.rows("Gain")[0].editor is not None)
    row = gain.rows("Gain")[0]
    lose(desk)
    desk.until(lambda: state(desk).startswith("Lost for"))
    assert "connection lost" in window.windowTitle()
    desk.until(lambda: desk.errors)
    assert len(desk.errors) == 1 and "reconnecting since" in desk.errors[0]
    assert window.picture.ageLabel.isVisible() and "Last picture" in window.picture.ageLabel.text()
    assert window.picture.canvas._item.opacity() < 0.5
    assert not row.isEnabled() and "does not answer" in row.toolTip()
    assert window.status.rateLabel.text().startswith("0.0 fps")
    lines = window.sources.sourceList
    desk.until(lambda: [lines.item(r).data(SOURCE_ROLE).lost for r in range(lines.count())] == [True])
    return_(desk)
    desk.until(lambda: state(desk) == "Live" and "lost" not in window.windowTitle())
    desk.until(lambda: desk.errors and desk.errors[0].startswith("back after"))
    assert len(desk.errors) == 1
    assert not window.picture.ageLabel.isVisible() and window.picture.canvas._item.opacity() == 1
    assert row.isEnabled() and "does not answer" not in row.toolTip()


def test_a_loss_is_shown_while_its_camera_is_the_current_one(desk):
    first = desk.program.connection.source
    desk.program.connection.open_additional("sim:colour?width=320&height=240")
    desk.until(lambda: len(desk.window.gallery.tiles) == 2)
    second = desk.program.connection.sources[1]
    desk.until(lambda: second.state is LinkState.STREAMING)
    tile = desk.window.gallery.tiles[0]
    desk.until(lambda: tile.thumbnail.image is not None)
    lose(desk)
    desk.until(lambda: desk.errors)
    desk.until(lambda: "lost" in tile.stateLabel.text() and tile.thumbnail._dimmed)
    desk.program.connection.make_current(second)
    desk.until(lambda: state(desk) == "Live" and not desk.errors)
    assert not desk.window.picture.ageLabel.isVisible() and "lost" not in desk.window.windowTitle()
    rows = desk.window.favourites.rows
    desk.until(lambda: rows.rows("Gain") and rows.rows("Gain")[0].isEnabled())
    desk.watch()
    desk.program.connection.make_current(first)
    desk.until(lambda: state(desk).startswith("Lost for") and desk.errors)
    # What is shown is its own last picture, as on its tile, with its age.
    desk.until(desk.window.picture.ageLabel.isVisible)
    desk.until(lambda: "Mono8" in desk.window.status.formatLabel.text())
    assert desk.program.picture.frame.pixel_format.name == "Mono8"
    assert desk.window.picture.canvas._item.opacity() < 0.5


def test_a_lost_camera_of_which_nothing_was_seen_is_brought_forward_without_an_image(desk):
    """The other camera's last picture is not this one's, nor are its figures."""
    desk.program.connection.open_additional("sim:colour?width=320&height=240")
    desk.until(lambda: len(desk.program.gallery.tiles) == 2)
    second = desk.program.connection.sources[1]
    desk.until(lambda: second.state is LinkState.STREAMING)
    second.grabber.stop()
    second.grabber.connection_changed.emit(ConnectionState.LOST, "the camera does not answer")
    small = desk.program.gallery.tiles[1].picture
    assert small.detach(PATIENCE)
    small._frame = small.last_received = None
    desk.program.connection.make_current(second)
    desk.until(lambda: state(desk).startswith("Lost for") and desk.errors)
    assert desk.window.picture.empty
    desk.until(lambda: not desk.window.status.formatLabel.text())
    assert not desk.window.actionSnapshot.isEnabled()


def test_waiting_for_a_trigger_is_a_state_with_two_ways_out(desk):
    desk.grabber.write_feature("TriggerMode", "On")
    desk.until(lambda: state(desk) == "Waiting for trigger")
    desk.until(lambda: set(offers(desk)) == {"Send trigger", "Trigger off"})
    assert not desk.window.picture.note.isVisible(), "there is a picture to look at"
    before = desk.grabber.statistics().frames
    desk.qtbot.mouseClick(offers(desk)["Send trigger"], Qt.LeftButton)
    desk.until(lambda: desk.grabber.statistics().frames == before + 1)
    assert set(offers(desk)) == {"Send trigger", "Trigger off"}, "for the next one"
    desk.qtbot.mouseClick(offers(desk)["Trigger off"], Qt.LeftButton)
    desk.until(lambda: state(desk) == "Live" and not desk.errors)
    assert desk.grabber.feature("TriggerMode").value == "Off"


@pytest.mark.parametrize("by_key", [False, True])
def test_a_button_that_goes_leaves_the_focus_to_the_image(desk, by_key):
    desk.window.activateWindow()
    desk.grabber.write_feature("TriggerMode", "On")
    desk.until(lambda: "Trigger off" in offers(desk))
    button = offers(desk)["Trigger off"]
    button.setFocus()
    desk.until(button.hasFocus)
    if by_key:
        desk.qtbot.keyClick(button, Qt.Key_Space)
    else:
        desk.qtbot.mouseClick(button, Qt.LeftButton)
    desk.until(lambda: state(desk) == "Live" and not desk.errors)
    assert desk.window.picture.canvas.hasFocus(), QApplication.focusWidget()


def test_the_note_of_a_trigger_that_was_closed_stays_closed(desk):
    desk.grabber.write_feature("TriggerMode", "On")
    desk.until(desk.window.messages.closeButton.isVisible)
    desk.qtbot.mouseClick(desk.window.messages.closeButton, Qt.LeftButton)
    assert not desk.errors
    frames = desk.grabber.statistics().frames
    desk.grabber.execute("TriggerSoftware")
    desk.until(lambda: desk.grabber.statistics().frames > frames and state(desk) == "Live")
    desk.until(lambda: state(desk) == "Waiting for trigger")
    assert not desk.errors


def test_events_of_one_camera_are_not_attributed_to_another(desk):
    desk.program.connection.source.features.write("ExposureTime", -5.0)
    desk.until(lambda: desk.errors)
    desk.connect("sim:colour?width=320&height=240")
    desk.until(lambda: not desk.errors)


def test_a_notice_goes_by_itself(desk):
    desk.program.messages._clock = lambda: 0.0
    desk.window.actionSnapshot.trigger()
    desk.until(lambda: any("Saved" in text for text in desk.errors))
    desk.program.messages._clock = lambda: NOTICE_SECONDS + 1
    desk.until(lambda: not desk.errors)


def test_no_empty_state_is_shown_while_a_camera_is_opening(window_desk):
    said = []
    note = window_desk.window.picture.note
    show = window_desk.window.picture.setNote
    window_desk.window.picture.setNote = lambda *note: (said.append(note[0]), show(*note))
    window_desk.program.connection.connect_to(SMALL)
    window_desk.program.status_bar.refresh()
    window_desk.watch()
    assert not {text for text in said if text} - {f"Connecting to {SMALL} …"}
    window_desk.until(lambda: not note.isVisible())


def test_figures_of_one_camera_are_not_shown_of_the_next(desk):
    strip = desk.window.status
    desk.until(lambda: "fps" in strip.rateLabel.text())
    desk.program.connection.disconnect()
    desk.until(lambda: state(desk) == "Not connected")
    assert not strip.rateLabel.text() and not strip.lossLabel.text()
    assert desk.window.windowTitle() == "grabbergui"
    assert "Nothing is connected" in desk.window.picture.note.summaryLabel.text()


def test_a_dark_image_is_not_covered_by_its_message(desk):
    desk.grabber.write_feature("ExposureTime", desk.grabber.feature("ExposureTime").minimum)
    desk.until(lambda: any("black" in text for text in desk.errors))
    assert not desk.window.picture.note.isVisible()
    desk.grabber.write_feature("ExposureTime", 10_000)
    desk.until(lambda: not desk.errors)
    assert np.isfinite(desk.program.picture.mean)
