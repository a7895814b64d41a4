"""Gate and loop with a guardian: it knows of each motion and each stop, and without it nothing moves."""

import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from psygnal import Signal

from grabbergui.core.errors import SourceUnavailableError, TransportError
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.servo.config import Config
from grabbergui.servo.gate import Command, CommandGate
from grabbergui.servo.guardian_link import ALLOWED, Guard, Verdict
from grabbergui.servo.runner import Runner
from patience import until
from robots_for_tests import RecordingRobot


class Obeyed(Guard):
    """A guardian whose words a test chooses."""

    def __init__(self):
        self.verdict, self.stops, self.heard = ALLOWED, 0, []

    def beat(self, moving):
        self.heard.append(moving())
        return self.verdict

    def stop(self):
        self.stops += 1

    def renew(self):
        if self.verdict.for_good:
            raise SourceUnavailableError(self.verdict.why_not)


@pytest.fixture
def guard():
    return Obeyed()


@pytest.fixture
def gate(guard):
    return CommandGate(RecordingRobot(), Config(), guard)


MOTION = Command(hand=np.array([0.02, 0, 0, 0, 0, 0]))


def test_the_guardian_knows_of_a_motion_before_the_robot_does(gate, guard):
    guard.beat = lambda moving: guard.heard.append((moving(), gate._robot.moving)) or ALLOWED
    assert gate.send(MOTION, 0.0)
    assert guard.heard == [(True, False)]


def test_the_guardian_knows_that_a_motion_was_stopped(gate, guard):
    seen = []
    guard.observe = seen.append
    gate.send(MOTION, 0.0)
    for now in (0.02, 0.3, 0.32, 0.34):
        gate._robot.time = now
        gate.expire(now)
        gate.beat(now)
    assert [one.stopped for one in seen] == [False, False, True, False, False]


def test_without_a_guardian_that_could_stop_it_nothing_moves(gate, guard):
    guard.verdict = Verdict("the guardian has ended", for_good=True)
    assert not gate.send(MOTION, 0.0)
    assert gate._robot.moves == []
    assert gate.halted == "the guardian has ended"
    with pytest.raises(SourceUnavailableError, match="has ended"):
        gate.release()
    assert gate.halted


def test_a_guardian_that_ends_stops_what_moves(gate, guard):
    gate.send(MOTION, 0.0)
    guard.verdict = Verdict("the guardian has ended", for_good=True)
    gate.beat(0.0)
    assert not gate._robot.moving
    assert gate.halted == "the guardian has ended"


def test_after_a_hiccup_it_goes_on_once_the_stop_is_over(gate, guard):
    gate.send(MOTION, 0.0)
    guard.verdict = Verdict("the guardian is stopping the robot")
    assert not gate.send(MOTION, 0.1)
    assert not gate._robot.moving
    assert not gate.halted
    guard.verdict = ALLOWED
    assert gate.send(MOTION, 1.2)


def test_every_stop_for_a_reason_is_the_guardian_s_too(gate, guard):
    gate.send(MOTION, 0.0)
    gate.expire(1.0)
    assert guard.stops == 1
    gate.halt("the button")
    assert guard.stops == 2
    gate.release()
    gate._robot.deaf = True
    gate.send(MOTION, 2.0)
    assert guard.stops == 3
    assert guard.heard[-1] is True


class SlowToObey(RecordingRobot):
    """A robot whose drives change their mode before a first motion, which a watchdog does not wait for."""

    gate = None

    def move_hand(self, twist):
        for step in range(8):
            now = 0.02 * step
            self.advance(now, 0.02)
            self.gate.expire(now)
            self.gate.beat(now)
        self.gate.expire(0.16)
        raise TransportError("a stop was requested meanwhile")


def test_a_motion_that_was_never_obeyed_is_not_missed(caplog):
    """On a busy computer TEO was stopped for good as it began to move: "only 0.9° in 0.3 s"."""
    robot, config = SlowToObey(), Config()
    robot.gate = gate = CommandGate(robot, config)
    assert not gate.send(Command(hand=np.array([0.12, 0, 0, 0, 0, 0]), until=0.1), 0.0)
    assert "too old: stopped" in caplog.text
    for step in range(8, 40):
        robot.advance(0.02 * step, 0.02)
        gate.beat(0.02 * step)
    assert not gate.halted


class Dark:
    """A source whose images never come."""

    features_changed = Signal(frozenset)

    def has_feature(self, name):
        return False

    def open_queue(self, depth):
        return FrameQueue(depth)

    def start(self):
        pass


class StartedOnce(Runner):
    """Refuses to start a second loop, which would wait for the end of the first one: for ever."""

    starts = 0

    def _start(self):
        self.starts += 1
        assert self.starts == 1, "a loop that runs was started again"
        super()._start()


def test_a_loop_that_runs_is_not_started_a_second_time():
    """Two presses of Start after an error came from two threads."""
    runner = StartedOnce(Dark(), RecordingRobot(), lambda frame: None)
    try:
        with ThreadPoolExecutor(2) as pool:
            list(pool.map(lambda _: runner.start(), range(2)))
        names = [thread.name for thread in threading.enumerate()]
        assert (names.count("servo loop"), names.count("servo watchdog")) == (1, 1)
    finally:
        runner.stop()


def test_a_start_that_holds_the_robot_holds_one_that_runs():
    runner = StartedOnce(Dark(), RecordingRobot(), lambda frame: None)
    runner.start()
    try:
        runner.start(held="press Start")
        assert runner.gate.halted == "press Start"
    finally:
        runner.stop()


def test_a_loop_that_waits_for_images_beats_all_the_same(guard):
    runner = Runner(Dark(), RecordingRobot(), lambda frame: None, guard=guard)
    runner.start()
    try:
        until(lambda: len(guard.heard) > 3)
        assert not any(guard.heard)
    finally:
        runner.stop()
