"""The simulated camera is recorded: until a limit, a request, the source's end, a full disk."""

import contextlib
import errno
import time
from dataclasses import replace
from pathlib import Path

import pytest

from full_disk import FullDisk
from grabbergui import sources
from grabbergui.core.errors import FrameTimeoutError
from grabbergui.core.uri import SourceUri
from grabbergui.recording import playback
from grabbergui.recording.errors import DiskFullError
from grabbergui.recording.kinds import MOVIE_KINDS, RecordingKind
from grabbergui.recording.opening import open_recording, playable_frames
from grabbergui.recording.recorder import Recorder, RecordingLimits, RecordingProgress, create_writer
from patience import PATIENCE, until
from recorded_frames import INFO, NAMES, made, written


@pytest.fixture
def camera():
    grabber = sources.create("sim:?width=64&height=48&fps=100")
    grabber.open()
    yield grabber
    grabber.close()


def ended(recorder):
    assert recorder.wait(PATIENCE)
    return recorder.progress


@pytest.mark.parametrize("kind", RecordingKind)
def test_a_camera_is_recorded_and_played(camera, tmp_path, kind):
    path = tmp_path / NAMES[kind]
    writer = create_writer(kind, path, camera.info, 100)
    recorder = Recorder(camera, writer, RecordingLimits(frames=10), reserve=0)
    reported = []
    recorder.changed.connect(reported.append)
    recorder.start()
    camera.start()
    progress = ended(recorder)
    assert (progress.frames, progress.reason) == (10, "")
    assert progress.size > 0 and reported[-1].ended

    player = playback.create(SourceUri.parse(f"file:{path}?loop=0&speed=4"))
    player.open()
    try:
        queue = player.open_queue(16)
        player.start()
        frames = [queue.get(PATIENCE) for _ in range(10)]
        assert len({frame.frame_id for frame in frames}) == 10
        assert all((frame.width, frame.height) == (64, 48) for frame in frames)
        with pytest.raises(FrameTimeoutError):
            queue.get(0.2)
        assert player.feature("PlaybackActive").value is False
    finally:
        player.close()


def test_it_ends_after_so_many_seconds(camera, tmp_path):
    writer = create_writer(RecordingKind.MCAP, tmp_path / "x.mcap", INFO)
    recorder = Recorder(camera, writer, RecordingLimits(seconds=0.1), reserve=0)
    recorder.start()
    camera.start()
    progress = ended(recorder)
    assert progress.frames and progress.seconds <= 0.1


def test_a_change_of_the_time_of_day_does_not_end_it(camera, tmp_path, monkeypatch):
    """As when the time of day is set by an hour while it records."""
    really, jumped = time.time_ns, []
    monkeypatch.setattr(time, "time_ns", lambda: really() + 3600 * 10**9 * bool(jumped))
    writer = create_writer(RecordingKind.MCAP, tmp_path / "x.mcap", INFO)
    recorder = Recorder(camera, writer, RecordingLimits(frames=20, seconds=PATIENCE), reserve=0)
    recorder.start()
    camera.start()
    until(lambda: recorder.progress.frames >= 5)
    jumped.append(True)
    progress = ended(recorder)
    assert progress.frames == 20 and progress.seconds < PATIENCE


def test_it_ends_after_so_many_seconds_even_if_no_frame_arrives(camera, tmp_path):
    writer = create_writer(RecordingKind.MCAP, tmp_path / "x.mcap", INFO)
    recorder = Recorder(camera, writer, RecordingLimits(seconds=0.3), reserve=0)
    recorder.start()
    camera.start()
    until(lambda: recorder.progress.frames)
    camera.stop()
    assert ended(recorder).reason == ""


def test_it_ends_once_so_many_bytes_are_written(camera, tmp_path):
    writer = create_writer(RecordingKind.TIFF, tmp_path / "x", INFO)
    recorder = Recorder(camera, writer, RecordingLimits(size=10_000), reserve=0)
    recorder.start()
    camera.start()
    progress = ended(recorder)
    frame = progress.size / progress.frames
    assert 10_000 <= progress.size < 10_000 + frame and progress.reason == ""


