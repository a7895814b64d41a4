"""Chains of joints, distances between shapes, and a gate that keeps the arm from table and body."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grabbergui.calibration import geometry
from grabbergui.core.errors import UsageError
from grabbergui.servo.clearance import Box, Capsule, CapsuleBody, _segment_distance, nearest_box, parse_boxes
from grabbergui.servo.closed_loop import AT_BOARD, ClosedLoop
from grabbergui.servo.config import Config, LoopConfig
from grabbergui.servo.gate import Command, CommandGate
from grabbergui.servo.motion import SLOWER
from grabbergui.servo.robots import teo
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.state_machine import State
from robots_for_tests import RecordingRobot

CHAINS = [teo.HEAD, teo.RIGHT_ARM]


def some_angles(chain, count=10):
    random = np.random.default_rng(4)
    return random.uniform(chain.low, chain.high, (count, len(chain.joints)))


def test_teo_s_hand_at_rest_is_where_its_table_puts_it():
    """Upper arm, forearm and hand hang straight down: 0.32901 + 0.215 + 0.09 + 0.0975 below the shoulder."""
    hand = teo.RIGHT_ARM.forward(np.zeros(6))
    assert hand[:3, 3] == pytest.approx([0, -0.3469, 0.4982 - 0.32901 - 0.215 - 0.09 - 0.0975], abs=1e-9)
    assert hand[:3, 2] == pytest.approx([0, 0, -1], abs=1e-9)


def test_teo_s_head_looks_ahead_at_rest_turns_left_and_looks_down():
    assert teo.HEAD.forward([0, 0]) == pytest.approx(geometry.pose(translation=(0, 0, 0.1932 + 0.4675)))
    left = teo.HEAD.forward(np.radians([90 * 0.5, 0]))[:3, 0]
    assert left == pytest.approx([np.sqrt(0.5), np.sqrt(0.5), 0])
    assert teo.HEAD.forward(np.radians([0, 8]))[2, 0] < 0


@pytest.mark.parametrize("chain", CHAINS, ids=lambda chain: chain.name)
def test_the_jacobian_is_the_derivative(chain):
    step = 1e-6
    for angles in some_angles(chain):
        jacobian = chain.jacobian(angles)
        for joint in range(len(chain.joints)):
            moved = angles.copy()
            moved[joint] += step
            numeric = geometry.diff(chain.forward(angles), chain.forward(moved)) / step
            assert jacobian[:, joint] == pytest.approx(numeric, abs=1e-5)


def test_joint_velocities_give_the_twist_that_was_asked_for():
    arm, angles = teo.RIGHT_ARM, teo.HOME
    twist = np.array([0.03, -0.02, 0.05, 0.1, 0.05, -0.1])
    velocities = arm.velocities_for(angles, twist, damping=1e-6)
    assert arm.jacobian(angles) @ velocities == pytest.approx(twist, abs=1e-6)


def test_no_joint_is_ever_asked_to_be_too_fast_even_where_the_arm_is_straight():
    arm = teo.RIGHT_ARM
    for angles in (*some_angles(arm), np.zeros(6)):
        velocities = arm.velocities_for(angles, np.array([0.5, 0.5, 0.5, 2.0, 2.0, 2.0]))
        assert (np.abs(velocities) <= arm.fastest + 1e-9).all()


def test_a_joint_at_its_limit_is_not_driven_further():
    arm = teo.RIGHT_ARM
    for joint, (low, high) in enumerate(zip(arm.low, arm.high, strict=True)):
        for limit, sign in ((low, 1), (high, -1)):
            angles = teo.HOME.copy()
            angles[joint] = limit
            for axis in range(6):
                twist = np.zeros(6)
                twist[axis] = 0.1
                for direction in (twist, -twist):
                    assert arm.velocities_for(angles, direction)[joint] * sign >= -1e-12


def test_inverse_kinematics_finds_what_it_can_and_says_what_it_cannot():
    arm = teo.RIGHT_ARM
    goal = arm.forward(teo.HOME + 0.2)
    angles = arm.inverse(goal, teo.HOME)
    assert arm.forward(angles) == pytest.approx(goal, abs=1e-5)
    assert arm.inverse(geometry.pose(translation=(2.0, 0, 0)), teo.HOME) is None


@pytest.mark.parametrize("angles", [[0.0], [0.0, float("nan")], [0, 0, 0]])
def test_angles_that_are_none_are_refused(angles):
    with pytest.raises(UsageError, match="TEO's head has 2 joints"):
        teo.HEAD.forward(angles)


TABLE = "table 0.15 0.9 -0.9 0.5 -0.9 0.05"
points = st.lists(st.floats(-1, 1), min_size=3, max_size=3).map(np.array)


@given(points, points, points, points)
def test_no_two_points_of_two_segments_are_nearer_than_the_segments(a, b, c, d):
    shares = np.linspace(0, 1, 41)
    first = a + shares[:, None] * (b - a)
    second = c + shares[:, None] * (d - c)
    sampled = np.linalg.norm(first[:, None] - second[None], axis=2).min()
    distance = _segment_distance(a, b, c, d)
    spacing = (np.linalg.norm(b - a) + np.linalg.norm(d - c)) / 80
    assert sampled - spacing - 1e-6 <= distance <= sampled + 1e-6


@pytest.mark.parametrize("length", [1e-2, 1e-4, 1e-6, 1e-7])
def test_short_segments_are_no_points_and_cross_at_right_angles(length):
    along, across, up = np.eye(3) * length
    assert _segment_distance(-along, along, up - across, up + across) == pytest.approx(length)
    assert _segment_distance(-along, along, -across + along / 2, across + along / 2) == pytest.approx(
        0, abs=1e-12
    )
    assert _segment_distance(3 * along, along, np.zeros(3), np.zeros(3)) == pytest.approx(length)


@given(points, points)
def test_the_distance_to_a_box_is_never_too_large_and_a_hundredth_too_small_at_most(start, end):
    box = Box("box", np.array([-0.3, -0.2, -0.1]), np.array([0.3, 0.2, 0.1]))
    dense = start + np.linspace(0, 1, 4001)[:, None] * (end - start)
    outside = np.linalg.norm(np.maximum(np.maximum(box.low - dense, dense - box.high), 0), axis=1).min()
    distance = nearest_box([Capsule("link", start, end, 0.0)], [box]).distance
    assert distance <= outside + 1e-9
    assert distance >= outside - 0.03 - (outside == 0) * 0.1


def test_boxes_are_read_and_bad_ones_are_named():
    box, shelf = parse_boxes(f"{TABLE}; shelf 1 2 1 2 1 2")
    assert (box.name, shelf.name) == ("table", "shelf")
    assert box.low.tolist() == [0.15, -0.9, -0.9]
    assert box.high.tolist() == [0.9, 0.5, 0.05]
    assert parse_boxes("") == ()
    for text in ("table 1 2 3", "table 1 2 3 4 5 x", "table 2 1 0 1 0 1", "table 0 1 0 1 0 nan"):
        with pytest.raises(UsageError, match="table"):
            parse_boxes(text)


def pushed(robot, clock, config, goal, touched, seconds=8.0):
    """Push the hand towards a goal in its base, whatever is between; the gate that was passed."""
    gate = CommandGate(robot, config)
    for _ in range(round(seconds / 0.02)):
        error = geometry.diff(robot.state().hand, goal)
        way, turn = np.linalg.norm(error[:3]), np.linalg.norm(error[3:])
        twist = np.concatenate(
            (
                error[:3] / max(way, 1e-9) * min(1.5 * way, 0.12),
                error[3:] / max(turn, 1e-9) * min(1.5 * turn, math.radians(35)),
            )
        )
        gate.send(Command(hand=twist), clock[0])
        clock[0] += 0.02
        assert not touched(robot.state().arm)
    return gate


def inside(arm, box):
    """Whether a point of the arm's links, with their thickness, lies in a box; by points alone."""
    for link in teo.BODY.capsules(arm):
        dense = link.start + np.linspace(0, 1, 50)[:, None] * (link.end - link.start)
        off = np.maximum(np.maximum(box.low - dense, dense - box.high), 0)
        if (np.linalg.norm(off, axis=1) < link.radius).any():
            return True
    return False


