"""Hand–eye calibration on a simulated robot, through the gate."""

import threading
import time
from dataclasses import replace

import numpy as np
import pytest

from fakes import ScriptedGrabber
from grabbergui.calibration import geometry
from grabbergui.core.errors import (
    CalibrationError,
    GrabberError,
    SourceUnavailableError,
    TransportError,
    UsageError,
)
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import by_name
from grabbergui.servo import closed_loop
from grabbergui.servo.errors import RobotStoppedError
from grabbergui.servo.hand_eye.run import arrangement
from grabbergui.servo.hand_eye.stand import TargetWatch
from grabbergui.servo.robots import teo
from hand_eye_bench import QUICK, Bench
from patience import PATIENCE

VIEWS = 10


def test_the_arm_keeps_away_from_obstacles_while_it_calibrates():
    table = "table 0.2 0.9 -0.9 0.3 -0.6 0.10"
    config = replace(QUICK, safety=replace(QUICK.safety, obstacles=table))
    bench = Bench("fixed", config=config)
    distances, pause = [], bench.run._pause

    def watch(seconds):
        pause(seconds)
        distances.append(bench.gate._space._nearest(bench.robot.state().arm).distance)

    bench.run._pause = watch
    bench.run.run(7)
    assert min(distances) > 0
    assert any("table" in progress.text for progress in bench.said)


def test_poses_that_are_obstructed_are_named():
    gate = Bench("hand").gate
    assert gate.obstruction(teo.HOME) == ""
    assert "workspace" in gate.obstruction(np.zeros(6))


def no_number(bench):
    state = bench.robot.state
    return lambda: replace(state(), head=np.array([np.nan, 0.0]))


@pytest.mark.parametrize(
    ("end", "complaint"),
    [
        (lambda bench: bench.gate.halt("the button"), "stopped: the button"),
        (lambda bench: (bench.gate.halt("the button"), bench.gate.release()), "not for this calibration"),
        (lambda bench: setattr(bench.robot, "state", lambda: None), "does not report its joints"),
        (lambda bench: setattr(bench.robot, "state", no_number(bench)), "does not report its joints"),
    ],
    ids=["stop", "stop that somebody else ended", "silent", "no number"],
)
def test_a_run_that_is_ended_leaves_the_robot_at_rest(end, complaint):
    bench = Bench("head")
    observe, observations = bench.observe, []

    def count(after):
        observations.append(observe(after))
        if len(observations) == 3:
            end(bench)
        return observations[-1]

    bench.run._observe = count
    with pytest.raises((RobotStoppedError, SourceUnavailableError), match=complaint):
        bench.run.run(VIEWS)
    assert bench.robot.speed < 1e-3
    assert not bench.gate._moving


def test_a_target_that_is_not_seen_is_asked_for_before_anything_moves():
    bench = Bench("hand")
    bench.run._observe = lambda after: None
    with pytest.raises(CalibrationError, match="target is not seen"):
        bench.run.run(VIEWS)
    assert bench.gate.sent == 0


def test_too_few_views_are_refused_before_anything_moves():
    bench = Bench("head")
    with pytest.raises(UsageError, match="hand–eye calibration needs 5 views or more, not 4"):
        bench.run.run(4)
    assert not bench.said and not bench.gate.sent


def test_an_arm_that_does_not_report_its_angles_is_refused():
    bench = Bench("fixed")
    state = bench.robot.state
    bench.robot.state = lambda: replace(state(), arm=None)
    with pytest.raises(UsageError, match="angles of its arm"):
        bench.run.run(VIEWS)


def test_a_place_that_cannot_be_is_refused():
    with pytest.raises(UsageError, match="head, hand, fixed"):
        arrangement("knee", teo.MODEL)


def test_a_source_that_cannot_be_started_keeps_no_queue(monkeypatch):
    grabber = ScriptedGrabber()

    def refuse(**options):
        raise TransportError("no stream")

    monkeypatch.setattr(grabber, "start", refuse)
    with pytest.raises(TransportError, match="no stream"):
        TargetWatch(grabber, QUICK.marker, closed_loop.calibration().scaled_to)
    assert not grabber._fanout.consumers


def test_a_frame_that_failed_before_an_observation_does_not_end_it():
    grabber, failed = ScriptedGrabber(), threading.Event()
    calibration = closed_loop.calibration()
    size = calibration.width, calibration.height

    def frame(payload):
        return Frame(payload, *size, by_name("Mono8"), received_ns=time.time_ns())

    watch = TargetWatch(grabber, QUICK.marker, calibration.scaled_to, failed=lambda error: failed.set())
    whole = np.zeros(size[0] * size[1], np.uint8)
    next_one = threading.Timer(0.3, lambda: grabber._fanout.put(frame(whole)))
    try:
        grabber._fanout.put(frame(whole[:10]))
        assert failed.wait(PATIENCE)
        next_one.start()
        assert watch(time.monotonic()) is None  # nothing is seen in the next one
        began = time.monotonic()
        grabber._fanout.put(frame(whole[:10]))
        with pytest.raises(GrabberError, match="the payload has 10"):
            watch(began)
    finally:
        next_one.join()
        watch.close()


@pytest.mark.parametrize("eye", ["head", "hand", "fixed"])
def test_encoders_that_freeze_stop_the_robot_for_good(eye):
    """The hand went on blindly by half a metre, and the head to its limit, pose after pose."""
    bench = Bench(eye)
    true_state, frozen = bench.robot.state, []

    def state():
        return replace(frozen[0], time=bench.now) if frozen else true_state()

    bench.robot.state = state
    bench.on_observation = lambda number: frozen.append(true_state()) if number == 3 else None
    with pytest.raises(RobotStoppedError, match="does not move as commanded"):
        bench.run.run(VIEWS)
    moved, before = true_state(), frozen[0]
    assert geometry.distance(moved.hand, before.hand) < 0.1
    assert np.degrees(np.abs(moved.head - before.head).max()) < 12
    assert bench.robot.speed < 1e-3