def test_it_ends_on_request_and_with_the_source(camera, tmp_path):
    reported = Recorder(camera, create_writer(RecordingKind.MCAP, tmp_path / "a.mcap", INFO))
    left = Recorder(camera, create_writer(RecordingKind.PNG, tmp_path / "b", INFO))
    reported.start()
    left.start()
    reported.stop()
    assert ended(reported).reason == ""
    camera.close()
    assert "closed" in ended(left).reason


@pytest.mark.parametrize("kind", list(RecordingKind))
def test_without_a_frame_the_name_is_free_again(camera, tmp_path, kind):
    path = tmp_path / NAMES[kind]
    recorder = Recorder(camera, create_writer(kind, path, INFO))
    recorder.start()
    recorder.stop()
    assert ended(recorder).reason == ""
    assert list(tmp_path.iterdir()) == []
    written(kind, path, [made("Mono8", 0)])


@pytest.mark.parametrize("kind", MOVIE_KINDS)
def test_without_a_frame_another_programs_file_stays(camera, tmp_path, kind):
    """A movie is made with its first frame; until then another program may have taken the name."""
    path = tmp_path / NAMES[kind]
    recorder = Recorder(camera, create_writer(kind, path, INFO))
    path.write_text("theirs")
    recorder.start()
    camera.start()
    assert "File exists" in ended(recorder).reason
    assert [file.name for file in tmp_path.iterdir()] == [path.name] and path.read_text() == "theirs"


def test_it_ends_even_if_closing_fails_unexpectedly(camera, tmp_path, monkeypatch):
    writer = create_writer(RecordingKind.PNG, tmp_path / "images", INFO)

    def no_memory(frame):
        time.sleep(0.1)  # so that others are begun, which fail when the writer is closed
        raise MemoryError("no room for an image")

    monkeypatch.setattr(writer, "_encoded", no_memory)
    recorder = Recorder(camera, writer)
    reported = []
    recorder.changed.connect(reported.append)
    recorder.start()
    camera.start()
    assert ended(recorder).reason == "internal error, see the log: no room for an image"
    assert reported[-1].ended


@pytest.mark.parametrize("kind", [RecordingKind.MCAP, RecordingKind.H264])
def test_it_ends_even_if_its_file_was_removed(camera, tmp_path, kind):
    recorder = Recorder(camera, create_writer(kind, tmp_path / NAMES[kind], camera.info))
    recorder.start()
    camera.start()
    until(lambda: recorder.progress.frames >= 3, "frames")
    (tmp_path / NAMES[kind]).unlink()
    recorder.stop()
    progress = ended(recorder)
    assert progress.ended and (progress.frames, progress.size) == (0, 0)
    assert progress.reason == f"{tmp_path / NAMES[kind]} could not be finished: it was removed"


def test_a_removed_folder_keeps_no_frames(camera, tmp_path):
    recorder = Recorder(camera, create_writer(RecordingKind.PNG, tmp_path / "images", camera.info))
    recorder.start()
    camera.start()
    until(lambda: recorder.progress.frames >= 3, "frames")
    (tmp_path / "images").rename(tmp_path / "elsewhere")
    progress = ended(recorder)
    assert progress.frames == 0 and progress.reason.endswith(
        "No such file or directory; nothing was recorded"
    )


def test_a_slow_disk_drops_frames_and_counts_them(camera, tmp_path, monkeypatch):
    writer = create_writer(RecordingKind.MCAP, tmp_path / "x.mcap", INFO)
    really = writer.write
    monkeypatch.setattr(writer, "write", lambda frame: (time.sleep(0.3), really(frame)))
    recorder = Recorder(camera, writer, RecordingLimits(frames=3), reserve=0)
    recorder.start()
    camera.start()
    progress = ended(recorder)
    assert progress.frames == 3 and progress.dropped > 10
    recording = open_recording(tmp_path / "x.mcap")
    assert len(recording) == 3
    recording.close()


