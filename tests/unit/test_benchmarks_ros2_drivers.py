"""The comparison of ROS 2 drivers counts and times images by their first pixel."""

import pytest

pytest.importorskip("benchmarks", reason="benchmarks/ is found from the checkout: python -m pytest")

from benchmarks._ros2_driver_ends import Seen, Watched
from benchmarks.ros2_drivers import OURS, PEER, Gains, Runs, goals, stream_table

MS = 1_000_000
EXPOSURES = [(pixel % 256, number * 30 * MS) for number, pixel in enumerate(range(250, 262))]
"Pixel and time of twelve images; the count begins again at 256."


def runs(late_ms: int, missing: int = 0, cpu: float = 0.012) -> Runs:
    found = Runs()
    arrivals = [(pixel, began + late_ms * MS) for pixel, began in EXPOSURES]
    before = [(249, 5 * MS)]  # exposed before the camera was watched
    found.add(Watched(EXPOSURES, []), [Seen(before + arrivals, 0.1), Seen(arrivals[missing:], 0.3)], cpu)
    return found


def test_the_worst_reader_decides_what_was_delivered():
    assert runs(40).counts == "12 of 12"
    assert runs(40, missing=3).counts == "9 of 12"
    assert runs(40, missing=3).share == 75


def test_images_are_as_old_as_their_exposure():
    found = runs(40)

    assert (found.age(0.5), found.age(0.99)) == (40, 40)
    assert found.cpu == pytest.approx(1.0)  # ms an image


def test_ours_is_judged_beside_the_peer_only_where_it_was_there():
    ours, theirs = runs(40, cpu=0.024), runs(30, missing=3)
    gains = {OURS: Gains([1.0], [2.0]), PEER: Gains([3.0], [4.0])}

    met = {
        goal.asked: goal.met for goal in goals({("1080p", OURS, 1): ours, ("1080p", PEER, 1): theirs}, gains)
    }

    assert list(met.values()) == [True, False, False, True]
    assert goals({("1080p", OURS, 1): ours}, {OURS: gains[OURS]}) == []
    row = stream_table({("1080p", OURS, 1): ours, ("1080p", PEER, 1): theirs}).rows[0]
    assert row[5] == "1.33" and row[7] == "2.00"
