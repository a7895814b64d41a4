"""Values over time: kept in bounded memory, read only while somebody looks."""

import csv
import io
import math
import threading
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fakes import ScriptedGrabber
from grabbergui.core.errors import AckTimeoutError, FeatureError
from grabbergui.core.features import AccessMode, Feature, FeatureKind
from grabbergui.models.features.value_history import (
    MOST_WATCHED,
    WATCH_PERIOD,
    ValueHistory,
    ValueWatch,
    to_csv,
)
from grabbergui.models.features.worker import FeatureWorker
from patience import PATIENCE


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), max_size=700), st.integers(1, 300))
def test_the_newest_samples_are_kept_and_no_more(values, most):
    history = ValueHistory(most)
    for moment, value in enumerate(values):
        history.add(float(moment), value)
    kept = values[-most:]
    times, found = history.since()
    assert found.tolist() == kept
    assert times.tolist() == [float(n) for n in range(len(values) - len(kept), len(values))]
    assert len(history) == len(kept)
    assert times.base.nbytes <= 16 * max(256, 2 * most)


def test_only_requested_measurements_are_made():
    history = ValueHistory()
    for moment in range(10):
        history.add(float(moment), 10.0 * moment)
    times, values = history.since(7.0)
    assert times.tolist() == [7, 8, 9] and values.tolist() == [70, 80, 90]


def test_csv_has_a_line_a_moment_and_gaps_where_nothing_was_read():
    first, second = ValueHistory(), ValueHistory()
    first.add(0.0, 1.5)
    first.add(0.1, math.nan)
    second.add(0.1, 7.0)
    rows = list(csv.reader(io.StringIO(to_csv({"Gain": first, "Width": second}))))
    assert rows == [
        ["time", "Gain", "Width"],
        ["1970-01-01T00:00:00.000+00:00", "1.5", ""],
        ["1970-01-01T00:00:00.100+00:00", "", "7.0"],
    ]


def number(name, value=1.0):
    return Feature(name=name, kind=FeatureKind.FLOAT, value=value, access=AccessMode.READ_WRITE)


class Bench:
    def __init__(self, period=0.005):
        self.grabber = ScriptedGrabber([number(f"F{n}", float(n)) for n in range(20)])
        self.worker = FeatureWorker()
        self.watch = ValueWatch(period)
        self.samples = []
        self.came = threading.Condition()
        self.watch.sampled.connect(self._on_sampled)

    def _on_sampled(self, moment, values, units):
        with self.came:
            self.samples.append((moment, values))
            self.came.notify_all()

    def more(self, count=3):
        """Wait for so many more samples."""
        with self.came:
            wanted = len(self.samples) + count
            assert self.came.wait_for(lambda: len(self.samples) >= wanted, PATIENCE)
            return self.samples[-1][1]

    def idle(self):
        """Whether the worker reads nothing any more."""
        reads = len(self.grabber.reads)
        for _ in range(4):
            done = threading.Event()
            self.worker.submit(done.set, delay=0.01)
            assert done.wait(PATIENCE)
        return len(self.grabber.reads) == reads


@pytest.fixture
def bench():
    made = Bench()
    yield made
    made.watch.detach()
    assert made.worker.close()


def test_nothing_is_read_until_somebody_looks_at_something(bench):
    bench.watch.attach(bench.grabber, bench.worker)
    assert bench.idle()
    bench.watch.want(True)
    assert bench.idle()
    bench.watch.add("F1")
    assert bench.more() == {"F1": 1.0}
    bench.watch.add("F2")
    bench.more()
    bench.grabber.set("F2", 5.0)
    bench.more()
    assert bench.samples[-1][1] == {"F1": 1.0, "F2": 5.0}
    bench.watch.remove("F1")
    bench.more()
    assert bench.samples[-1][1] == {"F2": 5.0}
    bench.watch.want(False)
    assert bench.idle()
    bench.watch.want(True)
    bench.more()
    bench.watch.detach()
    assert bench.idle()


def test_ten_times_a_second_and_no_faster():
    bench = Bench(WATCH_PERIOD)
    try:
        bench.watch.add("F1")
        bench.watch.want(True)
        bench.watch.attach(bench.grabber, bench.worker)
        bench.more(6)
        moments = [moment for moment, _ in bench.samples]
        assert np.diff(moments).min() > 0.9 * WATCH_PERIOD
    finally:
        bench.watch.detach()
        assert bench.worker.close()


def test_switching_back_and_forth_starts_one_reading_only(bench):
    bench.watch.attach(bench.grabber, bench.worker)
    for turn in range(50):
        bench.watch.want(bool(turn % 2))
        bench.watch.add(f"F{turn % 3}")
    begun = time.monotonic()
    reads = len(bench.grabber.reads)
    bench.more(20)
    assert (len(bench.grabber.reads) - reads) / 3 <= (time.monotonic() - begun) / 0.005 + 10


def test_an_unreadable_value_is_a_gap_and_the_others_continue(bench):
    bench.grabber.failures["F1"] = FeatureError("F1 is hidden", "F1")
    bench.watch.attach(bench.grabber, bench.worker)
    bench.watch.add("F1")
    bench.watch.add("F2")
    bench.watch.want(True)
    values = bench.more()
    assert math.isnan(values["F1"]) and values["F2"] == 2.0


def test_a_camera_that_does_not_answer_is_asked_seldom(bench, monkeypatch):
    monkeypatch.setattr("grabbergui.models.features.value_history.RETRY_PERIOD", 0.2)
    bench.grabber.failures["F1"] = AckTimeoutError("no answer")
    bench.watch.attach(bench.grabber, bench.worker)
    bench.watch.add("F1")
    bench.watch.want(True)
    bench.more(2)
    assert bench.samples[-1][0] - bench.samples[-2][0] > 0.19


def test_only_so_many_are_watched(bench):
    for n in range(20):
        bench.watch.add(f"F{n}")
    assert len(bench.watch.names) == MOST_WATCHED and bench.watch.full


def test_a_closed_worker_ends_the_reading(bench):
    bench.watch.attach(bench.grabber, bench.worker)
    bench.watch.add("F1")
    bench.watch.want(True)
    bench.more()
    assert bench.worker.close(5)
