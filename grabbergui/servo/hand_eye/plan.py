"""The plan of a hand–eye calibration: how the robot will move, and for how long."""

from __future__ import annotations

import math
from dataclasses import dataclass

from grabbergui.calibration.geometry import Vector
from grabbergui.servo.config import Config
from grabbergui.servo.hand_eye.run import FIRST_VIEWS
from grabbergui.servo.robots.robot import KinematicModel

_HEAD_MOVE_S, _ARM_MOVE_S, _REST_S = 1.5, 3.5, 1.0
"Seconds of one move of head or arm at full speed, and of the rest and the detection after it: an estimate."


@dataclass(frozen=True)
class RunPlan:
    """Limits of the motion of a run, for a person to agree to."""

    eye: str
    views: int
    small_moves: int
    "Views from moves of at most `SMALL_DEGREES` around the first pose; 0 for a head."
    fastest: float
    "Highest speed: of a head in degrees per second, of a hand in metres per second."
    low: tuple[float, ...]
    "Pan and tilt in degrees, or the workspace's corner in metres."
    high: tuple[float, ...]
    clearance: float
    "Metres that the arm keeps from the body and obstacles; 0 if they are not known, and for a head."
    seconds: float
    "Estimated duration."


def plan(eye: str, model: KinematicModel, config: Config, views: int) -> RunPlan:
    """Return the plan of a run."""
    speed = config.loop.speed
    if eye == "head":
        seconds = views * (_HEAD_MOVE_S / speed + _REST_S)
        limits = (_degrees(model.head.low), _degrees(model.head.high))
        return RunPlan(eye, views, 0, speed * config.head.fastest, *limits, 0.0, seconds)
    low, high = config.arm.workspace
    return RunPlan(
        eye,
        views,
        min(FIRST_VIEWS, views),
        speed * config.arm.fastest,
        tuple(low),
        tuple(high),
        config.safety.clearance if model.body is not None else 0.0,
        views * (_ARM_MOVE_S / speed + _REST_S),
    )


def _degrees(radians: Vector) -> tuple[float, ...]:
    return tuple(math.degrees(angle) for angle in radians)
