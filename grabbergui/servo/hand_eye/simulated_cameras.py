"""Cameras of a simulated robot, for a hand–eye calibration of each of its places."""

from __future__ import annotations

from grabbergui.core.grabber import FrameGrabber
from grabbergui.servo import closed_loop
from grabbergui.servo.config import MarkerConfig
from grabbergui.servo.robots.simulated import SimRobot


class SimulatedCameras:
    """Puts the camera of a simulated robot where the eye is to be, with the target before it."""

    def __init__(self, robot: SimRobot) -> None:
        self._robot = robot
        self._grabber: FrameGrabber | None = None

    def __call__(self, eye: str, marker: MarkerConfig) -> FrameGrabber:
        """Return the open camera; the one before is closed."""
        self.close()
        self._grabber = closed_loop.hand_eye_camera(self._robot, marker, eye, in_view=True)
        self._grabber.open()
        return self._grabber

    def close(self) -> None:
        """Close the camera. May be called twice."""
        grabber, self._grabber = self._grabber, None
        if grabber is not None:
            grabber.close()
