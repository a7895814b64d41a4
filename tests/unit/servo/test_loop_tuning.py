"""Gains, limits and rate changed while it runs, and what a robot reports of its model."""

import dataclasses

import numpy as np
import pytest

from grabbergui.driver.sim.rendered_scene import at
from grabbergui.servo.config import Config, SafetyConfig
from grabbergui.servo.gate import Command, CommandGate
from grabbergui.servo.loop import ServoLoop
from grabbergui.servo.robots import teo
from grabbergui.servo.robots.simulated import SimRobot
from robots_for_tests import RecordingRobot, seeing

BOARD = at(0.70, 0.10, 0.36)
"Not so far off centre that the highest speed would limit the head."


def tuned(**changes):
    config = Config()
    return dataclasses.replace(config, head=dataclasses.replace(config.head, **changes))


def head_speed(loop, robot, seconds=0.3):
    """Return the speed of the fastest command for a target far off centre; the robot itself does not move."""
    fastest = 0.0
    for _ in range(round(seconds / 0.02)):
        robot.time += 0.02
        loop.see(seeing(robot, robot.time, BOARD))
        fastest = max(fastest, float(np.abs(loop.cycle(robot.time, robot.state()).command.head).max()))
    return fastest


def test_a_gain_counts_from_the_next_turn_on():
    robot = RecordingRobot()
    loop = ServoLoop(Config(), robot)
    before = head_speed(loop, robot)
    loop.tune(tuned(gain=Config().head.gain / 2))
    assert head_speed(loop, robot) == pytest.approx(before / 2, rel=0.05)


def test_what_concerns_safety_is_not_tuned():
    loop = ServoLoop(Config(), RecordingRobot())
    loop.tune(dataclasses.replace(Config(), safety=SafetyConfig(freeze=1.0)))
    assert loop.config.safety == SafetyConfig()


def test_the_gate_holds_the_limit_that_was_tuned():
    robot = RecordingRobot()
    gate = CommandGate(robot, Config())
    command = Command(head=np.radians([30.0, 0.0]))
    assert gate.send(command, 0.0)
    gate.tune(tuned(fastest=20.0))
    assert gate.send(command, 0.02)
    assert robot.velocity == pytest.approx(np.radians([20.0, 0.0]))


def test_a_body_reaches_from_the_base_to_the_camera_and_to_the_hand():
    robot = SimRobot(teo.MODEL, lambda: 0.0, head=(0.3, -0.2))
    state = robot.state()
    neck, arm = robot.skeleton(state)
    assert neck[0] == pytest.approx(np.zeros(3))
    assert neck[-1] == pytest.approx(robot.camera_pose(state.head)[:3, 3])
    assert arm[-1] == pytest.approx(state.hand[:3, 3])


def test_a_body_of_which_nothing_is_known_still_carries_the_camera():
    robot = RecordingRobot(floating=True)
    (line,) = robot.skeleton(robot.state())
    assert line[-1] == pytest.approx(robot.camera_pose(robot.head)[:3, 3])
    assert len(teo.MODEL.skeleton(np.zeros(2), None)) == 1
