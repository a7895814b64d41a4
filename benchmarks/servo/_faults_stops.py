"""Measures how far the hand moves on after every way to stop the servo program at full speed.

The program is `_servo_program`. The robot is in this process (`_fallible_robots`), the camera in its own.
"""

from __future__ import annotations

import itertools
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks._faults import Outcome, fault
from benchmarks._faults_outages import end, simulate
from benchmarks.servo._fallible_robots import Stand, teo_on_yarp, tiago_on_ros2
from benchmarks.servo._servo_at_full_speed import SPEED
from grabbergui.calibration import camera_info
from grabbergui.core.calibration import Calibration

CHAPTER = "Every stop of a servo program"
TRIES = 3
PATIENCE = 60.0
"Longest wait in seconds until the hand moves at full speed, and until it rests."
REST_S = 0.7
"Seconds of rest after which the hand counts as stopped."
MIDDLE_M = 0.03
"Metres from the hand's first place within which it is stopped, so that it is far from turning back."
AGAIN_S = 1.0
"Seconds between two requests to resume."
WIDTH, HEIGHT = 320, 240
CAMERA = f"sim:?width={WIDTH}&height={HEIGHT}&fps=30"
CONFIG = f"[arm]\nfastest = {SPEED}\n[head]\nstart = 3\n"
"The program's configuration; with it the head rests, wherever the marker is."
AT_ONCE_MM, SILENT_MM, FROZEN_MM = 15.0, 35.0, 75.0
"Promises: of a stop; of images or readings that cease for 0.15 s; of encoders that stand still for 0.3 s."


ROBOTS: dict[str, tuple[str, Callable[[], AbstractContextManager[Stand]]]] = {
    "teo": ("TEO over YARP", teo_on_yarp),
    "tiago": ("TIAGo over ROS 2", tiago_on_ros2),
    "stock_tiago": ("stock TIAGo (trajectories) over ROS 2", partial(tiago_on_ros2, stock=True)),
}


class Program:
    """`grabbergui servo` in a process of its own, with simulated keyboard and mouse."""

    def __init__(self, options: list[str], camera: str, folder: str) -> None:
        config = Path(folder) / "servo.ini"
        config.write_text(CONFIG, encoding="utf-8")
        self._output = Path(folder) / "output.txt"
        self._hands, terminal = os.openpty()
        command = [sys.executable, "-m", "benchmarks.servo._servo_program", *options]
        calibration = Path(folder) / "camera.yaml"
        camera_info.save(Calibration.from_field_of_view(WIDTH, HEIGHT, 60.0), calibration)
        command += ["--source", f"gige:{camera}", "--calibration", str(calibration), "--config", str(config)]
        home = {f"XDG_{kind}_HOME": folder for kind in ("CACHE", "CONFIG", "DATA", "STATE")}
        with self._output.open("wb") as output:
            self._process = subprocess.Popen(
                command,
                cwd=Path(__file__).parents[2],
                stdin=terminal,
                stdout=output,
                stderr=output,
                env=os.environ | home | {"QT_QPA_PLATFORM": "offscreen"},
            )
        os.close(terminal)

    def do(self, line: str) -> None:
        """Send a line of input; actions in the window are lines, too."""
        os.write(self._hands, f"{line}\n".encode())

    def check(self) -> None:
        """Raise RuntimeError with the program's output if it has ended."""
        if self._process.poll() is not None:
            raise RuntimeError(f"the program ended: {self.said()}")

    def said(self) -> str:
        return self._output.read_text("utf-8", "replace")[-2000:]

    def close(self) -> None:
        self._process.terminate()
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(PATIENCE / 4)
        self._process.kill()
        self._process.wait()
        os.close(self._hands)


@dataclass(frozen=True)
class Scene:
    """A running program with its robot and camera."""

    stand: Stand
    program: Program
    camera: subprocess.Popen[str]

    def repair(self) -> None:
        """Undo all faults of camera and robot."""
        self.camera.send_signal(signal.SIGCONT)
        self.stand.robot.repair()


@dataclass(frozen=True)
class Stop:
    """A way to stop the program."""

    done: str
    most_mm: float
    act: Callable[[Scene], None]
    window: bool = False
    "Whether the program shows its window; otherwise it is headless."
    ends: bool = False
    "Whether the program exits afterwards."


_KEYS = itertools.cycle(("Space", "Escape"))


def _silence(scene: Scene) -> None:
    scene.stand.robot.silent = True


def _repeat_reading(scene: Scene) -> None:
    scene.stand.robot.repeated = scene.stand.robot.state()


