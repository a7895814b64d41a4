"""Which controllers drive TIAGo, and velocities as streamed trajectories; no ROS needed."""

import re

import numpy as np
import pytest

from grabbergui.servo.robots.joint_trajectory import LEAD, JointStream
from grabbergui.servo.robots.tiago_choice import TWISTS, Controller, choose
from grabbergui.servo.robots.tiago_messages import CommandKind
from grabbergui.servo.robots.tiago_topics import Follower

ARM = tuple(f"arm_{number}_joint" for number in range(1, 8))
JTC = "joint_trajectory_controller/JointTrajectoryController"

TRAJECTORIES = CommandKind.TRAJECTORY, "/arm_controller/joint_trajectory"


def controller(name="arm_controller", kind=JTC, state="active", joints=ARM, prefix=""):
    return Controller(name, kind, state, tuple(f"{prefix}{joint}/position" for joint in joints))


@pytest.mark.parametrize(
    ("listed", "listeners", "kind", "topic"),
    [
        ([controller()], {}, *TRAJECTORIES),
        (
            [controller(), controller("torso_controller", joints=["torso_lift_joint"])],
            {},
            CommandKind.TRAJECTORY,
            None,
        ),
        (
            [controller("arm_impedance_controller", prefix="gravity_compensation_controller/")],
            {},
            CommandKind.TRAJECTORY,
            "/arm_impedance_controller/joint_trajectory",
        ),
        (
            [
                controller(state="inactive"),
                controller("arm_position", "position_controllers/JointGroupPositionController"),
            ],
            {},
            CommandKind.POSITION,
            "/arm_position/commands",
        ),
        ([controller()], {TWISTS: 1}, CommandKind.TWIST, TWISTS),
        (None, {"/arm_controller/joint_trajectory": 1}, CommandKind.TRAJECTORY, None),
        (None, {"/arm_position_controller/commands": 1}, CommandKind.POSITION, None),
    ],
)
def test_the_arm_is_driven_by_what_is_active(listed, listeners, kind, topic):
    drive = choose("arm", ARM, listed, listeners, TWISTS).drive
    assert drive is not None
    assert drive.kind is kind
    assert topic in (None, drive.topic)


@pytest.mark.parametrize(
    ("listed", "reason"),
    [
        ([controller(state="inactive")], "arm_controller .* is inactive"),
        ([controller(joints=(*ARM, "torso_lift_joint"))], "arm_controller .* is active"),
        ([controller(kind="effort_controllers/JointGroupEffortController")], "JointGroupEffortController"),
        ([controller("head_controller", joints=["head_1_joint"])], "no controller has the arm's joints"),
        (None, "no controller subscribes to /arm_controller/joint_trajectory"),
    ],
)
def test_without_an_active_controller_of_just_its_joints_the_reason_is_given(listed, reason):
    choice = choose("arm", ARM, listed, {}, TWISTS)
    assert choice.drive is None
    assert re.search(reason, str(choice))


def lagging(seconds, velocity, period=0.02, lag=0.1):
    """Angles of a drive with a time constant, once every millisecond, that follows a stream."""
    low, high = np.full(1, -2.0), np.full(1, 2.0)
    stream, follower = JointStream(["a"], low, high, 0.2), Follower(["a"], low, high)
    angle, angles = np.zeros(1), []
    for step in range(round(seconds / 0.001)):
        now = 10 + step * 0.001
        if step % round(period / 0.001) == 0 and velocity(now - 10) is not None:
            follower.accept(stream.move(np.array([velocity(now - 10)]), angle, now), angle, now + 0.003)
        desired = follower.sample(now)
        if desired is not None:
            angle = angle + (desired - angle) * 0.001 / lag
        angles.append(float(angle[0]))
    return angles


def test_a_drive_that_lags_is_as_fast_as_it_is_commanded():
    angles = lagging(1.0, lambda now: 0.4)
    assert (angles[-1] - angles[499]) / 0.5 == pytest.approx(0.4, rel=0.02)


def test_without_further_commands_it_rests_within_the_horizon():
    angles = lagging(2.0, lambda now: 0.4 if now < 0.5 else None)
    assert angles[-1] == pytest.approx(0.4 * (0.5 - 0.02 + 0.2), abs=0.01)
    assert abs(angles[-1] - angles[-100]) < 1e-4


def test_a_joint_commanded_to_rest_holds_its_reference():
    angles = lagging(1.5, lambda now: 0.4 if now < 0.5 else 0.0)
    assert angles[-1] == pytest.approx(0.2, abs=0.01)


def test_the_reference_of_a_joint_that_is_blocked_does_not_run_away():
    stream = JointStream(["a"], np.full(1, -2.0), np.full(1, 2.0), 0.2)
    blocked = np.zeros(1)
    for step in range(200):
        trajectory = stream.move(np.array([1.0]), blocked, step * 0.02)
    assert trajectory.points[0] == pytest.approx([LEAD])
    assert trajectory.points[-1] == pytest.approx([LEAD + 0.2])


def test_no_point_lies_beyond_the_limits():
    stream = JointStream(["a"], np.full(1, -0.1), np.full(1, 0.1), 0.2)
    trajectory = stream.move(np.array([5.0]), np.array([0.09]), 0.0)
    assert trajectory.points[-1] == pytest.approx([0.1])
    assert stream.position(np.array([-50.0]), np.array([0.09]), 0.02, 0.02) == pytest.approx([-0.1])
