"""A device's stream, what it counted once it is gone, and the loss of its camera."""

from dataclasses import dataclass, field

import pytest

from fakes import XmlDevice
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.driver.device import lost_between


@dataclass
class Counting:
    """A stream that counts a last frame while it is closed, as a real one may."""

    counted: StreamStatistics = field(default_factory=lambda: StreamStatistics(frames=4, frame_rate=30.0))
    closed: int = 0

    def close(self):
        self.closed += 1
        self.counted.frames += 1

    def statistics(self):
        return self.counted


class Receiving(XmlDevice):
    """A device with a stream of the test's."""

    def receive(self, stream):
        self._receiving = stream


def test_what_was_counted_stays_when_the_stream_is_gone_but_nothing_runs_any_more():
    device, stream = Receiving(b""), Counting()
    assert device.stream_statistics() == StreamStatistics()
    device.receive(stream)
    assert device.stream_statistics() is stream.counted
    device.close_stream()
    device.close_stream()
    assert stream.closed == 1
    assert device.stream_statistics() == StreamStatistics(frames=5, frame_rate=0.0)


def test_nobody_changes_what_was_counted():
    device = Receiving(b"")
    device.receive(Counting())
    device.close_stream()
    device.stream_statistics().frames = 99
    assert device.stream_statistics().frames == 5


def test_a_loss_is_reported_once_whoever_detects_it_first():
    device, reported = XmlDevice(b""), []
    device.report_lost("nobody listens")
    device.lost, device.on_lost = "", reported.append
    device.report_lost("unplugged")
    device.report_lost("no answer")
    assert reported == ["unplugged"] and device.lost == "unplugged"


@pytest.mark.parametrize(
    "steps, lost",
    [(1, 0), (2, 1), (10_000, 9_999), (10_001, 0), (1 << 63, 0), (0, 0), (-65534, 0)],
)
def test_only_a_gap_of_sensible_length_counts_as_lost(steps, lost):
    assert lost_between(steps) == lost
