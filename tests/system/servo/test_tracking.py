"""The filter of a marker's pose, the motion of a target, and the hand that follows it."""

import math
from dataclasses import replace

import numpy as np
import pytest

import servo_scene
from grabbergui.calibration import geometry
from grabbergui.calibration.marker_pose import MarkerDetection
from grabbergui.calibration.markers import ArucoDetector
from grabbergui.core.errors import UsageError
from grabbergui.driver.sim.rendered_scene import Things, board_pose
from grabbergui.servo.closed_loop import AT_BOARD, ClosedLoop
from grabbergui.servo.config import ArmConfig, Config, SafetyConfig, TrackConfig
from grabbergui.servo.control import ArmController
from grabbergui.servo.detection import Sighting
from grabbergui.servo.gate import Command, CommandGate
from grabbergui.servo.marker_filter import UNKNOWN, MarkerFilter
from grabbergui.servo.robots import teo
from grabbergui.servo.state_machine import State
from grabbergui.servo.target_motion import RESTS_S, TargetMotion
from grabbergui.servo.tracking import MarkerTrack
from robots_for_tests import RecordingRobot

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
        grey = servo_scene.image(of, teo.MODEL.camera_pose(head), board_pose())
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


FPS = 30


def watched(path, seconds=1.0, noise=0.0, lost=0.0, seed=4):
    motion, random = TargetMotion(), np.random.default_rng(seed)
    for time in np.arange(0, seconds, 1 / FPS):
        if random.random() >= lost:
            motion.add(float(time), path(time) + random.normal(0, noise, 3))
    return motion, float(time)


def circle(time, radius=0.1, speed=0.2):
    angle = speed / radius * time
    return np.array([0.6, radius * math.sin(angle), 0.3 + radius * math.cos(angle)])


def test_a_target_that_rests_is_not_predicted_however_its_image_trembles():
    motion, last = watched(lambda time: np.array([0.6, 0.0, 0.3]), noise=0.0015)
    assert not motion.moving
    assert motion.position(last + 0.1) is None
    assert not motion.velocity(last + 0.1).any()


@pytest.mark.parametrize("lost", [0.0, 0.2])
def test_a_constant_velocity_is_predicted_to_two_millimetres(lost):
    motion, last = watched(lambda time: np.array([0.6, 0.2, 0.3]) * time, lost=lost)
    assert motion.position(last + 0.1) == pytest.approx(np.array([0.6, 0.2, 0.3]) * (last + 0.1), abs=0.002)
    assert motion.velocity(last + 0.2) == pytest.approx([0.6, 0.2, 0.3], abs=0.05)
    assert motion.speed == pytest.approx(0.7, abs=0.01)


def test_a_circle_is_predicted_to_a_few_millimetres():
    for seconds in np.arange(1.0, 4.0, 0.3):
        motion, last = watched(circle, seconds)
        assert np.linalg.norm(motion.position(last + 0.1) - circle(last + 0.1)) < 0.004
        assert (
            np.linalg.norm(motion.velocity(last + 0.1) - (circle(last + 0.11) - circle(last + 0.09)) / 0.02)
            < 0.05
        )


@pytest.mark.parametrize("speed", [0.1, 0.15, 0.2, 0.27])
def test_noise_of_a_millimetre_makes_a_prediction_wrong_by_a_few(speed):
    errors = []
    for seed in range(40):
        motion, last = watched(lambda time: circle(time, speed=speed), 2.0, noise=0.001, lost=0.05, seed=seed)
        errors.append(np.linalg.norm(motion.position(last + 0.13) - circle(last + 0.13, speed=speed)))
    assert np.median(errors) < 0.004
    assert np.percentile(errors, 95) < 0.009


def test_a_target_that_turns_back_still_moves_and_one_that_stops_rests_soon():
    motion = TargetMotion()
    moves = []
    for time in np.arange(0, 6, 1 / FPS):
        place = np.array([0.1 * math.sin(2 * min(time, 3.93)), 0, 0])
        motion.add(float(time), place)
        moves.append(motion.moving)
    assert all(moves[FPS : 4 * FPS])
    assert not any(moves[round((3.93 + RESTS_S + 0.5) * FPS) :])


