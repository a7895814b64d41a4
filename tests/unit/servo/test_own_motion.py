"""Images are of now if they show the head's own motion in time, whatever their stamps say."""

import dataclasses
import math
import re
from collections import deque

import numpy as np
import pytest

from grabbergui.calibration import geometry
from grabbergui.driver.sim.rendered_scene import at
from grabbergui.servo.config import Config, HeadConfig
from grabbergui.servo.control import off_centre
from grabbergui.servo.loop import ServoLoop
from grabbergui.servo.own_motion import NOD, NOD_PERIOD_S, Nod, OwnMotionWatch
from grabbergui.servo.robots import teo
from grabbergui.servo.robots.robot import ARM
from grabbergui.servo.state_machine import State
from robots_for_tests import RecordingRobot, seeing

BOARD = at(0.70, -0.32, 0.36, yaw=4, pitch=-8)
DT = 0.02
NOISE = 0.0005
"Of a detection: radians of direction."


class LateCamera:
    """A loop whose images arrive `late` seconds after their exposure, with the stamps of their arrival."""

    def __init__(self, late=0.0, board=lambda now: BOARD, aside=0.0, robot=RecordingRobot, **sections):
        self.robot = robot(floating=True)
        self.loop = ServoLoop(Config(**sections), self.robot)
        self.late, self.board = late, board
        self.random = np.random.default_rng(1)
        self.sent = deque()
        self.cycle, self.tilts = None, []
        for _ in range(20):
            off = off_centre(self.board(0.0)[:3, 3], self.robot.camera_pose(self.robot.head)) - (aside, 0)
            self.robot.head = np.clip(self.robot.head - off * (1, -1), teo.HEAD.low, teo.HEAD.high)

    def run(self, seconds, until=None, *, busy=False):
        """Return the states that were passed; a `busy` computer misses cycles of the loop and images."""
        states, idle = [], self.robot.time
        for _ in range(round(seconds / DT)):
            now = self.robot.time + DT
            self.robot.advance(now, DT)
            if not busy or self.random.random() < 0.5:
                self.sent.append(seeing(self.robot, now, self._shaken(self.board(now))))
            if busy and now >= idle and self.random.random() < 0.06:
                idle = now + self.random.uniform(0.05, 0.3)
            if now < idle:
                if idle - now < 0.15:  # as the watchdog
                    self.robot.stop()
                continue
            arrived = None
            while self.sent and self.sent[0].captured <= now - self.late + 1e-9:
                arrived = dataclasses.replace(self.sent.popleft(), captured=now)
            if arrived is not None:
                self.loop.see(arrived)
            self.cycle = self.loop.cycle(now, self.robot.state())
            self.robot.velocity, self.robot.twist = self.cycle.command.head, self.cycle.command.hand
            self.tilts.append(self.robot.head[1])
            if self.cycle.state not in states[-1:]:
                states.append(self.cycle.state)
            if self.cycle.state is until:
                break
        return states

    def _shaken(self, board):
        return geometry.pose(board[:3, :3], board[:3, 3] + self.random.normal(0, 0.7 * NOISE, 3))


@pytest.mark.parametrize("late", [0.0, 0.06, 0.1])
def test_the_arm_moves_after_a_nod_that_is_seen_in_time(late):
    run = LateCamera(late)
    assert run.run(1.0, State.APPROACHING)[-1] is State.APPROACHING
    assert run.robot.time < 0.7 + late
    assert 0.3 * NOD < max(run.tilts) - min(run.tilts) < 1.3 * NOD


@pytest.mark.parametrize("low", [at(0.45, -0.34, 0.0, yaw=27, roll=171), at(0.41, -0.49, 0.05)])
def test_a_marker_that_the_head_cannot_centre_is_approached_after_a_nod(low):
    """With the head at its limit each nod was broken off, as the head was not centred during it, for ever."""
    run = LateCamera(board=lambda now: low)
    assert run.robot.head[1] > teo.HEAD.high[1] - 0.01
    assert run.run(1.5, State.APPROACHING)[-1] is State.APPROACHING
    assert 0.3 * NOD < max(run.tilts) - min(run.tilts) < 1.3 * NOD
    assert State.APPROACHING not in LateCamera(1.0, board=lambda now: low).run(3 * NOD_PERIOD_S)