@pytest.fixture
def clock():
    return [0.0]


@pytest.fixture
def simulated(clock):
    return SimRobot(teo.MODEL, lambda: clock[0])


def test_a_hand_that_is_aimed_through_the_table_stops_above_it(simulated, clock):
    config = replace(Config(), safety=replace(Config().safety, obstacles=TABLE))
    (table,) = parse_boxes(TABLE)
    goal = simulated.state().hand.copy()
    goal[2, 3] = -0.2
    gate = pushed(simulated, clock, config, goal, lambda arm: inside(arm, table))
    assert "of table" in gate.hindrance
    assert simulated.state().hand[2, 3] < 0.18  # it went as near as it may
    free = pushed(SimRobot(teo.MODEL, lambda: clock[0]), clock, Config(), goal, lambda arm: False)
    assert free.hindrance == ""


def test_a_hand_that_is_aimed_through_the_body_stops_before_it(simulated, clock):
    goal = simulated.state().hand.copy()
    goal[:3, 3] = (0.06, 0.1, 0.15)
    gate = pushed(
        simulated, clock, Config(), goal, lambda arm: teo.BODY.nearest(arm).distance < 0.01, seconds=10
    )
    assert "the trunk" in gate.hindrance


def test_a_hand_that_is_aimed_out_of_the_workspace_stays_inside(simulated, clock):
    config = replace(Config(), arm=replace(Config().arm, z_low=0.1))
    goal = simulated.state().hand.copy()
    goal[2, 3] = -0.2
    gate = pushed(simulated, clock, config, goal, lambda arm: teo.RIGHT_ARM.forward(arm)[2, 3] < 0.095)
    assert "leave the workspace (z = 0.0" in gate.hindrance


