"""Runs the servo program against simulated robots with faults, and measures where the hand truly went.

Each trial runs two commands, as anybody can: `grabbergui simulate-teo` or `simulate-tiago` with `--marker`,
`--fault` and `--truth`, and `grabbergui servo` on the same YARP network or in the same ROS domain. The
figures come from the simulator's record of the truth; nothing of the servo program takes part in them. With
`--minutes` and `--json FILE` it can be run in slices: the next run does the trials that are not in the file.
With `--simulated-time` the loop runs in this process, without images, networks and a clock.
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
import os
import random
import re
import signal
import statistics
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks._priority import run_as_others
from benchmarks.servo._forked_commands import Command, Launcher
from grabbergui.calibration.geometry import Pose
from grabbergui.core.scheduling import single_threaded
from grabbergui.driver.sim.rendered_scene import Things, at
from grabbergui.servo import closed_loop
from grabbergui.servo.config import Config
from grabbergui.servo.robots import teo, tiago
from grabbergui.servo.robots.fault_list import FAULTS, Fault
from grabbergui.servo.robots.faults import Faults
from grabbergui.servo.robots.robot import KinematicModel

NAME_SERVER = "127.39.7.1"
WORKSPACE = {"x_low": 0.30, "x_high": 0.70, "y_low": -0.55, "y_high": -0.10}
"Of the approaches, metres: smaller than the default, so that arms want to leave it."
ALLOWED_SPEED = 1.05
"Share of the speed limit that still counts as kept."
STANDOFF = 0.10
"Metres before a marker at which the hand's goal is."
WINDOW_S = 0.05
"Seconds over which a speed is measured."
RESTS = 0.002
"Speed of a hand at rest, m/s."
REST_S = 1.0
"Seconds of rest after which a trial ends."
LATE_REST_S = 4.0
"The same of images that are late: for a second none come, and with those that follow the arm must not move."
SAYS_S = 0.4
"Seconds after the hand came to rest in which the program may say why: the simulated drives take a while."
STUCK_S = 3.6
"The same of an approach: only after 3 s does the program say that it is stuck, and a late image is a pause."
AFTER_FAULT_S = 6.0
"Longest time from a fault to the end of its trial."
APPROACH_S = 16.0
"Longest time of an approach, and until an arm first moves."
DOMAINS = 8
"ROS domains that are used in turn."
MARKERS = {"teo": (0.70, -0.32, 0.36, 4.0, -8.0, 0.0), "tiago": (0.80, -0.17, 0.07, 4.0, -8.0, 0.0)}
"Markers in front of each robot that it reaches: x, y, z, yaw, pitch, roll."
HEIGHTS = {"teo": (0.05, 0.60), "tiago": (-0.25, 0.35)}
"Heights of the random markers above each robot's base, metres."
OF_PIXELS = ("image-repeats", "images-alternate")
"Faults that only pixels show, so that computed detections cannot have them."
MODELS = {"teo": lambda: teo.MODEL, "tiago": tiago.model}


@dataclass(frozen=True)
class Trial:
    """What is tried."""

    robot: str
    marker: tuple[float, ...]
    fault: str = ""
    "`NAME[@SECONDS]`; empty for an approach."

    @property
    def rest(self) -> float:
        """Seconds of rest after which it ends."""
        return LATE_REST_S if self.fault.startswith("images-late") else REST_S


@dataclass
class Outcome:
    """What the hand did. Distances are millimetres, speeds mm/s, times seconds."""

    trial: Trial
    speed: float = 0.0
    "Greatest speed in any window of 50 ms."
    outside: float = 0.0
    "Greatest distance outside the workspace."
    moved: float = 0.0
    "From the beginning of the fault, or of the record: greatest distance from there."
    stopped_after: float | None = None
    "From the beginning of the fault, or of the arm's motion, until the hand rested; None if it did not."
    said_after: float | None = None
    "From there until the program said why the hand rests."
    said: str = ""
    "The last sentence until it rested."
    reached_after: float | None = None
    "From there until the program reported that the marker was reached."
    error: float = math.nan
    "From the hand to its goal in front of the marker, at the end."
    happened: bool = True
    "Whether there was any motion, and the fault."
    load: float = field(default_factory=lambda: os.getloadavg()[0])
    "Of the computer at its end: processes that run or wait."
    lines: list[str] = field(default_factory=list)
    "All that the program said, with seconds from the fault or the beginning."


@dataclass(frozen=True, eq=False)
class Truth:
    """A simulator's record."""

    times: NDArray[np.float64]
    hand: NDArray[np.float64]
    "(n, 3) metres."
    fault: float | None
    "When the fault began; None before."

    @staticmethod
    def read(file: Path) -> Truth:
        """Read as much as was written."""
        rows = [line.split(",") for line in file.read_text("utf-8").splitlines()[1:]]
        rows = [row for row in rows if len(row) > 8]
        begun = next((float(row[0]) for row in rows if row[7]), None)
        numbers = np.array([[float(value) for value in row[:4]] for row in rows]).reshape(-1, 4)
        return Truth(numbers[:, 0], numbers[:, 1:], begun)

    def speeds(self) -> NDArray[np.float64]:
        """Return the mean speed in the window that begins at each time, m/s."""
        if len(self.times) < 2:
            return np.zeros(len(self.times))
        later = np.minimum(self.times + WINDOW_S, self.times[-1])
        ahead = np.stack([np.interp(later, self.times, axis) for axis in self.hand.T], axis=1)
        speeds: NDArray[np.float64] = np.linalg.norm(ahead - self.hand, axis=1) / WINDOW_S
        return speeds

    def moving(self) -> tuple[float, float] | None:
        """Return when the hand began to move and when it came to rest; None if it never moved."""
        steps = np.linalg.norm(np.diff(self.hand, axis=0), axis=1)
        seconds = np.maximum(np.diff(self.times), 1e-4)
        moves = np.flatnonzero(steps / seconds > RESTS)
        return None if not len(moves) else (float(self.times[moves[0]]), float(self.times[moves[-1] + 1]))


