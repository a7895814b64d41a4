"""Faults that show only in long runs, or at one unlucky moment."""

import gc
import threading
import time
import types
import weakref

import numpy as np
import pytest

from grabbergui.calibration import geometry
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import UsageError
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.settings import SettingKey
from grabbergui.driver.sim.device import SimulatedDevice
from grabbergui.driver.sim.model import CameraModel
from grabbergui.net.yarp.os.values import Dialect
from grabbergui.servo import runner
from grabbergui.servo.config import Config
from grabbergui.servo.detection import Detector
from grabbergui.servo.face_detectors import CascadeFaceDetector
from grabbergui.servo.gate import Command, CommandGate
from grabbergui.servo.robots import teo, teo_ports
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.runner import Runner
from grabbergui.servo.state_machine import Situation, State, StateMachine
from patience import PATIENCE, set_aside_what_stays, until
from robots_for_tests import RecordingRobot
from second_writer import selector_in_motion

MOVE = Command(head=np.array([0.1, 0.0]))


def test_the_watchdog_knows_of_a_command_that_came_while_it_stopped_the_robot():
    class Slow(RecordingRobot):
        def stop(self):
            delivered = super().stop()
            if self.stops == 1:
                gate.send(MOVE, 2.0)
            return delivered

    robot = Slow()
    gate = CommandGate(robot, Config())
    gate.send(MOVE, 1.0)
    assert gate.expire(1.5)
    assert robot.moving, "the late command came behind the stop"
    assert gate.expire(2.5)
    assert not robot.moving


def test_a_search_begins_though_time_began_at_zero():
    machine = StateMachine(grace=0.3, search_after=2.0)
    states = [machine.step(second / 10, Situation()) for second in range(30)]
    assert states[-1] is State.SEARCHING


def test_an_hour_at_rest_is_passed_at_once_and_nothing_is_moved_by_it(monkeypatch):
    now = [0.0]
    robot = SimRobot(teo.MODEL, lambda: now[0])
    robot.step_head(np.array([0.2, -0.1]))
    robot.move_hand(np.array([0.05, 0, 0, 0, 0, 0]))
    now[0] = 5.0
    before = robot.state()
    steps = []
    integrate = robot._integrate
    monkeypatch.setattr(robot, "_integrate", lambda seconds: (steps.append(seconds), integrate(seconds)))
    now[0] = 5.0 + 10 * 3600
    after = robot.state()
    assert after.time == pytest.approx(now[0])
    assert np.allclose(after.head, before.head, atol=1e-6)
    assert np.allclose(after.arm, before.arm, atol=1e-6)
    assert len(steps) < 300
    assert np.allclose(robot.camera_at(1800.0), robot.camera_at(now[0]), atol=1e-6)


def test_where_the_camera_will_be_is_foretold_while_no_command_changes_it():
    now = [0.0]
    robot = SimRobot(teo.MODEL, lambda: now[0])
    robot.COMMAND_TIMEOUT = 10.0
    robot.move_head(np.array([0.5, -0.1]))
    now[0] = 0.5
    foretold = robot.camera_at(0.515)
    at_rest = robot.camera_at(0.5)
    now[0] = 0.515
    there = robot.camera_at(0.515)
    assert geometry.angle_between(at_rest, there) > 0.005
    assert geometry.angle_between(foretold, there) < 1e-4


def test_a_motion_does_not_depend_on_how_often_it_is_sampled():
    now = [0.0]
    asked, unasked = SimRobot(teo.MODEL, lambda: now[0]), SimRobot(teo.MODEL, lambda: now[0])
    for robot in (asked, unasked):
        robot.move_head(np.array([0.3, 0.1]))
    for _ in range(600):
        now[0] += 0.01
        asked.state()
    assert np.allclose(unasked.state().head, asked.state().head, atol=1e-9)
    assert asked.state().head[0] > 0.01


