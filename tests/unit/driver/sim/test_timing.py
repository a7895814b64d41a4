"""Cadence, modes and triggers, with time as an argument."""

import itertools

from grabbergui.driver.sim.timing import BURST_START, FRAME_START, Sequencer, SimulatedClock, Timing

FREE = Timing(100, (False, False))
PER_FRAME = Timing(100, (True, False))
PER_BURST = Timing(100, (False, True), 3)


def started(frames=None):
    sequencer = Sequencer()
    sequencer.start(1000, frames)
    return sequencer


def test_nothing_is_due_before_the_start_and_after_the_stop():
    sequencer = Sequencer()
    assert sequencer.due(FREE) is None
    sequencer.start(1000, None)
    assert sequencer.due(FREE) == 1000
    sequencer.stop()
    assert sequencer.due(FREE) is None
    assert sequencer.take(FREE, 2000) is None


def test_free_running_frames_keep_their_cadence_and_count_from_one():
    sequencer = started()
    assert [sequencer.take(FREE, 1000 + 100 * n + 30) for n in range(3)] == [(1, 1000), (2, 1100), (3, 1200)]


def test_frames_are_skipped_when_the_reader_falls_behind():
    sequencer = started()
    sequencer.take(FREE, 1000)
    assert sequencer.take(FREE, 5000) == (2, 4900)


def test_an_acquisition_of_so_many_frames_ends_by_itself():
    sequencer = started(2)
    sequencer.take(FREE, 1000)
    assert not sequencer.finished
    sequencer.take(FREE, 1100)
    assert sequencer.finished
    assert sequencer.due(FREE) is None


def test_one_trigger_gives_one_frame():
    sequencer = started()
    assert sequencer.due(PER_FRAME) is None
    assert sequencer.trigger(FRAME_START, 1500)
    assert sequencer.take(PER_FRAME, 1500) == (1, 1500)
    assert sequencer.due(PER_FRAME) is None


def test_a_trigger_during_readout_is_lost():
    sequencer = started()
    sequencer.trigger(FRAME_START, 1500)
    assert not sequencer.trigger(FRAME_START, 1510)
    sequencer.take(PER_FRAME, 1500)
    assert not sequencer.trigger(FRAME_START, 1590)
    assert sequencer.trigger(FRAME_START, 1600)


def test_a_trigger_without_acquisition_is_lost():
    assert not Sequencer().trigger(FRAME_START, 1)


def test_a_burst_trigger_gives_its_frames_and_then_waits():
    sequencer = started()
    assert sequencer.due(PER_BURST) is None
    assert sequencer.trigger(BURST_START, 2000)
    assert [sequencer.take(PER_BURST, 2500) for _ in range(3)] == [(1, 2000), (2, 2100), (3, 2200)]
    assert sequencer.due(PER_BURST) is None


def test_switching_ptp_loses_no_time_on_a_busy_machine():
    """The clock lost what passed between two looks at the host's: a millisecond, once in many runs."""
    times = itertools.count(0, 1_000_000)  # each look is a millisecond after the one before
    clock = SimulatedClock(lambda: next(times), drift=50e-6)
    before = clock.to_monotonic(0)
    clock.follow(False)
    assert clock.to_monotonic(0) == before
