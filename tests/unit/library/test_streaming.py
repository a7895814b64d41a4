"""The stream of a camera that several loops, recordings and grabs use at once."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import grabbergui
from grabbergui.core.errors import FrameTimeoutError, GrabberError
from grabbergui.library.streaming import StreamUse
from patience import until

FAST = "sim:?width=64&height=48&fps=200&exposure=1000"


@pytest.fixture
def camera() -> Iterator[grabbergui.Camera]:
    with grabbergui.open(FAST) as camera:
        yield camera


def test_a_loop_that_ends_leaves_the_stream_to_another(camera: grabbergui.Camera) -> None:
    first, second = iter(camera.frames()), iter(camera.frames())
    next(first), next(second)
    first.close()
    assert camera.streaming
    ids = [next(second).frame_id for _ in range(20)]  # more than waited for it
    assert ids == sorted(set(ids))
    second.close()
    assert not camera.streaming


@pytest.mark.parametrize("recording_first", [True, False])
def test_a_recording_and_a_loop_leave_each_other_the_stream(
    camera: grabbergui.Camera, tmp_path: Path, recording_first: bool
) -> None:
    if recording_first:
        recording = camera.record(tmp_path / "run.mcap")
        assert len(list(camera.frames(2))) == 2
        assert camera.streaming
        seen = recording.progress.frames
        until(lambda: recording.progress.frames >= seen + 2, "frames after the end of the loop")
        assert recording.stop().frames >= 2
    else:
        loop = iter(camera.frames())
        next(loop)
        camera.record(tmp_path / "run.mcap", frames=2).wait()
        assert camera.streaming
        loop.close()
    assert not camera.streaming


def test_a_stream_that_is_started_inside_a_loop_goes_on(camera: grabbergui.Camera) -> None:
    for _ in camera.frames(2):
        camera.start()
    assert camera.streaming


def test_a_loop_that_ends_leaves_the_stream_to_a_grab_that_waits(camera: grabbergui.Camera) -> None:
    use = StreamUse(camera.grabber)
    with use.loop(camera.grabber.start), use.grab():
        pass
    assert not camera.streaming
    with use.grab():
        with use.loop(camera.grabber.start):
            assert camera.streaming
        assert camera.streaming
    assert camera.streaming


def test_a_loop_whose_start_fails_leaves_nothing_behind(camera: grabbergui.Camera) -> None:
    def refuse() -> None:
        raise GrabberError("no")

    use = StreamUse(camera.grabber)
    with pytest.raises(GrabberError), use.loop(refuse):
        pass
    with use.loop(camera.grabber.start):
        assert camera.streaming
    assert not camera.streaming


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    """A recording of four frames."""
    path = tmp_path / "run.npy"
    np.save(path, np.arange(4, dtype=np.uint8).reshape(4, 1, 1) * np.ones((4, 8, 16), np.uint8))
    return path


def test_a_loop_over_a_recording_ends_behind_its_last_frame(recording: Path) -> None:
    with grabbergui.open(f"file:{recording}?loop=0&speed=20") as camera:
        for _ in range(2):  # the second loop plays it again
            assert [int(frame.raw()[0, 0]) for frame in camera.frames()] == [0, 1, 2, 3]
        assert not camera.streaming


def test_a_slow_loop_gets_every_frame_of_a_recording(recording: Path) -> None:
    with grabbergui.open(f"file:{recording}?loop=0&speed=20") as camera:
        frames = camera.frames(depth=1)
        with frames.started() as taken:
            until(lambda: camera.statistics.frames > 0, "a frame that waits for the loop")
            assert [int(frame.raw()[0, 0]) for frame in taken] == [0, 1, 2, 3]
        assert frames.dropped == 0


def test_a_loop_with_a_count_that_the_recording_lacks_ends_with_it(recording: Path) -> None:
    with grabbergui.open(f"file:{recording}?loop=0&speed=20") as camera:
        with camera.frames(100).started() as frames:
            assert len(list(frames)) == 4
        assert next(iter(camera.frames(0)), None) is None


def test_an_asyncio_loop_over_a_recording_ends(recording: Path) -> None:
    async def seen(camera: grabbergui.Camera) -> int:
        return len([frame async for frame in camera.aframes()])

    with grabbergui.open(f"file:{recording}?loop=0&speed=20") as camera:
        assert asyncio.run(seen(camera)) == 4


def test_a_frame_of_a_paused_recording_is_awaited_in_vain_with_the_reason(recording: Path) -> None:
    with grabbergui.open(f"file:{recording}") as camera:
        camera["PlaybackActive"] = False
        camera.start()
        with camera.frames(timeout=0.2).started() as frames, pytest.raises(FrameTimeoutError, match="paused"):
            for _ in range(3):
                next(frames)
