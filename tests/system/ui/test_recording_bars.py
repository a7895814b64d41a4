"""A recording played in the window: the bar, the keys, and a recording's limits."""

import numpy as np
import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QApplication, QWidget

from grabbergui.core import pfnc
from grabbergui.core.frame import Frame
from grabbergui.core.identity import DeviceInfo
from grabbergui.models.playback import PlaybackState
from grabbergui.recording.kinds import RecordingKind
from grabbergui.recording.recorder import create_writer
from grabbergui.ui.theme import Theme, dress
from grabbergui.ui.views.recording_bars import PlaybackBar, RecordingBar

FRAMES, STEP_NS = 21, 50_000_000
DIRECT = Qt.FindDirectChildrenOnly
START = 1_700_000_000_000_000_000


@pytest.fixture
def recording(tmp_path):
    """A second of frames, each of another grey."""
    path = tmp_path / "greys"
    writer = create_writer(RecordingKind.TIFF, path, DeviceInfo("sim:", model="M"))
    for index in range(FRAMES):
        payload = np.full(48 * 64, 10 * index, np.uint8)
        received = START + index * STEP_NS
        writer.write(Frame(payload, 64, 48, pfnc.by_name("Mono8"), index, index, received))
    writer.close()
    return f"file:{path}"


@pytest.fixture
def player(app, recording):
    app.connect(recording)
    app.until(app.window.image.playbackBar.isVisible)
    return app


def shown(app):
    """Which frame the image shows."""
    frame = app.program.image.frame
    return int(frame.raw()[0, 0]) // 10 if frame is not None else -1


def bar_of(app):
    return app.window.image.playbackBar


def held_at(app, index):
    place = f"{index + 1} / {FRAMES}"
    app.until(lambda: shown(app) == index and bar_of(app).placeLabel.text().endswith(place))


def test_a_camera_has_no_bar(app):
    app.connect()
    app.watch()
    assert not bar_of(app).isVisible()


def test_the_slider_keeps_its_length_with_another_digit(qtbot):
    bar = PlaybackBar()
    qtbot.addWidget(bar)
    bar.show()
    lengths = set()
    for position in (0, 50, 500, 999):
        bar.setState(PlaybackState(True, position, 1000, position / 20, 50.0, 1.0, True))
        QApplication.processEvents()
        lengths.add(bar.slider.width())
    assert len(lengths) == 1


def test_it_plays_holds_and_steps(player):
    bar = bar_of(player)
    seen = set()
    player.until(lambda: seen.add(shown(player)) or len(seen) > 5)
    assert "00:01.0" in bar.placeLabel.text(), "how long it is"
    assert not player.program.open_sources.current.journal.changes, "that it plays is no change"
    player.until(lambda: "Playing" in player.window.status.stateLabel.text())
    player.qtbot.mouseClick(bar.playButton, Qt.LeftButton)
    player.until(lambda: bar.playButton.text() == "Play")
    player.until(lambda: "Paused" in player.window.status.stateLabel.text())
    player.qtbot.wait(200)
    at = shown(player)
    player.qtbot.wait(200)
    assert shown(player) == at
    player.program.open_sources.current.grabber.write_feature("PlaybackPosition", 7)
    held_at(player, 7)
    player.qtbot.mouseClick(bar.forwardButton, Qt.LeftButton)
    held_at(player, 8)
    player.qtbot.keyClick(player.window, Qt.Key_Comma)
    held_at(player, 7)
    player.qtbot.keyClick(player.window, Qt.Key_P)
    player.until(lambda: bar.playButton.text() == "Pause" and shown(player) != 7)
    assert not player.window.image.pauseBar.isVisible(), "a recording has its own past"
    assert not player.errors


