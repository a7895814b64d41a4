"""The servoing window as a process: killed, or left alone by a loop that was killed."""

import contextlib
import os
import signal
import subprocess
import sys
import threading

import psutil
import pytest

from grabbergui.calibration import camera_info
from grabbergui.calibration.calibration_choice import CalibrationChoice
from grabbergui.core.calibration import Calibration
from grabbergui.servo import closed_loop
from grabbergui.servo.config import Config
from grabbergui.servo.hand_eye.stand import HandEyeStand
from grabbergui.servo.models.servo_proxy import CLOSED
from grabbergui.servo.robots import teo
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.runner import HELD, Runner
from grabbergui.servo.ui import servo_process
from grabbergui.servo.ui.servo_process import servo_in_own_process
from grabbergui.ui.theme import Theme
from patience import PATIENCE, PROGRAM, until

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="kills processes by signals")


def windows(of):
    """Process ids of the windows that a process has started."""
    found = []
    for child in psutil.Process(of).children():
        with contextlib.suppress(psutil.ZombieProcess):  # another test's, that has just ended
            if any("servo_process" in word for word in child.cmdline()):
                found.append(child.pid)
    return found


def await_window(of):
    return until(lambda: windows(of), "a window")[0]


@pytest.fixture
def shown(monkeypatch):
    """A run with its window: the runner, an event that ends it, and a function that awaits the outcome."""
    monkeypatch.setenv("QT_QPA_PLATFORM", "offscreen")
    robot = SimRobot(teo.MODEL)
    camera = closed_loop.mounted_camera(robot, closed_loop.things_for(Config().marker), fps=10)
    camera.open()
    calibration = closed_loop.calibration()
    runner = Runner(camera, robot, lambda frame: closed_loop.detector(Config(), calibration))
    runner.start()
    stop, failures = threading.Event(), []

    def show():
        failures.append(servo_in_own_process(runner, calibration.scaled_to, None, stop=stop))

    def outcome():
        showing.join(PATIENCE)
        (failure,) = failures
        return failure

    showing = threading.Thread(target=show)
    showing.start()
    yield runner, stop, outcome
    stop.set()
    showing.join(PATIENCE)
    runner.stop()
    camera.close()


def test_a_window_that_is_killed_stops_the_robot_and_says_so(shown):
    runner, _, outcome = shown
    os.kill(await_window(os.getpid()), signal.SIGKILL)
    assert outcome() == f"the window has ended unexpectedly (exit status {-signal.SIGKILL})"
    assert runner.gate.halted == CLOSED


def test_a_window_that_hangs_when_the_program_is_to_end_is_no_failure(shown, monkeypatch):
    """On a busy machine the program killed its window, and said that it had ended unexpectedly."""
    runner, stop, outcome = shown
    monkeypatch.setattr(servo_process, "_END_S", 0.2)
    os.kill(await_window(os.getpid()), signal.SIGSTOP)
    stop.set()
    assert outcome() == ""
    assert runner.gate.halted == "interrupted"


def test_a_window_that_is_still_starting_holds_up_nobody(monkeypatch):
    """On a busy machine the program waited five seconds for it, and complained of it."""
    monkeypatch.setattr(servo_process, "WINDOW_PROGRAM", ["-c", "import time; time.sleep(3600)"])
    monkeypatch.setattr(servo_process, "_END_S", 3600)
    runner, stop = Runner(Dark(), SimRobot(teo.MODEL), lambda frame: None), threading.Event()
    stop.set()
    options = servo_process._Options(None, None, Theme.AUTO, False)
    assert servo_process._show_once(runner, closed_loop.calibration().scaled_to, options, stop) == ("", False)
    assert runner.gate.halted == "interrupted"


WIZARD = """
import threading
from grabbergui.servo import closed_loop
from grabbergui.servo.config import Config
from grabbergui.servo.gate import CommandGate
from grabbergui.servo.hand_eye.simulated_cameras import SimulatedCameras
from grabbergui.servo.hand_eye.stand import HandEyeStand
from grabbergui.servo.robots import teo
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.ui import windows

robot, stop = SimRobot(teo.MODEL), threading.Event()
calibration = closed_loop.calibration().scaled_to
cameras = SimulatedCameras(robot)
stand = HandEyeStand(robot, CommandGate(robot, Config()), Config(), cameras, calibration, lambda eye: None)
threading.Timer(1, stop.set).start()
for _ in range(2):
    print(windows.hand_eye(stand, stop=stop), flush=True)
cameras.close()
"""