def test_a_motion_costs_a_look_at_the_body_for_each_of_its_speeds_and_one_at_where_it_is(
    simulated, monkeypatch
):
    looks = []
    nearest = CapsuleBody.nearest
    monkeypatch.setattr(CapsuleBody, "nearest", lambda body, arm: looks.append(arm) or nearest(body, arm))
    gate = CommandGate(simulated, Config())
    assert gate.send(Command(hand=np.array([0.05, 0, 0, 0, 0, 0])), 0.0)
    assert len(looks) == 1  # it is free
    looks.clear()
    near = replace(Config(), safety=replace(Config().safety, obstacles=TABLE, clearance=0.5))
    CommandGate(simulated, near).send(Command(hand=np.array([0, 0, -0.1, 0, 0, 0])), 0.02)
    assert len(looks) == len(SLOWER) + 1


def test_other_obstacles_hold_from_the_next_command_and_are_named_in_the_log_once(simulated, caplog):
    gate, down = CommandGate(simulated, Config()), Command(hand=np.array([0, 0, -0.1, 0, 0, 0]))
    assert gate.send(down, 0.0) and gate.hindrance == ""
    gate.tune(replace(Config(), safety=replace(Config().safety, obstacles=TABLE, clearance=0.5)))
    for number in range(1, 4):
        gate.send(down, 0.02 * number)
        assert "of table" in gate.hindrance
    assert caplog.text.count("the hand is held back") == 1


def test_what_is_too_near_may_go_away(simulated, clock):
    config = replace(Config(), safety=replace(Config().safety, obstacles=TABLE, clearance=0.5))
    gate = CommandGate(simulated, config)
    assert gate.send(Command(hand=np.array([0, 0, 0.1, 0, 0, 0])), 0.0)
    assert gate.hindrance == ""
    gate.send(Command(hand=np.array([0, 0, -0.1, 0, 0, 0])), 0.0)
    assert "of table" in gate.hindrance


