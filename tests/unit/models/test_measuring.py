"""The measurements of frames, and when they are made."""

import threading

import cv2
import numpy as np
import pytest

from frames import frame_of
from grabbergui.core.pixels import Region
from grabbergui.models.measuring import (
    HISTORY_SECONDS,
    FocusHistory,
    Line,
    MeasuringModel,
    Wanted,
    estimate_saturated,
    measure_histogram,
    measure_profile,
    sharpness,
)
from patience import until

RANDOM = np.random.default_rng(1)


def test_the_histogram_of_grey_counts_every_pixel():
    image = RANDOM.integers(0, 4096, (50, 60), np.uint16)
    found = measure_histogram(frame_of(image, "Mono12"))
    assert found.channels["grey"].tolist() == np.bincount(image.reshape(-1), minlength=4096).tolist()
    assert found.mean("grey") == pytest.approx(image.mean())
    assert found.binned("grey").size == 256 and found.binned("grey").sum() == image.size
    assert found.saturated == (image == 4095).sum() / image.size


@pytest.mark.parametrize(("name", "white"), [("Mono8", 255), ("BayerGB12", 4095), ("RGB8", 255)])
@pytest.mark.parametrize("height", [3, 64, 1001])
def test_the_share_of_saturated_samples_is_estimated_from_some_lines(name, white, height):
    image = np.zeros(
        (height, 30, 3) if name == "RGB8" else (height, 30), np.uint16 if white > 255 else np.uint8
    )
    image[:, :10] = white
    assert estimate_saturated(frame_of(image, name)) == pytest.approx(1 / 3)


def test_coordinates_are_never_saturated():
    assert estimate_saturated(frame_of(np.ones((4, 4, 3), np.float32), "Coord3D_ABC32f")) is None


@pytest.mark.parametrize("order", ["RG", "GR", "BG", "GB"])
def test_the_histogram_of_a_mosaic_is_that_of_its_colours(order):
    colours = {"R": 10, "G": 20, "B": 30}
    second = {"R": "GB", "B": "GR", "G": "BG" if order == "GR" else "RG"}[order[0]]
    cell = [[colours[c] for c in order], [colours[c] for c in second]]
    found = measure_histogram(frame_of(np.tile(np.array(cell, np.uint8), (4, 5)), f"Bayer{order}8"))
    assert list(found.channels) == ["R", "G", "B"]
    counts = {name: (int(c.argmax()), int(c.sum())) for name, c in found.channels.items()}
    assert counts == {"R": (10, 20), "G": (20, 40), "B": (30, 20)}


def test_the_histogram_of_colour_knows_the_order_in_memory():
    found = measure_histogram(frame_of(np.full((4, 4, 4), (1, 2, 3, 255), np.uint8), "BGRa8"))
    assert {name: int(c.argmax()) for name, c in found.channels.items()} == {"R": 3, "G": 2, "B": 1}
    luma = measure_histogram(frame_of(np.full((4, 4, 2), (128, 77), np.uint8), "YUV422_8_UYVY"))
    assert int(luma.channels["Y"].argmax()) == 77


def test_a_blurred_image_is_less_sharp_and_a_brighter_one_is_not_sharper():
    image = RANDOM.integers(20, 120, (200, 200), np.uint8)
    blurred = [cv2.GaussianBlur(image, (0, 0), sigma) for sigma in (0.5, 1, 2, 4)]
    scores = [sharpness(frame_of(p)) for p in (image, *blurred)]
    assert scores == sorted(scores, reverse=True) and scores[-1] > 0
    assert sharpness(frame_of(image * 2)) == pytest.approx(scores[0], rel=0.02)
    assert sharpness(frame_of(np.zeros((9, 9), np.uint8))) == 0


def test_sharpness_is_of_the_region_asked_for():
    image = np.full((100, 100), 90, np.uint8)
    image[:50] = RANDOM.integers(20, 160, (50, 100))
    frame = frame_of(image)
    assert sharpness(frame, Region(0, 0, 100, 40)) > 100 * sharpness(frame, Region(0, 60, 100, 40))


def test_a_flat_mosaic_is_not_sharp():
    cell = np.array([[200, 100], [100, 30]], np.uint8)
    assert sharpness(frame_of(np.tile(cell, (40, 40)), "BayerRG8"), Region(8, 8, 60, 60)) < 0.5


def test_the_history_of_scores_lasts_a_minute_and_knows_the_best():
    history = FocusHistory()
    for second in range(100):
        history.add(float(second % 50), now=second)
    assert history.scores[0][0] >= 99 - HISTORY_SECONDS and history.best == 49
    history.clear()
    assert not history.scores and not history.best


def test_the_profile_of_grey_has_the_sensors_own_values():
    image = np.arange(600, dtype=np.uint16).reshape(20, 30) * 5
    frame = frame_of(image, "Mono12")
    assert measure_profile(frame, Line(2, 3, 9, 3))["grey"].tolist() == image[3, 2:10].tolist()
    assert measure_profile(frame, Line(5, 9, 5, 4))["grey"].tolist() == image[9:3:-1, 5].tolist()
    assert measure_profile(frame, Line(0, 0, 4, 4))["grey"].tolist() == np.diag(image)[:5].tolist()
    assert measure_profile(frame, Line(-5, 0, 99, 0))["grey"].size == 30


