"""The plan of a hand–eye calibration before it begins, and the events of one that runs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from grabbergui.calibration.geometry import Vector
from grabbergui.servo.config import Config
from grabbergui.servo.robots.robot import KinematicModel

FIRST_VIEWS = 6
"Views from small moves around the first pose, if the model does not give the place of camera or target."
SMALL_DEGREES = 7.0
"Largest joint move for those views."
SPAN_DEGREES = 40.0
"Range of the arm's joints around the first pose."
HEAD_S, ARM_S, REST_S = 1.5, 3.5, 1.0
"Seconds of one move of head or arm at full speed, and of the rest and the detection after it: an estimate."


class Step(Enum):
    """Kinds of events."""

    MOVING = "moving"
    VIEW = "view"
    SKIPPED = "skipped"
    KNOWN = "known"
    COMPUTING = "computing"


class Skip(Enum):
    """Reasons for which a pose was skipped."""

    OBSTRUCTED = "the gate refuses it"
    NOT_REACHED = "it was not reached"
    NOT_SEEN = "the target is not seen surely"
    NOT_AT_REST = "the robot did not come to rest"


@dataclass(frozen=True)
class Progress:
    """State of a run for display."""

    views: int
    wanted: int
    text: str
    "Latest event as display text."
    step: Step
    skip: Skip | None = None
    "Of a skipped pose."
    detail: str = ""
    "The gate's reason for a skipped pose; empty if it has none."
    known: tuple[float, float] | None = None
    "How well the camera is known, standard deviations in metres and radians; None if nothing was computed."


@dataclass(frozen=True)
class Plan:
    """Limits of the motion of a run, for a person to agree to."""

    eye: str
    views: int
    small_moves: int
    "Of the views, those from moves of at most `SMALL_DEGREES` around the first pose; 0 for a head."
    fastest: float
    "Of the head degrees per second, of the hand metres per second."
    low: tuple[float, ...]
    "Pan and tilt in degrees, or the workspace's corner in metres."
    high: tuple[float, ...]
    clearance: float
    "Metres that the arm keeps from the body and obstacles; 0 if they are not known, and for a head."
    seconds: float
    "Estimated duration."


def plan(eye: str, model: KinematicModel, config: Config, views: int) -> Plan:
    """Return the plan of a run."""
    speed = config.loop.speed
    if eye == "head":
        seconds = views * (HEAD_S / speed + REST_S)
        limits = (_degrees(model.head.low), _degrees(model.head.high))
        return Plan(eye, views, 0, speed * config.head.fastest, *limits, 0.0, seconds)
    low, high = config.arm.workspace
    return Plan(
        eye,
        views,
        min(FIRST_VIEWS, views),
        speed * config.arm.fastest,
        tuple(low),
        tuple(high),
        config.safety.clearance if model.body is not None else 0.0,
        views * (ARM_S / speed + REST_S),
    )


def _degrees(radians: Vector) -> tuple[float, ...]:
    return tuple(math.degrees(angle) for angle in radians)
