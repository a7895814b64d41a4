import threading
import weakref

import numpy as np
import pytest

from grabbergui.core.errors import FrameTimeoutError, StreamEndedError
from grabbergui.core.frame import Frame, FrameStatus
from grabbergui.core.frame_queue import FrameFanout, FrameQueue, RateMeter
from grabbergui.core.pfnc import by_name
from patience import PATIENCE, until


def frame(frame_id):
    return Frame(np.zeros(1, np.uint8), 1, 1, by_name("Mono8"), frame_id=frame_id)


def ids(queue):
    taken = []
    while True:
        try:
            taken.append(queue.get(0).frame_id)
        except FrameTimeoutError:
            return taken


def test_frames_are_returned_in_order():
    queue = FrameQueue(3)
    for number in range(3):
        queue.put(frame(number))
    assert ids(queue) == [0, 1, 2] and queue.dropped == 0


def test_a_full_queue_drops_the_oldest_frame_and_counts_it():
    queue = FrameQueue(2)
    for number in range(5):
        queue.put(frame(number))
    assert ids(queue) == [3, 4] and queue.dropped == 3


def test_a_queue_of_depth_zero_is_refused():
    with pytest.raises(ValueError, match="depth 0"):
        FrameQueue(0)


def test_waiting_ends_after_the_timeout():
    with pytest.raises(FrameTimeoutError, match=r"within 0\.01 s"):
        FrameQueue().get(0.01)


def test_closing_wakes_waiting_threads_and_discards_frames():
    queue = FrameQueue()
    caught = []

    def wait():
        try:
            queue.get(PATIENCE)
        except FrameTimeoutError as error:
            caught.append(str(error))

    threads = [threading.Thread(target=wait) for _ in range(3)]
    for thread in threads:
        thread.start()
    queue.close()
    for thread in threads:
        thread.join(PATIENCE)
    assert caught == ["the stream was closed"] * 3
    queue.close()
    assert queue.closed and ids(queue) == []


def test_a_closed_queue_accepts_no_frames():
    """A frame keeps its buffer from the pool; nobody would ever give it back."""
    queue = FrameQueue()
    queue.close()
    queue.put(frame(1))
    assert ids(queue) == [] and queue.dropped == 0


@pytest.mark.parametrize("timeout", [float("inf"), 1e300])
def test_waiting_without_end_is_allowed(timeout):
    queue = FrameQueue(1)
    sender = threading.Timer(0.05, queue.put, [frame(1)])
    sender.start()

    assert queue.get(timeout).frame_id == 1
    sender.join()


def test_no_wait_is_longer_than_this_system_allows(monkeypatch):
    """Windows: 49 days."""
    monkeypatch.setattr(threading, "TIMEOUT_MAX", 0.01)
    with pytest.raises(FrameTimeoutError, match=r"within 1e\+09 s"):
        FrameQueue().get(1e9)


def test_a_waiting_consumer_gets_the_frame_another_thread_puts():
    queue = FrameQueue()
    thread = threading.Thread(target=lambda: queue.put(frame(9)))
    thread.start()
    assert queue.get(PATIENCE).frame_id == 9
    thread.join()


def test_every_frame_put_by_many_threads_is_returned_or_counted_as_dropped():
    queue = FrameQueue(4)
    taken = []

    def take():
        try:
            while True:
                taken.append(queue.get(PATIENCE))
        except FrameTimeoutError:
            pass

    taker = threading.Thread(target=take)
    putters = [threading.Thread(target=lambda: [queue.put(frame(n)) for n in range(300)]) for _ in range(3)]
    taker.start()
    for putter in putters:
        putter.start()
    for putter in putters:
        putter.join()
    until(lambda: len(taken) + queue.dropped == 900)
    queue.close()
    taker.join(PATIENCE)
    assert not taker.is_alive()


def test_the_fanout_reaches_every_open_queue():
    fanout = FrameFanout()
    slow, gone, quick = fanout.open_queue(1), fanout.open_queue(), fanout.open_queue(5)
    gone.close()
    assert fanout.consumers == 2
    for number in range(3):
        fanout.put(frame(number))
    assert ids(slow) == [2] and ids(quick) == [0, 1, 2] and slow.dropped == 2 and quick.dropped == 0
    fanout.put(frame(3))
    fanout.clear()
    assert ids(quick) == []
    fanout.close()
    assert quick.closed and fanout.consumers == 0


