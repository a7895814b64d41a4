"""A run and its proxy, joined by pipes as two processes join them."""

import os
import threading

import numpy as np
import pytest

from grabbergui.core.errors import SourceUnavailableError
from grabbergui.core.frame import Frame, FrameStatus
from grabbergui.core.pfnc import by_name
from grabbergui.servo import closed_loop
from grabbergui.servo.config import Config
from grabbergui.servo.gate import Command
from grabbergui.servo.loop import ControlCycle
from grabbergui.servo.models import servo_proxy
from grabbergui.servo.models.servo_proxy import RunnerProxy, RunnerServer
from grabbergui.servo.models.servoing import ServoModel, Tuning
from grabbergui.servo.robots import teo
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.runner import Runner
from grabbergui.servo.state_machine import State
from patience import PATIENCE, until

SIZE = closed_loop.WIDTH, closed_loop.HEIGHT


class Pair:
    """Both ends; the runner does not run: cycles are reported by hand."""

    def __init__(self):
        robot = SimRobot(teo.MODEL)
        camera = closed_loop.mounted_camera(robot, closed_loop.things_for(Config().marker))
        self.runner = Runner(camera, robot, lambda frame: None)
        (from_loop, to_window), (from_window, to_loop) = os.pipe(), os.pipe()
        self.pipes = [os.fdopen(end, mode) for end, mode in ((to_window, "wb"), (from_window, "rb"))]
        self.window_pipes = [os.fdopen(end, mode) for end, mode in ((from_loop, "rb"), (to_loop, "wb"))]
        self.server = RunnerServer(self.runner, closed_loop.calibration().scaled_to, *self.pipes)
        self.server.open()
        self.ended = threading.Event()
        self.proxy = RunnerProxy(*self.window_pipes, self.ended.set)
        self.failures = []
        self.proxy.failed.connect(self.failures.append)
        self.proxy.open()

    def cycle(self, seconds, frame=None, state=State.CENTRING):
        self.runner.cycle_done.emit(cycle_of(self, seconds, state), frame)

    def kill_window(self):
        """End as the kernel ends a process that dies; the proxy's reader ends with the loop's pipe."""
        self.window_pipes[1].close()

    def close(self):
        self.server.close()
        if not self.window_pipes[1].closed:
            self.window_pipes[1].close()
        assert self.server.closed.wait(PATIENCE)
        for thread in self.server._threads:
            thread.join(PATIENCE)
        self.pipes[0].close()
        self.proxy._thread.join(PATIENCE)
        for pipe in (*self.pipes, *self.window_pipes):
            pipe.close()


def cycle_of(pair, seconds, state=State.CENTRING):
    state_of = pair.runner.robot.state()
    return ControlCycle(seconds, state, "", Command(), (0.0, 0.0), (0.1, 0.2), state_of)


@pytest.fixture
def pair(monkeypatch):
    """Both ends; a stop is waited for until it is confirmed, however busy the machine is."""
    monkeypatch.setattr(servo_proxy, "CONFIRMATION_TIMEOUT", PATIENCE)
    made = Pair()
    yield made
    made.close()


def frame(number=1):
    payload = np.full(SIZE[0] * SIZE[1], number, np.uint8)
    return Frame(payload, *SIZE, by_name("Mono8"), number, status=FrameStatus.COMPLETE, captured=1.5)


def test_cycles_and_images_reach_the_window_with_the_state_of_the_loop(pair):
    seen = []
    pair.proxy.cycle_done.connect(lambda cycle, image: seen.append((cycle, image)))
    for number in range(5):
        pair.cycle(number / 10, frame(number) if number == 4 else None)
    until(lambda: len(seen) == 5)
    assert [cycle.time for cycle, _ in seen] == [0.0, 0.1, 0.2, 0.3, 0.4]
    image = seen[-1][1]
    assert (image.width, image.height, image.captured, int(image.raw()[7, 9])) == (*SIZE, 1.5, 4)
    here = pair.runner.robot.state()
    assert np.allclose(pair.proxy.robot.camera_pose(here.head), pair.runner.robot.camera_pose(here.head))
    assert np.allclose(pair.proxy.robot.skeleton(here)[0], pair.runner.robot.skeleton(here)[0])
    assert pair.proxy.calibration(*SIZE).matrix == pytest.approx(closed_loop.calibration().matrix)


def test_an_image_is_reported_with_its_cycle_or_a_later_one(pair):
    pair.server.close()  # reports are made by hand, one of them between an image and its cycle
    reports = []

    class Interrupted(type(pair.server._moments)):
        def append(self, moment):
            reports.append(pair.server._report())
            super().append(moment)

    pair.server._threads[0].join(PATIENCE)
    pair.server._moments, pair.server._frame, pair.server._taken = Interrupted(), None, True
    for number in range(2):
        pair.server._on_cycle(cycle_of(pair, number / 10), frame(number) if number == 1 else None)
    reports.append(pair.server._report())
    assert [(len(report.moments), report.frame is not None) for report in reports] == [
        (0, False), (1, False), (1, True),
    ]  # fmt: skip


