"""A camera that sends images again, and one whose region changes."""

import dataclasses

import numpy as np
import pytest

from frames import frame_of
from grabbergui.core.errors import UsageError
from grabbergui.servo.image_watch import REPEATS, ImageWatch, SenderStamps


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"offset_x": 8}, r"from 64×48 at \(0, 0\) to 64×48 at \(8, 0\): set it back"),
        ({"width": 32, "height": 24}, r"to 32×24 at \(0, 0\)"),
    ],
)
def test_a_region_that_changes_ends_the_run_until_a_person_starts_it_again(change, said):
    frame = frame_of(np.zeros((48, 64), np.uint8))
    changed = dataclasses.replace(frame, **change)
    watch, head = ImageWatch(), np.zeros(2)
    watch.problem_of(frame, frame.mono(), head)
    with pytest.raises(UsageError, match=said):
        watch.problem_of(changed, changed.mono(), head)


def test_only_an_image_that_is_the_same_in_every_pixel_is_a_repetition():
    frame, watch = frame_of(np.zeros((48, 64), np.uint8)), ImageWatch()
    grey = frame.mono()
    other = grey.copy()
    other[17, 5] = 1
    assert [bool(watch.problem_of(frame, each, None)) for each in (grey, other, grey, grey)] == [0, 0, 1, 1]


def test_a_simulator_without_noise_may_repeat_the_view_of_a_head_at_rest():
    """In Gazebo, nothing would ever move for a marker that stands still."""
    frame, watch = frame_of(np.zeros((48, 64), np.uint8)), ImageWatch()
    person = frame.mono().copy()
    for image in range(40):
        person[:, :20] = image % 256
        assert not watch.problem_of(frame, person.copy(), np.array([0.1, 0.0]))
    for _ in range(40):
        assert not watch.problem_of(frame, person.copy(), np.array([0.1, 0.0004])), "readings scatter"
    assert watch.problem_of(frame, person.copy(), np.array([0.1, 0.02])) == "the camera repeats its image"
    person[0, 0] += 1
    assert not watch.problem_of(frame, person.copy(), np.array([0.1, 0.02]))


def test_a_camera_with_noise_never_repeats_its_image():
    generator, watch = np.random.default_rng(1), ImageWatch()
    frame = frame_of(np.zeros((48, 64), np.uint8))
    for _ in range(12):
        grey = generator.integers(100, 104, (48, 64), np.uint8)
        assert not watch.problem_of(frame, grey, np.zeros(2))
    assert watch.problem_of(frame, grey, np.zeros(2)) == "the camera repeats its image"


@pytest.mark.parametrize("buffers", [1, 2, 3, 8, 64])
def test_a_stuck_ring_of_buffers_repeats_its_images(buffers):
    generator, watch = np.random.default_rng(1), ImageWatch()
    frame = frame_of(np.zeros((48, 64), np.uint8))
    ring = [generator.integers(100, 104, (48, 64), np.uint8) for _ in range(buffers + 12)]
    assert not any(watch.problem_of(frame, grey, np.zeros(2)) for grey in ring)
    for _ in range(3):
        for grey in ring[-buffers:]:
            assert watch.problem_of(frame, grey.copy(), np.zeros(2)) == REPEATS
    assert not watch.problem_of(frame, generator.integers(100, 104, (48, 64), np.uint8), np.zeros(2))


def test_two_images_without_noise_alternate_only_for_a_head_at_rest():
    frame, watch = frame_of(np.zeros((48, 64), np.uint8)), ImageWatch()
    first = frame.mono()
    second = first.copy()
    second[:, :20] = 9
    for _ in range(5):
        for grey in (first, second):
            assert not watch.problem_of(frame, grey, np.zeros(2))
    for grey in (first, second, first):
        assert watch.problem_of(frame, grey, np.array([0.0, 0.02])) == REPEATS


def test_the_noise_of_a_good_sensor_is_found_in_the_simulated_images():
    """It changes a tenth of the pixels by one value."""
    generator, watch = np.random.default_rng(1), ImageWatch()
    frame = frame_of(np.full((480, 640), 100, np.uint8))
    for _ in range(6):
        grey = frame.mono() + (generator.random((480, 640)) < 0.1).astype(np.uint8)
        assert not watch.problem_of(frame, grey, np.zeros(2))
    assert watch.problem_of(frame, grey, np.zeros(2)) == REPEATS


@pytest.mark.parametrize(
    ("ages", "late"),
    [
        ((0.01, 0.02, 1.0, 3.0), (0.01, 0.02, 1.0, 3.0)),
        ((1.0, 1.0), (1.0, 1.0)),
        ((500.0, 501.0), (0.0, 0.0)),
        ((-0.1, 0.01), (0.0, 0.01)),
        ((None, None), (0.0, 0.0)),
    ],
    ids=["suddenly", "from the start", "another clock", "a clock that is ahead", "no stamps"],
)
def test_images_are_as_old_as_their_senders_stamps_say(ages, late):
    stamps, frame = SenderStamps(), frame_of(np.zeros((4, 4), np.uint8))
    frame.received_ns = 10**18
    found = []
    for age in ages:
        frame.timestamp_ns = 0 if age is None else round(10**18 - 1e9 * age)
        found.append(stamps.seconds_late(frame))
    assert found == pytest.approx(late)
