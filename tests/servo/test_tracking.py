"""The filter of a marker's pose."""

from dataclasses import replace

import numpy as np
import pytest
import servo_scene

from grabbergui.calibration import geometry
from grabbergui.calibration.markers import ArucoDetector, MarkerDetection
from grabbergui.driver.sim.rendered_scene import board_pose
from grabbergui.servo.config import TrackConfig
from grabbergui.servo.detection import Sighting
from grabbergui.servo.robots import teo
from grabbergui.servo.tracking import UNKNOWN, MarkerFilter, MarkerTrack

SQUARE = np.array([[0.0, 0], [50, 0], [50, 50], [0, 50]])
FACING = np.diag([1.0, -1.0, -1.0])
LEFT, RIGHT = (
    geometry.pose(FACING @ geometry.rotation_from_vector((0, tilt, 0)), (0, 0, 0.8)) for tilt in (-0.4, 0.4)
)


def jitter(poses):
    """Millimetres and degrees, root mean square over poses about their mean."""
    off = np.array([geometry.diff(poses[0], pose) for pose in poses])
    off -= off.mean(axis=0)
    metres, radians = (np.sqrt(np.mean(np.sum(part**2, axis=1))) for part in (off[:, :3], off[:, 3:]))
    return 1e3 * metres, np.degrees(radians)


def test_a_resting_marker_rests_though_the_head_moves_and_all_is_noisy():
    """The head sways by 6° at up to 15°/s; its encoders are noisy by 0.01°, pixels by 8 grey levels."""
    of, random = servo_scene.settings(4), np.random.default_rng(2)
    calibration = servo_scene.calibration(of)
    detector, track = ArucoDetector(calibration=calibration), MarkerTrack(20, TrackConfig())
    raw, filtered = [], []
    for index in range(90):
        head = np.array((-0.42, 0.1)) + np.radians(6) * np.sin(2.5 * 0.04 * index) * np.array((1, 0.5))
        grey = servo_scene.picture(of, teo.MODEL.camera_pose(head), board_pose())
        noisy = np.clip(grey + random.normal(0, 8, grey.shape), 0, 255).astype(np.uint8)
        camera = teo.MODEL.camera_pose(head + random.normal(0, np.radians(0.01), 2))
        sighting = Sighting(0.04 * index, tuple(detector.detect(noisy)))
        track.update(sighting, camera)
        if index >= 45:
            raw.append(camera @ sighting.markers[0].pose)
            assert track.pose is not None, track.problem
            filtered.append(track.pose)
    assert jitter(raw)[0] > 0.4
    millimetres, degrees = jitter(filtered)
    assert millimetres < 0.3
    assert degrees < 0.1


def test_a_marker_that_moves_is_followed_within_a_few_millimetres():
    random, filter_ = np.random.default_rng(1), MarkerFilter(TrackConfig().smoothing)
    behind = []
    for index in range(150):
        moved = max(0, index - 75) * 0.008  # 0.2 m/s at 25 frames a second
        true = geometry.pose(FACING, (0.5, moved, 0.4))
        seen = geometry.add_delta(true, random.normal(0, 1, 6) * np.sqrt(np.diag(UNKNOWN)) / 3)
        filter_.update(seen, UNKNOWN)
        behind.append(geometry.distance(filter_.pose, true))
    assert max(behind[40:75]) < 0.001
    assert max(behind[75:]) < 0.02
    assert np.mean(behind[80:]) < 0.008


def test_a_view_that_is_surer_counts_for_more():
    for factor, share in ((1.0, 0.51), (0.01, 0.99), (100.0, 0.0103)):
        filter_ = MarkerFilter(0.04)
        filter_.update(np.eye(4), UNKNOWN)
        near = geometry.pose(translation=(0.001, 0, 0))
        assert filter_.update(near, factor * UNKNOWN)[0, 3] == pytest.approx(0.001 * share, rel=0.05)


def sighting(index, pose, other=None):
    return Sighting(index * 0.04, (MarkerDetection(20, SQUARE, pose, other_pose=other),))


def settled():
    track = MarkerTrack(20, replace(TrackConfig(), jump_angle=180.0))
    for index in range(10):
        track.update(sighting(index, LEFT, RIGHT), np.eye(4))
    assert track.pose == pytest.approx(LEFT, abs=1e-6)
    return track


def test_a_flip_counts_as_not_seen():
    track = settled()
    track.update(sighting(10, RIGHT, LEFT), np.eye(4))
    assert track.pose is None
    assert "flipped" in track.problem


def test_poses_that_flip_to_and_fro_are_never_usable():
    track = settled()
    for index in range(10, 60):
        pair = (LEFT, RIGHT) if index % 2 else (RIGHT, LEFT)
        track.update(sighting(index, *pair), np.eye(4))
        assert track.pose is None or track.pose == pytest.approx(LEFT, abs=1e-6)
        assert not track.usable or index % 2


def test_a_filter_that_began_with_the_wrong_pose_believes_the_other_in_the_end():
    track = settled()
    for index in range(10, 17):
        track.update(sighting(index, RIGHT, LEFT), np.eye(4))
    assert track.pose == pytest.approx(RIGHT, abs=1e-6)


def test_a_pose_that_turned_without_its_other_one_agreeing_is_no_flip():
    track = settled()
    turned = geometry.pose(LEFT[:3, :3] @ geometry.rotation_from_vector((0.5, 0, 0)), LEFT[:3, 3])
    track.update(sighting(10, turned, LEFT @ np.diag([-1.0, -1.0, 1.0, 1.0])), np.eye(4))
    assert "flipped" not in track.problem