def test_the_slider_winds(player):
    bar = bar_of(player)
    player.qtbot.mouseClick(bar.playButton, Qt.LeftButton)
    player.until(lambda: bar.playButton.text() == "Play")
    player.qtbot.keyClick(bar.slider, Qt.Key_End)
    held_at(player, FRAMES - 1)
    player.qtbot.keyClick(bar.slider, Qt.Key_Home)
    held_at(player, 0)
    player.qtbot.keyClick(bar.slider, Qt.Key_PageUp)
    held_at(player, FRAMES // 10)


def test_speed_and_loop_are_the_recordings_features(player):
    bar, grabber = bar_of(player), player.grabber
    player.qtbot.mouseClick(bar.loopButton, Qt.LeftButton)
    player.until(lambda: grabber.feature("PlaybackLoop").value is False)
    bar.speedBox.setFocus()
    player.qtbot.keyClick(bar.speedBox, Qt.Key_End)
    player.until(lambda: grabber.feature("PlaybackSpeed").value == 10)
    player.until(lambda: shown(player) == FRAMES - 1 and bar.playButton.text() == "Play")
    grabber.write_feature("PlaybackSpeed", 3)
    player.until(lambda: bar.speedBox.currentText() == "3 ×")
    player.qtbot.mouseClick(bar.playButton, Qt.LeftButton)
    player.until(lambda: grabber.feature("PlaybackActive").value is True)


def test_winding_is_nothing_to_be_undone(player):
    player.qtbot.keyClick(bar_of(player).slider, Qt.Key_Home)
    player.qtbot.mouseClick(bar_of(player).playButton, Qt.LeftButton)
    player.until(lambda: bar_of(player).playButton.text() == "Play")
    assert not player.window.actionUndo.isEnabled()


def test_the_bar_goes_with_the_recording(player):
    player.connect("sim:")
    player.watch()
    player.until(lambda: not bar_of(player).isVisible())
    player.until(lambda: len(player.program.image_controls.history.frames) > 2)
    player.qtbot.keyClick(player.window, Qt.Key_P)
    assert player.window.image.pauseBar.isVisible()


@pytest.mark.parametrize(
    ("limit", "amount", "check"),
    [
        ("For a time", 0.5, lambda progress: 0.3 < progress.seconds <= 0.5),
        ("For a number of frames", 7, lambda progress: progress.frames == 7),
        ("Up to a size", 1, lambda progress: 1e6 <= progress.size < 1.5e6),
    ],
)
def test_a_recording_ends_at_its_limit(app, limit, amount, check):
    app.connect("sim:?width=320&height=240&fps=60")
    app.watch()  # half a second may pass between the first frames of a stream that starts on a busy machine
    bar = app.window.recordingBar
    bar.kindBox.setCurrentIndex(bar.kindBox.findData(RecordingKind.TIFF))
    bar.limitBox.setFocus()
    for _ in range(bar.limitBox.findText(limit)):
        app.qtbot.keyClick(bar.limitBox, Qt.Key_Down)
    assert bar.limitBox.currentText() == limit and bar.amountBox.isVisible()
    bar.amountBox.selectAll()
    app.qtbot.keyClicks(bar.amountBox, str(amount))
    app.qtbot.mouseClick(bar.recordButton, Qt.LeftButton)
    app.until(bar.playButton.isVisible)  # a short recording may begin and end between two looks at its button
    progress = app.program.source_controls.recordings.of(app.program.open_sources.current).progress
    assert check(progress), progress
    assert not bar.recordButton.isChecked()


@pytest.mark.parametrize("width", [1280, 800])
def test_nothing_moves_when_a_recording_starts_or_ends(make_app, qapp, request, width):
    request.addfinalizer(lambda: qapp.setStyleSheet(""))
    dress(qapp, Theme.LIGHT)
    app = make_app()
    app.window.resize(width, 700)
    app.connect("sim:?width=320&height=240")
    bar, canvas = app.window.recordingBar, app.window.image.canvas
    heights, images = [app.settled(bar.height)], []
    for running in (True, False, True, False):
        app.qtbot.mouseClick(bar.recordButton, Qt.LeftButton)
        app.until(lambda running=running: bar.recordButton.isChecked() is running)
        images.append(app.settled(canvas.geometry))
        heights.append(bar.height())
    assert len(set(heights)) == 1
    # From the second on: controls that were made in another style take their size when they are first moved.
    assert images[1:] == 3 * images[1:2]


def test_free_space_and_length_are_shown_while_recording(app):
    app.connect("sim:?width=320&height=240")
    bar = app.window.recordingBar
    app.qtbot.mouseClick(bar.recordButton, Qt.LeftButton)
    app.until(lambda: "free" in bar.progressLabel.text())
    assert "frame" in bar.progressLabel.text() and "MB" in bar.progressLabel.text()
    app.qtbot.mouseClick(bar.recordButton, Qt.LeftButton)
    app.until(bar.playButton.isVisible)


def test_above_a_recording_nothing_is_said_of_exposure(app, recording):
    hint = app.window.favourites.hintLabel
    assert hint.text().startswith("Exposure, gain and frame rate appear here")
    app.connect(recording)
    app.until(lambda: hint.isVisible() and hint.text().startswith("Drag the name of a feature here"))


@pytest.mark.parametrize("limit", range(4))
@pytest.mark.parametrize("playable", [False, True])
def test_no_part_of_the_bar_is_cut_at_any_width(qtbot, limit, playable):
    window = QWidget()
    qtbot.addWidget(window)
    bar = RecordingBar(window)
    bar.limitBox.setCurrentIndex(limit)
    if playable:
        bar.setPlayable("scene.mcap")
    window.show()
    for width in range(bar.minimumSizeHint().width(), 800, 20):
        bar.resize(width, bar.sizeHint().height())
        QApplication.processEvents()

        def nothing_is_cut(width=width):
            shown = [part for part in bar.findChildren(QWidget, options=DIRECT) if part.isVisible()]
            last = max(shown, key=lambda part: part.geometry().right())
            assert last.geometry().right() < width, f"{last.objectName()} at {width} pixels"

        qtbot.waitUntil(nothing_is_cut)  # showing and hiding parts takes another layout
