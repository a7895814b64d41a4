"""Recordings belong to cameras: several run at once, and none is cut off unasked."""

import contextlib

import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QMessageBox

from grabbergui.models.open_source import LinkState
from grabbergui.recording.kinds import RecordingKind
from grabbergui.recording.opening import open_recording
from grabbergui.recording.recorder import RecordingProgress
from grabbergui.ui.views.recording_bars import RecordingBar

GREY = "sim:?width=64&height=48&fps=20"
COLOUR = "sim:colour?width=64&height=48&fps=20"


@pytest.fixture
def app(make_app):
    app = make_app()
    app.connect(GREY)
    app.watch()
    bar = app.window.recordingBar
    bar.kindBox.setCurrentIndex(bar.kindBox.findData(RecordingKind.TIFF))
    return app


def press_record(app):
    """Once the button shows what is so: what it does depends on that."""
    button, source = app.window.recordingBar.recordButton, app.program.open_sources.current
    app.until(
        lambda: (
            button.isEnabled() and button.isChecked() == app.program.source_controls.recordings.runs(source)
        )
    )
    app.qtbot.mouseClick(button, Qt.LeftButton)


def open_beside(app, uri=COLOUR):
    app.program.opener.open_additional(uri)
    app.until(lambda: len(app.window.gallery.tiles) == 2)
    second = app.program.open_sources.all[1]
    app.until(lambda: second.state is LinkState.STREAMING)
    return second


def written(app, source):
    recording = app.program.source_controls.recordings.of(source)
    return recording.progress.frames if recording is not None else 0


def answer(app, text):
    app.until(lambda: app.program.source_controls.recording.question is not None)
    box = app.program.source_controls.recording.question
    button = next(b for b in box.buttons() if b.text() == text)
    app.qtbot.mouseClick(button, Qt.LeftButton)
    app.until(lambda: app.program.source_controls.recording.question is None)


def test_two_cameras_are_recorded_at_once_each_with_its_own_progress(app, tmp_path):
    first, second = app.program.open_sources.current, open_beside(app)
    press_record(app)
    app.until(lambda: written(app, first) > 2)
    app.program.open_sources.make_current(second)
    app.until(lambda: not app.window.recordingBar.recordButton.isChecked())
    assert app.window.recordingBar.progressLabel.text() == ""
    press_record(app)
    app.until(lambda: written(app, second) > 2)
    assert set(app.program.source_controls.recordings.running) == {first, second}
    tiles = app.window.gallery.tiles
    app.until(lambda: all(tile.recordingLabel.isVisible() for tile in tiles))
    app.until(lambda: app.window.windowTitle().startswith("● Recording — "))
    press_record(app)
    app.until(lambda: app.program.source_controls.recordings.running == (first,))
    app.until(lambda: not tiles[1].recordingLabel.isVisible())
    app.until(lambda: "Recording" not in app.window.windowTitle())
    app.program.source_controls.recordings.stop(first)
    app.until(lambda: not app.program.source_controls.recordings.running)
    folders = sorted(path.name for path in (tmp_path / "snapshots").iterdir())
    assert len(folders) == 2
    for folder, source in zip(folders, (first, second), strict=True):
        assert source.grabber.info.serial in folder


def test_a_recording_that_ended_is_played_from_where_its_camera_is(app):
    first, second = app.program.open_sources.current, open_beside(app)
    press_record(app)
    app.until(lambda: written(app, first) > 2)
    press_record(app)
    bar = app.window.recordingBar
    app.until(bar.playButton.isVisible)
    app.program.open_sources.make_current(second)
    app.until(lambda: not bar.playButton.isVisible())
    app.program.open_sources.make_current(first)
    app.until(bar.playButton.isVisible)


@pytest.mark.parametrize("close", ["menu", "list", "tile"])
def test_closing_a_camera_that_is_recorded_asks(app, close):
    first = app.program.open_sources.current
    open_beside(app)
    press_record(app)
    app.until(lambda: written(app, first) > 2)
    ask = {
        "menu": app.window.actionDisconnect.trigger,
        "list": app.window.sources.disconnectRequested.emit,
        "tile": lambda: app.qtbot.mouseClick(app.window.gallery.tiles[0].closeButton, Qt.LeftButton),
    }[close]
    ask()
    answer(app, "Continue recording")
    assert first in app.program.open_sources.all and app.program.source_controls.recordings.runs(first)
    ask()
    answer(app, "Stop recording and close")
    app.until(lambda: first not in app.program.open_sources.all)
    app.until(lambda: not app.program.source_controls.recordings.running)
    app.until(lambda: any("recorded" in text and " to " in text for text in app.errors))


def test_a_camera_that_is_not_recorded_closes_at_once(app):
    app.window.actionDisconnect.trigger()
    assert app.program.source_controls.recording.question is None and app.program.open_sources.current is None


def test_closing_the_window_asks_while_something_is_recorded(app):
    first = app.program.open_sources.current
    press_record(app)
    app.until(lambda: written(app, first) > 2)
    app.window.actionQuit.trigger()
    answer(app, "Continue recording")
    assert app.window.isVisible() and app.program.source_controls.recordings.runs(first)
    app.window.actionQuit.trigger()
    assert isinstance(app.program.source_controls.recording.question, QMessageBox)
    answer(app, "Stop recording and close")
    app.until(lambda: not app.window.isVisible())
    app.until(lambda: not app.program.source_controls.recordings.running)


def test_record_is_grey_where_there_is_nothing_to_record(make_app):
    app = make_app()
    button, action = app.window.recordingBar.recordButton, app.window.actionRecord
    assert not button.isEnabled() and not action.isEnabled()
    app.connect(GREY)
    app.until(lambda: button.isEnabled() and action.isEnabled())
    app.window.actionStop.trigger()
    app.until(lambda: not button.isEnabled() and not action.isEnabled())
    app.program.open_sources.close_current()
    app.until(lambda: app.program.open_sources.current is None)
    assert not button.isEnabled() and not action.isEnabled()


@pytest.mark.parametrize(("frames", "said"), [(0, "0 frames"), (1, "1 frame"), (2, "2 frames")])
def test_one_frame_is_not_frames(qtbot, frames, said):
    bar = RecordingBar()
    qtbot.addWidget(bar)
    bar.setProgress(RecordingProgress(frames))
    assert bar.progressLabel.text().split(" · ")[1] == said


def test_every_kind_of_recording_is_offered_by_a_name_of_its_own(qtbot):
    bar = RecordingBar()
    qtbot.addWidget(bar)
    offered = {
        bar.kindBox.itemText(index): bar.kindBox.itemData(index) for index in range(bar.kindBox.count())
    }
    assert set(offered.values()) == set(RecordingKind) and len(offered) == len(RecordingKind)


def test_a_full_disk_is_reported_with_what_was_saved_where(app, monkeypatch):
    room = iter([1 << 40] * 3)
    monkeypatch.setattr("grabbergui.recording.recorder.RecordingWriter.free", lambda _: next(room, 3 << 20))
    source = app.program.open_sources.current
    press_record(app)
    app.until(lambda: any("is full" in text for text in app.errors))
    path = app.program.source_controls.recordings.of(source).path
    (said,) = [text for text in app.errors if "is full" in text]
    assert said.endswith(f"the disk of {path} is full (3 MiB left); 3 frames recorded by then are kept")
    app.until(app.window.recordingBar.playButton.isVisible)
    with contextlib.closing(open_recording(path)) as recording:
        assert len(recording) == 3
