"""A run on the simulated robot in the servoing window: shown, stopped, started, calibrated."""

import dataclasses
import threading

import numpy as np
import pytest
from PyQt5.QtWidgets import QPushButton

from grabbergui.calibration import camera_info
from grabbergui.calibration.calibration_choice import CalibrationChoice
from grabbergui.core.errors import FrameTimeoutError, SourceUnavailableError
from grabbergui.servo import closed_loop
from grabbergui.servo.config import Config
from grabbergui.servo.models.servo_proxy import HAND_EYE
from grabbergui.servo.models.servoing import Tuning
from grabbergui.servo.robots import teo
from grabbergui.servo.state_machine import State
from grabbergui.ui.controllers.calibration_dialogs import CalibratingController
from grabbergui.ui.views.calibration_dialogs import CalibrationDialog
from patience import PATIENCE, attempts


def test_a_live_run_is_shown_and_stopped_from_the_window(window, live, qtbot):
    runner, robot = live
    runner.start()
    qtbot.waitUntil(lambda: bool(window.drawing.drawing.strokes))
    qtbot.waitUntil(lambda: robot.speed > 0.02)
    qtbot.waitUntil(lambda: window.distancePlot.values() is not None)
    for watch in attempts(1.0):
        qtbot.waitUntil(lambda: robot.speed > 0.01)
        with watch:
            window.stopButton.click()
            qtbot.waitUntil(lambda: robot.speed == 0)
        qtbot.waitUntil(lambda: window.states.state is State.STOPPED)
        assert window.reasonLabel.text() == "stopped in the window"
        assert window.history.topLevelItem(window.history.topLevelItemCount() - 1).text(1) == "stopped"
        qtbot.waitUntil(window.startButton.isEnabled)
        window.startButton.click()
    qtbot.waitUntil(lambda: robot.speed > 0.01)


def test_a_robot_that_is_held_waits_for_start(window, live, qtbot):
    runner, robot = live
    runner.start(held="press Start")
    qtbot.waitUntil(lambda: window.reasonLabel.text() == "press Start")
    qtbot.waitUntil(lambda: window.distancePlot.values() is not None)
    assert window.states.state is State.STOPPED
    assert robot.speed == 0
    window.startButton.click()
    qtbot.waitUntil(lambda: robot.speed > 0.01)
    qtbot.waitUntil(lambda: not window.startButton.isEnabled())


@pytest.mark.parametrize("limits", [Config()], ids=["of a real robot"])
def test_a_gain_set_in_the_window_reaches_the_loop_and_nonsense_does_not(window, live, qtbot):
    runner, _ = live
    runner.start()
    window.headGainBox.setValue(0.7)
    qtbot.waitUntil(lambda: runner.config.head.gain == 0.7)
    window.tuningChanged.emit(dataclasses.replace(Tuning.of(Config()), rate=5))
    assert "too long" in window.messages.messages[0]
    assert window.rateBox.value() == 50


def test_a_stop_that_hangs_in_the_network_does_not_hold_up_the_window(window, live, qtbot):
    runner, robot = live
    entered, leave = threading.Event(), threading.Event()
    stop = robot.stop

    def hang():
        entered.set()
        leave.wait(PATIENCE)
        stop()

    robot.stop = hang
    window.stopButton.click()  # returns at once, or the test would end in its time limit
    assert entered.wait(PATIENCE)
    leave.set()
    qtbot.waitUntil(lambda: bool(runner.gate.halted))


@pytest.fixture
def slow_start(live, monkeypatch):
    """Returns the starts of the loop so far, and the event that lets them proceed."""
    runner, _ = live
    starts, proceed, start = [], threading.Event(), runner._start

    def start_slowly():
        starts.append(True)
        assert proceed.wait(PATIENCE)
        if len(starts) == 1:  # a second one would wait for the end of the first one's loop
            start()

    monkeypatch.setattr(runner, "_start", start_slowly)
    return starts, proceed


def starting():
    return any(thread.name == "start" for thread in threading.enumerate())


