"""The model of a servo run, without its window."""

import threading
from dataclasses import replace

import numpy as np
import pytest

from grabbergui.servo import closed_loop
from grabbergui.servo.config import Config
from grabbergui.servo.gate import Command
from grabbergui.servo.loop import ControlCycle
from grabbergui.servo.models import servoing
from grabbergui.servo.models.servoing import ServoModel, Tuning, state_text
from grabbergui.servo.robots import teo
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.runner import Runner
from grabbergui.servo.state_machine import State
from patience import PATIENCE, attempts, until


@pytest.fixture
def runner():
    """One that does not run: cycles are reported by hand."""
    robot = SimRobot(teo.MODEL)
    camera = closed_loop.mounted_camera(robot, closed_loop.things_for(Config().marker))
    return Runner(camera, robot, lambda frame: closed_loop.detector(Config(), closed_loop.calibration()))


@pytest.fixture
def model(runner):
    made = ServoModel(runner, closed_loop.calibration().scaled_to)
    made.open()
    yield made
    made.close()
    assert "servo display" not in {thread.name for thread in threading.enumerate()}


def turned(runner, seconds, state=State.CENTRING, error=(0.1, 0.2), hand=0.0, began=None):
    command, robot = Command(hand=np.full(6, hand)), runner.robot.state()
    cycle = ControlCycle(seconds, state, f"at {seconds:g}", command, (0.0, 0.0), error, robot, began)
    runner.cycle_done.emit(cycle, None)


def test_curves_are_in_order_and_end_now(model, runner):
    for number in range(10):
        turned(runner, 100 + 0.02 * number, error=(number, 0.0), hand=number / 10)
    curves = model.curves()
    assert curves[:, 0] == pytest.approx(np.arange(-9, 1) * 0.02)
    assert curves[:, 1] == pytest.approx(np.arange(10))
    assert curves[:, 8] == pytest.approx(np.arange(10) / 10)


def test_the_limits_are_beside_what_is_measured(model, runner):
    at_home, moved = runner.robot.state(), runner.robot.state().hand.copy()
    moved[0, 3] += 0.006
    for time_s, hand in ((1.0, at_home.hand), (1.1, moved)):
        cycle = ControlCycle(time_s, State.APPROACHING, "", Command(), (0.0, 0.0), (0.0, 0.0), None)
        runner.cycle_done.emit(replace(cycle, robot=replace(at_home, time=time_s, hand=hand)), None)
    low, high = Config().arm.workspace
    inside = 1e3 * min((moved[:3, 3] - low).min(), (high - moved[:3, 3]).min())
    assert model._limits() == f"Hand: 60 of 120 mm/s, 0 of 35 °/s, {inside:.0f} mm inside its workspace"


def test_curves_remember_some_seconds_however_fast_the_loop_is(model, runner):
    for number in range(5000):
        turned(runner, 0.005 * number)
    curves = model.curves()
    assert len(curves) == servoing.CURVE_SECONDS * servoing.CURVE_RATE
    assert -curves[0, 0] == pytest.approx(servoing.CURVE_SECONDS, rel=0.05)
    assert (np.diff(curves[:, 0]) > 0).all()


def test_no_curves_before_the_first_turn(model):
    assert len(model.curves()) == 0


def test_states_are_noted_when_they_change(model, runner):
    entered = []
    model.entered.connect(entered.append)
    for seconds, state in ((5, State.LOST), (5.5, State.LOST), (6, State.CENTRING), (8, State.LOST)):
        turned(runner, seconds, state, began=4)
    assert [(entry.time, entry.state) for entry in model.entries] == [
        (1, State.LOST),
        (2, State.CENTRING),
        (4, State.LOST),
    ], "on the console's clock, also if the window opened later"
    assert entered == model.entries


def test_a_moment_without_an_image_still_shows_the_robot(model, runner):
    ready = threading.Event()
    model.ready.connect(ready.set)
    turned(runner, 1.0)
    assert ready.wait(PATIENCE)
    shown = model.take()
    assert shown.image is None
    assert shown.posture.hand == pytest.approx(runner.robot.state().hand)
    assert model.take() is None


def test_a_window_that_takes_nothing_does_not_block_the_loop(model, runner):
    for watch in attempts(1.0):
        with watch:
            for number in range(500):
                turned(runner, 0.02 * number)


def test_a_moment_that_cannot_be_drawn_is_skipped_and_the_next_is_shown(model, runner, caplog):
    ready = threading.Event()
    model.ready.connect(ready.set)
    right = runner.robot.camera_pose
    runner.robot.camera_pose = lambda head: 1 / 0
    turned(runner, 1.0)
    until(lambda: "cannot be shown" in caplog.text)
    runner.robot.camera_pose = right
    turned(runner, 2.0)
    assert ready.wait(PATIENCE)


def test_the_tuning_of_a_configuration_leaves_it_unchanged():
    tuning = Tuning.of(Config())
    assert tuning.applied_to(Config()) == Config()
    assert tuning.arm_fastest == pytest.approx(120)


@pytest.mark.parametrize("state", State)
def test_every_state_has_a_text(state):
    assert state_text(state) == state.value
