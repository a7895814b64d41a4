"""The last seconds before an event are recorded, and what follows; long recordings come in segments."""

import contextlib

import numpy as np
import pytest

from grabbergui.core.errors import FrameTimeoutError
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameFanout
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.pfnc import by_name
from grabbergui.recording.mcap_writer import McapWriter
from grabbergui.recording.opening import open_recording
from grabbergui.recording.pre_trigger import PreTriggerBuffer
from grabbergui.recording.segments import SegmentedWriter
from patience import until


def frame(number):
    return Frame(
        np.full(64, number % 256, np.uint8), 8, 8, by_name("Mono8"), frame_id=number,
        received_ns=10**18 + number * 10**8, captured=1000 + number / 10,
    )  # fmt: skip


class Bench:
    def __init__(self, **more):
        self.fanout = FrameFanout()
        self.buffer = PreTriggerBuffer(self.fanout, 1.0, 0.5, **more)
        self.queue = self.buffer.open_queue()
        self.number = 0

    def send(self, count):
        for _ in range(count):
            self.number += 1
            self.fanout.put(frame(self.number))
            until(lambda: self.buffer.newest == frame(self.number).captured)

    def recorded(self):
        found = []
        with contextlib.suppress(FrameTimeoutError):
            while True:
                found.append(self.queue.get(0).frame_id)
        return found


@pytest.fixture
def bench():
    made = Bench()
    yield made
    made.buffer.close()


def test_what_was_before_the_event_is_recorded_and_what_follows(bench):
    bench.send(30)
    assert bench.recorded() == [] and bench.buffer.kept == 11
    bench.buffer.trigger()
    bench.send(8)
    assert bench.recorded() == list(range(20, 36))  # a second before, half a second after
    bench.send(20)
    bench.buffer.trigger()
    assert bench.recorded() == list(range(48, 59)) and bench.buffer.triggers == 2 and not bench.buffer.dropped


def test_a_further_event_prolongs_the_recording(bench):
    bench.send(5)
    bench.buffer.trigger()
    bench.send(3)
    bench.buffer.trigger()
    bench.send(5)
    assert bench.recorded() == list(range(1, 14))


def test_memory_is_bounded():
    bench = Bench(memory=5 * 64)
    bench.send(20)
    assert bench.buffer.kept == 5
    bench.buffer.close()


def test_each_frame_is_in_one_segment(tmp_path):
    info = DeviceInfo("sim:")
    writer = SegmentedWriter(tmp_path / "run.mcap", lambda file: McapWriter(file, info), 1.0)
    for number in range(25):
        writer.write(frame(number))
    writer.close()
    files = sorted(tmp_path.iterdir())
    assert [file.name for file in files] == ["run.0001.mcap", "run.0002.mcap", "run.0003.mcap"]
    found = []
    for file in files:
        recording = open_recording(file)
        found += [recording.frame(index, 0).frame_id for index in range(len(recording))]
        recording.close()
    assert found == list(range(25)) and writer.size() == sum(file.stat().st_size for file in files)