def test_a_window_shows_the_proxy_as_it_shows_a_run(pair):
    model = ServoModel(pair.proxy, pair.proxy.calibration)
    model.open()
    shown = []
    model.ready.connect(lambda: shown.append(model.take()))
    try:
        pair.cycle(0.0, frame())
        until(lambda: any(one is not None and one.image is not None for one in shown))
    finally:
        model.close()
    with_image = next(one for one in shown if one is not None and one.image is not None)
    assert with_image.size == SIZE
    assert with_image.posture.skeleton


def test_of_two_stops_at_once_the_newest_stays_confirmed(pair):
    class Slow(int):
        """A number that is compared while a later stop is carried out."""

        def __gt__(self, other):
            greater = super().__gt__(other)
            later = threading.Thread(target=stop, args=(2,))
            later.start()
            later.join(0.05)
            return greater

        def __reduce__(self):
            return int, (int(self),)  # in a report that is sent in between

    def stop(number):
        pair.server._stop(servo_proxy.ProxyRequest(servo_proxy.RequestKind.STOP, "test", number))

    stop(Slow(1))
    until(lambda: pair.server._confirmed == 2)


def test_a_stop_in_the_window_stops_the_robot_and_is_confirmed(pair):
    pair.proxy.emergency_stop("stopped in the window")
    assert pair.runner.gate.halted == "stopped in the window"
    until(lambda: pair.proxy.gate.halted == "stopped in the window")
    assert pair.failures == []


def test_a_second_stop_does_not_wait_for_a_first_that_hangs(pair, monkeypatch):
    hangs, stops = threading.Event(), []

    def stop(reason):
        stops.append(reason)
        if reason == "first":
            assert hangs.wait(PATIENCE)

    monkeypatch.setattr(pair.runner, "emergency_stop", stop)
    monkeypatch.setattr(servo_proxy, "CONFIRMATION_TIMEOUT", 0.2)
    pair.proxy.emergency_stop("first")
    assert pair.failures == ["the loop has not confirmed the stop within 0.2 s"]
    until(lambda: stops)
    monkeypatch.setattr(servo_proxy, "CONFIRMATION_TIMEOUT", PATIENCE)
    pair.proxy.emergency_stop("second")
    hangs.set()
    assert stops == ["first", "second"]


def test_start_ends_a_stop_and_a_refusal_is_reported(pair, monkeypatch):
    monkeypatch.setattr(Runner, "running", property(lambda self: True))
    pair.proxy.emergency_stop("stopped")
    pair.proxy.request_start()
    until(lambda: pair.runner.gate.halted == "")

    def refuse():
        raise SourceUnavailableError("the guardian has ended")

    monkeypatch.setattr(pair.runner.gate._guard, "renew", refuse)
    pair.proxy.request_start()
    until(lambda: pair.failures == ["the guardian has ended"])


@pytest.fixture
def starting(pair, monkeypatch):
    """The loop is being started; returns a function that lets it start, and waits for the end of that."""
    begun, proceed = threading.Event(), threading.Event()

    def start_slowly():
        begun.set()
        assert proceed.wait(PATIENCE)  # and starts nothing

    def finish():
        proceed.set()
        until(lambda: not any(thread.name == "start" for thread in threading.enumerate()))

    monkeypatch.setattr(pair.runner, "_start", start_slowly)
    pair.proxy.request_start()
    assert begun.wait(PATIENCE)
    yield finish
    proceed.set()


def test_a_stop_while_the_loop_starts_keeps_the_robot_still(pair, starting):
    pair.proxy.emergency_stop("stopped in the window")
    starting()
    assert pair.runner.gate.halted == "stopped in the window"


def test_another_stop_while_the_loop_starts_keeps_its_reason(pair, starting):
    pair.runner.emergency_stop("stopped over YARP")
    pair.proxy.emergency_stop("stopped in the window")
    starting()
    assert pair.runner.gate.halted == "stopped over YARP"


def test_a_window_that_dies_while_the_loop_starts_keeps_the_robot_still(pair, starting):
    pair.kill_window()
    assert pair.server.closed.wait(PATIENCE)
    starting()
    assert pair.runner.gate.halted


def test_a_window_closed_while_the_loop_starts_keeps_the_robot_still(pair, starting):
    pair.proxy._request(servo_proxy.ProxyRequest(servo_proxy.RequestKind.CLOSED))
    assert pair.server.closed.wait(PATIENCE)
    starting()
    assert pair.runner.gate.halted


