"""A consumer of a stream: fed on a thread of its own, counted, and never lost to its own errors."""

import logging
import threading
import time

import numpy as np
import pytest

from grabbergui.core import pfnc
from grabbergui.core.errors import PixelFormatError
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameFanout, FrameSink
from patience import PATIENCE, until


def frame(number):
    return Frame(np.zeros(16, np.uint8), 4, 4, pfnc.by_name("Mono8"), frame_id=number)


@pytest.fixture
def stream():
    return FrameFanout()


@pytest.fixture
def sinks():
    begun = []
    yield begun
    assert all(sink.stop(PATIENCE) for sink in begun)


def sink_of(stream, consume, sinks, **options):
    sink = FrameSink(stream, consume, name="test sink", wait=0.01, **options)
    sinks.append(sink)
    sink.start()
    return sink


def running():
    """Return the names of all threads."""
    return {thread.name for thread in threading.enumerate()}


def test_every_frame_is_delivered_in_order(stream, sinks):
    seen = []
    sink = sink_of(stream, lambda one: seen.append(one.frame_id), sinks, depth=50)
    for number in range(50):
        stream.put(frame(number))
    until(lambda: len(seen) == 50)
    assert seen == list(range(50))
    until(lambda: sink.consumed == 50)
    assert sink.dropped == 0 and sink.rate > 0


def test_a_slow_consumer_loses_the_oldest_frames_which_are_counted(stream, sinks):
    seen, go_on = [], threading.Event()
    sink = sink_of(stream, lambda one: (seen.append(one.frame_id), go_on.wait(PATIENCE)), sinks)
    stream.put(frame(0))
    until(lambda: seen == [0])
    for number in range(1, 11):
        stream.put(frame(number))
    go_on.set()
    until(lambda: seen == [0, 9, 10])
    assert sink.dropped == 8


@pytest.mark.parametrize("error", [PixelFormatError("no colours"), ValueError("short")])
def test_a_consumer_that_fails_is_reported_once_and_gets_the_next_frame(stream, sinks, error):
    reported, seen = [], []

    def consume(one):
        seen.append(one.frame_id)
        if one.frame_id != 2:
            raise error

    sink = sink_of(stream, consume, sinks, depth=9, failed=lambda error, one: reported.append(error))
    for number in range(5):
        stream.put(frame(number))
    until(lambda: len(seen) == 5)
    until(lambda: len(reported) == 2)  # and once more after frame 2, which was consumed
    assert reported == [error, error]
    assert sink.consumed == 1


def test_another_failure_than_the_last_is_reported_too(stream, sinks):
    reported = []

    def consume(one):
        raise PixelFormatError(f"no {'colours' if one.frame_id < 2 else 'depth'}")

    sink_of(
        stream, consume, sinks, depth=9, failed=lambda error, one: reported.append((str(error), one.frame_id))
    )
    for number in range(4):
        stream.put(frame(number))
    until(lambda: len(reported) == 2)
    assert reported == [("no colours", 0), ("no depth", 2)]


def test_a_failing_report_of_a_failure_does_not_end_the_sink(stream, sinks, caplog):
    def consume(one):
        if one.frame_id == 0:
            raise PixelFormatError("no colours")

    def failed(error, one):
        raise RuntimeError("the display is closed")

    sink = sink_of(stream, consume, sinks, depth=2, failed=failed)
    for number in range(2):
        stream.put(frame(number))
    until(lambda: sink.consumed == 1)
    assert "the display is closed" in caplog.text


def test_an_unhandled_failure_is_logged(stream, sinks, caplog):
    def consume(one):
        raise PixelFormatError("no colours")

    with caplog.at_level(logging.WARNING):
        sink_of(stream, consume, sinks)
        stream.put(frame(0))
        until(lambda: "test sink: no colours" in caplog.text)


def test_a_sink_ends_with_its_source(stream, sinks):
    sink_of(stream, lambda one: None, sinks)
    stream.close()
    until(lambda: "test sink" not in running())


def test_a_sink_that_reopens_waits_for_its_source_without_spinning(stream, sinks):
    seen, turns = [], []
    sink_of(
        stream,
        lambda one: seen.append(one.frame_id),
        sinks,
        reopens=True,
        between=lambda: turns.append(time.monotonic()),
    )
    stream.close()
    until(lambda: len(turns) >= 12)
    assert turns[11] - turns[1] > 10 * 0.005
    until(lambda: stream.consumers)
    stream.put(frame(7))
    until(lambda: seen == [7])


def test_frames_that_were_dropped_before_its_source_closed_still_count(stream, sinks):
    seen, go_on = [], threading.Event()
    sink = sink_of(stream, lambda one: (seen.append(one.frame_id), go_on.wait(PATIENCE)), sinks, reopens=True)
    stream.put(frame(0))
    until(lambda: seen == [0])
    for number in range(1, 6):
        stream.put(frame(number))
    stream.close()
    go_on.set()
    until(lambda: stream.consumers)
    stream.put(frame(6))
    until(lambda: seen[-1] == 6)
    assert sink.dropped == 3


def test_a_sink_that_is_stopped_while_it_opens_a_queue_again_keeps_none(sinks):
    class Source(FrameFanout):
        def open_queue(self, depth=2):
            if sinks:
                sinks[0].stop()
            return super().open_queue(depth)

    source = Source()
    sink_of(source, lambda one: None, sinks, reopens=True)
    source.close()
    until(lambda: "test sink" not in running())
    assert source.consumers == 0


def test_between_is_called_while_no_frame_arrives_and_at_the_end(stream, sinks):
    jobs, done = [], []
    sink = sink_of(stream, lambda one: None, sinks, between=lambda: done.extend(jobs))
    jobs.append(1)
    until(lambda: done)
    done.clear()
    jobs.append(2)
    assert sink.stop(PATIENCE)
    assert 2 in done


def test_a_consumer_may_stop_its_own_sink(stream, sinks):
    seen = []

    def consume(one):
        seen.append(one.frame_id)
        assert sinks[0].stop()

    sink = sink_of(stream, consume, sinks, depth=9)
    stream.put(frame(0))
    until(lambda: seen == [0])
    stream.put(frame(1))
    assert sink.stop(PATIENCE) and seen == [0]


def test_a_sink_that_was_never_started_can_be_stopped(stream):
    sink = FrameSink(stream, lambda one: None, name="test sink")
    assert sink.stop(0) and not stream.consumers