def test_what_is_kept_of_a_run_has_an_end():
    one = Runner(types.SimpleNamespace(), RecordingRobot(), lambda frame: None)
    for times in (one.detection_ms, one.latency_ms):
        times.extend(float(number) for number in range(runner.TIMES_KEPT + 5))
        assert (len(times), times[-1]) == (runner.TIMES_KEPT, runner.TIMES_KEPT + 4)


@pytest.fixture
def camera():
    from grabbergui.driver.device_grabber import DeviceGrabber

    camera = DeviceGrabber(SimulatedDevice(DeviceInfo("sim:"), CameraModel()))
    camera.open()
    yield camera
    camera.close()


def test_a_run_frees_every_trigger_though_somebody_else_moves_their_selector(camera):
    """Servoing writes no other setting than those with which its camera starts."""
    entries = ("FrameStart", "FrameBurstStart")
    triggers = [SettingKey("TriggerMode", (("TriggerSelector", entry),)) for entry in entries]
    nothing = types.SimpleNamespace(detect=lambda grey: [])
    with selector_in_motion(camera, "TriggerSelector", entries):
        for _ in range(10):
            for trigger in triggers:
                camera.write_setting(trigger, "On")
            one = Runner(camera, RecordingRobot(), lambda frame: Detector(nothing))
            one.start()
            until(lambda: one.images)  # noqa: B023 - waited for in this turn
            one.stop()
            assert [camera.read_setting(trigger).value for trigger in triggers] == ["Off", "Off"]
            camera.stop()


@pytest.fixture
def collection():
    """Automatic garbage collection, which the application of other tests may have disabled."""
    automatic = gc.isenabled()
    gc.enable()
    yield
    (gc.enable if automatic else gc.disable)()


@pytest.mark.usefixtures("collection")
@pytest.mark.parametrize("before", [False, True], ids=["nothing frozen", "frozen before"])
def test_a_run_freezes_what_is_there_and_leaves_what_somebody_else_has_frozen(camera, before):
    one = Runner(camera, RecordingRobot(), lambda frame: Detector(types.SimpleNamespace(detect=lambda _: [])))
    gc.unfreeze()
    if before:
        gc.freeze()
    try:
        one.start()
        assert gc.get_freeze_count() > runner.FEW_FROZEN
        one.stop()
        assert (gc.get_freeze_count() > runner.FEW_FROZEN) is before
    finally:
        one.stop()
        set_aside_what_stays()


class Cycle:
    """Refers to itself."""

    def __init__(self):
        self.itself = self


@pytest.mark.usefixtures("collection")
def test_a_run_leaves_garbage_to_a_program_that_collects_by_itself(camera):
    """One with a window collects in the GUI thread only: see decision 16."""
    one = Runner(camera, RecordingRobot(), lambda frame: Detector(types.SimpleNamespace(detect=lambda _: [])))
    gc.unfreeze()
    gc.disable()
    cycle = Cycle()
    alive, frozen = weakref.ref(cycle), gc.get_freeze_count()
    del cycle
    try:
        one.start()
        assert alive() is not None
        assert gc.get_freeze_count() == frozen
    finally:
        one.stop()
        set_aside_what_stays()


def test_an_unexpected_error_in_detection_is_reported_and_the_robot_rests(camera):
    class Broken:
        def detect(self, grey):
            raise ZeroDivisionError("corners")

    robot, reasons = RecordingRobot(), []
    one = Runner(camera, robot, lambda frame: Detector(Broken()))
    one.failed.connect(reasons.append)
    one.start()
    until(lambda: reasons)
    until(lambda: not one.running)
    one.stop()
    assert reasons == ["internal error, see the log: corners"]
    assert robot.stops


def test_a_listener_that_fails_ends_the_run_with_its_reason(camera):
    def listener(cycle, frame):
        raise UsageError("the calibration is of another crop")

    reasons = []
    nothing = types.SimpleNamespace(detect=lambda grey: [])
    one = Runner(camera, RecordingRobot(), lambda frame: Detector(nothing))
    one.failed.connect(reasons.append)
    one.cycle_done.connect(listener)
    one.start()
    until(lambda: reasons)
    one.stop()
    assert "the calibration is of another crop" in reasons[0]


