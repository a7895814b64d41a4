"""`grabbergui servo` with a hand that never arrives: `python _servo_program.py OPTIONS`.

All of the command is real but the marker. Whatever the images show, it is far above the hand's first place
or far below, so that the hand goes up and down at full speed for ever. Lines of standard input are what a
person does in the window: `click startButton`, `click stopButton`, `press Space`, `press Escape`.
"""

import os
import sys
from argparse import Namespace
from contextlib import ExitStack
from typing import Any
from unittest.mock import patch

import numpy as np

from grabbergui import cli
from grabbergui.calibration import geometry
from grabbergui.calibration.marker_pose import MarkerDetection
from grabbergui.calibration.markers import Grey
from grabbergui.cli import servo_robots
from grabbergui.servo import closed_loop
from grabbergui.servo.config import Config
from grabbergui.servo.control import HAND_ON_MARKER
from grabbergui.servo.detection import Detector
from grabbergui.servo.priority import run_as_others
from grabbergui.servo.robots.robot import Robot

TRAVEL = 0.10
"Metres up and down from the hand's first place at which it turns back."
AHEAD = 0.25
"Metres up and down from there to which it is drawn: too far to slow down before it turns back."


class MarkerAhead:
    """Sees a marker that draws the hand up, and once the hand is high, down."""

    def __init__(self, robot: Robot, config: Config) -> None:
        self._robot, self._id = robot, config.marker.id
        self._marker_on_goal = geometry.inverse(
            geometry.pose(HAND_ON_MARKER, (0.0, 0.0, config.marker.standoff))
        )
        self._start: geometry.Pose | None = None
        self._side = 1.0

    def detect(self, grey: Grey) -> list[MarkerDetection]:
        """The marker as the camera would see it now."""
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


def assembled(options: Namespace, config: Config, stack: ExitStack) -> servo_robots.Scene:
    """Robot and camera as the command has them, and the marker before them."""
    scene = _assemble(options, config, stack)

    def detector(*_: Any, **__: Any) -> Detector:
        return Detector(MarkerAhead(scene.robot, config))

    stack.enter_context(patch.object(closed_loop, "detector", detector))
    return scene


def obey_in_window() -> Any:
    """Click and press as standard input says; return the object that does it."""
    from PyQt5.QtCore import QSocketNotifier, Qt
    from PyQt5.QtTest import QTest

    from grabbergui.ui.run.application import application
    from grabbergui.ui.views.servo_window import ServoWindow

    app, lines = application(), sys.stdin.fileno()
    hands: Any = QTest  # the stubs take its functions for methods

    def obey(*_: object) -> None:
        window = next((each for each in app.topLevelWidgets() if isinstance(each, ServoWindow)), None)
        for verb, name in map(str.split, os.read(lines, 1024).decode().splitlines()):
            if window is None:
                continue
            if verb == "click":
                hands.mouseClick(getattr(window, name), Qt.MouseButton.LeftButton)
            else:
                hands.keyClick(app.focusWidget() or window, getattr(Qt.Key, f"Key_{name}"))

    notifier = QSocketNotifier(lines, QSocketNotifier.Type.Read)  # type: ignore[arg-type]
    notifier.activated.connect(obey)
    return notifier


def main(arguments: list[str]) -> int:
    """Run the command until it is ended."""
    run_as_others()  # whoever starts it stands for a robot, and has priority
    notifier = None if "--headless" in arguments else obey_in_window()
    with patch.object(servo_robots, "assemble", assembled):
        code = cli.main(["servo", *arguments])
    del notifier  # it must live as long as the window
    return code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