STOPS = {
    "button": Stop(
        "the emergency stop is clicked in the window",
        AT_ONCE_MM,
        lambda scene: scene.program.do("click stopButton"),
        window=True,
    ),
    "key": Stop(
        "Space or Escape is pressed in the window",
        AT_ONCE_MM,
        lambda scene: scene.program.do(f"press {next(_KEYS)}"),
        window=True,
    ),
    "window_killed": Stop(
        "the window's process gets SIGKILL",
        SILENT_MM,  # the kernel closes its pipe once it has taken down the rest of it
        lambda scene: scene.program.do("kill"),
        window=True,
        ends=True,
    ),
    "enter": Stop("Enter is pressed in the terminal", AT_ONCE_MM, lambda scene: scene.program.do("")),
    "request": Stop(
        "`stop` is sent over the network (to `/rpc:s`, or to the ROS 2 service)",
        AT_ONCE_MM,
        lambda scene: scene.stand.ask_to_stop(),
    ),
    "image_lost": Stop(
        "images stop (the camera gets SIGSTOP)",
        SILENT_MM,
        lambda scene: scene.camera.send_signal(signal.SIGSTOP),
    ),
    "robot_silent": Stop("the robot stops sending readings", SILENT_MM, _silence),
    "encoders_frozen": Stop("the robot repeats the same readings", FROZEN_MM, _repeat_reading),
}
TRIED: dict[str, tuple[str, ...]] = {
    "teo": tuple(STOPS),
    "tiago": ("button", "request", "image_lost", "robot_silent", "encoders_frozen"),
    "stock_tiago": ("request", "image_lost", "robot_silent", "encoders_frozen"),
}
"Ways to stop that are tried with each robot; the others do not depend on the robot."


def _tried(robot: str, stop: Stop) -> Outcome:
    """Return how far and how long the hand still moves, at worst."""
    name, stand_of = ROBOTS[robot]
    moved = []
    for _ in range(TRIES if stop.ends else 1):
        with scene_of(stand_of(), window=stop.window) as scene:
            go_on = "click startButton" if stop.window else ""  # a headless program begins by itself
            for _ in range(1 if stop.ends else TRIES):
                await_full_speed(scene, go_on)
                moved.append(moved_after(scene, stop.act))
                scene.repair()
                go_on = go_on or "r"
    metres, seconds = (max(values) for values in zip(*moved, strict=True))
    return Outcome(
        f"{name}, the hand at {SPEED} m/s: {stop.done}",
        f"{TRIES} times",
        f"the hand moved on by {1e3 * metres:.1f} mm at most",
        f"{seconds:.2f} s at most: the hand rests",
        1e3 * metres < stop.most_mm,
    )


@contextmanager
def scene_of(opened: AbstractContextManager[Stand], *, window: bool) -> Iterator[Scene]:
    """Run robot, camera and program."""
    with ExitStack() as stack:
        folder = stack.enter_context(tempfile.TemporaryDirectory())
        stand = stack.enter_context(opened)
        camera = simulate(stand.camera, "--camera", CAMERA)
        stack.callback(end, camera)
        program = Program([*stand.options, *(() if window else ("--headless",))], stand.camera, folder)
        stack.callback(program.close)
        yield Scene(stand, program, camera)


def await_full_speed(scene: Scene, go_on: str) -> None:
    """Wait until the hand is at full speed in the middle of its way; call `go_on` while it rests."""
    robot, begun, due = scene.stand.robot, time.monotonic(), 0.0
    middle = robot.model.arm.forward(robot.model.home)[2, 3]
    while True:
        scene.program.check()
        now = time.monotonic()
        if now - begun > PATIENCE:
            raise TimeoutError(f"the hand does not reach its full speed: {scene.program.said()}")
        if go_on and robot.speed < 1e-4 and now >= due:
            scene.program.do(go_on)
            due = now + AGAIN_S
        measured, before = time.monotonic(), robot.place()
        time.sleep(0.04)
        after, seconds = robot.place(), time.monotonic() - measured
        fast = np.linalg.norm(after - before) > 0.95 * SPEED * seconds
        if fast and abs(after[2] - middle) < MIDDLE_M:
            return


def moved_after(scene: Scene, act: Callable[[Scene], None]) -> tuple[float, float]:
    """Call a function; return how far the hand moves on, in metres, and the seconds until it rests."""
    robot = scene.stand.robot
    start, begun = robot.place(), time.monotonic()
    act(scene)
    farthest, moving = 0.0, begun
    while time.monotonic() < moving + REST_S:
        farthest = max(farthest, float(np.linalg.norm(robot.place() - start)))
        if robot.speed > 1e-4:
            moving = time.monotonic()
        if moving > begun + PATIENCE:
            raise TimeoutError(f"the hand does not rest: {scene.program.said()}")
        time.sleep(0.005)
    return farthest, moving - begun


def _put_on_list(robot: str, name: str) -> None:
    def tried() -> Outcome:
        return _tried(robot, STOPS[name])

    tried.__name__ = f"{robot}_stop_{name}"
    fault(CHAPTER)(tried)


for _robot, _names in TRIED.items():
    for _name in _names:
        _put_on_list(_robot, _name)
