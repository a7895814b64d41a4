"""Measures photon to command: the age of an image when its command is sent to the robot."""

import argparse
import importlib.util
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass

from typing_extensions import override

from benchmarks._document import markdown
from benchmarks._priority import run_as_others
from benchmarks._results import Goal, Section, Table, machine
from benchmarks.servo._servo_stand import EXPOSURE_US, stand
from benchmarks.servo.servo_guardian import busy
from grabbergui import sources
from grabbergui.core.calibration import Calibration
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.scheduling import run_first, single_threaded
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.servo import closed_loop
from grabbergui.servo.config import Config
from grabbergui.servo.detection import Detector
from grabbergui.servo.loop import ControlCycle
from grabbergui.servo.robots import tiago
from grabbergui.servo.robots.robot import Robot
from grabbergui.servo.robots.teo_yarp import TeoOverYarp
from grabbergui.servo.runner import Runner
from grabbergui.servo.ui.servo_process import servo_in_own_process

Photon = Callable[[Frame], float]
"""Returns the middle of a frame's exposure, seconds of `time.monotonic`."""
Opened = AbstractContextManager[tuple[Robot, FrameGrabber, Photon]]
"""A robot and a camera, closed at the end."""
ELSEWHERE, SAME = "2, other terminals", "2, same terminal"
FPS = 30
PERIOD_MS = 1e3 / FPS
WARM_UP = 60
WINDOW_WARM_UP = 150
"Images at the beginning that do not count, while detectors and window start."
LOADS = 0, 2
TIAGO = bool(importlib.util.find_spec("pinocchio") and importlib.util.find_spec("rclpy"))
"Whether the simulated TIAGo can be run here."
METHOD = f"""The whole loop in real time at {FPS} images per second of 608×512: an image arrives, is
searched, and is answered with a command. Robot and camera run in a process of their own with real-time
priority, as they have their own computers; TEO's camera is a GigE Vision device (Mono8), TIAGo's a ROS 2
topic (RGB8), and commands go over YARP and ROS 2. The servo program has **normal priority**. The time begins
in the true middle of the exposure ({EXPOSURE_US / 1e3:g} ms; TIAGo's {closed_loop.EXPOSURE_US / 1e3:g} ms),
by the simulated camera's own clock, and ends when the command has been given to the robot's connection. It
includes the rest of the exposure and the transport: *image here* is the time until the loop has the image.
It excludes rendering, as a sensor has its image when the exposure ends: rendering begins
{1e3 * closed_loop.DRAWN_AHEAD_S:g} ms before that, for where the robot will be by then. But rendering takes
its CPU time from the same two cores. *face*: there is no marker, and the head follows a face; *marker,
face*: faces are searched although a marker is seen, which the program never does.

In some rows, two other programs compute without a pause. Those from *other terminals* are in scheduling
groups of their own; Linux shares the processor's time between such groups first (autogroup, or a desktop's
control groups). Those from the *same terminal* compete with every thread of the loop."""


@dataclass(frozen=True)
class Case:
    """One row of the table."""

    robot: str
    seen: str
    "Detected objects: `marker`, `face`, or `marker, face`."
    busy: int
    window: bool = False
    elsewhere: bool = True
    "Whether the busy programs were started from other terminals."


@contextmanager
def teo_on_yarp(board: bool) -> Iterator[tuple[Robot, FrameGrabber, Photon]]:
    """Provide the simulated TEO in a process of its own, with GigE Vision images and commands over YARP."""
    with ExitStack() as stack:
        there = stack.enter_context(stand(FPS, board=board))
        robot, camera = TeoOverYarp(NameClient.find(there.name_server)), sources.create(there.camera)
        for part in (robot, camera):
            part.open()
            stack.callback(part.close)
        yield robot, camera, lambda frame: there.zero + 1e-9 * frame.timestamp_ns + 0.5e-6 * EXPOSURE_US


@contextmanager
def over_ros2() -> Iterator[tuple[Robot, FrameGrabber, Photon]]:
    """Provide the simulated TIAGo in a process of its own, with images and commands over rclpy."""
    from grabbergui.servo.robots.tiago_ros2 import TiagoOverRos2

    run_first()  # the simulation inherits it
    simulation = subprocess.Popen(
        [sys.executable, "-m", "grabbergui", "simulate-tiago", "--fps", str(FPS)], stdout=subprocess.PIPE
    )
    run_as_others()
    assert simulation.stdout is not None
    try:
        simulation.stdout.readline()
        with ExitStack() as stack:
            robot, camera = TiagoOverRos2(tiago.model()), sources.create("ros2:/camera")
            for part in (robot, camera):
                part.open()
                stack.callback(part.close)
            # The stamp is the exposure's beginning, on the clock of this computer.
            yield robot, camera, lambda frame: frame.captured + 0.5e-6 * closed_loop.EXPOSURE_US
    finally:
        simulation.terminate()
        simulation.wait(10)
        simulation.stdout.close()