def goal_of(marker: Sequence[float]) -> NDArray[np.float64]:
    """Return where the hand is to go, metres in the base."""
    board = at(*marker)
    goal: NDArray[np.float64] = board[:3, 3] + STANDOFF * board[:3, 2]
    return goal


def judge(trial: Trial, truth: Truth, said: Sequence[tuple[float, str]], config: Config) -> Outcome:
    """Return the figures of a trial; `said` has the program's lines with their times."""
    outcome = Outcome(trial)
    low, high = config.arm.workspace
    outcome.speed = 1e3 * float(truth.speeds().max(initial=0.0))
    off = np.maximum(np.maximum(low - truth.hand, truth.hand - high), 0.0)
    outcome.outside = 1e3 * float(np.linalg.norm(off, axis=1).max(initial=0.0))
    moving = truth.moving()
    begun = truth.fault if trial.fault else (moving[0] if moving else None)
    outcome.happened = begun is not None and moving is not None
    if begun is None or moving is None:
        outcome.lines = [text for _, text in said]
        outcome.said = outcome.lines[-1] if said else ""
        return outcome
    outcome.error = 1e3 * float(np.linalg.norm(truth.hand[-1] - goal_of(trial.marker)))
    after = truth.times >= begun - 1e-6
    outcome.moved = 1e3 * float(np.linalg.norm(truth.hand[after] - truth.hand[after][0], axis=1).max())
    if truth.times[-1] - moving[1] > REST_S / 2:
        outcome.stopped_after = max(moving[1] - begun, 0.0)
    outcome.lines = [f"{moment - begun:.2f} {text}" for moment, text in said]
    # What follows from a fault may be reported in the same cycle; a marker is reached only after a while.
    rest = math.inf if outcome.stopped_after is None or not trial.fault else moving[1] + SAYS_S
    for moment, text in said:
        if begun - 0.05 < moment < rest:
            outcome.said, outcome.said_after = text, moment - begun
        if text.startswith("reached:") and moment > begun:
            outcome.reached_after = outcome.reached_after or moment - begun
    return outcome


