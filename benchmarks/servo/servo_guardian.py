"""Measures how far the robot's hand moves on when the servo program is killed or frozen at full speed."""

import argparse
import itertools
import math
import os
import signal
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks._document import markdown
from benchmarks._priority import run_as_others
from benchmarks._results import Goal, Section, Table, machine
from benchmarks.servo._servo_at_full_speed import SPEED
from grabbergui.calibration.geometry import Vector
from grabbergui.core.scheduling import run_first
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.name_server import NameServer
from grabbergui.servo.robots import teo, tiago
from grabbergui.servo.robots.simulated import SimRobot

REPOSITORY = Path(__file__).parents[2]
GOAL_MM = 30.0
FAULTS = {"killed (kill -9)": signal.SIGKILL, "frozen (SIGSTOP)": signal.SIGSTOP}
TRIES = 6
STARTS = 3
"Starts of a program until it may move the robot."
LOADS = 0, 8
BUSY_S = 600
"Seconds after which a busy program ends by itself, even if this process is killed."
PATIENCE = 30.0
"Longest wait in seconds until a program moves the hand, and until the hand rests."
METHOD = f"""A program with the real robot client, gate and guardian, but without a camera, drives the hand
at {SPEED} m/s with a command every 20 ms. The simulated robot runs in another process and obeys its last
command until the next one, as velocity drives do. Its drives follow a command with a time constant of 30 ms,
which alone accounts for {1e3 * SPEED * 0.03:.1f} mm. The program receives the signal at full speed; the
distance is that between the hand's true positions then and at rest. The busy programs compute without a
pause. The guardian takes real-time priority if the machine allows it, as it did here unless noted; robot and
program get it too, as a robot's controllers have a computer of their own."""


class Tireless(SimRobot):
    """A robot that obeys a twist until the next, like a controller without a timeout."""

    COMMAND_TIMEOUT = math.inf


class Program:
    """`_servo_at_full_speed` in a process of its own."""

    def __init__(self, *arguments: str) -> None:
        command = [sys.executable, "-m", "benchmarks.servo._servo_at_full_speed", *arguments]
        self.process = subprocess.Popen(command, cwd=REPOSITORY, stdout=subprocess.PIPE, text=True)
        self.guardian = int(self.said().partition(" ")[2] or 0)

    def said(self) -> str:
        """Return the next line of output; empty at the end."""
        assert self.process.stdout is not None
        return self.process.stdout.readline().strip()

    def close(self) -> None:
        """End the program, and wait for the end of its guardian."""
        for pid in filter(None, (self.process.pid, self.guardian)):
            with suppress(OSError):
                os.kill(pid, signal.SIGCONT)
        self.process.kill()
        self.process.wait()
        assert self.process.stdout is not None
        self.process.stdout.close()
        deadline = time.monotonic() + PATIENCE
        while running(self.guardian):
            if time.monotonic() > deadline:
                raise TimeoutError(f"the guardian {self.guardian} does not end")
            time.sleep(0.02)


def running(pid: int) -> bool:
    """Return whether a process exists and is not a zombie."""
    with suppress(OSError):
        stat = Path(f"/proc/{pid}/stat").read_text("utf-8")
        return stat.rpartition(")")[2].split()[0] not in "ZX"
    return False


@contextmanager
def at_full_speed(robot: SimRobot, *arguments: str) -> Iterator[Program]:
    """Run the program and wait until the hand moves at full speed."""
    program = _moving(arguments)
    try:
        deadline = time.monotonic() + PATIENCE
        while speed(robot) < 0.95 * SPEED:
            if time.monotonic() > deadline:
                raise TimeoutError("the hand does not reach its full speed")
        yield program
    finally:
        program.close()


def _moving(arguments: Sequence[str]) -> Program:
    """Start the program; repeat if, on a busy machine, its guardian answers too late for any motion."""
    for _ in range(STARTS):
        program = Program(*arguments)
        if program.said() == "moving":
            return program
        program.close()
    raise RuntimeError("the program does not move the hand")


def place(robot: SimRobot) -> Vector:
    """Return the position of the hand, metres."""
    return robot.state().hand[:3, 3].copy()


def speed(robot: SimRobot) -> float:
    """Return the speed of the hand, metres per second."""
    before = robot.state()
    time.sleep(0.04)
    after = robot.state()
    return float(np.linalg.norm(after.hand[:3, 3] - before.hand[:3, 3]) / (after.time - before.time))