@pytest.mark.parametrize("late", [0.3, 0.5, 1.0, 1.8])
def test_images_that_are_late_from_the_start_never_move_the_arm(late):
    """Before, the arm set out: stamps of the arrival say nothing of an image's age."""
    run = LateCamera(late)
    assert State.APPROACHING not in run.run(5.0)
    assert run.cycle.state is State.CENTRING
    lag = re.fullmatch(
        r"images show the head's motion (\d\.\d) s late, where 150 ms are allowed", run.cycle.reason
    )
    assert float(lag[1]) == pytest.approx(late, abs=0.1)


def test_images_that_become_late_stop_the_arm_until_they_are_in_time_again():
    run = LateCamera()
    run.run(1.0, State.APPROACHING)
    run.late = 1.0
    assert run.run(7.0)[1:] == [State.LOST, State.CENTRING]
    assert "1.0 s late" in run.cycle.reason
    run.late = 0.0
    assert run.run(4.0, State.APPROACHING)[-1] is State.APPROACHING


@pytest.mark.parametrize("seed", range(4))
def test_a_busy_computer_does_not_take_late_images_for_those_of_now(seed):
    """The arm had moved on for 113 mm: the head's path was known only where images had come."""
    run = LateCamera(1.0)
    run.random = np.random.default_rng(seed)
    assert State.APPROACHING not in run.run(6.0, busy=True)
    run = LateCamera()
    run.random = np.random.default_rng(seed)
    assert State.APPROACHING in run.run(6.5, State.APPROACHING, busy=True)


def test_where_any_age_is_permitted_every_motion_is_in_time():
    watch, tilts = OwnMotionWatch(60.0, 90.0), np.radians([0, 0, 0, 1, 2, 1, 0, 0, 0, 0])
    for moment, tilt in enumerate(tilts):
        camera = teo.MODEL.camera_pose(np.array([0.0, tilt]))
        watch.look(0.05 * moment, camera)
        watch.add(0.05 * moment, geometry.inverse(camera) @ BOARD)
    assert watch.shown


def test_a_head_that_turned_to_the_marker_need_not_nod():
    run = LateCamera(aside=0.3)
    run.run(3.0, State.APPROACHING)
    assert run.cycle.state is State.APPROACHING
    assert max(run.tilts) - min(run.tilts) < 0.3 * NOD


@pytest.mark.parametrize("hertz", [0.3, 0.7, 1.5])
def test_a_marker_that_a_person_holds_is_approached(hertz):
    def held(now):
        board = BOARD.copy()
        board[1:3, 3] += 0.006 * math.sin(2 * math.pi * hertz * now), 0.004 * math.cos(4 * hertz * now)
        return board

    run = LateCamera(board=held)
    assert State.APPROACHING in run.run(2 * NOD_PERIOD_S, State.APPROACHING)
    assert State.APPROACHING not in LateCamera(1.0, board=held).run(3 * NOD_PERIOD_S)


class OnlyArm(RecordingRobot):
    parts = frozenset((ARM,))


@pytest.mark.parametrize(
    ("robot", "head"),
    [
        (RecordingRobot, HeadConfig(mode="steps")),
        (RecordingRobot, HeadConfig(fastest=2.0)),
        (OnlyArm, HeadConfig()),
    ],
)
def test_a_head_that_cannot_nod_leaves_it_open(robot, head):
    run = LateCamera(1.0, robot=robot, head=head)
    assert State.APPROACHING in run.run(3.0, State.APPROACHING)


def test_a_target_above_is_nodded_to_upwards_and_a_limit_is_not_nodded_into():
    low, high = teo.HEAD.low, teo.HEAD.high
    for tilt, below, sign in ((0.0, 0.01, 1), (0.0, -0.01, -1), (high[1], 0.01, -1), (low[1], -0.01, 1)):
        assert np.sign(Nod(low, high).velocity(0.0, np.array([0.0, tilt]), below)[1]) == sign
