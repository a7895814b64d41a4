"""Every n-th frame, and time-lapse."""

import pytest

from grabbergui.core.errors import UsageError
from grabbergui.recording.thinning import ThinnedFrames, Thinning


def taken(thinning, times):
    frames = ThinnedFrames(thinning)
    return [at for at in times if frames.take(at)]


def test_all_every_third_and_one_a_second():
    times = [number / 10 for number in range(50)]
    assert taken(Thinning(), times) == times
    assert taken(Thinning(every=3), times) == times[::3]
    assert taken(Thinning(interval=1), times) == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert taken(Thinning(every=2, interval=1), [0.0, 0.5, 1.1, 1.2, 2.3]) == [0.0, 1.1, 2.3]


def test_late_frames_do_not_shift_the_ones_after_them():
    assert taken(Thinning(interval=10), [100, 109.9, 112, 119, 120.5, 145, 149, 150]) == [
        100, 112, 120.5, 145, 150,
    ]  # fmt: skip


def test_the_rate_of_what_is_recorded():
    assert Thinning(every=4).rate(20) == 5
    assert Thinning(interval=2).rate(20) == 0.5
    assert Thinning(interval=2).rate(0) == 0.5
    assert Thinning(every=100, interval=1).rate(10) == 0.1


@pytest.mark.parametrize("wrong", [{"every": 0}, {"interval": -1.0}, {"interval": float("nan")}])
def test_what_cannot_be_is_refused(wrong):
    with pytest.raises(UsageError):
        Thinning(**wrong)