def moved_after(robot: SimRobot, pid: int, number: int) -> float:
    """Send a signal to a process; return how far the hand moves on until it rests, metres."""
    start = place(robot)
    os.kill(pid, number)
    deadline = time.monotonic() + PATIENCE
    while robot.speed > 1e-4 and time.monotonic() < deadline:
        time.sleep(0.005)
    return float(np.linalg.norm(place(robot) - start))


@contextmanager
def undisturbed() -> Iterator[None]:
    """Raise the priority of this process, which stands for controllers with a computer of their own."""
    run_first()
    try:
        yield
    finally:
        run_as_others()


@contextmanager
def teo_on_yarp() -> Iterator[tuple[SimRobot, list[str]]]:
    """Run the simulated TEO behind its ports; yield the arguments to find it."""
    from grabbergui.servo.robots.teo_ports import TeoPorts

    server = NameServer("127.0.0.1", 0)
    server.open()
    robot = SimRobot(teo.MODEL)
    ports = TeoPorts(robot, NameClient(server.contact))
    try:
        with undisturbed():
            ports.open()
            yield robot, ["teo", f"{server.contact.host}:{server.contact.port}"]
    finally:
        ports.close()
        server.close()


@contextmanager
def tiago_on_ros2(*, stock: bool = False) -> Iterator[tuple[SimRobot, list[str]]]:
    """Run the simulated TIAGo behind its topics, likewise; `stock` takes trajectories for its arm."""
    from grabbergui.servo.robots.tiago_topics import TiagoTopics

    robot = Tireless(tiago.model())
    topics = TiagoTopics(robot, stock=stock)
    try:
        with undisturbed():
            topics.open()
            yield robot, ["tiago"]
    finally:
        topics.close()


@contextmanager
def busy(programs: int, *, elsewhere: bool = False) -> Iterator[None]:
    """Run programs that each keep a core busy.

    With `elsewhere` they have scheduling groups of their own, like programs of other terminals.
    """
    code = f"import time\nend = time.monotonic() + {BUSY_S}\nwhile time.monotonic() < end: pass"
    command = [sys.executable, "-c", code]
    started = [subprocess.Popen(command, start_new_session=elsewhere) for _ in range(programs)]
    try:
        yield
    finally:
        for program in started:
            program.kill()
            program.wait()


COLUMNS = ["robot", "the program is", "busy programs", "runs", "median, mm", "worst, mm"]
ROBOTS: dict[str, Callable[[], AbstractContextManager[tuple[SimRobot, list[str]]]]] = {
    "TEO over YARP": teo_on_yarp,
    "TIAGo over ROS 2": tiago_on_ros2,
    "stock TIAGo (trajectories) over ROS 2": partial(tiago_on_ros2, stock=True),
}


def distances(
    robot: AbstractContextManager[tuple[SimRobot, list[str]]], number: int, tries: int = TRIES
) -> list[float]:
    """Return how far the hand moved on in each try, millimetres."""
    with robot as (simulated, arguments):
        moved = []
        for _ in range(tries):
            with at_full_speed(simulated, *arguments) as program:
                moved.append(1e3 * moved_after(simulated, program.process.pid, number))
    return moved


def measure(arguments: list[str] | None = None) -> Section:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.servo.servo_guardian", description=__doc__)
    parser.add_argument("--tries", type=int, default=TRIES, help=f"of each kind ({TRIES})")
    options = parser.parse_args(arguments)
    rows, worst = [], 0.0
    notes = [f"On this machine {refused}." for refused in [run_first()] if refused]
    run_as_others()
    for load, (robot, simulated), (fault, number) in itertools.product(LOADS, ROBOTS.items(), FAULTS.items()):
        with busy(load):
            moved = distances(simulated(), number, options.tries)
        worst = max(worst, *moved)
        numbers = f"{statistics.median(moved):.1f}", f"{max(moved):.1f}"
        rows.append([robot, fault, str(load), str(len(moved)), *numbers])
    return Section(
        title="A servo program that dies",
        program="python -m benchmarks servo_guardian",
        method=METHOD,
        tables=[Table(COLUMNS, rows)],
        goals=[Goal(f"under {GOAL_MM:g} mm at {SPEED} m/s", f"at most {worst:.1f} mm", worst < GOAL_MM)],
        reading=notes,
        machine=machine(),
    )


if __name__ == "__main__":
    print(markdown(measure()))