def test_no_prediction_goes_far_ahead_or_outlives_its_target():
    motion, last = watched(lambda time: np.array([time, 0, 0]))
    assert motion.position(last + 5)[0] < last + 0.3
    motion.restart()
    assert motion.position(last) is None
    motion.add(last + 1, np.zeros(3))
    motion.add(last + 1, np.ones(3))
    motion.add(last, np.ones(3))
    assert not motion.moving


def test_a_hand_that_follows_goes_with_the_marker_and_no_faster_than_it_may():
    config = ArmConfig(follow=0.3)
    arm, marker = ArmController(config, 0.1), board_pose()
    marker[:3, 3] = 0.5, -0.2, 0.2
    goal = arm.goal(marker)
    for _ in range(50):
        twist = arm.approach(goal, marker, 0.02, np.array([0, 0.2, 0.0]))
    assert twist[:3] == pytest.approx([0, 0.2, 0])
    for _ in range(50):
        twist = arm.approach(goal, marker, 0.02, np.array([0, 5.0, 5.0]))
    assert np.linalg.norm(twist[:3]) == pytest.approx(0.3)


@pytest.mark.parametrize(("behind", "nearer"), [(0.005, 6.5 * 0.005), (0.02, math.sqrt(0.4 * 0.02))])
def test_a_hand_that_is_behind_catches_up_no_faster_than_it_can_brake(behind, nearer):
    arm, marker = ArmController(ArmConfig(follow=0.5), 0.1), board_pose()
    marker[:3, 3] = 0.5, -0.2, 0.2
    hand = arm.goal(marker)
    hand[1, 3] -= behind
    for _ in range(50):
        twist = arm.approach(hand, marker, 0.02, np.array([0, 0.1, 0.0]))
    assert twist[:3] == pytest.approx([0, 0.1 + nearer, 0])


def test_the_gate_lets_a_hand_follow_as_fast_as_the_configuration_says():
    command = Command(hand=np.array([0, 0.25, 0, 0, 0, 0]))
    for follow, speed in ((0.0, 0.12), (0.3, 0.25)):
        robot = RecordingRobot()
        gate = CommandGate(robot, replace(Config(), arm=ArmConfig(follow=follow)))
        assert gate.send(command, 0.0)
        assert np.linalg.norm(robot.twist[:3]) == pytest.approx(speed, rel=0.05)
    with pytest.raises(UsageError, match=r"\[arm\] follow of 0\.6 m/s; allowed: 0 to 0\.5"):
        Config.parse("[arm]\nfollow 0.6")


def circling(seconds):
    pose = board_pose()
    angle = 2.0 * max(seconds - 2.5, 0.0)
    pose[:3, 3] += 0, 0.1 * math.sin(angle), 0.1 * (math.cos(angle) - 1)
    return pose


def following(run):
    """Let the run follow the circling marker; images are rendered for the last second only."""
    run.rendered = False
    run.run(4.0)
    run.rendered = True
    run.run(1.0)
    return run


def test_the_hand_follows_a_moving_marker_within_15_mm():
    config = replace(Config(), arm=ArmConfig(follow=0.3))
    run = following(ClosedLoop(config=config, things=Things(board=circling), head=AT_BOARD, fps=30))
    errors = []
    while run.now < 7.0:
        assert run.cycle().state is State.FOLLOWING
        errors.append(run.true_error()[0])
    assert max(errors) < 0.015


def test_a_moment_without_images_costs_the_hand_a_few_millimetres_and_the_head_nothing():
    safety = SafetyConfig(image_timeout=0.18)
    config = replace(Config(), arm=ArmConfig(follow=0.3), safety=safety)
    things = Things(board=circling)
    run = following(ClosedLoop(config=config, things=things, head=AT_BOARD, fps=30, latency=0.1))
    errors, off_centre, stops = [], [], 0
    for cycle_number in range(150):
        run.camera_runs = cycle_number % 50 > 3  # two images in a row are lost, once a second
        cycle = run.cycle()
        stops += cycle.state is State.LOST
        errors.append(run.true_error()[0])
        off_centre.append(cycle.off_centre[0])
    assert stops >= 3
    assert max(errors) < 0.018
    assert np.nanmax(np.abs(off_centre)) < 0.06
