"""Messages of TIAGo's topics, read from any object with their fields; no ROS needed."""

import math
import time
from types import SimpleNamespace as Message

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grabbergui.calibration import geometry
from grabbergui.core.errors import RemoteProtocolError
from grabbergui.servo.robots import tiago_messages as messages
from grabbergui.servo.robots.joint_readings import JointReadings
from grabbergui.servo.robots.joint_trajectory import read_trajectory
from grabbergui.servo.robots.static_frames import StaticFrames
from grabbergui.servo.robots.tiago_channel import TiagoChannel
from grabbergui.servo.robots.tiago_topics import Follower

HEAD = ("head_1_joint", "head_2_joint")


def stamped(seconds=0, nanoseconds=0, frame=""):
    return Message(stamp=Message(sec=seconds, nanosec=nanoseconds), frame_id=frame)


def trajectory(
    positions=(0.1, 0.2), names=HEAD, velocities=(), seconds=1, nanoseconds=500_000_000, stamp=(0, 0)
):
    duration = Message(sec=seconds, nanosec=nanoseconds)
    point = Message(positions=list(positions), velocities=list(velocities), time_from_start=duration)
    return Message(header=stamped(*stamp), joint_names=list(names), points=[point])


def joint_state(names, positions, seconds=0):
    return Message(header=stamped(seconds), name=list(names), position=list(positions))


def test_a_trajectory_is_read_in_the_order_of_its_message():
    read = read_trajectory(trajectory((0.2, 0.1), HEAD[::-1]))
    assert read.joints == HEAD[::-1]
    assert read.points.tolist() == [[0.2, 0.1]]
    assert read.times == (1.5,)
    assert read.start is None
    assert read_trajectory(trajectory(stamp=(3, 500_000_000))).start == 3.5


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        (trajectory(names=("arm_1_joint", "head_2_joint")), "arm_1_joint"),
        (trajectory(names=HEAD[:1], positions=(0.1,)), "not"),
        (trajectory((0.1,)), "1 positions"),
        (trajectory((0.1, math.nan)), "finite"),
        (trajectory((0.1, 2.0)), "head_2_joint at 2.000 rad is beyond"),
        (trajectory(velocities=(0.1, 0.0)), "rest"),
        (trajectory(stamp=(3, 0)), "it ended 5.5 s ago"),
        (Message(header=stamped(), joint_names=list(HEAD), points=[]), "0 times"),
    ],
)
def test_a_trajectory_that_a_controller_would_refuse_is_refused_and_the_one_before_goes_on(message, reason):
    follower = Follower(HEAD, np.full(2, -1.0), np.full(2, 1.0))
    follower.accept(read_trajectory(trajectory((0.5, -0.5))), np.zeros(2), 9.0)
    with pytest.raises(RemoteProtocolError, match=reason):
        follower.accept(read_trajectory(message), np.zeros(2), 10.0)
    assert follower.sample(9.75) == pytest.approx([0.25, -0.25])


def twist(values, frame="torso_lift_link"):
    axes = [Message(**dict(zip("xyz", part, strict=True))) for part in (values[:3], values[3:])]
    return Message(header=stamped(frame=frame), twist=Message(linear=axes[0], angular=axes[1]))


def test_a_twist_is_read_along_our_axes_only():
    assert messages.read_twist(twist(range(6))).tolist() == list(range(6))
    with pytest.raises(RemoteProtocolError, match="'arm_tool_link'"):
        messages.read_twist(twist(range(6), "arm_tool_link"))
    with pytest.raises(RemoteProtocolError, match="not finite"):
        messages.read_twist(twist([0, 0, math.inf, 0, 0, 0]))


def test_joints_may_come_in_parts_and_count_from_the_oldest():
    readings = JointReadings(("a", "b", "c"))
    readings.take(joint_state("bx", (0.2, 9.0)), 1.0)
    assert readings.angles("ab") is None
    assert readings.missing() == ["a", "c"]
    readings.take(joint_state("a", (0.1,)), 2.0)
    time, angles = readings.angles("ab")
    assert time == 1.0
    assert angles.tolist() == [0.1, 0.2]


def test_a_message_that_is_sent_again_says_nothing_new():
    readings = JointReadings("a")
    readings.take(joint_state("a", (0.1,), seconds=5), 1.0)
    readings.take(joint_state("a", (0.1,), seconds=5), 2.0)
    readings.take(joint_state("a", (0.7,), seconds=4), 3.0)
    assert readings.angles("a") == (1.0, [0.1])
    readings.take(joint_state("a", (0.2,), seconds=6), 4.0)
    assert readings.angles("a") == (4.0, [0.2])


def test_a_clock_that_was_set_back_is_followed_after_half_a_second():
    readings = JointReadings("a")
    for _ in range(2):
        readings.take(joint_state("a", (0.1,), seconds=1000), 0.0)
    for tick in range(1, 11):
        readings.take(joint_state("a", (tick,), seconds=10 + tick), 0.1 * tick)
    time, angles = readings.angles("a")
    assert (time, angles) == (1.0, [10])
    readings.take(joint_state("a", (0.2,), seconds=21), 1.1)
    assert readings.angles("a") == (1.1, [0.2])


