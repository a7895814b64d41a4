"""The servoing window, alone and on a loop with the simulated robot."""

import threading

import pytest

from grabbergui.calibration.calibration_choice import CalibrationChoice
from grabbergui.servo import closed_loop
from grabbergui.servo.config import Config
from grabbergui.servo.robots import teo
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.runner import Runner
from grabbergui.servo.ui.servo_controller import ServoController
from servo_limits import patient_config
from servoing_window import window  # noqa: F401


@pytest.fixture
def calibration():
    """The calibration of the live run; a test may exchange it."""
    return CalibrationChoice(closed_loop.calibration().scaled_to)


@pytest.fixture
def limits():
    return patient_config()


@pytest.fixture
def live(qtbot, window, calibration, limits):  # noqa: F811
    """A runner on the simulated robot, shown."""
    threads = set(threading.enumerate())
    robot = SimRobot(teo.MODEL)
    camera = closed_loop.mounted_camera(robot, closed_loop.things_for(Config().marker))
    camera.open()
    runner = Runner(
        camera,
        robot,
        lambda frame: closed_loop.detector(limits, calibration(frame.width, frame.height)),
        limits,
    )
    controller = ServoController(window, runner, calibration, hand_eye=True)
    try:
        yield runner, robot
    finally:
        controller.close()
        runner.stop()
        camera.close()
        # Those of the stop button end by themselves.
        qtbot.waitUntil(lambda: set(threading.enumerate()) <= threads)
