"""An approach that cannot come to its end: it is noticed, and said why, instead of pushing for ever."""

import dataclasses
import math

import numpy as np
import pytest

from grabbergui.calibration import geometry
from grabbergui.driver.sim.rendered_scene import at
from grabbergui.servo.config import Config
from grabbergui.servo.detection import Sighting
from grabbergui.servo.gate import CommandGate
from grabbergui.servo.loop import ServoLoop
from grabbergui.servo.progress_watch import ProgressWatch
from grabbergui.servo.robots import teo
from grabbergui.servo.robots.robot import RobotState
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.state_machine import State
from robots_for_tests import marker

DT = 0.02
REACHABLE = at(0.70, -0.32, 0.36, yaw=4, pitch=-8)
ROLLED = at(0.70, -0.32, 0.36, roll=120)
"Nearer than REACHABLE to nothing but the shoulder's and the wrist's limits."
FAR = at(0.93, -0.30, 0.50)
"The hand's goal is in the workspace, but farther than the arm is long."


def off(metres, degrees=0.0):
    return geometry.pose(geometry.rotation_from_vector((0, 0, math.radians(degrees))), (metres, 0, 0))


class Chase:
    """A loop, its gate and a robot with real kinematics, and a perfect camera, under one clock."""

    def __init__(self, board, robot=SimRobot):
        self.now, self.board = 0.0, board
        self.robot = robot(teo.MODEL, lambda: self.now)
        self.loop = ServoLoop(Config(), self.robot)
        self.gate = CommandGate(self.robot, Config())

    def run(self, seconds, until=None):
        for _ in range(round(seconds / DT)):
            state = self.robot.state()
            view = geometry.inverse(self.robot.camera_pose(state.head))
            self.loop.see(Sighting(self.now, (marker(view @ self.board),)))
            cycle = self.loop.cycle(self.now, state)
            self.gate.send(cycle.command, self.now)
            self.loop.held_back(self.gate.hindrance)
            if self.gate.halted:
                self.loop.machine.stop(self.now, self.gate.halted)
            self.now += DT
            if cycle.state is until:
                break
        return cycle


def stuck(board, reason):
    """Return a chase whose hand came no nearer, gave up and said why."""
    chase = Chase(board)
    cycle = chase.run(15, State.STUCK)
    assert cycle.state is State.STUCK
    assert "comes no nearer than" in cycle.reason and reason in cycle.reason
    assert chase.run(0.5).state is State.STUCK
    assert not cycle.command.hand.any()
    assert chase.robot.speed < 1e-3
    assert chase.robot.limit_violations == 0
    return chase


def test_a_hand_at_its_limits_gives_up_and_tries_again_once_the_marker_moved_and_not_before():
    chase = stuck(ROLLED, "AxialRightShoulder and FrontalRightWrist are at their limits")
    assert chase.run(5).state is State.STUCK
    chase.board = REACHABLE
    assert chase.run(1, State.APPROACHING).state is State.APPROACHING
    assert chase.run(15, State.REACHED).state is State.REACHED


def test_a_hand_that_is_stretched_gives_up_and_tries_again_after_a_stop_was_ended():
    chase = stuck(FAR, "stretched")
    chase.loop.machine.stop(chase.now, "pressed")
    chase.run(0.1)
    chase.loop.machine.resume(chase.now)
    assert chase.run(2, State.APPROACHING).state is State.APPROACHING


class CoarseEncoders(SimRobot):
    """Steps of a tenth of a degree make an arm that creeps along its limits stand still, to the last bit."""

    STEP = math.radians(0.1)

    def state(self):
        state = super().state()
        arm, head = (self.STEP * np.round(angles / self.STEP) for angles in (state.arm, state.head))
        return RobotState(state.time, head, self.model.arm.forward(arm), arm)


class SlowEncoders(CoarseEncoders):
    """Coarse readings at 20 Hz, 20 ms late. With much slower ones nothing moves at all."""

    PERIOD, DELAY = 0.05, 0.02

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self._readings = []

    def state(self):
        state = super().state()
        if not self._readings or state.time >= self._readings[-1].time + self.PERIOD - 1e-9:
            self._readings.append(state)
        arrived = [reading for reading in self._readings[-9:] if reading.time + self.DELAY <= state.time]
        if not arrived:
            return state
        return dataclasses.replace(arrived[-1], time=arrived[-1].time + self.DELAY)