def cases() -> Iterator[Case]:
    """Return the cases that can run here."""
    window = importlib.util.find_spec("PyQt5") is not None
    for load in LOADS:
        for seen in ("marker", "face", "marker, face"):
            yield Case("TEO", seen, load)
        if window:
            yield Case("TEO", "face", load, window=True)
        if TIAGO:
            yield Case("TIAGo", "marker", load)
    for seen in ("marker", "face"):
        yield Case("TEO", seen, LOADS[-1], elsewhere=False)
    if window:
        yield Case("TEO", "face", LOADS[-1], window=True, elsewhere=False)
    if TIAGO:
        yield Case("TIAGo", "marker", LOADS[-1], elsewhere=False)


def opened(case: Case) -> Opened:
    """Return the robot and camera of a case."""
    return over_ros2() if case.robot == "TIAGo" else teo_on_yarp(case.seen != "face")


def measure(arguments: list[str] | None = None) -> Section:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.servo.servo_latency")
    parser.add_argument("--seconds", type=float, default=15.0, help="of each row (15)")
    parser.add_argument("--robot", choices=("TEO", "TIAGo"), help="both by default")
    parser.add_argument("--busy", type=int, choices=LOADS, help="busy programs beside it")
    options = parser.parse_args(arguments)
    single_threaded()
    run_as_others()
    rows = []
    worst = {"none": 0.0, ELSEWHERE: 0.0, SAME: 0.0}
    chosen = [
        case for case in cases() if options.robot in (None, case.robot) and options.busy in (None, case.busy)
    ]
    for case in chosen:
        with opened(case) as (robot, camera, photon), busy(case.busy, elsewhere=case.elsewhere):
            arrivals, latencies = latencies_of(robot, camera, photon, options.seconds, case)
        percentiles = statistics.quantiles(latencies, n=100)
        median, p99 = statistics.median(latencies), percentiles[98]
        beside = "none" if not case.busy else ELSEWHERE if case.elsewhere else SAME
        worst[beside] = max(worst[beside], p99)
        window = "in its window" if case.window else "headless"
        numbers = f"{median:.1f}", f"{percentiles[94]:.1f}", f"{p99:.1f}", f"{max(latencies):.1f}"
        here = f"{statistics.median(arrivals):.1f}"
        rows.append([case.robot, case.seen, window, beside, str(len(latencies)), here, *numbers])
        print(rows[-1], flush=True)
    header = ["robot", "seen", "program", "busy programs", "images", "image here, ms", "median, ms"]
    header += ["95 %", "99 %", "worst"]
    return Section(
        "Servoing, photon to command",
        "python -m benchmarks servo_latency    # four minutes",
        METHOD,
        [Table(header, rows)],
        goals=[
            Goal(
                f"99 % within one frame period ({PERIOD_MS:.0f} ms), busy programs beside it: {beside}",
                f"up to {p99:.1f} ms",
                p99 <= PERIOD_MS,
            )
            for beside, p99 in worst.items()
            if p99
        ],
        machine=machine(),
    )


class TimedRunner(Runner):
    """Records the true age of each image when the loop gets it and when its command is sent, milliseconds."""

    def __init__(self, camera: FrameGrabber, robot: Robot, photon: Photon, case: Case) -> None:
        super().__init__(camera, robot, lambda _: _detector(case))
        self.arrivals: list[float] = []
        self.latencies: list[float] = []
        self._photon = photon
        self.cycle_done.connect(self._on_cycle_done)

    @override
    def _see(self, frame: Frame) -> float | None:
        self.arrivals.append(1e3 * (time.monotonic() - self._photon(frame)))
        return super()._see(frame)

    def _on_cycle_done(self, cycle: ControlCycle, frame: Frame | None) -> None:
        if frame is not None:
            self.latencies.append(1e3 * (time.monotonic() - self._photon(frame)))


def _detector(case: Case) -> Detector:
    made = closed_loop.detector(Config(), closed_loop.calibration(), real_time=True)
    made.faces_with_markers = case.seen == "marker, face"
    return made


def latencies_of(
    robot: Robot, camera: FrameGrabber, photon: Photon, seconds: float, case: Case
) -> tuple[list[float], list[float]]:
    """Return the ages of images when the loop got them and when their commands were sent, milliseconds."""
    runner = TimedRunner(camera, robot, photon, case)
    runner.start()
    if case.window:
        show(runner, seconds)
    else:
        time.sleep(seconds)
    runner.stop()
    first = WINDOW_WARM_UP if case.window else WARM_UP
    return runner.arrivals[first:], runner.latencies[first:]


def show(runner: Runner, seconds: float) -> None:
    """Show the run in its window for some time."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

    def calibration(width: int, height: int) -> Calibration:
        return closed_loop.calibration().scaled_to(width, height)

    servo_in_own_process(runner, calibration, seconds)


if __name__ == "__main__":
    print(markdown(measure()))
