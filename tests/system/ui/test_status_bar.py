"""The status bar is true, says each thing once, and no longer than it holds."""

import numpy as np
import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QAbstractButton, QApplication

from grabbergui import doctor
from grabbergui.core.grabber import ConnectionState
from grabbergui.models.messages import NOTICE_SECONDS
from grabbergui.models.open_source import LinkState
from grabbergui.ui.run.source_controls import FIRST_URI
from grabbergui.ui.widgets.source_cards import SOURCE_ROLE
from patience import PATIENCE

SMALL = "sim:?width=320&height=240"


@pytest.fixture
def app(make_app):
    app = make_app()
    app.connect(SMALL)
    app.watch()
    return app


def state(app):
    return app.window.status.stateLabel.text().removeprefix("● ")


def offers(app):
    return {b.text(): b for b in app.window.messages.findChildren(QAbstractButton, "offerButton")
            if b.isVisible()}  # fmt: skip


def lose(app):
    """The camera falls silent, and its driver says so."""
    app.grabber.stop()
    app.grabber.connection_changed.emit(ConnectionState.LOST, "the camera does not answer")


def return_(app):
    app.grabber.start()
    app.grabber.connection_changed.emit(ConnectionState.OPEN, "set as before")


def test_a_lost_camera_is_shown_as_lost_everywhere_until_it_returns(app):
    window, gain = app.window, app.window.favourites.rows
    app.until(lambda: gain.rows("Gain") and gain.rows("Gain")[0].editor is not None)
    row = gain.rows("Gain")[0]
    app.watch()  # an image, which then ages
    lose(app)
    app.until(lambda: state(app).startswith("Lost for"))
    assert "connection lost" in window.windowTitle()
    app.until(lambda: app.errors)
    assert len(app.errors) == 1 and "reconnecting since" in app.errors[0]
    assert window.image.ageLabel.isVisible() and "Last image" in window.image.ageLabel.text()
    assert window.image.canvas._item.opacity() < 0.5
    assert not row.isEnabled() and "does not answer" in row.toolTip()
    assert window.status.rateLabel.text().startswith("0.0 fps")
    lines = window.sources.sourceList
    app.until(lambda: [lines.item(r).data(SOURCE_ROLE).lost for r in range(lines.count())] == [True])
    return_(app)
    app.until(lambda: state(app) == "Live" and "lost" not in window.windowTitle())
    app.until(lambda: app.errors and app.errors[0].startswith("back after"))
    assert len(app.errors) == 1
    assert not window.image.ageLabel.isVisible() and window.image.canvas._item.opacity() == 1
    assert row.isEnabled() and "does not answer" not in row.toolTip()


def test_a_loss_is_shown_while_its_camera_is_the_current_one(app):
    first = app.program.open_sources.current
    app.program.opener.open_additional("sim:colour?width=320&height=240")
    app.until(lambda: len(app.window.gallery.tiles) == 2)
    second = app.program.open_sources.all[1]
    app.until(lambda: second.state is LinkState.STREAMING)
    tile = app.window.gallery.tiles[0]
    app.until(lambda: tile.thumbnail.image is not None)
    lose(app)
    app.until(lambda: app.errors)
    app.until(lambda: "lost" in tile.stateLabel.text() and tile.thumbnail._dimmed)
    app.program.open_sources.make_current(second)
    app.until(lambda: state(app) == "Live" and not app.errors)
    assert not app.window.image.ageLabel.isVisible() and "lost" not in app.window.windowTitle()
    rows = app.window.favourites.rows
    app.until(lambda: rows.rows("Gain") and rows.rows("Gain")[0].isEnabled())
    app.watch()
    app.program.open_sources.make_current(first)
    app.until(lambda: state(app).startswith("Lost for") and app.errors)
    # What is shown is its own last image, as on its tile, with its age.
    app.until(app.window.image.ageLabel.isVisible)
    app.until(lambda: "Mono8" in app.window.status.formatLabel.text())
    assert app.program.image.frame.pixel_format.name == "Mono8"
    assert app.window.image.canvas._item.opacity() < 0.5


def test_a_lost_camera_of_which_nothing_was_seen_is_brought_forward_without_an_image(app):
    """The other camera's last image is not this one's, nor are its figures."""
    app.program.opener.open_additional("sim:colour?width=320&height=240")
    app.until(lambda: len(app.program.source_controls.gallery.tiles) == 2)
    second = app.program.open_sources.all[1]
    app.until(lambda: second.state is LinkState.STREAMING)
    second.grabber.stop()
    second.grabber.connection_changed.emit(ConnectionState.LOST, "the camera does not answer")
    small = app.program.source_controls.gallery.tiles[1].image
    assert small.detach(PATIENCE)
    small._frame = small.last_received = None
    app.program.open_sources.make_current(second)
    app.until(lambda: state(app).startswith("Lost for") and app.errors)
    assert app.window.image.empty
    app.until(lambda: not app.window.status.formatLabel.text())
    assert not app.window.actionSnapshot.isEnabled()


