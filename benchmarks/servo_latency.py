"""Photon to command: how old a picture is when what follows from it has been sent to the robot."""

import argparse
import importlib.util
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager

from benchmarks._document import markdown
from benchmarks._results import Goal, Section, Table, machine
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import FrameGrabber
from grabbergui.driver.sim.rendered.scene import Things
from grabbergui.servo import closed_loop
from grabbergui.servo.config import Config
from grabbergui.servo.detection import Detector
from grabbergui.servo.robots import teo, tiago
from grabbergui.servo.robots.robot import KinematicModel, Robot
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.runner import Runner

Opened = AbstractContextManager[tuple[Robot, FrameGrabber]]
"""A robot and a camera, closed at the end."""
FPS = 30
WARM_UP = 30
"Pictures at the beginning that do not count."
METHOD = f"""The whole loop in real time at {FPS} pictures per second of 608×512 RGB, each rendered, searched
for the marker and for heads, and answered by a command. The time begins with the picture's exposure, so that
rendering it is in it."""


@contextmanager
def in_process(model: KinematicModel) -> Iterator[tuple[Robot, FrameGrabber]]:
    """The simulated robot and its camera, without a network."""
    robot = SimRobot(model)
    camera = closed_loop.mounted_camera(robot, closed_loop.things_for(Config().marker, Things()), FPS)
    camera.open()
    try:
        yield robot, camera
    finally:
        camera.close()
        robot.close()


@contextmanager
def over_ros2() -> Iterator[tuple[Robot, FrameGrabber]]:
    """The simulated TIAGo in a process of its own, picture and commands over rclpy."""
    from grabbergui import sources
    from grabbergui.servo.robots.tiago_ros2 import TiagoOverRos2

    simulation = subprocess.Popen(
        [sys.executable, "-m", "grabbergui", "simulate-tiago", "--fps", str(FPS)], stdout=subprocess.PIPE
    )
    assert simulation.stdout is not None
    try:
        simulation.stdout.readline()
        with ExitStack() as stack:
            robot, camera = TiagoOverRos2(tiago.model()), sources.create("ros2:/camera")
            for part in (robot, camera):
                part.open()
                stack.callback(part.close)
            yield robot, camera
    finally:
        simulation.terminate()
        simulation.wait(10)
        simulation.stdout.close()


def chains() -> Iterator[tuple[str, Callable[[], Opened]]]:
    """Those that can be run here, by name."""
    yield "TEO, in one process", lambda: in_process(teo.MODEL)
    if importlib.util.find_spec("pinocchio") is not None:
        yield "TIAGo, in one process", lambda: in_process(tiago.model())
        if importlib.util.find_spec("rclpy") is not None:
            yield "TIAGo over ROS 2, in two processes", over_ros2


def measure(arguments: list[str] | None = None) -> Section:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.servo_latency")
    parser.add_argument("--seconds", type=float, default=15.0)
    options = parser.parse_args(arguments)
    closed_loop.single_threaded()
    rows, medians = [], []
    for name, opened in chains():
        with opened() as (robot, camera):
            latencies = latencies_of(robot, camera, options.seconds)
        medians.append(statistics.median(latencies))
        times = medians[-1], statistics.quantiles(latencies, n=20)[-1], max(latencies)
        rows.append([name, str(len(latencies)), *(f"{each:.1f}" for each in times)])
        print(rows[-1], flush=True)
    return Section(
        "Servoing, photon to command",
        "python -m benchmarks servo_latency",
        METHOD,
        [Table(["robot", "pictures", "median, ms", "95 %, ms", "worst, ms"], rows)],
        goals=[Goal("under 60 ms at 30 fps", f"medians up to {max(medians):.1f} ms", max(medians) < 60)],
        reading=["With real-time priority, as the machine was shared."] if real_time() else [],
        machine=machine(),
    )


def real_time() -> bool:
    return os.sched_getscheduler(0) in (os.SCHED_FIFO, os.SCHED_RR)


def latencies_of(robot: Robot, camera: FrameGrabber, seconds: float) -> list[float]:
    def detector(frame: Frame) -> Detector:
        return closed_loop.detector(Config(), closed_loop.calibration())

    runner = Runner(camera, robot, detector)
    runner.start()
    time.sleep(seconds)
    runner.stop()
    return list(runner.latency_ms)[WARM_UP:]


if __name__ == "__main__":
    print(markdown(measure()))