def test_the_hand_eye_wizard_opens_in_a_process_without_a_window_so_far():
    """`hand-eye --window`, and Hand–eye… in the servoing window, aborted: there was no application."""
    environment = os.environ | {"QT_QPA_PLATFORM": "offscreen"}
    program = [sys.executable, "-c", WIZARD]
    run = subprocess.run(program, env=environment, capture_output=True, text=True, timeout=PROGRAM)
    assert (run.returncode, run.stdout.split()) == (0, ["None", "None"]), run.stderr


@pytest.mark.parametrize("assumed", [False, True], ids=["own process", "this process"])
def test_hand_and_eye_are_calibrated_between_two_windows(assumed, monkeypatch):
    monkeypatch.setenv("QT_QPA_PLATFORM", "offscreen")
    robot, happened = SimRobot(teo.MODEL), []
    camera = closed_loop.mounted_camera(robot, closed_loop.things_for(Config().marker), fps=10)
    camera.open()
    runner = Runner(camera, robot, lambda frame: closed_loop.detector(Config(), closed_loop.calibration()))
    calibration = CalibrationChoice.nominal(60) if assumed else closed_loop.calibration().scaled_to
    stand = HandEyeStand(robot, runner.gate, Config(), None, calibration, None)
    wanted = iter([True, False])

    def window(*arguments, **options):
        happened.append(("window", runner.running, runner.gate.halted))
        return next(wanted) if assumed else ("", next(wanted))

    monkeypatch.setattr(servo_process, "servo" if assumed else "_show_once", window)
    monkeypatch.setattr(
        servo_process, "hand_eye", lambda *_, **__: happened.append(("wizard", runner.running))
    )
    runner.start()
    try:
        assert servo_in_own_process(runner, calibration, None, stand=stand) == ""
        assert happened == [("window", True, ""), ("wizard", False), ("window", True, HELD)]
    finally:
        runner.stop()
        camera.close()


def test_a_window_that_is_closed_for_the_calibration_says_so(monkeypatch):
    program = (
        "from grabbergui.servo.ui import servo_process\n"
        "servo_process.servo = lambda *_, **options: options['hand_eye']\n"
        "servo_process.main()"
    )
    monkeypatch.setattr(servo_process, "WINDOW_PROGRAM", ["-c", program])
    runner, options = Runner(Dark(), SimRobot(teo.MODEL), lambda frame: None), servo_process._Options
    for offered in (True, False):
        shown = options(None, None, Theme.AUTO, offered)
        assert servo_process._show_once(runner, closed_loop.calibration().scaled_to, shown, None) == (
            "",
            offered,
        )
        assert runner.gate.halted == CLOSED


class Dark:
    """A source whose images never come."""


def test_a_screenshot_that_cannot_be_written_is_named(tmp_path):
    path, calibration = tmp_path / "folder" / "servo.png", tmp_path / "camera.yaml"
    camera_info.save(Calibration.from_field_of_view(320, 240, 60), calibration)
    robot = ["--source", "sim:?width=320&height=240&fps=10", "--calibration", calibration]
    program = subprocess.run(
        [sys.executable, "-m", "grabbergui", "servo", *robot, "--seconds", "0.2", "--screenshot", path],
        env=os.environ | {"QT_QPA_PLATFORM": "offscreen"},
        capture_output=True,
        text=True,
        timeout=PROGRAM,
    )
    assert program.returncode == 1
    assert f"grabbergui: the screenshot could not be written to {path}\n" in program.stderr


def test_a_window_closes_when_the_loops_process_is_killed():
    program = subprocess.Popen(
        [sys.executable, "-m", "grabbergui", "servo", "--robot", "sim-teo"],
        env=os.environ | {"QT_QPA_PLATFORM": "offscreen"},
        stdout=subprocess.DEVNULL,
    )
    try:
        window = psutil.Process(await_window(program.pid))
        program.kill()
        program.wait()
        window.wait(PATIENCE)
        assert not window.is_running()
    finally:
        program.kill()
        program.wait()