def test_the_profile_of_colour_has_three_channels():
    image = RANDOM.integers(0, 255, (10, 10, 3), np.uint8)
    profile = measure_profile(frame_of(image, "RGB8"), Line(1, 2, 8, 2))
    assert {name: p.tolist() for name, p in profile.items()} == {
        name: image[2, 1:9, index].tolist() for index, name in enumerate("RGB")
    }


def test_the_raw_profile_of_a_mosaic_has_each_value_under_its_filters_colour():
    image = RANDOM.integers(0, 1 << 12, (10, 12), np.uint16)
    profile = measure_profile(frame_of(image, "BayerGB12"), Line(1, 2, 8, 2), raw=True)
    line = image[2, 1:9].astype(float)  # green and blue alternate, the line begins on a blue one
    assert list(profile) == ["R", "G", "B"]
    assert np.isnan(profile["R"]).all(), "no red lies on this line"
    assert np.array_equal(profile["B"][::2], line[::2]) and np.isnan(profile["B"][1::2]).all()
    assert np.array_equal(profile["G"][1::2], line[1::2]) and np.isnan(profile["G"][::2]).all()
    down = measure_profile(frame_of(image, "BayerGB12"), Line(0, 0, 0, 9), raw=True)
    assert np.array_equal(down["R"][1::2], image[1::2, 0].astype(float))


def test_the_raw_profile_of_components_is_as_they_came():
    image = RANDOM.integers(0, 255, (6, 8, 3), np.uint8)
    profile = measure_profile(frame_of(image, "BGR8"), Line(0, 1, 7, 1), raw=True)
    assert np.array_equal(profile["R"], image[1, :, 2]) and np.array_equal(profile["B"], image[1, :, 0])
    pairs = RANDOM.integers(0, 255, (6, 8, 2), np.uint8)
    profile = measure_profile(frame_of(pairs, "YUV422_8_UYVY"), Line(0, 1, 7, 1), raw=True)
    assert np.array_equal(profile["Y"], pairs[1, :, 1])
    assert np.array_equal(profile["U"][::2], pairs[1, ::2, 0]) and np.isnan(profile["U"][1::2]).all()
    assert np.array_equal(profile["V"][1::2], pairs[1, 1::2, 0])


def test_levels_fitted_to_an_image_leave_out_the_rarest_values():
    image = np.full((100, 100), 1000, np.uint16)
    image[:40] = 300
    image[0, :40], image[1, :40] = 0, 4095  # four in a thousand at each end
    black, white = measure_histogram(frame_of(image, "Mono12")).levels()
    assert (round(black * 4095), round(white * 4095)) == (300, 1000)
    flat = measure_histogram(frame_of(np.full((8, 8), 255, np.uint8))).levels()
    assert flat[1] > flat[0]


class Bench:
    def __init__(self):
        self.frame = frame_of(np.full((8, 8), 9, np.uint8))
        self.asked, self.reported = 0, []
        self.model = MeasuringModel(self.newest, period=0.005)
        self.model.measured.connect(self.reported.append)

    def newest(self):
        self.asked += 1
        return self.frame


@pytest.fixture
def bench():
    bench = Bench()
    yield bench
    assert bench.model.close(5)


def test_without_a_request_nothing_is_measured_and_no_thread_runs(bench):
    before = set(threading.enumerate())
    bench.model.want(Wanted())
    assert not set(threading.enumerate()) - before
    bench.model.want(Wanted(histogram=True))
    until(lambda: bench.reported)
    assert bench.reported[0].histogram is not None and bench.reported[0].sharpness is None
    bench.model.want(Wanted())
    until(lambda: not set(threading.enumerate()) - before)


def test_each_frame_is_measured_once_and_again_when_something_else_is_wanted(bench):
    bench.model.want(Wanted(histogram=True))
    until(lambda: bench.reported)
    asked = bench.asked
    until(lambda: bench.asked > asked + 3)
    assert len(bench.reported) == 1
    bench.model.want(Wanted(focus=True, line=Line(0, 0, 3, 3)))
    until(lambda: len(bench.reported) == 2)
    assert bench.reported[1].histogram is None and bench.reported[1].profile["grey"].tolist() == [9] * 4


def test_a_frame_that_cannot_be_measured_does_not_end_it(bench):
    bench.frame = frame_of(np.zeros((4, 4), np.uint8))
    bench.frame.payload = bench.frame.payload[:3]
    bench.model.want(Wanted(histogram=True))
    until(lambda: bench.asked > 2)
    assert bench.reported == []
    bench.frame = frame_of(np.full((4, 4), 7, np.uint8))
    until(lambda: bench.reported)
    assert bench.reported[0].histogram.channels["grey"][7] == 16