def test_of_two_publishers_the_one_whose_clock_is_behind_is_not_believed():
    readings = JointReadings("a")
    for tick in range(20):
        readings.take(joint_state("a", (0.1,), seconds=1000 + tick), 0.1 * tick)
        readings.take(joint_state("a", (0.7,), seconds=10 + tick), 0.1 * tick)
        assert readings.angles("a") == (0.1 * tick, [0.1])


def test_an_old_message_that_is_repeated_is_not_believed():
    readings = JointReadings("a")
    readings.take(joint_state("a", (0.1,), seconds=1000), 0.0)
    for tick in range(1, 20):
        readings.take(joint_state("a", (0.7,), seconds=10), 0.1 * tick)
    assert readings.angles("a") == (0.0, [0.1])


def test_without_stamps_every_message_counts():
    readings = JointReadings("a")
    for now in (1.0, 2.0):
        readings.take(joint_state("a", (now,)), now)
    assert readings.angles("a") == (2.0, [2.0])


@pytest.mark.parametrize(("age", "sent"), [(0.1, [0.5, 0.5]), (10, None)])
def test_the_guardian_moves_no_part_to_where_it_was_long_ago(monkeypatch, age, sent):
    stops = {}
    channel = TiagoChannel("/joint_states", head="/head")
    clock = Message(now=lambda: Message(to_msg=lambda: "now"))
    channel._ros = Message(node=Message(get_clock=lambda: clock))
    channel._parts = {"head": Message(stop=lambda angles, stamp: stops.update(angles=angles))}
    channel._readings.take(joint_state(["head_1_joint", "head_2_joint"], (0.5, 0.5)), time.monotonic() - age)

    channel.stop()

    found = stops["angles"]
    assert (None if found is None else found.tolist()) == sent


@pytest.mark.parametrize(
    "message", [joint_state("ab", (0.1,)), joint_state("ab", ()), joint_state("ab", (0.1, math.nan))]
)
def test_a_joint_state_that_contradicts_itself_is_not_believed(message):
    readings = JointReadings("b")
    with pytest.raises(RemoteProtocolError):
        readings.take(message, 1.0)
    assert readings.angles("b") is None


@given(
    st.lists(st.sampled_from("abcx"), max_size=6), st.lists(st.floats(), max_size=6), st.integers(0, 2**31)
)
def test_whatever_comes_what_is_known_is_finite(names, positions, stamp):
    readings = JointReadings("abc")
    try:
        readings.take(joint_state(names, positions, stamp), 1.0)
    except RemoteProtocolError:
        return
    for name in "abc":
        found = readings.angles(name)
        assert found is None or np.isfinite(found[1]).all()


def transform(parent, child, place=(0.0, 0.0, 0.0), turn=(0.0, 0.0, 0.0, 1.0)):
    translation = Message(**dict(zip("xyz", place, strict=True)))
    rotation = Message(**dict(zip("xyzw", turn, strict=True)))
    return Message(
        header=stamped(frame=parent),
        child_frame_id=child,
        transform=Message(translation=translation, rotation=rotation),
    )


def frames(*transforms):
    tree = StaticFrames()
    tree.take(Message(transforms=list(transforms)))
    return tree


def test_frames_are_followed_up_to_the_ancestor():
    quarter = math.sqrt(0.5)
    tree = frames(
        transform("/head", "mount", (0.1, 0.0, 0.0), (0.0, 0.0, quarter, quarter)),
        transform("mount", "/camera", (1.0, 0.0, 0.0)),
    )
    assert tree.of("camera", "head")[:3, 3] == pytest.approx([0.1, 1.0, 0.0])
    assert tree.of("camera", "camera") == pytest.approx(np.eye(4))
    assert tree.of("camera", "elsewhere") is None
    assert tree.of("nobody", "head") is None


def test_a_circle_of_frames_and_a_turn_that_is_none_lead_nowhere():
    assert frames(transform("a", "b"), transform("b", "a")).of("a", "head") is None
    assert frames(transform("head", "camera", turn=(0.0, 0.0, 0.0, 0.0))).of("camera", "head") is None
    assert frames(transform("head", "camera", (math.nan, 0, 0))).of("camera", "head") is None


def test_quaternions_go_there_and_back():
    for vector in ((0, 0, 0), (0.1, -0.2, 0.3), (0, 3.1, 0), (1.0, 1.0, -1.0)):
        rotation = geometry.rotation_from_vector(vector)
        x, y, z, w = geometry.quaternion_from_rotation(rotation)
        assert math.hypot(x, y, z, w) == pytest.approx(1)
        assert geometry.rotation_from_quaternion(2 * x, 2 * y, 2 * z, 2 * w) == pytest.approx(rotation)
