"""A device's stream, and what it counted once it is gone."""

from dataclasses import dataclass, field

from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.driver.device import StreamSlot


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


def test_what_was_counted_stays_when_the_stream_is_gone_but_nothing_runs_any_more():
    slot, stream = StreamSlot(), Counting()
    assert not slot.taken and slot.statistics() == StreamStatistics()
    slot.put(stream)
    assert slot.taken and slot.statistics() is stream.counted
    slot.close()
    slot.close()
    assert not slot.taken and stream.closed == 1
    assert slot.statistics() == StreamStatistics(frames=5, frame_rate=0.0)


def test_nobody_changes_what_was_counted():
    slot = StreamSlot()
    slot.put(Counting())
    slot.close()
    slot.statistics().frames = 99
    assert slot.statistics().frames == 5
