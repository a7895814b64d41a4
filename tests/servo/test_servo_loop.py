"""What the loop tells a window of each cycle, and what is tuned while it runs."""

import dataclasses

import numpy as np
import pytest
from robots_for_tests import RecordingRobot, seeing

from grabbergui.driver.sim.rendered_scene import at
from grabbergui.servo.config import ArmConfig, Config, HeadConfig, LoopConfig
from grabbergui.servo.control import off_centre
from grabbergui.servo.detection import Sighting
from grabbergui.servo.loop import ServoLoop

BOARD = at(0.70, -0.32, 0.36, yaw=4, pitch=-8)
FACE = (1.35, -0.1, 0.8)
DT = 0.02


class Bench:
    """A loop and a robot that stays where it is, under one clock."""

    def __init__(self, **sections):
        self.robot = RecordingRobot()
        self.loop = ServoLoop(Config(**sections), self.robot)

    def run(self, see, cycles=30):
        for _ in range(cycles):
            self.robot.time += DT
            self.loop.see(see(self.robot.time))
            cycle = self.loop.cycle(self.robot.time, self.robot.state())
        return cycle

    def look_at(self, board):
        """Turn the head at once to where the camera has a board in its middle."""
        for _ in range(20):
            aside = off_centre(board[:3, 3], self.robot.camera_pose(self.robot.head))
            self.robot.head = self.robot.head - aside * (1, -1)

    def board(self, now):
        return seeing(self.robot, now, BOARD)


def test_a_moment_has_what_the_loop_knew():
    bench = Bench()
    cycle = bench.run(lambda now: seeing(bench.robot, now, BOARD, FACE))
    moment = bench.loop.moment(cycle)
    assert moment.cycle is cycle and moment.sighting.captured == bench.robot.time
    assert moment.marker == pytest.approx(BOARD, abs=1e-6)
    assert moment.goal == pytest.approx(bench.loop.arm.goal(BOARD), abs=1e-6)
    assert moment.person == pytest.approx(FACE)
    cycle = bench.run(Sighting)
    moment = bench.loop.moment(cycle)
    assert moment.marker is moment.goal is moment.person is None
    assert np.isnan(cycle.off_centre).all() and np.isnan(cycle.error).all()


def test_what_is_tuned_are_head_arm_and_loop():
    bench = Bench()
    sections = {
        "head": HeadConfig(fastest=7.0),
        "arm": ArmConfig(fastest=0.01),
        "loop": dataclasses.replace(LoopConfig(), speed=0.5),
    }
    bench.loop.tune(Config(**sections))
    assert bench.loop.config == dataclasses.replace(Config(), **sections)
    cycle = bench.run(lambda now: seeing(bench.robot, now, face=(1.0, 1.0, 0.7)))
    assert np.degrees(np.abs(cycle.command.head)).max() == pytest.approx(7.0 / 2)
    bench.look_at(BOARD)
    cycle = bench.run(bench.board, 100)
    assert np.linalg.norm(cycle.command.hand[:3]) == pytest.approx(0.01 / 2)
