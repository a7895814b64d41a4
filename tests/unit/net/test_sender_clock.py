"""The age of remote images: clocks that agree or not, late images, and clocks that are set."""

import pytest

from grabbergui.net.sender_clock import SenderClock

MS = 1_000_000
PERIOD = 40 * MS
START = 1_700_000_000_000 * MS


class Sender:
    """Sends an image every 40 ms; its clock is `off` ours, and `fast` by a factor."""

    def __init__(self, off=0, fast=0.0):
        self.off, self.fast = off, fast
        self.now = 5000 * MS  # monotonic
        self.day = START  # our time of day, at monotonic 0
        self.clock = SenderClock()

    def ages(self, *delays):
        """The ages of images that take so many milliseconds, rounded to milliseconds."""
        found = []
        for delay in delays:
            self.now += PERIOD
            stamp = self.day + self.off + self.now + round(self.fast * self.now)
            arrived = self.now + delay * MS
            found.append(round(self.clock.age(stamp, arrived, self.day + arrived) / MS))
        return found


def test_the_stamp_counts_where_the_clocks_agree():
    assert Sender().ages(8, 12, 30, 1000, 1000, 9) == [8, 12, 30, 1000, 1000, 9]


@pytest.mark.parametrize("off", [-3600_000, -700, -200, 300, 3600_000])
def test_images_that_begin_to_be_late_are_old_by_any_clock(off):
    sender = Sender(off * MS)
    assert sender.ages(8, 12, 9) == [0, 4, 1]
    assert sender.ages(1008, 1010, 8) == [1000, 1002, 0]


@pytest.mark.parametrize("fast", [-1e-4, -2e-5, 2e-5, 1e-4])
def test_a_clock_that_runs_fast_or_slow_makes_no_image_old(fast):
    sender = Sender(-700 * MS, fast)
    ages = sender.ages(*[8] * 20_000)  # a quarter of an hour
    assert max(ages) <= 1
    assert sender.ages(1008)[0] == pytest.approx(1000, abs=10)


def test_a_senders_clock_that_is_set_back_or_forward_makes_no_image_old_for_long():
    for step in (-3600_000, 3600_000, 500):
        sender = Sender()
        sender.ages(8, 9)
        sender.off += step * MS
        assert sender.ages(8, 9, 8) == [0, 1, 0]


def test_our_own_clock_that_is_set_changes_nothing():
    for step in (-1000, 1000):
        sender = Sender()
        sender.ages(8, 9)
        sender.day += step * MS  # the sender is on this computer
        assert sender.ages(8, 9) == [8, 9]


def test_an_image_without_a_stamp_is_as_old_as_its_arrival():
    clock = SenderClock()
    assert clock.age(0, 5000 * MS, START) == 0
    assert clock.age(-1, 5000 * MS, START) == 0


def test_a_first_late_image_is_corrected_by_the_next():
    assert Sender().ages(800, 8, 800) == [0, 8, 800]