def test_start_pressed_twice_starts_one_loop(window, live, slow_start, qtbot):
    starts, proceed = slow_start
    window.startPressed.emit()
    window.startPressed.emit()
    qtbot.waitUntil(lambda: bool(starts))
    proceed.set()
    qtbot.waitUntil(lambda: not starting())
    assert len(starts) == 1


def test_a_stop_pressed_while_the_loop_starts_keeps_the_robot_still(window, live, slow_start, qtbot):
    runner, robot = live
    starts, proceed = slow_start
    window.startPressed.emit()
    qtbot.waitUntil(lambda: bool(starts))
    window.stopButton.click()
    qtbot.waitUntil(lambda: runner.gate.halted == "stopped in the window")
    proceed.set()
    qtbot.waitUntil(lambda: not starting())
    assert runner.gate.halted == "stopped in the window"
    assert robot.speed == 0


def test_a_run_that_failed_says_why_and_can_be_started_again(window, live, qtbot):
    runner, _ = live
    make = runner._make_detector

    def fail(frame):
        raise FrameTimeoutError("the lens fell off")

    runner._make_detector = fail
    runner.start()
    qtbot.waitUntil(lambda: window.messages.messages == ["the lens fell off"])
    runner._make_detector = make
    qtbot.waitUntil(lambda: not runner.running and window.startButton.isEnabled())
    window.startButton.click()
    qtbot.waitUntil(lambda: bool(window.drawing.drawing.strokes))


def test_a_camera_that_does_not_start_leaves_the_start_to_be_repeated(window, live, qtbot, monkeypatch):
    runner, _ = live

    def fail():
        raise SourceUnavailableError("the camera is used by another program")

    with monkeypatch.context() as refused:
        refused.setattr(runner.grabber, "start", fail)
        runner.start()
        qtbot.waitUntil(lambda: window.startButton.isEnabled())
    assert window.messages.messages == ["the camera is used by another program"]
    window.startButton.click()
    qtbot.waitUntil(lambda: bool(window.drawing.drawing.strokes))


def test_the_robot_that_is_drawn_is_the_one_that_moves(live, window, qtbot):
    runner, robot = live
    runner.start()
    qtbot.waitUntil(lambda: bool(window.drawing.drawing.strokes))
    shown = window.robotView._posture
    reach = teo.RIGHT_ARM.forward(robot.state().arm)[:3, 3]
    assert np.linalg.norm(shown.hand[:3, 3] - reach) < 0.05
    assert shown.sight.shape == (4, 3)


def test_a_camera_that_is_not_calibrated_can_be_from_here(window, live, calibration, qtbot, tmp_path):
    runner, robot = live
    calibration.exchange(CalibrationChoice.nominal(60))
    runner.start()
    qtbot.waitUntil(lambda: bool(window.messages.messages))
    assert "not calibrated" in window.messages.messages[0]
    window.findChild(QPushButton, "offerButton").click()
    dialog = window.findChild(CalibrationDialog)
    assert dialog.isVisible()
    qtbot.waitUntil(lambda: bool(runner.gate.halted) and robot.speed == 0)
    path = tmp_path / "camera.yaml"
    camera_info.save(closed_loop.calibration(), path)
    dialog.findChild(CalibratingController).model.saved.emit(path)
    qtbot.waitUntil(lambda: "in use" in window.messages.messages[0])
    assert not calibration(608, 512).nominal
    qtbot.waitUntil(lambda: not any("not calibrated" in text for text in window.messages.messages))
    dialog.reject()


def test_the_robot_rests_once_hand_and_eye_are_to_be_calibrated(window, live, qtbot):
    runner, robot = live
    runner.start()
    qtbot.waitUntil(lambda: robot.speed > 0.01)
    window.handEyeButton.click()
    window.startPressed.emit()
    qtbot.waitUntil(lambda: runner.gate.halted == HAND_EYE and robot.speed == 0)
    sent = runner.gate.sent
    qtbot.wait(200)
    assert (runner.gate.sent, runner.gate.halted) == (sent, HAND_EYE)
