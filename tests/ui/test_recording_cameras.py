"""Recordings belong to cameras: several run at once, and none is cut off unasked."""

import contextlib

import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QMessageBox

from grabbergui.models.open_source import LinkState
from grabbergui.recording.recorder import RecordingProgress
from grabbergui.recording.recording import open_recording
from grabbergui.recording.writer import RecordingKind
from grabbergui.ui.views.recording_bars import RecordingBar

GREY = "sim:?width=64&height=48&fps=60"
COLOUR = "sim:colour?width=64&height=48&fps=60"


@pytest.fixture
def desk(window_desk):
    window_desk.connect(GREY)
    window_desk.watch()
    bar = window_desk.window.recordingBar
    bar.kindBox.setCurrentIndex(bar.kindBox.findData(RecordingKind.TIFF))
    return window_desk


def press_record(desk):
    """Once the button shows what is so: what it does depends on that."""
    button, source = desk.window.recordingBar.recordButton, desk.program.connection.source
    desk.until(lambda: button.isEnabled() and button.isChecked() == desk.program.recordings.runs(source))
    desk.qtbot.mouseClick(button, Qt.LeftButton)


def open_beside(desk, uri=COLOUR):
    desk.program.connection.open_additional(uri)
    desk.until(lambda: len(desk.window.gallery.tiles) == 2)
    second = desk.program.connection.sources[1]
    desk.until(lambda: second.state is LinkState.STREAMING)
    return second


def written(desk, source):
    recording = desk.program.recordings.of(source)
    return recording.progress.frames if recording is not None else 0


def answer(desk, text):
    desk.until(lambda: desk.program.recording.question is not None)
    box = desk.program.recording.question
    button = next(b for b in box.buttons() if b.text() == text)
    desk.qtbot.mouseClick(button, Qt.LeftButton)
    desk.until(lambda: desk.program.recording.question is None)


def test_two_cameras_are_recorded_at_once_each_with_its_own_progress(desk, tmp_path):
    first, second = desk.program.connection.source, open_beside(desk)
    press_record(desk)
    desk.until(lambda: written(desk, first) > 2)
    desk.program.connection.make_current(second)
    desk.until(lambda: not desk.window.recordingBar.recordButton.isChecked())
    assert desk.window.recordingBar.progressLabel.text() == ""
    press_record(desk)
    desk.until(lambda: written(desk, second) > 2)
    assert set(desk.program.recordings.running) == {first, second}
    tiles = desk.window.gallery.tiles
    desk.until(lambda: all(tile.recordingLabel.isVisible() for tile in tiles))
    desk.until(lambda: desk.window.windowTitle().startswith("● Recording — "))
    press_record(desk)
    desk.until(lambda: desk.program.recordings.running == (first,))
    desk.until(lambda: not tiles[1].recordingLabel.isVisible())
    desk.until(lambda: "Recording" not in desk.window.windowTitle())
    desk.program.recordings.stop(first)
    desk.until(lambda: not desk.program.recordings.running)
    folders = sorted(path.name for path in (tmp_path / "snapshots").iterdir())
    assert len(folders) == 2
    for folder, source in zip(folders, (first, second), strict=True):
        assert source.grabber.info.serial in folder


def test_a_recording_that_ended_is_played_from_where_its_camera_is(desk):
    first, second = desk.program.connection.source, open_beside(desk)
    press_record(desk)
    desk.until(lambda: written(desk, first) > 2)
    press_record(desk)
    bar = desk.window.recordingBar
    desk.until(bar.playButton.isVisible)
    desk.program.connection.make_current(second)
    desk.until(lambda: not bar.playButton.isVisible())
    desk.program.connection.make_current(first)
    desk.until(bar.playButton.isVisible)


@pytest.mark.parametrize("close", ["menu", "list", "tile", "another"])
def test_closing_a_camera_that_is_recorded_asks(desk, close):
    first = desk.program.connection.source
    open_beside(desk)
    press_record(desk)
    desk.until(lambda: written(desk, first) > 2)
    ask = {
        "menu": desk.window.actionDisconnect.trigger,
        "list": desk.window.sources.disconnectRequested.emit,
        "tile": lambda: desk.qtbot.mouseClick(desk.window.gallery.tiles[0].closeButton, Qt.LeftButton),
        "another": lambda: desk.program.sources.connect_to("sim:?width=32&height=32"),
    }[close]
    ask()
    answer(desk, "Go on recording")
    assert first in desk.program.connection.sources and desk.program.recordings.runs(first)
    ask()
    answer(desk, "Stop recording and close")
    desk.until(lambda: first not in desk.program.connection.sources)
    desk.until(lambda: not desk.program.recordings.running)
    desk.until(lambda: any("recorded" in text and " to " in text for text in desk.errors))


def test_a_camera_that_is_not_recorded_closes_at_once(desk):
    desk.window.actionDisconnect.trigger()
    assert desk.program.recording.question is None and desk.program.connection.source is None


def test_closing_the_window_asks_while_something_is_recorded(desk):
    first = desk.program.connection.source
    press_record(desk)
    desk.until(lambda: written(desk, first) > 2)
    desk.window.actionQuit.trigger()
    answer(desk, "Go on recording")
    assert desk.window.isVisible() and desk.program.recordings.runs(first)
    desk.window.actionQuit.trigger()
    assert isinstance(desk.program.recording.question, QMessageBox)
    answer(desk, "Stop recording and close")
    desk.until(lambda: not desk.window.isVisible())
    desk.until(lambda: not desk.program.recordings.running)


def test_record_is_grey_where_there_is_nothing_to_record(window_desk):
    button, action = window_desk.window.recordingBar.recordButton, window_desk.window.actionRecord
    assert not button.isEnabled() and not action.isEnabled()
    window_desk.connect(GREY)
    window_desk.until(lambda: button.isEnabled() and action.isEnabled())
    window_desk.window.actionStop.trigger()
    window_desk.until(lambda: not button.isEnabled() and not action.isEnabled())
    window_desk.program.connection.disconnect()
    window_desk.until(lambda: window_desk.program.connection.source is None)
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


def test_a_full_disk_is_reported_with_what_was_saved_where(desk, monkeypatch):
    room = iter([1 << 40] * 3)
    monkeypatch.setattr("grabbergui.recording.writer.RecordingWriter.free", lambda _: next(room, 3 << 20))
    source = desk.program.connection.source
    press_record(desk)
    desk.until(lambda: any("is full" in text for text in desk.errors))
    path = desk.program.recordings.of(source).path
    (said,) = [text for text in desk.errors if "is full" in text]
    assert said.endswith(f"the disk of {path} is full (3 MiB left); 3 frames recorded by then are kept")
    desk.until(desk.window.recordingBar.playButton.isVisible)
    with contextlib.closing(open_recording(path)) as recording:
        assert len(recording) == 3