def test_a_queue_that_was_closed_is_not_kept():
    fanout = FrameFanout()
    closed = fanout.open_queue()
    reference = weakref.ref(closed)
    closed.close()
    del closed
    fanout.open_queue()
    assert reference() is None


def test_only_a_frame_without_missing_packets_is_complete():
    assert frame(1).complete
    assert not Frame(np.zeros(1, np.uint8), 1, 1, by_name("Mono8"), status=FrameStatus.INCOMPLETE).complete


def test_rates_are_right_from_the_second_event_on():
    meter = RateMeter(window=2)
    assert meter.rates(now=0) == (0, 0)
    meter.add(100, now=10.0)
    assert meter.rates(now=10.0) == (0, 0)
    meter.add(100, now=10.1)
    assert meter.rates(now=10.1) == pytest.approx((10, 1000))
    for step in range(2, 50):
        meter.add(100, now=10 + step / 10)
    assert meter.rates(now=14.95) == pytest.approx((10, 1000))


def test_a_stalled_stream_slows_down_and_stops():
    meter = RateMeter(window=2)
    for step in range(11):
        meter.add(1, now=step / 10)
    assert meter.rates(now=1.2) == pytest.approx((10, 10))
    assert meter.rates(now=1.5) == pytest.approx((10 / 1.4, 10 / 1.4)), (
        "ten periods, and four without an event"
    )
    assert meter.rates(now=3.5) == (0, 0)


def test_a_slow_stream_has_a_rate_too():
    """At 0.5 Hz the window showed 0.0 fps while images came."""
    meter = RateMeter(window=2)
    for step in range(5):
        meter.add(10, now=2.0 * step)
    for now in (8.0, 9.0, 9.9, 11.9):
        assert meter.rates(now=now) == pytest.approx((0.5, 5))
    assert meter.rates(now=13.0)[0] < 0.5
    assert meter.rates(now=15.0) == (0, 0)


def test_simultaneous_events_give_no_infinite_rate():
    meter = RateMeter()
    meter.add(1, now=5.0)
    meter.add(1, now=5.0)
    assert meter.rates(now=5.0) == (0, 0)


def test_a_cleared_meter_measures_anew():
    meter = RateMeter()
    for second in range(3):
        meter.add(7, now=second / 2)
    assert meter.rates(now=1.0) == (2, 14)
    meter.clear()
    assert meter.rates(now=1.0) == (0, 0)


def test_two_events_far_apart_have_a_rate():
    meter = RateMeter(window=2)
    meter.add(10, now=0.0)
    assert meter.rates(now=0.0) == (0.0, 0.0)
    meter.add(30, now=5.0)
    assert meter.rates(now=5.0) == (0.2, 6.0)
    assert meter.rates(now=15.0)[0] == 0.2 and meter.rates(now=16.0)[0] < 0.2, "a stream that has stalled"


def test_a_source_that_can_wait_is_told_of_a_full_queue_that_needs_all():
    fanout = FrameFanout()
    loop, view = fanout.open_queue(2), fanout.open_queue(2)
    loop.needs_all = True
    fanout.put(frame(0))
    assert not fanout.awaited
    fanout.put(frame(1))
    assert fanout.awaited
    view.get(0), view.get(0)
    assert not fanout.awaited, "the other consumer waits for a frame"
    view.close()
    assert fanout.awaited
    loop.get(0)
    assert not fanout.awaited


def test_the_end_of_a_stream_is_reported_once_behind_the_frames_that_wait():
    fanout = FrameFanout()
    queue = fanout.open_queue(2)
    for number in range(3):
        fanout.put(frame(number))
    fanout.end()
    assert [queue.get(0).frame_id, queue.get(0).frame_id] == [1, 2] and queue.dropped == 1
    with pytest.raises(StreamEndedError):
        queue.get(PATIENCE)
    with pytest.raises(FrameTimeoutError, match="within 0 s"):
        queue.get(0)


def test_a_stream_that_starts_again_does_not_report_its_end():
    fanout = FrameFanout()
    queue = fanout.open_queue(1)
    fanout.end()
    fanout.clear()
    fanout.put(frame(7))
    assert ids(queue) == [7] and queue.dropped == 0


def test_an_end_that_a_slow_consumer_did_not_see_counts_as_no_frame():
    queue = FrameQueue(1)
    queue.end()
    queue.put(frame(1))
    assert ids(queue) == [1] and queue.dropped == 0
