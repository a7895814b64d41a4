"""Work on several threads whose results come in order, and writers that use it."""

import threading

import numpy as np
import pytest

from grabbergui.core import pfnc
from grabbergui.core.frame import Frame
from grabbergui.core.identity import DeviceInfo
from grabbergui.recording.kinds import RecordingKind
from grabbergui.recording.opening import open_recording
from grabbergui.recording.ordered_work import OrderedWork
from grabbergui.recording.recorder import create_writer
from patience import PATIENCE

INFO = DeviceInfo("sim:", model="M")


def test_results_are_in_the_order_of_the_tasks():
    done, second_began = [], threading.Event()
    work = OrderedWork("test", 2, 8, done.append)

    def first():
        assert second_began.wait(PATIENCE)  # overtaken
        return 1

    work.add(first)
    work.add(lambda: second_began.set() or 2)
    work.finish()

    assert done == [1, 2]


def test_no_more_tasks_than_allowed_are_held():
    done, release = [], threading.Event()
    work = OrderedWork("test", 1, 2, done.append)
    for number in (1, 2):
        work.add(lambda number=number: release.wait(PATIENCE) and number)
    assert (work.held, done) == (2, [])

    threading.Timer(0.05, release.set).start()
    work.add(lambda: 3)  # waits for the first

    assert done[0] == 1 and work.held <= 2
    work.finish()
    assert done == [1, 2, 3]


def test_with_none_waiting_a_task_is_done_when_add_returns():
    done = []
    work = OrderedWork("test", 1, 0, done.append)

    work.add(lambda: 1)

    assert (done, work.held) == ([1], 0)
    work.finish()


def test_an_error_is_raised_by_a_later_call_and_the_other_tasks_are_still_done():
    done, release = [], threading.Event()
    work = OrderedWork("test", 1, 1, done.append)
    work.add(lambda: release.wait(PATIENCE) and 1 // 0)
    release.set()
    with pytest.raises(ZeroDivisionError):
        work.add(lambda: 2)

    work.finish()

    assert done == [2]
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("test_")]


def frames(count, width=320, height=240):
    random = np.random.default_rng(1)
    for index in range(count):
        payload = random.integers(0, 256, width * height, np.uint8)
        yield Frame(payload, width, height, pfnc.by_name("BayerRG8"), index, index, 10**18 + index)


@pytest.mark.parametrize("kind", [RecordingKind.PNG, RecordingKind.H264])
def test_images_compressed_side_by_side_are_noted_in_order(tmp_path, kind):
    path = tmp_path / ("x.mp4" if kind is RecordingKind.H264 else "x")
    writer = create_writer(kind, path, INFO)
    made = list(frames(20))
    for frame in made:
        writer.write(frame)
    writer.close()

    recording = open_recording(path)
    assert len(recording) == 20
    for index in (0, 7, 19):
        read = recording.frame(index, 0)
        assert recording.times_ns[index] - recording.times_ns[0] == index
        assert read.timestamp_ns == made[index].timestamp_ns
        if kind is RecordingKind.PNG:
            assert np.array_equal(read.raw(), made[index].raw())
    recording.close()


def test_an_image_that_does_not_fit_is_not_noted_and_those_around_it_are(tmp_path, monkeypatch):
    writer = create_writer(RecordingKind.PNG, tmp_path / "x", INFO)
    really = type(tmp_path).write_bytes
    overtaken = threading.Event()

    def write_bytes(path, data):
        if path.name == "00000002.png":
            really(path, bytes(data)[:100])
            assert overtaken.wait(PATIENCE)
            raise OSError(28, "No space left on device")
        written = really(path, data)
        if path.name == "00000003.png":
            overtaken.set()
        return written

    monkeypatch.setattr(type(tmp_path), "write_bytes", write_bytes)
    with pytest.raises(OSError, match="space"):
        for frame in frames(50):
            writer.write(frame)
    writer.close()

    names = sorted(path.name for path in (tmp_path / "x").glob("*.png"))
    assert "00000002.png" not in names and names[:3] == ["00000000.png", "00000001.png", "00000003.png"]
    recording = open_recording(tmp_path / "x")
    assert len(recording) == len(names)
    recording.close()


def test_images_being_compressed_count_for_the_size(tmp_path):
    writer = create_writer(RecordingKind.PNG, tmp_path / "x", INFO)
    for frame in frames(10):
        writer.write(frame)
    estimate = writer.size()
    writer.close()

    assert abs(estimate - writer.size()) < 0.1 * writer.size()
