"""Closed loop over random starts, in simulated time, through rendered pictures and their detection.

    python -m benchmarks servo_closed_loop [--starts N] [--seed N]

Each start: a marker somewhere in the arm's reach where the head can see it, shown after two seconds by a
person who sways behind it; the arm and the head anywhere near their home. Errors are against the
marker's true pose.
"""

import argparse
import math
import statistics
import time

import numpy as np

from grabbergui.driver.sim.rendered.scene import Things, swaying
from grabbergui.servo import control, geometry
from grabbergui.servo.desk import Desk, single_threaded
from grabbergui.servo.robots.robot import teo
from grabbergui.servo.state_machine import State

SHOWN = 2.0
LONGEST = 30.0
REST = 3.0


def random_board(random):
    """A pose of the marker whose goal the arm can take from its home, its joints off their limits."""
    arm, margin = teo.RIGHT_ARM, 0.15
    low, high = arm.low + margin * (arm.high - arm.low), arm.high - margin * (arm.high - arm.low)
    before = geometry.inverse(geometry.pose(control.HAND_ON_MARKER, (0, 0, 0.10)))
    eye = teo.HEAD.forward([0, 0])[:3, 3]
    while True:
        board = arm.forward(random.uniform(low, high)) @ before
        sight = board[:3, 3] - eye
        distance = float(np.linalg.norm(sight))
        down = math.degrees(math.asin(-sight[2] / distance))
        facing = math.degrees(math.acos(float(np.clip(-board[:3, 2] @ sight / distance, -1, 1))))
        aside = abs(math.degrees(math.atan2(sight[1], sight[0])))
        goal = board @ geometry.pose(control.HAND_ON_MARKER, (0, 0, 0.10))
        visible = down < 33 and aside < 60 and facing < 45 and board[2, 1] > 0.6
        if board[0, 3] > 0.35 and visible and arm.inverse(goal, teo.HOME) is not None:
            return board


def run(random):
    board = random_board(random)
    behind = 1.35 * board[1, 3] / board[0, 3]
    things = Things(
        face=swaying(1.35, behind + float(random.uniform(-0.25, 0.25)), float(random.uniform(0.7, 0.85))),
        board=lambda seconds: board if seconds >= SHOWN else None,
    )
    head = np.radians((random.uniform(-50, 50), random.uniform(-20, 5)))
    arm = np.radians(np.degrees(teo.HOME) + random.uniform(-12, 12, 6))
    desk = Desk(things=things, head=tuple(head), arm=teo.RIGHT_ARM.clamped(arm))
    desk.run(LONGEST, State.REACHED)
    reached = desk.loop.machine.state is State.REACHED
    turn = desk.turns[-1]
    result = {
        "reached": reached,
        "violations": desk.robot.limit_violations,
        "state": f"{turn.state.value}, {1e3 * turn.error[0]:.0f} mm off; {desk.loop.marker.problem}",
    }
    arrivals = {step.state: step.time for step in reversed(desk.loop.machine.transitions)}
    if State.APPROACHING in arrivals:
        result["centred_s"] = arrivals[State.APPROACHING] - SHOWN
    if reached:
        result["reached_s"] = desk.now - SHOWN
        positions = []
        for _ in range(int(REST * desk.config.loop.rate)):
            desk.turn()
            positions.append(desk.robot.state().hand[:3, 3])
        metres, radians = desk.true_error()
        result["error_mm"], result["error_deg"] = 1e3 * metres, math.degrees(radians)
        result["jitter_mm"] = 1e3 * float(np.linalg.norm(np.std(positions, axis=0)))
        result["overshoot_mm"] = overshoot(desk)
    return result


def overshoot(desk):
    """How far beyond the goal the hand went along its way, mm."""
    hands = [turn.robot.hand[:3, 3] for turn in desk.turns]
    goal = desk.loop.arm.goal(desk.things.board(desk.now))[:3, 3]
    way = goal - hands[0]
    way = way / np.linalg.norm(way)
    return 1e3 * max(0.0, max(float((hand - goal) @ way) for hand in hands))


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python -m benchmarks servo_closed_loop")
    parser.add_argument("--starts", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(arguments)
    starts, seed = options.starts, options.seed
    single_threaded()
    random, results, began = np.random.default_rng(seed), [], time.monotonic()
    for _ in range(starts):
        results.append(run(random))
        if not results[-1]["reached"]:
            print(f"start {len(results)} was not reached: {results[-1]['state']}")
    good = [result for result in results if result["reached"]]
    seconds = time.monotonic() - began
    print(f"TEO, simulated: {len(good)} of {starts} reached, seed {seed}, {seconds:.0f} s of work")
    for key, title in (
        ("centred_s", "marker shown to centred (s)"),
        ("reached_s", "marker shown to reached (s)"),
        ("error_mm", "final error (mm)"),
        ("error_deg", "final error (degrees)"),
        ("overshoot_mm", "overshoot (mm)"),
        ("jitter_mm", "jitter at rest (mm)"),
    ):
        values = sorted(result[key] for result in good)
        if values:
            print(f"{title:32} median {statistics.median(values):7.3f}   worst {values[-1]:7.3f}")
    print(f"limits violated: {sum(result['violations'] for result in results)}")


if __name__ == "__main__":
    main()
