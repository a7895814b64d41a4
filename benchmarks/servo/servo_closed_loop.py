"""Closed loop from random starts in simulated time, with rendered images and their detection.

Errors are against the marker's true pose.
"""

import argparse
import importlib.util
import math
import statistics
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from benchmarks._document import markdown
from benchmarks._results import Goal, Section, Table, machine
from benchmarks._viewpoint import looking_at
from grabbergui.calibration import geometry
from grabbergui.calibration.geometry import Pose, Vector
from grabbergui.core.scheduling import single_threaded
from grabbergui.driver.sim.rendered_scene import Things, swaying
from grabbergui.servo import control
from grabbergui.servo.closed_loop import ClosedLoop, in_base
from grabbergui.servo.config import ArmConfig, HeadConfig
from grabbergui.servo.kinematics import STRETCHED, Chain
from grabbergui.servo.robots import teo, tiago
from grabbergui.servo.robots.robot import KinematicModel
from grabbergui.servo.state_machine import State

Result = dict[str, Any]
"""The result of a start: `reached`, `violations`, `state`, and those of MEASURES that apply."""
METHOD = """Simulated robots in simulated time, with rendered images and their detection, from 50 random
starts each. A person stands somewhere in front of the robot, sways, and shows a marker after two seconds, in
any pose that the arm can reach from its home without being stretched and that a head which looks at the
person has in view. Arm and head begin anywhere near their home. Errors are against the marker's true pose.
The scene has no lens distortion and no motion blur, its marker is perfectly flat, and the simulated joints
follow their commands within 30 ms. A real robot will do worse."""
MEASURES = (
    ("centred_s", "marker shown to centred, s", ".1f"),
    ("reached_s", "marker shown to reached, s", ".1f"),
    ("error_mm", "final error, mm", ".1f"),
    ("error_deg", "final error, degrees", ".2f"),
    ("overshoot_mm", "overshoot, mm", ".1f"),
    ("jitter_mm", "jitter at rest, mm", ".2f"),
)
SHOWN = 2.0
LONGEST = 30.0
REST = 3.0


def random_start(random: np.random.Generator, model: KinematicModel) -> tuple[Pose, Vector]:
    """Return a board and the person who holds it, in the world.

    The arm can reach the goal from its home, neither stretched nor with a joint near its limit, and a head
    that looks at the person sees the board.
    """
    arm, margin = model.arm, 0.15
    low, high = arm.low + margin * (arm.high - arm.low), arm.high - margin * (arm.high - arm.low)
    reach = control.ArmController(ArmConfig(), 0.10)
    before = geometry.inverse(reach.goal(geometry.pose()))
    eye = (model.stands @ model.camera_pose(np.zeros(2)))[:3, 3]
    while True:
        goal = arm.forward(random.uniform(low, high))
        board = model.stands @ goal @ before
        behind = 1.35 * (board[1, 3] - eye[1]) / max(board[0, 3], 0.1) + random.uniform(-0.25, 0.25)
        person = np.array([1.35, behind, random.uniform(0.7, 0.85)])
        looking = looking_at(eye, person - (0, 0, HeadConfig().below))
        sight = board[:3, 3] - eye
        facing = -board[:3, 2] @ sight / np.linalg.norm(sight)
        visible = sight[0] > 0.25 and facing > math.cos(math.radians(45)) and board[2, 1] > 0.6
        if (
            visible
            and in_image(board, looking)
            and math.degrees(abs(math.atan2(sight[1], sight[0]))) < 60
            and reach.inside(goal[:3, 3])
            and can_take(arm, goal, model.home)
        ):
            return board, person


def in_image(board: Pose, camera: Pose) -> bool:
    """Return whether the camera sees the whole board, even if the head does not point at it exactly."""
    half = 0.08
    corners = ([x, y, 0.0, 1.0] for x in (-half, half) for y in (-half, half))
    off = np.degrees([control.off_centre((board @ corner)[:3], camera) for corner in corners])
    return bool((np.abs(off) < (28, 24)).all())


def can_take(arm: Chain, goal: Pose, home: Vector) -> bool:
    """Return whether the arm reaches the goal from its home without being stretched."""
    angles = arm.inverse(goal, home)
    return angles is not None and bool(np.linalg.svd(arm.jacobian(angles))[1][-1] > STRETCHED)


