"""Faults of the servo program: it is killed or frozen while the hand moves at full speed."""

from __future__ import annotations

import signal
import time

from benchmarks._faults import Outcome, fault
from benchmarks.servo._servo_at_full_speed import SPEED
from benchmarks.servo.servo_guardian import GOAL_MM, ROBOTS, at_full_speed, moved_after

CHAPTER = "A servo program that dies"
TRIES = 5


@fault(CHAPTER)
def teo_servo_killed() -> Outcome:
    return _stopped("TEO over YARP", signal.SIGKILL)


@fault(CHAPTER)
def teo_servo_frozen() -> Outcome:
    return _stopped("TEO over YARP", signal.SIGSTOP)


@fault(CHAPTER)
def tiago_servo_killed() -> Outcome:
    return _stopped("TIAGo over ROS 2", signal.SIGKILL)


@fault(CHAPTER)
def tiago_servo_frozen() -> Outcome:
    return _stopped("TIAGo over ROS 2", signal.SIGSTOP)


@fault(CHAPTER)
def stock_tiago_servo_killed() -> Outcome:
    return _stopped("stock TIAGo (trajectories) over ROS 2", signal.SIGKILL)


@fault(CHAPTER)
def stock_tiago_servo_frozen() -> Outcome:
    return _stopped("stock TIAGo (trajectories) over ROS 2", signal.SIGSTOP)


def _stopped(robot: str, number: signal.Signals) -> Outcome:
    """Return how far and how long the hand still moves, at worst."""
    millimetres, seconds = [], []
    with ROBOTS[robot]() as (simulated, arguments):
        for _ in range(TRIES):
            with at_full_speed(simulated, *arguments) as program:
                begun = time.monotonic()
                millimetres.append(1e3 * moved_after(simulated, program.process.pid, number))
                seconds.append(time.monotonic() - begun)
    return Outcome(
        f"the servo program of {robot} gets {number.name} while the hand moves at {SPEED} m/s",
        f"{TRIES} times",
        f"the hand moved on by {max(millimetres):.1f} mm at most",
        f"{max(seconds):.2f} s at most: the hand rests",
        max(millimetres) < GOAL_MM,
    )
