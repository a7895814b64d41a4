"""A robot that obeys at once and remembers every command, with faults on demand."""

import numpy as np

from grabbergui.calibration import geometry
from grabbergui.calibration.marker_pose import MarkerDetection
from grabbergui.core.errors import TransportError
from grabbergui.servo.detection import FaceDetection, Sighting
from grabbergui.servo.robots import teo
from grabbergui.servo.robots.robot import Robot, RobotState


class RecordingRobot(Robot):
    """Joints follow commands at once when `advance` is called."""

    def __init__(self, *, floating=False):
        """A `floating` hand obeys without an arm, whose angles are not known then."""
        super().__init__(teo.MODEL, "recording robot")
        self._floating = teo.RIGHT_ARM.forward(teo.HOME) if floating else None
        self.head = np.zeros(2)
        self.arm = teo.HOME.copy()
        self.velocity, self.twist = np.zeros(2), np.zeros(6)
        self.moves, self.stops = [], 0
        self.time = 0.0
        self.frozen = self.silent = self.deaf = False

    def open(self):
        pass

    def close(self):
        self.stop()

    def state(self):
        arm = None if self._floating is not None else self.arm.copy()
        return None if self.silent else RobotState(self.time, self.head.copy(), self.hand, arm)

    @property
    def hand(self):
        return teo.RIGHT_ARM.forward(self.arm) if self._floating is None else self._floating

    def move_head(self, velocity):
        self._hear(("head", velocity))
        self.velocity = velocity

    def step_head(self, move):
        self._hear(("step", move))
        if not self.frozen:
            self.head = teo.HEAD.clamped(self.head + move)

    def move_hand(self, twist):
        self._hear(("hand", twist))
        self.twist = twist

    def stop(self):
        self.stops += 1
        if not self.deaf:
            self.velocity, self.twist = np.zeros(2), np.zeros(6)
        return not self.deaf

    def advance(self, now, seconds):
        if not self.frozen:
            self.head = teo.HEAD.clamped(self.head + self.velocity * seconds)
            if self._floating is not None:
                self._floating = geometry.add_delta(self._floating, self.twist * seconds)
            self.arm = self.arm + teo.RIGHT_ARM.velocities_for(self.arm, self.twist) * seconds
        if not self.silent:
            self.time = now

    @property
    def moving(self):
        return bool(self.velocity.any() or self.twist.any())

    def _hear(self, command):
        if self.deaf:
            raise TransportError("the robot's port is gone")
        if np.any(command[1]):
            self.moves.append(command)


SQUARE = np.array([[0.0, 0], [60, 0], [60, 60], [0, 60]])


def marker(pose, problem="", marker_id=20):
    return MarkerDetection(marker_id, SQUARE, pose, problem)


def seeing(robot, time, board=None, face=None):
    """A sighting of a board (pose) and a face (point) that are in the room, by a perfect camera."""
    view = geometry.inverse(robot.camera_pose(robot.head))
    heads = ()
    if face is not None:
        heads = (FaceDetection((0, 0, 50, 50), tuple((view @ (*face, 1.0))[:3])),)
    return Sighting(time, (marker(view @ board),) if board is not None else (), heads)