def run(random: np.random.Generator, model: KinematicModel) -> Result:
    """Run one start to its end."""
    board, person = random_start(random, model)
    things = Things(
        face=swaying(*person),
        board=lambda seconds: board if seconds >= SHOWN else None,
    )
    head = np.radians((random.uniform(-50, 50), random.uniform(-20, 5)))
    arm = model.home + np.radians(random.uniform(-12, 12, len(model.home)))
    simulation = ClosedLoop(model, things=things, head=tuple(head), arm=model.arm.clamped(arm))
    simulation.run(LONGEST, State.REACHED)
    reached = simulation.loop.machine.state is State.REACHED
    cycle = simulation.cycles[-1]
    result: Result = {
        "reached": reached,
        "violations": simulation.robot.limit_violations,
        "state": f"{cycle.state.value}: {cycle.reason}, {1e3 * cycle.error[0]:.0f} mm off",
    }
    arrivals = {step.state: step.time for step in reversed(simulation.loop.machine.transitions)}
    if State.APPROACHING in arrivals:
        result["centred_s"] = arrivals[State.APPROACHING] - SHOWN
    if reached:
        result["reached_s"] = simulation.now - SHOWN
        positions = []
        for _ in range(int(REST * simulation.config.loop.rate)):
            simulation.cycle()
            positions.append(simulation.robot.state().hand[:3, 3])
        metres, radians = simulation.true_error()
        result["error_mm"], result["error_deg"] = 1e3 * metres, math.degrees(radians)
        result["jitter_mm"] = 1e3 * float(np.linalg.norm(np.std(positions, axis=0)))
        result["overshoot_mm"] = overshoot(simulation)
    return result


def overshoot(simulation: ClosedLoop) -> float:
    """Return how far the hand moved beyond the goal in its direction, millimetres."""
    board = simulation.things.board(simulation.now)
    assert board is not None
    hands = [cycle.robot.hand[:3, 3] for cycle in simulation.cycles if cycle.robot is not None]
    goal = simulation.loop.arm.goal(in_base(simulation.robot, board))[:3, 3]
    way = goal - hands[0]
    way = way / np.linalg.norm(way)
    return 1e3 * max(0.0, max(float((hand - goal) @ way) for hand in hands))


def bodies(names: Iterable[str]) -> Iterator[KinematicModel]:
    """Return the robots that can be simulated here."""
    for name in names:
        if name == "teo":
            yield teo.MODEL
        elif importlib.util.find_spec("pinocchio") is None:
            print("TIAGo is left out: pip install '.[servo]'")
        else:
            yield tiago.model()


def measure(arguments: list[str] | None = None) -> Section:
    parser = argparse.ArgumentParser(prog="python -m benchmarks servo_closed_loop")
    parser.add_argument("--robot", nargs="+", choices=("teo", "tiago"), default=["teo", "tiago"])
    parser.add_argument("--starts", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(arguments)
    single_threaded()
    found: dict[str, list[Result]] = {}
    for model in bodies(options.robot):
        found[model.name] = results = many(model, options.starts, options.seed)
        print(f"{model.name}: {sum(result['reached'] for result in results)} of {len(results)}", flush=True)
    reached = {name: [result for result in results if result["reached"]] for name, results in found.items()}
    rows = [["reached", *(f"{len(reached[name])} of {len(found[name])}" for name in found)]]
    for key, title, form in MEASURES:
        rows.append([title, *(spread(reached[name], key, form) for name in found)])
    rows.append(["limits violated", *(str(sum(r["violations"] for r in found[name])) for name in found)])
    return Section(
        "Servoing, closed loop",
        "python -m benchmarks servo_closed_loop    # about five minutes on an idle core",
        METHOD,
        [Table(["", *(f"{name}, simulated" for name in found)], rows)],
        goals=goals(found, reached),
        reading=[
            "Each cell has the median and the worst of the starts that reached the marker.",
            "The time to centre begins when the marker is shown, and includes a search for it.",
            f"Jitter is the hand's deviation over {REST:g} s at rest; overshoot is along its path.",
        ],
        machine=machine(),
    )


def goals(found: dict[str, list[Result]], reached: dict[str, list[Result]]) -> list[Goal]:
    """Judge the results by the goals."""
    everyone = [result for results in reached.values() for result in results]
    starts = sum(map(len, found.values()))
    worst = {key: max(result[key] for result in everyone) for key in ("error_mm", "error_deg")}
    violations = sum(result["violations"] for results in found.values() for result in results)
    shares = [len(reached[name]) / len(found[name]) for name in found]
    return [
        Goal("at least 98 % reached", f"{len(everyone)} of {starts}", min(shares) >= 0.98),
        Goal("final error under 10 mm", f"worst {worst['error_mm']:.1f} mm", worst["error_mm"] < 10),
        Goal("final error under 2°", f"worst {worst['error_deg']:.2f}°", worst["error_deg"] < 2),
        Goal("no limit violated", str(violations), violations == 0),
    ]


def many(model: KinematicModel, starts: int, seed: int) -> list[Result]:
    """Run a number of starts and report each failure."""
    random = np.random.default_rng(seed)
    results: list[Result] = []
    for number in range(starts):
        results.append(run(random, model))
        if not results[-1]["reached"]:
            print(f"{model.name}, start {number + 1} was not reached: {results[-1]['state']}", flush=True)
    return results


def spread(results: list[Result], key: str, form: str) -> str:
    """Return median and worst value as text."""
    values = [result[key] for result in results]
    if not values:
        return "–"
    return f"{format(statistics.median(values), form)} … {format(max(values), form)}"


if __name__ == "__main__":
    print(markdown(measure()))
