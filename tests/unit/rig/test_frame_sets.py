"""No order of arrivals, losses and drifts makes a mismatched set."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grabbergui.rig.frame_sets import (
    MOST_OPEN,
    FrameStamp,
    MatchByAction,
    MatchByCounter,
    MatchByTime,
    SetState,
    SetTimes,
)

MS = 1_000_000
NAMES = ("left", "right", "top")
TIMES = SetTimes(tolerance_ns=10 * MS, period_ns=30 * MS, deadline_ns=100 * MS, wait_ns=500 * MS)
"Frames may be measured up to 4 ms from their moment."

moments = st.lists(st.integers(30 * MS, 90 * MS), min_size=1, max_size=30).map(
    lambda gaps: [sum(gaps[: index + 1]) for index in range(len(gaps))]
)


@st.composite
def journeys(draw):
    """Frames as (arrival, camera, moment's index, measured time), lost and delayed at will, in any order."""
    times = draw(moments)
    frames = []
    for index, moment in enumerate(times):
        for name in NAMES:
            if draw(st.integers(0, 9)):
                measured = moment + draw(st.integers(-4 * MS, 4 * MS))
                frames.append((moment + draw(st.integers(0, 400 * MS)), name, index, measured))
    return times, sorted(frames)


def run(matcher, frames, stamp_of):
    """Feed the frames and return all finished sets; each frame is its moment's index."""
    sets = []
    for arrival, name, index, measured in frames:
        sets += matcher.add(name, index, stamp_of(name, index, measured), arrival)
    return sets + matcher.flush()


def check(sets, matcher, frames):
    """Nothing is mismatched, twice or out of order, and each frame is accounted for."""
    for each in sets:
        assert len(set(each.values())) <= 1
        assert set(each) | set(each.missing) == set(NAMES)
        assert (each.state is SetState.INCOMPLETE) == bool(each.missing)
    times = [each.time_ns for each in sets]
    assert times == sorted(times)
    indices = [each.index for each in sets]
    assert indices == sorted(set(indices))
    counts = matcher.statistics.counts()
    delivered = sum(map(len, sets))
    assert delivered + counts.uncertain + counts.overdue + counts.strays == len(frames)
    assert counts.sets == len(sets)


@given(journeys())
def test_no_order_and_loss_mismatches_sets_by_time(journey):
    _, frames = journey
    matcher = MatchByTime(NAMES, TIMES)
    sets = run(matcher, frames, lambda name, index, measured: FrameStamp(measured, 4 * MS))
    check(sets, matcher, frames)
    assert all(sets), "a set begins with a frame"


@given(journeys(), st.booleans())
def test_no_order_and_loss_mismatches_sets_by_action(journey, late):
    times, frames = journey
    matcher = MatchByAction(NAMES, TIMES)
    for moment in times:
        matcher.expect(moment, moment)
    sets = run(matcher, frames, lambda name, index, measured: FrameStamp(measured, 4 * MS))
    check(sets, matcher, frames)
    assert all(each.index == next(iter(each.values())) for each in sets if each)


@given(journeys(), st.booleans())
def test_no_order_and_loss_mismatches_sets_by_counter(journey, with_clocks):
    _, frames = journey
    matcher = MatchByCounter(NAMES, TIMES)
    uncertainty = 4 * MS if with_clocks else 10**12
    sets = run(matcher, frames, lambda name, index, measured: FrameStamp(measured, uncertainty, index + 1))
    for each in sets:
        assert len(set(each.values())) <= 1


@given(journeys(), st.data())
def test_a_camera_that_misses_triggers_is_put_right_by_its_clock(journey, data):
    """Each camera counts only the triggers that it accepted."""
    _, frames = journey
    numbers = {}
    for name in NAMES:
        own = sorted({index for _, camera, index, _ in frames if camera == name})
        missed = set(data.draw(st.lists(st.sampled_from(own), max_size=3))) if own else set()
        taken = [index for index in own if index not in missed]
        numbers |= {(name, index): number for number, index in enumerate(taken, 1)}
    frames = [frame for frame in frames if (frame[1], frame[2]) in numbers]
    matcher = MatchByCounter(NAMES, TIMES)
    sets = run(matcher, frames, lambda name, index, t: FrameStamp(t, 4 * MS, numbers[name, index]))
    for each in sets:
        assert len(set(each.values())) <= 1
    times = [each.time_ns for each in sets]
    assert times == sorted(times)


def test_in_order_and_without_loss_every_set_is_complete():
    for matcher in (MatchByTime(NAMES, TIMES), MatchByCounter(NAMES, TIMES)):
        sets = []
        for index in range(100):
            for name in NAMES:
                sets += matcher.add(name, index, FrameStamp(index * 40 * MS, 0, index + 1), index * 40 * MS)
        assert [each.state for each in sets] == [SetState.COMPLETE] * 100
        assert matcher.statistics.counts().skew_worst_ns == 0 and matcher.waiting == 0


def test_a_counter_goes_on_after_its_largest_number():
    matcher = MatchByCounter(("a", "b"), TIMES, first=0xFFFF - 9, modulus=0xFFFF)
    sets = []
    for index in range(0xFFFF - 10, 0xFFFF + 10):
        number = index % 0xFFFF + 1
        for name in ("a", "b"):
            sets += matcher.add(name, index, FrameStamp(index * 40 * MS, 10**12, number), index)
    assert [(each["a"], each["b"]) for each in sets] == [(n, n) for n in range(0xFFFF - 10, 0xFFFF + 10)]
    assert [each.index for each in sets] == list(range(20))


def test_a_missed_trigger_shifts_no_later_set():
    matcher = MatchByCounter(("a", "b"), TIMES)
    sets = []
    for index in range(20):
        moment = index * 40 * MS
        if index != 5:  # b was busy and did not count it
            sets += matcher.add("b", index, FrameStamp(moment, 0, index + 1 - (index > 5)), moment)
        sets += matcher.add("a", index, FrameStamp(moment, 0, index + 1), moment)
    sets += matcher.flush()
    assert [each.index for each in sets if each.missing] in ([5], [5, 6])
    assert sum(not each.missing for each in sets) >= 18 and matcher.statistics.slips == 1


def test_a_late_set_and_one_that_is_given_up():
    matcher = MatchByTime(("a", "b"), TIMES)
    assert matcher.add("a", 0, FrameStamp(0), 0) == []
    (late,) = matcher.add("b", 0, FrameStamp(1000), 101 * MS)
    assert late.state is SetState.LATE and late.skew_ns == 1000
    assert matcher.add("a", 1, FrameStamp(40 * MS), 140 * MS) == []
    assert matcher.advance(639 * MS) == []
    (given_up,) = matcher.advance(640 * MS)
    assert given_up.missing == ("b",) and given_up.state is SetState.INCOMPLETE
    assert matcher.add("b", 1, FrameStamp(40 * MS), 700 * MS) == []
    counts = matcher.statistics.counts()
    assert (counts.overdue, counts.incomplete, counts.missing) == (1, 1, {"a": 0, "b": 1})
    assert "1 incomplete (missing: b 1)" in str(counts) and "1 frames too late" in str(counts)


def test_a_lost_frame_is_known_from_the_next_one():
    matcher = MatchByTime(("a", "b"), TIMES)
    matcher.add("a", 0, FrameStamp(0), 0)
    matcher.add("a", 1, FrameStamp(40 * MS), 40 * MS)
    sets = matcher.add("b", 1, FrameStamp(40 * MS), 41 * MS)
    assert [each.missing for each in sets] == [("b",), ()]


def test_incomplete_sets_may_be_left_out_and_a_lost_camera_is_not_waited_for():
    matcher = MatchByTime(("a", "b"), TIMES, deliver_incomplete=False)
    matcher.set_present("b", present=False)
    assert matcher.add("a", 0, FrameStamp(0), 0) == []
    assert matcher.waiting == 0 and matcher.statistics.counts().incomplete == 1
    matcher.add("b", 1, FrameStamp(40 * MS), 40 * MS)  # it is back
    assert len(matcher.add("a", 1, FrameStamp(40 * MS), 40 * MS)) == 1


def test_an_expected_moment_without_any_frame_is_an_incomplete_set():
    matcher = MatchByAction(("a", "b"), TIMES)
    matcher.expect(100 * MS, 0)
    (none,) = matcher.advance(500 * MS)
    assert none.missing == ("a", "b") and not none and none.time_ns == 100 * MS


def test_the_time_until_a_scheduled_moment_and_the_way_of_its_frames_do_not_make_a_set_late():
    times = SetTimes(tolerance_ns=10 * MS, deadline_ns=50 * MS, wait_ns=200 * MS)
    matcher = MatchByAction(("a", "b"), times)
    for moment in (1000 * MS, 2000 * MS):
        matcher.expect(moment, moment)
    assert not matcher.advance(999 * MS)
    assert not matcher.add("a", 0, FrameStamp(1000 * MS), 1180 * MS)
    (whole,) = matcher.add("b", 0, FrameStamp(1000 * MS), 1225 * MS)
    assert whole.state is SetState.COMPLETE
    assert not matcher.add("a", 1, FrameStamp(2000 * MS), 2001 * MS)
    (late,) = matcher.add("b", 1, FrameStamp(2000 * MS), 2052 * MS)
    assert late.state is SetState.LATE


def test_frames_with_an_uncertain_time_are_left_out():
    matcher = MatchByTime(("a", "b"), TIMES)
    matcher.add("a", 0, FrameStamp(0, 11 * MS), 0)
    assert matcher.waiting == 0 and matcher.statistics.uncertain == 1


def test_memory_is_bounded_and_strangers_are_refused():
    matcher = MatchByTime(("a", "b"), SetTimes(tolerance_ns=10 * MS, wait_ns=10**18))
    finished = [matcher.add("a", index, FrameStamp(index * 40 * MS), 0) for index in range(200)]
    assert matcher.waiting == MOST_OPEN and sum(map(len, finished)) == 200 - MOST_OPEN
    with pytest.raises(ValueError, match="c is not one of a, b"):
        matcher.add("c", 0, FrameStamp(0), 0)


@settings(max_examples=20)
@given(st.integers(0, 10**9), st.integers(0, 10**9))
def test_cameras_that_run_free_are_paired_within_the_tolerance(phase_a, phase_b):
    period = 33 * MS
    matcher = MatchByTime(("a", "b"), SetTimes(tolerance_ns=period // 2, wait_ns=10**18))
    frames = [(phase_a % period + index * period, "a") for index in range(50)]
    frames += [(phase_b % period + index * period, "b") for index in range(50)]
    sets = [each for time, name in sorted(frames) for each in matcher.add(name, time, FrameStamp(time), time)]
    assert sum(not each.missing for each in sets) >= 48
    assert all(each.skew_ns <= period // 2 for each in sets)


def test_the_tolerance_shrinks_to_the_rate_that_is_seen():
    times = SetTimes(tolerance_ns=50 * MS, least_tolerance_ns=5 * MS, wait_ns=10**18)
    matcher = MatchByTime(("a", "b"), times)
    sets = matcher.add("a", 0, FrameStamp(0), 0) + matcher.add("b", 0, FrameStamp(30 * MS), 0)
    assert len(sets) == 1 and not sets[0].missing
    matcher.add("a", 1, FrameStamp(70 * MS), 0)
    assert matcher.times.tolerance_ns == 35 * MS
    matcher.add("a", 2, FrameStamp(74 * MS), 0)
    assert matcher.times.tolerance_ns == 5 * MS