def test_an_honest_robot_with_slow_and_coarse_encoders_is_not_taken_for_a_dead_one():
    chase = Chase(REACHABLE, SlowEncoders)
    chase.run(8)
    states = [step.state for step in chase.loop.machine.transitions]
    assert State.STOPPED not in states
    assert State.APPROACHING in states
    assert geometry.distance(chase.robot.state().hand, chase.loop.arm.goal(chase.loop.marker.pose)) < 0.02


@pytest.mark.parametrize("board", [ROLLED, FAR])
def test_an_arm_at_its_limits_is_not_taken_for_one_whose_encoders_froze(board):
    chase = Chase(board, CoarseEncoders)
    cycle = chase.run(15, State.STUCK)
    assert cycle.state is State.STUCK, cycle.reason
    assert [step.state for step in chase.loop.machine.transitions if step.state is State.STOPPED] == []


def fed(watch, hands, approaching=True):
    for step, hand in enumerate(hands):
        watch.update(DT * (step + 1), hand, geometry.pose(), approaching)
    return watch.stuck


@pytest.mark.parametrize(("speed", "patience"), [(1.0, 3.0), (0.5, 6.0)])
def test_patience_is_counted_in_seconds_at_full_speed(speed, patience):
    watch, near, nearer = ProgressWatch(3.0), off(0.05), off(0.047)
    watch.update(0.0, near, geometry.pose(), True, speed)
    watch.update(patience - 0.1, near, geometry.pose(), True, speed)
    assert not watch.stuck
    watch.update(patience - 0.05, nearer, geometry.pose(), True, speed)
    watch.update(2 * patience - 0.1, nearer, geometry.pose(), True, speed)
    assert not watch.stuck, "it began again with the progress"
    watch.update(2 * patience, nearer, geometry.pose(), True, speed)
    assert watch.stuck


@pytest.mark.parametrize(
    ("goal", "another"), [(off(0.019), False), (off(0.03), True), (off(0, 4), False), (off(0, 6), True)]
)
def test_a_goal_that_moved_a_little_is_the_same(goal, another):
    watch = ProgressWatch(1.0)
    watch.update(0.0, off(0.5), geometry.pose(), True)
    watch.update(1.1, off(0.5), geometry.pose(), True)
    watch.update(1.2, off(0.5), goal, True)
    assert watch.stuck is not another


def test_slow_progress_is_progress():
    """4 mm in three seconds, first of place, then of direction."""
    assert not fed(ProgressWatch(3.0), [off(0.05 - 0.0013 * DT * step) for step in range(1000)])
    assert not fed(ProgressWatch(3.0), [off(0.02, 30 - 0.8 * DT * step) for step in range(1000)])


def test_trembling_is_no_progress():
    random = np.random.default_rng(3)
    assert fed(ProgressWatch(3.0), [off(0.05 + random.normal(0, 3e-4)) for _ in range(500)])


def test_time_at_rest_does_not_count():
    assert not fed(ProgressWatch(3.0), [off(0.05)] * 500, approaching=False)


def test_a_goal_that_wanders_is_followed_for_ever():
    watch = ProgressWatch(3.0)
    for step in range(1000):
        watch.update(DT * step, off(0.05), off(0.1 + 0.05 * DT * step), True)
    assert not watch.stuck


def test_nothing_hinders_an_arm_in_the_middle_of_its_reach():
    twists = np.vstack((np.eye(6), -np.eye(6))) * 0.1
    assert {teo.RIGHT_ARM.hindrance(teo.HOME, twist) for twist in twists} == {""}


@pytest.mark.parametrize("joint", range(6))
def test_the_joint_that_is_in_the_way_is_named(joint):
    for limit, sign in ((teo.RIGHT_ARM.high, 1), (teo.RIGHT_ARM.low, -1)):
        angles = teo.HOME.copy()
        angles[joint] = limit[joint]
        twist = sign * teo.RIGHT_ARM.jacobian(angles)[:, joint]
        if np.linalg.svd(teo.RIGHT_ARM.jacobian(angles))[1][-1] > 0.1:
            assert teo.RIGHT_ARM.joint_names[joint] in teo.RIGHT_ARM.hindrance(angles, twist)
            assert teo.RIGHT_ARM.joint_names[joint] not in teo.RIGHT_ARM.hindrance(angles, -twist)