def test_an_interruption_while_the_loop_starts_keeps_the_robot_still(pair, starting):
    pair.runner.emergency_stop("interrupted")
    closing = threading.Thread(target=pair.server.close)
    closing.start()
    assert pair.server.closed.wait(PATIENCE)
    starting()
    closing.join(PATIENCE)
    assert pair.runner.gate.halted


def test_tuning_reaches_the_loop(pair):
    tuned = Tuning.of(Config())
    tuned = Tuning(**{**vars(tuned), "rate": 20.0})
    pair.proxy.tune(tuned.applied_to(pair.proxy.config))
    until(lambda: pair.runner._tuned is not None)
    assert pair.runner._tuned.loop.rate == 20.0


def test_the_reason_for_the_end_of_the_loop_is_shown(pair):
    pair.runner.failed.emit("the source was closed")
    until(lambda: pair.failures == ["the source was closed"])


def test_a_window_that_dies_stops_the_robot(pair):
    pair.proxy.heartbeat()
    pair.kill_window()
    assert pair.server.closed.wait(PATIENCE)
    assert pair.runner.gate.halted == servo_proxy.CLOSED


def test_closing_the_window_stops_the_robot(pair, monkeypatch):
    monkeypatch.setattr(servo_proxy, "HEARTBEAT_TIMEOUT", 0.0)
    pair.proxy.close()
    assert pair.server.closed.wait(PATIENCE)
    pair.kill_window()
    pair.server._threads[1].join(PATIENCE)
    pair.cycle(1.0)
    assert not pair.server._not_answering
    assert pair.runner.gate.halted == servo_proxy.CLOSED


def test_a_window_that_hangs_stops_the_robot_once(pair, monkeypatch):
    pair.proxy.heartbeat()
    until(lambda: pair.server._last_heartbeat)
    monkeypatch.setattr(servo_proxy, "HEARTBEAT_TIMEOUT", 0.0)
    until(lambda: (pair.cycle(1.0), pair.runner.gate.halted)[1])
    assert pair.runner.gate.halted == servo_proxy.NOT_ANSWERING
    pair.runner.gate.release()
    pair.cycle(2.0)
    assert pair.runner.gate.halted == ""  # it was said once


def test_a_window_that_is_late_makes_the_robot_wait_until_it_answers(pair, monkeypatch):
    pair.proxy.heartbeat()
    until(lambda: pair.server._last_heartbeat)
    monkeypatch.setattr(servo_proxy, "HEARTBEAT_TIMEOUT", PATIENCE)
    monkeypatch.setattr(servo_proxy, "HEARTBEAT_LATE", 0.0)
    until(lambda: (pair.cycle(1.0), pair.runner.gate.paused)[1])
    assert pair.runner.gate.paused == servo_proxy.NOT_ANSWERING
    monkeypatch.setattr(servo_proxy, "HEARTBEAT_LATE", PATIENCE)
    pair.cycle(2.0)
    assert (pair.runner.gate.paused, pair.runner.gate.halted) == ("", "")


def test_a_window_whose_gui_hangs_is_not_alive_because_it_takes_images(pair):
    taken = servo_proxy.ProxyRequest(servo_proxy.RequestKind.IMAGE_TAKEN)
    pair.server._taken = False
    pair.proxy._request(taken)
    until(lambda: pair.server._taken)
    assert pair.server._last_heartbeat is None


def test_heartbeats_for_a_loop_that_hangs_do_not_fill_its_pipe(pair, monkeypatch):
    """The GUI thread would wait for room in it."""
    monkeypatch.setattr(servo_proxy, "HEARTBEAT_TIMEOUT", 0.0)
    unread, to_loop = (os.fdopen(end, mode) for end, mode in zip(os.pipe(), ("rb", "wb"), strict=True))
    with unread, monkeypatch.context() as hanging:
        hanging.setattr(pair.proxy, "_to", to_loop)
        with to_loop:
            for _ in range(3000):
                pair.proxy.heartbeat()
        assert unread.read() == b""


def test_a_window_that_reads_nothing_does_not_block_the_loop(pair):
    blocked = threading.Event()
    pair.proxy.cycle_done.connect(lambda cycle, image: blocked.wait(PATIENCE))
    try:
        for number in range(3 * servo_proxy._MOST_CYCLES):
            pair.cycle(number / 50, frame(number % 200))
        assert len(pair.server._moments) <= servo_proxy._MOST_CYCLES
    finally:
        blocked.set()


def test_the_proxy_ends_with_the_loops_process(pair):
    pair.server.close()
    for thread in pair.server._threads[:1]:
        thread.join(PATIENCE)
    pair.pipes[0].close()
    assert pair.ended.wait(PATIENCE)
    assert not pair.proxy.running