@pytest.mark.parametrize("kind", RecordingKind)
def test_a_disk_that_fills_up_ends_it_with_readable_files(camera, tmp_path, monkeypatch, kind):
    path = tmp_path / NAMES[kind]
    writer = create_writer(kind, path, INFO, 100)
    left = iter([10**9] * 5 + [10**6] * 99)
    monkeypatch.setattr(writer, "free", lambda: next(left))
    recorder = Recorder(camera, writer)
    recorder.start()
    camera.start()
    progress = ended(recorder)
    assert progress.frames == 5
    assert progress.reason == (f"the disk of {path} is full (0 MiB left); 5 frames recorded by then are kept")
    recording = open_recording(path)
    assert len(recording) == 5
    assert recording.frame(4, 0).width == 64
    recording.close()


@pytest.mark.parametrize("fitting", [0, 5])
def test_images_that_did_not_fit_are_not_counted(camera, tmp_path, monkeypatch, fitting):
    """As with a quota, or where another program filled the disk."""
    save = Path.write_bytes

    def limited(file, content):
        if file.suffix == ".png" and int(file.stem) >= fitting:
            raise OSError(errno.EDQUOT, "Disk quota exceeded")
        return save(file, content)

    monkeypatch.setattr(Path, "write_bytes", limited)
    path = tmp_path / "images"
    recorder = Recorder(camera, create_writer(RecordingKind.PNG, path, INFO), reserve=0)
    recorder.start()
    camera.start()
    progress = ended(recorder)
    assert progress.frames == fitting
    assert "Disk quota exceeded" in progress.reason
    if fitting:
        with contextlib.closing(open_recording(path)) as recording:
            assert len(recording) == fitting
    else:
        assert progress.reason.endswith("nothing was recorded")
        assert not path.exists()


SOON_FULL = (
    RecordingKind.PNG,
    RecordingKind.TIFF,
    RecordingKind.LOSSLESS,
    RecordingKind.FFV1,
    RecordingKind.MCAP,
)


@pytest.mark.parametrize(
    ("kind", "room"), [*((kind, 300) for kind in RecordingKind), *((kind, 60_000) for kind in SOON_FULL)]
)
def test_the_frames_that_are_counted_are_those_that_play(camera, tmp_path, monkeypatch, kind, room):
    """Where another program fills the disk, encoders and buffers have accepted more than is in the file."""
    really, save = Path.open, Path.write_bytes

    def limited(path, mode="r", *arguments, **options):
        opened = really(path, mode, *arguments, **options)
        return FullDisk(opened, room) if mode == "xb" else opened

    def limited_image(path, content):
        if int(path.stem) * len(content) > room:
            raise OSError(errno.ENOSPC, "No space left on device")
        return save(path, content)

    monkeypatch.setattr(Path, "open", limited)
    monkeypatch.setattr(Path, "write_bytes", limited_image)
    path = tmp_path / NAMES[kind]
    recorder = Recorder(camera, create_writer(kind, path, INFO, 100), reserve=-(10**12))
    recorder.start()
    camera.start()
    progress = ended(recorder)
    camera.stop()
    assert progress.error is not None
    if not path.exists():
        assert progress.frames == 0 and progress.reason.endswith("nothing was recorded")
        return
    assert progress.frames == playable_frames(path)
    if progress.frames:
        with contextlib.closing(open_recording(path)) as recording:
            played = [recording.frame(index, 0) for index in range(progress.frames)]
        assert f"{len(played)} frame" in progress.reason


def test_less_than_nothing_is_not_left_on_a_disk():
    assert str(DiskFullError(Path("x.mp4"), -5)) == "the disk of x.mp4 is full (0 MiB left)"


def test_a_disk_without_any_room_leaves_no_file(camera, tmp_path, monkeypatch):
    path = tmp_path / "x.mcap"
    writer = create_writer(RecordingKind.MCAP, path, INFO)
    monkeypatch.setattr(writer, "free", lambda: 0)
    finish = writer.close

    def full():
        finish()
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(writer, "close", full)
    recorder = Recorder(camera, writer)
    recorder.start()
    camera.start()
    assert ended(recorder).reason == f"the disk of {path} is full (0 MiB left); nothing was recorded"
    assert not path.exists()


def test_the_time_that_is_left_follows_from_rate_and_free_space():
    progress = RecordingProgress(frames=100, seconds=10.0, size=1_000, free=60_000)
    assert progress.left == 600.0
    assert replace(progress, seconds=0.5).left is None, "too early"
    assert replace(progress, ended=True).left is replace(progress, size=0).left is None