def test_a_pause_that_was_refused_without_frames_is_no_state(make_app):
    app = make_app()
    app.program.opener.connect_to("sim:?width=64&height=48", start=False)
    app.until(lambda: app.window.actionStart.isEnabled())
    app.window.actionPause.trigger()
    app.until(lambda: any("no frame yet to pause" in text for text in app.errors))
    app.window.actionStart.trigger()
    app.until(lambda: state(app) == "Live")


@pytest.mark.parametrize("by_key", [False, True])
def test_a_button_that_goes_leaves_the_focus_to_the_image(app, by_key):
    app.window.activateWindow()
    app.grabber.write_feature("TriggerMode", "On")
    button = app.window.image.triggerBar.offButton
    app.until(button.isVisible)
    button.setFocus()
    app.until(button.hasFocus)
    if by_key:
        app.qtbot.keyClick(button, Qt.Key_Space)
    else:
        app.qtbot.mouseClick(button, Qt.LeftButton)
    app.until(lambda: state(app) == "Live" and not app.errors)
    app.until(lambda: not button.isVisible())
    assert app.window.image.canvas.hasFocus(), QApplication.focusWidget()


def test_events_of_one_camera_are_not_attributed_to_another(app):
    app.program.open_sources.current.features.write("ExposureTime", -5.0)
    app.until(lambda: app.errors)
    app.connect("sim:colour?width=320&height=240")
    app.until(lambda: not app.errors)


def test_a_notice_goes_by_itself(app):
    app.program.messages.clock = lambda: 0.0
    app.window.actionSnapshot.trigger()
    app.until(lambda: any("Saved" in text for text in app.errors))
    app.program.messages.clock = lambda: NOTICE_SECONDS + 1
    app.until(lambda: not app.errors)


def test_no_empty_state_is_shown_while_a_camera_is_opening(make_app):
    app = make_app()
    said = []
    note = app.window.image.note
    show = app.window.image.setNote
    app.window.image.setNote = lambda *note: (said.append(note[0]), show(*note))
    app.program.opener.connect_to(SMALL)
    app.program.source_controls.status_bar.refresh()
    app.watch()
    assert not {text for text in said if text} - {f"Connecting to {SMALL} …"}
    app.until(lambda: not note.isVisible())


def test_figures_of_one_camera_are_not_shown_of_the_next(app):
    strip = app.window.status
    app.until(lambda: "fps" in strip.rateLabel.text())
    app.program.open_sources.close_current()
    app.until(lambda: state(app) == "Not connected")
    assert not strip.rateLabel.text() and not strip.lossLabel.text()
    assert app.window.windowTitle() == "grabbergui"
    assert "Nothing is connected" in app.window.image.note.summaryLabel.text()


def test_the_empty_window_offers_three_ways_to_begin(make_app, monkeypatch):
    monkeypatch.setattr(doctor, "check", lambda: ())
    app = make_app()
    note, window = app.window.image.note, app.window

    def button(text):
        return next(b for b in note.findChildren(QAbstractButton) if b.text() == text and b.isVisible())

    for size in ((1280, 800), (640, 360)):
        window.resize(*size)
        for text in ("Simulated camera", "Type an address", "Why is mine missing?"):
            app.until(lambda text=text: button(text).visibleRegion().boundingRect() == button(text).rect())
    button("Why is mine missing?").click()
    app.until(lambda: app.program.help_controls.help.doctor is not None)
    app.program.help_controls.help.doctor.close()
    window.activateWindow()
    button("Type an address").click()
    app.until(window.sources.addressEdit.hasFocus)
    button("Simulated camera").click()
    app.watch()
    assert str(app.program.open_sources.current.uri) == FIRST_URI
    assert not note.isVisible()


def test_a_dark_image_is_not_covered_by_its_message(app):
    app.grabber.write_feature("ExposureTime", app.grabber.feature("ExposureTime").minimum)
    app.until(lambda: any("black" in text for text in app.errors))
    assert not app.window.image.note.isVisible()
    app.grabber.write_feature("ExposureTime", 10_000)
    app.until(lambda: not app.errors)
    assert np.isfinite(app.program.image.mean)