@dataclass
class Stand:
    """What all trials share."""

    launcher: Launcher
    first: bool
    "Whether programs get real-time priority."
    domain: int = field(default_factory=lambda: random.randrange(1, 90))
    "The first ROS domain."
    _used: Iterator[int] = field(default_factory=lambda: itertools.cycle(range(DOMAINS)))

    def next_domain(self) -> int:
        """Return a ROS domain that was not used recently: programs of earlier trials may still be ending."""
        return self.domain + next(self._used)


@contextmanager
def stage(trial: Trial, stand: Stand, folder: Path, config: Path) -> Iterator[tuple[Command, Path]]:
    """Run simulator and servo program; yield the latter, and the record of the truth."""
    truth = folder / "truth.csv"
    options = ["--marker=" + ",".join(f"{value:g}" for value in trial.marker), "--truth", str(truth)]
    options += ["--fault", trial.fault] if trial.fault else []
    domain = stand.next_domain()
    environment = {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    started = partial(Command, stand.launcher, environment=environment, first=stand.first)
    with ExitStack() as stack:
        if trial.robot == "teo":
            network = ["--with-name-server", "--nameserver", f"{NAME_SERVER}:0"]
            simulator = started(["simulate-teo", *network, *options])
            stack.callback(simulator.end)
            place = simulator.wait_for(r"is on the name server at (\S+)")[1]
            servo = ["--nameserver", place, "--calibration", "resources/servo/teo-sim-camera.yaml"]
        else:
            simulator = started(["simulate-tiago", *options])
            stack.callback(simulator.end)
            simulator.wait_for("TIAGo listens")
            servo = []
        servo = ["servo", "--robot", trial.robot, "--headless", "--no-keyboard", "--seconds", "90", *servo]
        program = started([*servo, "--config", str(config)])
        stack.callback(program.end)
        yield program, truth


STATE = re.compile(r"^ *-?\d+\.\d\d s  ")
"The beginning of a line of the program that reports a state, as opposed to a log."
END = re.compile(STATE.pattern + "(reached|stuck|stopped)")
"The same of a state that ends an approach."
PREFIX = re.compile(STATE.pattern + r"|^\S+ \S+ [A-Z]+ \S+: ")
"What stands before the sentence itself in either."


def run(trial: Trial, config: Config, file: Path, stand: Stand) -> Outcome:
    """Run a trial with the real commands."""
    with (
        tempfile.TemporaryDirectory() as folder,
        stage(trial, stand, Path(folder), file) as (program, record),
    ):
        program.wait_for(STATE.pattern)
        _await_end(trial, program, record)
        truth = Truth.read(record)
        lines = list(program.lines)
    return judge(trial, truth, [(moment, PREFIX.sub("", text)) for moment, text in lines], config)


def _await_end(trial: Trial, program: Command, record: Path) -> None:
    begun = time.monotonic()
    while program.running:
        time.sleep(0.1)
        now, truth = time.monotonic(), Truth.read(record)
        moving = truth.moving()
        if moving is None or (trial.fault and truth.fault is None):
            if now - begun > APPROACH_S:
                return
            continue
        start = truth.fault if trial.fault and truth.fault is not None else moving[0]
        ended = program.said(END.pattern) is not None
        rest = trial.rest if trial.fault or ended else STUCK_S
        if now - max(moving[1], start) > rest or now - start > (AFTER_FAULT_S if trial.fault else APPROACH_S):
            return


def simulate(trial: Trial, config: Config, model: KinematicModel) -> Outcome:
    """Run a trial in simulated time."""
    board = model.stands @ at(*trial.marker)
    faults = Faults([Fault.parse(trial.fault)] if trial.fault else [], reports_hand=trial.robot == "teo")
    head = closed_loop.looking_at(model, at(*trial.marker))
    loop = closed_loop.ClosedLoop(
        model, config, Things(board=lambda _: board), head, rendered=False, faults=faults
    )
    times, hand, said = [], [], [(0.0, "")]
    begun = None
    while loop.now < APPROACH_S + AFTER_FAULT_S:
        cycle = loop.cycle()
        text = f"{cycle.state.value}: {cycle.reason}"
        if cycle.state.value != said[-1][1].partition(":")[0]:
            said.append((cycle.time, text))
        times.append(loop.now)
        hand.append(loop.robot.truth().hand[:3, 3])
        if begun is None and faults.active(loop.now):
            begun = loop.now
        truth = None if len(times) % 25 else Truth(np.array(times), np.array(hand), begun)
        moving = truth.moving() if truth is not None else None
        if moving is not None and (begun is not None or not trial.fault):
            start = begun or moving[0]
            if loop.now - max(moving[1], start) > (trial.rest if trial.fault else STUCK_S) or (
                begun and loop.now - begun > AFTER_FAULT_S
            ):
                break
    return judge(trial, Truth(np.array(times), np.array(hand), begun), said[1:], config)


def visible_marker(source: np.random.Generator, robot: str, model: KinematicModel) -> tuple[float, ...]:
    """Return a random pose of a marker that the camera sees, with a goal inside the workspace."""
    while True:
        place = source.uniform((0.35, -0.65, HEIGHTS[robot][0]), (0.90, 0.15, HEIGHTS[robot][1]))
        turn = source.uniform((-40, -40, -180), (40, 40, 180))
        marker = (
            *(round(float(value), 3) for value in place),
            *(round(float(value), 1) for value in turn),
        )
        board, goal = at(*marker), goal_of(marker)
        low, high = (np.array([WORKSPACE[f"{axis}_{end}"] for axis in "xy"]) for end in ("low", "high"))
        if (low < goal[:2]).all() and (goal[:2] < high).all() and _visible(board, model):
            return marker


def _visible(board: Pose, model: KinematicModel) -> bool:
    camera = model.camera_pose(np.array(closed_loop.looking_at(model, board)))
    return bool(closed_loop.computed_sighting(camera, board, Config().marker, 0.0).markers)


def trials(options: argparse.Namespace, models: Mapping[str, KinematicModel]) -> list[Trial]:
    """Return all trials in such an order that whoever ends the benchmark early has some of each kind."""
    ordered: list[tuple[float, Trial]] = []

    def add(kind: Sequence[Trial]) -> None:
        ordered.extend(((number + 0.5) / len(kind), trial) for number, trial in enumerate(kind))

    for robot, model in models.items():
        source = np.random.default_rng(options.seed)
        add([Trial(robot, visible_marker(source, robot, model)) for _ in range(options.approaches)])
        add([Trial(robot, MARKERS[robot])] * options.near)
        all_faults = [name for name in FAULTS if name not in OF_PIXELS or not options.simulated_time]
        for name in all_faults if options.fault is None else options.fault:
            # Of their own, so that more trials are the same ones and others.
            source = np.random.default_rng([options.seed, *name.encode()])
            begin = ["" if "@" in name else f"@{source.uniform(0.2, 1.0):.2f}" for _ in range(options.each)]
            add([Trial(robot, MARKERS[robot], f"{name}{after}") for after in begin])
    return [trial for _, trial in sorted(ordered, key=lambda entry: entry[0])]


def remaining(wanted: Sequence[Trial], outcomes: Sequence[Outcome]) -> list[Trial]:
    """Return the trials that have no outcome yet."""
    had, left = Counter(outcome.trial for outcome in outcomes), []
    for trial in wanted:
        if had[trial] > 0:
            had[trial] -= 1
        else:
            left.append(trial)
    return left


def stored(file: Path) -> list[Outcome]:
    """Return the outcomes in a file; none if there is no such file. Raises SystemExit for another one."""
    try:
        entries = json.loads(file.read_text("utf-8")) if file.exists() else []
        return [
            Outcome(
                **{**entry, "trial": Trial(**{**entry["trial"], "marker": tuple(entry["trial"]["marker"])})}
            )
            for entry in entries
        ]
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise SystemExit(f"{file} has no trials of this benchmark ({error!r}); name another file") from error


def summary(outcomes: Sequence[Outcome], config: Config) -> list[list[str]]:
    """Return a row for the approaches, and for each fault its worst figures."""
    groups: dict[tuple[str, str], list[Outcome]] = {}
    for outcome in outcomes:
        near = outcome.trial.marker == MARKERS[outcome.trial.robot]
        name = outcome.trial.fault.partition("@")[0] or ("near marker" if near else "random marker")
        groups.setdefault((outcome.trial.robot, name), []).append(outcome)
    rows = []
    for (robot, name), group in groups.items():
        happened = [outcome for outcome in group if outcome.happened]
        rows.append([robot, name, f"{len(happened)} of {len(group)}"])
        if not happened:
            continue
        stops = [outcome.stopped_after for outcome in happened]
        limit = 1e3 * max(config.arm.fastest, config.arm.follow) * ALLOWED_SPEED
        rows[-1] += [
            f"{max(outcome.moved for outcome in happened):.0f}",
            "moves on" if None in stops else f"{max(filter(None, stops), default=0.0):.2f}",
            f"{max(outcome.speed for outcome in happened):.0f}",
            str(sum(outcome.speed > limit for outcome in happened)),
            f"{max(outcome.outside for outcome in happened):.0f}",
            str(sum(outcome.outside > 1 for outcome in happened)),
            _reached(happened),
            _most_said(happened),
        ]
    return rows


def for_the_manual(outcomes: Sequence[Outcome]) -> str:
    """Return the table of faults, and a sentence on the approaches of each robot, as in docs/servoing.md."""
    lines = ["| fault | what happens | TEO over YARP | TIAGo over ROS 2 |", "|---|---|---|---|"]
    happened = [outcome for outcome in outcomes if outcome.happened]
    for name, what in FAULTS.items():
        cells = []
        for robot in MODELS:
            group = [
                one for one in happened if one.trial.robot == robot and one.trial.fault.split("@")[0] == name
            ]
            stops = [math.inf if one.stopped_after is None else one.stopped_after for one in group]
            worst = f"{max(one.moved for one in group):.0f} mm, {max(stops):.1f} s" if group else "not tried"
            cells.append(f"{worst} ({len(group)})")
        lines.append(f"| `{name}` | {what} | {' | '.join(cells)} |")
    for robot in MODELS:
        for name, near in (("the near marker", True), ("random markers", False)):
            group = [one for one in happened if one.trial.robot == robot and not one.trial.fault]
            group = [one for one in group if (one.trial.marker == MARKERS[robot]) is near]
            if not group:
                continue
            lines.append(
                f"\n{robot}, {len(group)} approaches to {name}: reached {_reached(group)} at most; at most "
                f"{max(one.speed for one in group):.1f} mm/s and "
                f"{max(one.outside for one in group):.1f} mm outside"
            )
    return "\n".join(lines)


HEADER = [
    *("robot", "trial", "happened", "moved on, mm", "rests after, s", "fastest, mm/s", "too fast"),
    *("outside, mm", "outside", "reached", "said most often"),
]


def _reached(outcomes: Sequence[Outcome]) -> str:
    reached = [outcome for outcome in outcomes if outcome.reached_after is not None]
    if not reached:
        return "0"
    seconds = statistics.median(outcome.reached_after or 0.0 for outcome in reached)
    return f"{len(reached)} in {seconds:.1f} s, {max(outcome.error for outcome in reached):.1f} mm off"


def _most_said(outcomes: Sequence[Outcome]) -> str:
    said = [re.sub(r"\d+(\.\d+)?", "…", outcome.said) for outcome in outcomes]
    most = max(set(said), key=said.count)
    times = [o.said_after for o, text in zip(outcomes, said, strict=True) if text == most and o.said_after]
    return f"{most} ({said.count(most)}; after {max(times, default=math.nan):.2f} s at most)"


def printed(rows: Sequence[Sequence[str]]) -> str:
    """Return a table of Markdown."""
    lines = [HEADER, ["---"] * len(HEADER), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def main(arguments: list[str] | None = None) -> None:
    """Run the trials and print their table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks servo_faults", description=__doc__)
    parser.add_argument("--robot", nargs="+", choices=tuple(MODELS), default=list(MODELS))
    parser.add_argument("--approaches", type=int, default=3, help="of each robot, to random markers (3)")
    parser.add_argument("--near", type=int, default=1, help="approaches to a marker in easy reach (1)")
    parser.add_argument("--each", type=int, default=1, help="trials of each fault (1)")
    parser.add_argument("--fault", nargs="*", metavar="NAME[@SECONDS]", help="only these faults (all)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--simulated-time", action="store_true", help="in this process, without a clock")
    parser.add_argument(
        "--first", action="store_true", help="programs get real-time priority (busy machines)"
    )
    parser.add_argument(
        "--side-by-side",
        type=int,
        default=1,
        metavar="N",
        help="trials at once, on a machine with cores for them (1)",
    )
    parser.add_argument("--minutes", type=float, default=60.0, help="begin no further trial after this (60)")
    parser.add_argument(
        "--json",
        type=Path,
        metavar="FILE",
        help="store every trial, and continue after those that are stored there",
    )
    options = parser.parse_args(arguments)
    for name in options.fault or ():
        Fault.parse(name)
    # A benchmark that is ended must end its programs.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("ended"))
    run_as_others()
    single_threaded()
    default, outcomes = Config(), [] if options.json is None else stored(options.json)
    models = {robot: MODELS[robot]() for robot in options.robot}
    left = remaining(trials(options, models), outcomes)
    end = time.monotonic() + 60 * options.minutes
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        small = Path(folder) / "servo.ini"
        small.write_text(
            "[arm]\n" + "".join(f"{key} {value:g}\n" for key, value in WORKSPACE.items()), "utf-8"
        )
        whole = Path(folder) / "default.ini"
        whole.write_text("", "utf-8")
        confined = Config.load(small)
        stand = None if options.simulated_time else Stand(Launcher(), options.first)
        if stand is not None:
            stack.callback(stand.launcher.close)
        waiting, lock = iter(left), threading.Lock()

        def try_all() -> None:
            while time.monotonic() < end:
                with lock:
                    trial = next(waiting, None)
                if trial is None:
                    return
                easy = trial.marker == MARKERS[trial.robot]
                config, file = (default, whole) if easy else (confined, small)
                began = time.monotonic()
                try:
                    if stand is None:
                        outcome = simulate(trial, config, models[trial.robot])
                    else:
                        outcome = run(trial, config, file, stand)
                except RuntimeError as error:
                    print(f"{trial}: {error}", flush=True)
                    continue
                with lock:
                    outcomes.append(outcome)
                    print(f"{_line(outcome)} ({time.monotonic() - began:.1f} s)", flush=True)
                    if options.json is not None:
                        _store(outcomes, options.json)

        with ThreadPoolExecutor() as side_by_side:
            works = [side_by_side.submit(try_all) for _ in range(options.side_by_side if stand else 1)]
            try:
                for work in works:
                    work.result()
            finally:
                waiting = iter(())  # who ends it waits for the present trials only
    if missing := len(remaining(left, outcomes)):
        print(f"{missing} trials are left")
    outcomes.sort(key=lambda outcome: outcome.trial.robot)
    print(printed(summary(outcomes, default)))
    print(f"\n{for_the_manual(outcomes)}")
    loads = [outcome.load for outcome in outcomes]
    print(
        f"\n{len(outcomes)} trials, load average {min(loads, default=0):.1f} to {max(loads, default=0):.1f}"
    )


def _store(outcomes: Sequence[Outcome], file: Path) -> None:
    """Write the outcomes, so that whoever ends the benchmark meanwhile keeps those before."""
    text = json.dumps([asdict(one) for one in outcomes], indent=1, ensure_ascii=False)
    new = file.with_suffix(".new")
    new.write_text(text + "\n", "utf-8")
    new.replace(file)


def _line(outcome: Outcome) -> str:
    trial = outcome.trial
    what = trial.fault or "marker " + ",".join(f"{value:g}" for value in trial.marker)
    rests = "moves on" if outcome.stopped_after is None else f"rests after {outcome.stopped_after:.2f} s"
    if not outcome.happened:
        rests = "did not happen"
    return (
        f"{trial.robot} {what}: {outcome.moved:.0f} mm, {rests}, {outcome.speed:.0f} mm/s, "
        f"{outcome.outside:.0f} mm outside, load {outcome.load:.0f}; {outcome.said}"
    )


if __name__ == "__main__":
    main()
