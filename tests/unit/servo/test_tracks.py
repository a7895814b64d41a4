"""Tracks of marker and person, which make usable targets of single detections; where the head was."""

import numpy as np
import pytest

from grabbergui.calibration import geometry
from grabbergui.calibration.marker_pose import MarkerDetection
from grabbergui.servo.config import TrackConfig
from grabbergui.servo.detection import FaceDetection, Sighting
from grabbergui.servo.robots.robot import JointHistory
from grabbergui.servo.tracking import FaceTrack, MarkerTrack

AHEAD = geometry.pose([[0, 0, 1], [-1, 0, 0], [0, -1, 0]], (0, 0, 0.7))
"A camera 0.7 m above the base's origin that looks along its x axis."
FACING = np.diag([1.0, -1.0, -1.0])


def sighting(time, *poses, marker_id=20, problem=""):
    """Return the detection of a marker for each pose, in an image of that time."""
    square = np.array([[0.0, 0], [50, 0], [50, 50], [0, 50]])
    return Sighting(time, tuple(MarkerDetection(marker_id, square, pose, problem) for pose in poses))


def seen_at(x=0.0, z=0.8):
    return geometry.pose(FACING @ geometry.rotation_from_vector((0.3, 0, 0)), (x, 0, z))


def track(count=3):
    """Return the track of a marker that so many images showed in one place, a second apart."""
    marker = MarkerTrack(20, TrackConfig())
    for index in range(count):
        marker.update(sighting(index, seen_at()), AHEAD)
    return marker


def test_a_marker_is_usable_after_some_images_in_a_row():
    assert not track(2).usable
    assert track(3).pose == pytest.approx(AHEAD @ seen_at())


@pytest.mark.parametrize(
    ("bad", "problem"),
    [
        (Sighting(9.0), "no marker 20"),
        (sighting(9.0, seen_at(), seen_at(0.3)), "several markers 20"),
        (sighting(9.0, None, problem="two poses explain it"), "two poses"),
        (sighting(9.0, np.full((4, 4), np.nan)), "no pose"),
        (sighting(9.0, seen_at(z=-0.8)), "behind the camera"),
        (sighting(9.0, seen_at(), marker_id=7), "no marker 20"),
    ],
)
def test_one_image_that_does_not_show_it_surely_interrupts(bad, problem):
    marker = track(10)
    marker.update(bad, AHEAD)
    assert marker.pose is None
    assert problem in marker.problem


def test_a_flickering_marker_is_never_usable():
    marker = MarkerTrack(20, TrackConfig())
    for index in range(100):
        marker.update(sighting(index, seen_at()) if index % 3 else Sighting(index), AHEAD)
        assert not marker.usable


def test_a_marker_that_jumps_about_is_never_usable():
    marker = MarkerTrack(20, TrackConfig())
    for index in range(60):
        marker.update(sighting(index, seen_at(0.2 * (index % 2))), AHEAD)
        assert not marker.usable


def test_without_knowing_where_the_head_looked_nothing_is_usable():
    marker = track(10)
    marker.update(sighting(11, seen_at()), None)
    assert marker.pose is None
    assert "where the head looked" in marker.problem


def test_noise_is_smoothed():
    marker, random = MarkerTrack(20, TrackConfig()), np.random.default_rng(1)
    raw, smooth = [], []
    for index in range(300):
        noisy = geometry.add_delta(seen_at(), random.normal(0, 0.002, 6))
        marker.update(sighting(index, noisy), AHEAD)
        if index > 50:
            raw.append(noisy[2, 3])
            smooth.append(marker.pose[0, 3])
    assert np.std(smooth) < 0.5 * np.std(raw)


def test_a_person_is_followed_in_the_base_s_coordinates():
    person = FaceTrack(TrackConfig())
    for index in range(3):
        person.update(Sighting(index, faces=(FaceDetection((0, 0, 9, 9), (0.1, -0.2, 1.5)),)), AHEAD)
    assert person.point == pytest.approx([1.5, -0.1, 0.9])
    person.update(Sighting(4), AHEAD)
    assert person.point is None


def test_where_the_head_was_is_known_between_readings_only():
    history = JointHistory()
    history.add(1.0, np.array([0.0, 1.0]))
    history.add(1.1, np.array([1.0, 0.0]))
    history.add(1.2, np.array([np.nan, 0.0]))
    assert history.at(1.025) == pytest.approx([0.25, 0.75])
    assert history.at(1.12) == pytest.approx([1.0, 0.0])
    assert history.at(0.5) is None
    assert history.at(1.5) is None


def test_a_reading_that_comes_late_or_twice_is_ignored():
    history = JointHistory()
    for time, angle in ((1.0, 0.0), (1.1, 1.0), (1.05, 7.0), (1.1, 7.0)):
        history.add(time, np.array([angle]))
    assert history.at(1.05) == pytest.approx([0.5])
    assert history.at(1.1) == pytest.approx([1.0])


def test_a_marker_that_turns_about_is_never_usable():
    marker = MarkerTrack(20, TrackConfig())
    turned = geometry.pose(seen_at()[:3, :3] @ geometry.rotation_from_vector((0, 0, 1.0)), (0, 0, 0.8))
    for index in range(60):
        marker.update(sighting(index, turned if index % 2 else seen_at()), AHEAD)
        assert not marker.usable


@pytest.mark.parametrize("place", [(0.1, -0.2, -1.5), (0.1, -0.2, 0.0), (np.nan, 0.0, 1.5)])
def test_a_face_that_cannot_be_where_it_is_seen_interrupts(place):
    person = FaceTrack(TrackConfig())
    for index in range(3):
        person.update(Sighting(index, faces=(FaceDetection((0, 0, 9, 9), (0.1, -0.2, 1.5)),)), AHEAD)
    assert person.point is not None
    for index in range(3, 9):
        person.update(Sighting(index, faces=(FaceDetection((0, 0, 9, 9), place),)), AHEAD)
        assert person.point is None