def test_tiago_s_meshes_never_touch_its_body(clock):
    pinocchio = pytest.importorskip("pinocchio", reason="Pinocchio is not installed: pip install '.[servo]'")
    pytest.importorskip("example_robot_data", reason="no robot data: pip install '.[servo]'")
    from grabbergui.servo.robots import tiago
    from grabbergui.servo.robots.urdf_chain import UrdfBody, load_urdf, package_folders

    model = tiago.model()
    assert isinstance(model.body, UrdfBody)
    full = load_urdf(tiago.shipped_urdf())
    urdf = tiago.shipped_urdf()
    shapes = pinocchio.buildGeomFromUrdf(
        full, str(urdf), pinocchio.GeometryType.COLLISION, package_dirs=package_folders(urdf)
    )
    names = [shape.name for shape in shapes.geometryObjects]
    for arm in ("arm_4_link_0", "arm_5_link_0", "arm_6_link_0", "hand_palm_link_0"):
        for body in ("torso_lift_link_0", "head_2_link_0", "base_link_0"):
            if arm in names and body in names:
                pair = pinocchio.CollisionPair(names.index(arm), names.index(body))
                shapes.addCollisionPair(pair)
    assert len(shapes.collisionPairs) > 5

    def touched(arm):
        angles = pinocchio.neutral(full)
        angles[[full.joints[full.getJointId(name)].idx_q for name in tiago.ARM_JOINTS]] = arm
        data = shapes.createData()
        return pinocchio.computeCollisions(full, full.createData(), shapes, data, angles, True)

    robot = SimRobot(model, lambda: clock[0])
    goal = robot.state().hand.copy()
    goal[:3, 3] = (-0.05, 0.0, -0.2)
    config = replace(Config(), arm=replace(Config().arm, x_low=-0.5))
    gate = pushed(robot, clock, config, goal, touched, seconds=6)
    assert "would come within" in gate.hindrance
    assert geometry.distance(robot.state().hand, goal) > 0.05


def test_the_loop_says_what_holds_the_hand_back():
    loop = ClosedLoop(rendered=False)
    wall = wall_before(loop.loop.arm.goal(loop.things.board(0.0)))
    loop = ClosedLoop(config=wall, head=AT_BOARD, rendered=False)
    cycle = loop.run(25, until=State.STUCK)
    assert cycle.state is State.STUCK
    assert "of wall" in cycle.reason


def wall_before(goal):
    """A wall 6 cm before the goal, which reaches to everything behind it."""
    x = goal[0, 3] - 0.06
    return replace(Config(), safety=replace(Config().safety, obstacles=f"wall {x:.3f} {x + 1:.3f} -2 2 -2 2"))


def test_nothing_reaches_a_robot_in_a_dry_run_not_even_a_stop():
    robot = RecordingRobot()
    gate = CommandGate(robot, Config(), dry_run=True)
    assert not gate.send(Command(np.array([0.1, 0]), None, np.full(6, 0.01)), 1.0)
    assert not gate.send(Command(head_step=np.array([0.01, 0])), 1.02)
    gate.rest()
    gate.halt("emergency stop")
    gate.release()
    gate.expire(9.0)
    assert robot.moves == []
    assert robot.stops == 0
    assert gate.sent == 0


def test_all_motion_is_slowed_down_by_the_speed_override():
    def fastest(speed):
        aside = (AT_BOARD[0] + 0.2, AT_BOARD[1])
        config = replace(Config(), loop=LoopConfig(speed=speed))
        loop = ClosedLoop(config=config, head=aside, rendered=False)
        assert loop.run(9, until=State.APPROACHING).state is State.APPROACHING
        loop.run(1)  # within which the hand is as fast as it may be
        hands = [np.linalg.norm(cycle.command.hand[:3]) for cycle in loop.cycles]
        heads = [np.abs(cycle.command.head).max() for cycle in loop.cycles]
        return np.array([max(hands), max(heads)])

    whole, slow = fastest(1.0), fastest(0.3)
    assert (whole > 0.05).all()
    assert slow[0] <= 0.3 * Config().arm.fastest + 1e-9
    assert (slow < 0.6 * whole).all()
    with pytest.raises(UsageError, match=r"0\.01 to 1"):
        replace(Config(), loop=LoopConfig(speed=1.5))
