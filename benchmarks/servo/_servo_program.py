"""Runs `grabbergui servo` with a hand that never arrives: `python _servo_program.py OPTIONS`.

Everything but the marker is real. Whatever the images show, the marker is reported far above or far below
the hand's first position, so the hand moves up and down at full speed without end. With a window,
`_servo_window` reads the terminal.
"""

import os
import sys
from argparse import Namespace
from contextlib import ExitStack
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

from benchmarks._priority import run_as_others
from grabbergui import cli
from grabbergui.calibration import geometry
from grabbergui.calibration.marker_pose import MarkerDetection
from grabbergui.calibration.markers import Grey
from grabbergui.servo import closed_loop
from grabbergui.servo.cli import servo_robots
from grabbergui.servo.config import Config
from grabbergui.servo.control import HAND_ON_MARKER
from grabbergui.servo.detection import Detector
from grabbergui.servo.robots.robot import Robot

TRAVEL = 0.10
"Metres above and below the hand's first position at which it turns back."
AHEAD = 0.25
"Metres above and below that position of the goal; the hand never gets near enough to slow down."


class MarkerAhead:
    """Detects a marker above the hand, and once the hand is high, one below it."""

    def __init__(self, robot: Robot, config: Config) -> None:
        self._robot, self._id = robot, config.marker.id
        self._marker_on_goal = geometry.inverse(
            geometry.pose(HAND_ON_MARKER, (0.0, 0.0, config.marker.standoff))
        )
        self._start: geometry.Pose | None = None
        self._side = 1.0

    def detect(self, grey: Grey) -> list[MarkerDetection]:
        """Return the marker as the camera would see it now."""
        state = self._robot.state()
        if state is None:
            return []
        if self._start is None:
            self._start = state.hand.copy()
        height = state.hand[2, 3] - self._start[2, 3]
        self._side = -1.0 if height > TRAVEL else 1.0 if height < -TRAVEL else self._side
        goal = self._start.copy()
        goal[2, 3] += AHEAD * self._side
        camera = self._robot.camera_pose(state.head)
        pose = geometry.inverse(camera) @ goal @ self._marker_on_goal
        return [MarkerDetection(self._id, np.zeros((4, 2)), pose)]


_assemble = servo_robots.assemble


def assembled(options: Namespace, config: Config, stack: ExitStack) -> servo_robots.RobotScene:
    """Return the robot and camera of the command, with the simulated detection of the marker."""
    scene = _assemble(options, config, stack)

    def detector(*_: Any, **__: Any) -> Detector:
        return Detector(MarkerAhead(scene.robot, config))

    stack.enter_context(patch.object(closed_loop, "detector", detector))
    return scene


def main(arguments: list[str]) -> int:
    """Run the command until it ends."""
    run_as_others()  # the parent simulates a robot and has a raised priority
    with ExitStack() as stack:
        stack.enter_context(patch.object(servo_robots, "assemble", assembled))
        if "--headless" not in arguments:
            from grabbergui.servo.ui import servo_process

            window = [str(Path(__file__).with_name("_servo_window.py")), os.ttyname(sys.stdin.fileno())]
            stack.enter_context(patch.object(servo_process, "WINDOW_PROGRAM", window))
        return cli.main(["servo", *arguments])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