def test_the_end_of_a_run_stops_the_robot_at_once_though_a_detection_hangs(camera):
    """No watchdog is left to do it by then, and some robots' drives go on until they get a command."""
    hangs, let_go = threading.Event(), threading.Event()

    class Hanging:
        def detect(self, grey):
            hangs.set()
            let_go.wait(PATIENCE)
            return []

    robot = RecordingRobot()
    one = Runner(camera, robot, lambda frame: Detector(Hanging()))
    one.start()
    assert hangs.wait(PATIENCE)
    ending = threading.Thread(target=one.stop)
    before = robot.stops
    ending.start()
    try:
        until(lambda: robot.stops > before)
        assert ending.is_alive(), "it waits for the detection"
    finally:
        let_go.set()
        ending.join(PATIENCE)
    assert not one.gate.send(MOVE, time.monotonic())
    assert State.STOPPED not in [step.state for step in one.loop.machine.transitions]


@pytest.mark.parametrize("shape", [(8, 4096), (1, 640), (700, 3)])
def test_heads_are_looked_for_in_images_of_any_shape(shape):
    height, width = shape
    finder = CascadeFaceDetector(Calibration.from_field_of_view(width, height))
    assert finder.detect(np.zeros(shape, np.uint8)) == []


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("[track]\nconfirm = 0", "confirm of 0 images; allowed: 1 to 100"),
        ("[track]\nsmoothing = 0", "smoothing of 0; allowed: 0.001 to 1"),
        ("[track]\nsmoothing = 2.5", "smoothing of 2.5; allowed: 0.001 to 1"),
        ("[arm]\nx_low = 0.9", "x_low must be less than x_high"),
        ("[arm]\nz_high = -inf", "must be finite"),
        ("[head]\ngain = -1", "finite and not negative"),
    ],
)
def test_settings_that_would_move_a_robot_wrongly_are_refused(text, complaint):
    with pytest.raises(UsageError, match=complaint):
        Config.parse(text)


def test_corners_of_the_workspace_may_be_negative():
    assert Config.parse("[arm]\nx_low = -0.5\nx_high = -0.1").arm.x_high == -0.1


def test_a_simulated_teo_closes_whenever_its_stream_looks_whether_to_go_on(monkeypatch):
    """Between looking and waiting there was a moment in which an end was overlooked."""
    ports = teo_ports.TeoPorts.__new__(teo_ports.TeoPorts)
    robot = SimRobot(teo.MODEL)
    quiet = types.SimpleNamespace(write=lambda data: None, step=lambda: None)
    ports._robot, ports._dialect = robot, Dialect.YARP3
    ports._head = ports._arm = ports._arm_encoders = quiet
    ports._ports = ()

    class ClosedBehindTheLook(threading.Event):
        looks = 0

        def is_set(self):
            seen = super().is_set()
            self.looks += 1
            if self.looks == 3:
                self.clear()
            return seen

    ports._running = ClosedBehindTheLook()
    ports._running.set()
    ports._thread = threading.Thread(target=ports._stream, daemon=True)
    ports._thread.start()
    ports._thread.join(PATIENCE)
    assert not ports._thread.is_alive()


def test_a_camera_on_the_head_is_where_the_head_is_though_its_clock_is_set():
    from grabbergui.driver.sim.rendered_scene import Things
    from grabbergui.servo import closed_loop

    robot = SimRobot(teo.MODEL)
    seen = []
    camera = closed_loop.mounted_camera(robot, Things(), camera_at=seen.append)
    model = camera.device.model
    pose = model.sensor.scene._camera
    for _ in range(2):
        pose(model.timestamp())
        now = time.monotonic()
        assert seen[-1] == pytest.approx(now, abs=5.0)
        model.device_clock._epoch -= 3600 * 10**9
