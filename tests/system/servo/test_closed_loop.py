"""The loop through real pixels: in simulated time to the bit, in real time, and on the command line."""

import dataclasses
import errno
import functools
import json
import math
import os
import sys
import threading
import time
import types

import cv2
import numpy as np
import pytest
from psygnal import Signal

from fakes import ScriptedGrabber
from frames import frame_of
from grabbergui.calibration import geometry
from grabbergui.core import environment
from grabbergui.core.errors import UsageError
from grabbergui.core.features import AccessMode, Feature, FeatureKind
from grabbergui.core.frame import FrameStatus
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.driver.sim.rendered_scene import Things, at, board_pose
from grabbergui.recording.movie_writer import MovieFile
from grabbergui.servo import closed_loop, plot_image, report
from grabbergui.servo.cli import servo as command
from grabbergui.servo.config import Config
from grabbergui.servo.detection import Detector
from grabbergui.servo.robots import teo
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.runner import Runner
from grabbergui.servo.state_machine import State
from patience import until
from servo_options import options


@functools.cache
def cycles_to_the_marker():
    """Return the cycles of a whole run, without images, for all tests that only read them."""
    run = closed_loop.ClosedLoop(rendered=False, head=closed_loop.AT_BOARD)
    run.run(20, State.REACHED)
    return tuple(run.cycles)


def test_it_looks_waits_approaches_and_arrives():
    run = closed_loop.ClosedLoop(things=Things(board=lambda seconds: board_pose() if seconds > 1 else None))
    run.run(20, State.REACHED)
    states = [step.state for step in run.loop.machine.transitions]
    assert states[-2:] == [State.APPROACHING, State.REACHED]
    assert State.WAITING in states
    run.run(1.0)
    metres, radians = run.true_error()
    assert metres < 0.010
    assert math.degrees(radians) < 2
    assert run.robot.limit_violations == 0
    assert run.robot.speed == 0
    assert run.gate.refused == 0


def test_the_same_run_again_is_the_same_to_the_bit():
    runs = [closed_loop.ClosedLoop() for _ in range(2)]
    for run in runs:
        run.run(1.5)
    assert np.array_equal(runs[0].robot.state().hand, runs[1].robot.state().hand)
    assert np.array_equal(runs[0].robot.state().head, runs[1].robot.state().head)


@pytest.mark.parametrize("board", [board_pose(), at(0.5, -0.25, 0.3, -20, 15, 130)])
def test_a_computed_detection_is_what_the_detector_finds(board):
    rendered, computed = (
        closed_loop.ClosedLoop(
            things=Things(board=lambda _: board), head=closed_loop.AT_BOARD, rendered=rendered
        )
        for rendered in (True, False)
    )
    for run in (rendered, computed):
        run.run(0.1)
    (found,), (expected,) = rendered.loop.sighting.markers, computed.loop.sighting.markers
    assert found.marker_id == expected.marker_id
    assert np.abs(found.corners - expected.corners).max() < 0.5
    assert geometry.distance(found.pose, expected.pose) < 0.004


@pytest.mark.parametrize(
    "board",
    [None, at(0.7, -0.32, 0.36, yaw=180), at(-0.7, -0.32, 0.36), at(0.7, 0.9, 0.36)],
    ids=["no board", "its back", "behind the camera", "outside the image"],
)
def test_an_invisible_marker_is_not_detected_by_computation(board):
    camera = teo.MODEL.camera_pose(np.array(closed_loop.AT_BOARD))
    assert closed_loop.computed_sighting(camera, board, Config().marker, 0.0).markers == ()


def test_an_approach_with_computed_detections_arrives():
    run = closed_loop.ClosedLoop(rendered=False, head=closed_loop.AT_BOARD)
    run.run(10, State.REACHED)
    assert run.true_error()[0] < 0.005


def test_the_robot_rests_200_ms_after_the_last_image():
    run = closed_loop.ClosedLoop(rendered=False, head=closed_loop.AT_BOARD)
    run.run(10, State.APPROACHING)
    run.run(0.5)
    assert run.robot.speed > 0
    run.camera_runs = False
    last = run.cycles[-1].time
    while run.robot.speed and run.now < last + 1:
        run.cycle()
    assert run.now - last < 0.2 + run.latency


def test_a_board_that_is_taken_away_stops_the_arm():
    things = Things(board=lambda seconds: board_pose() if seconds < 2 else None)
    run = closed_loop.ClosedLoop(things=things, rendered=False, head=closed_loop.AT_BOARD)
    assert run.run(5, State.APPROACHING).state is State.APPROACHING
    run.run(2.3 - run.now)
    twists = [cycle.command.hand for cycle in run.cycles if cycle.time > 2.1]
    assert not np.any(twists)


class Clock:
    now = 0.0

    def __call__(self):
        return self.now


def test_the_simulated_robot_forgets_a_command_after_a_while():
    clock = Clock()
    robot = SimRobot(teo.MODEL, clock)
    robot.move_hand(np.array([0.05, 0, 0, 0, 0, 0]))
    robot.move_head(np.array([0.3, 0.0]))
    clock.now = 0.15
    assert robot.speed > 0.1
    clock.now = 0.6
    assert robot.speed < 1e-4


def test_the_simulated_robot_keeps_to_its_limits_whatever_it_is_commanded():
    clock, random = Clock(), np.random.default_rng(7)
    robot = SimRobot(teo.MODEL, clock)
    for _ in range(400):
        robot.move_hand(random.normal(0, 5, 6))
        robot.move_head(random.normal(0, 20, 2))
        clock.now += 0.02
    state = robot.state()
    assert robot.limit_violations == 0
    assert (teo.RIGHT_ARM.low - 1e-9 <= state.arm).all()
    assert (state.arm <= teo.RIGHT_ARM.high + 1e-9).all()
    assert (teo.HEAD.low - 1e-9 <= state.head).all()


@pytest.mark.parametrize("bad", [np.full(6, np.nan), np.zeros(3)])
def test_the_simulated_robot_rests_on_what_is_no_command(bad):
    clock = Clock()
    robot = SimRobot(teo.MODEL, clock)
    robot.move_hand(bad)
    clock.now = 0.1
    assert np.allclose(robot.state().arm, teo.HOME)


def test_the_simulated_hand_moves_as_it_is_commanded():
    clock = Clock()
    robot = SimRobot(teo.MODEL, clock)
    start = robot.state().hand
    for _ in range(50):
        robot.move_hand(np.array([0.03, 0.02, -0.01, 0, 0, 0.1]))
        clock.now += 0.02
    moved = robot.state().hand[:3, 3] - start[:3, 3]
    # Drives lag by their response time, 0.03 s of one second; damping costs some more.
    assert moved == pytest.approx(np.array([0.03, 0.02, -0.01]) * 0.97, abs=1e-3)


@pytest.fixture
def live(config):
    robot = SimRobot(teo.MODEL)
    camera = closed_loop.mounted_camera(robot, closed_loop.things_for(Config().marker))
    camera.open()
    runner = Runner(
        camera, robot, lambda frame: closed_loop.detector(config, closed_loop.calibration()), config
    )
    yield runner, camera, robot
    runner.stop()
    camera.close()


def test_a_run_moves_the_arm_and_an_emergency_stop_ends_that(live):
    runner, _, robot = live
    cycles = []
    runner.cycle_done.connect(lambda cycle, frame: cycles.append(cycle))
    runner.start()
    until(lambda: runner.loop.machine.state is State.APPROACHING and robot.speed > 0.02)
    runner.emergency_stop("test")
    assert robot.speed == 0
    sent = runner.gate.sent
    until(lambda: cycles[-1].state is State.STOPPED)
    before = len(cycles)
    until(lambda: len(cycles) > before + 20)
    assert runner.gate.sent == sent
    assert robot.speed == 0
    runner.resume()
    until(lambda: robot.speed > 0.01)


def test_a_run_that_is_held_sees_but_moves_nothing_until_it_is_let(live):
    runner, _, robot = live
    cycles = []
    runner.cycle_done.connect(lambda cycle, frame: cycles.append(cycle))
    runner.start(held="press Start")
    until(lambda: len(runner.detection_ms) > 3 and len(cycles) > 50)
    assert all((cycle.state, cycle.reason) == (State.STOPPED, "press Start") for cycle in cycles)
    assert robot.speed == 0
    assert runner.gate.sent == 0
    runner.emergency_stop("the button")
    until(lambda: (cycles[-1].state, cycles[-1].reason) == (State.STOPPED, "the button"))
    runner.resume()
    until(lambda: robot.speed > 0.01)


def test_a_run_without_images_comes_to_rest(live):
    runner, camera, robot = live
    runner.start()
    until(lambda: runner.loop.machine.state is State.APPROACHING and robot.speed > 0.02)
    camera.stop()
    stopped = time.monotonic()
    until(lambda: robot.speed == 0)
    assert runner.running
    assert runner.loop.sighting.captured <= stopped
    until(lambda: runner.loop.machine.state is State.LOST)


def test_a_run_whose_source_closes_reports_it_and_leaves_the_robot_at_rest(live):
    runner, camera, robot = live
    reasons = []
    runner.failed.connect(reasons.append)
    runner.start()
    until(lambda: runner.detection_ms)
    camera.close()
    for queue in _queues(camera):
        queue.close()
    until(lambda: not runner.running or runner.loop.machine.state is State.LOST)
    assert robot.speed == 0


def _queues(camera) -> tuple[FrameQueue, ...]:
    return camera._fanout._queues


def test_an_image_that_is_not_complete_is_not_announced_as_one_that_counted():
    """Publishers gave the last detections a second time, stamped as those of the new image."""

    class Lossy:
        features_changed = Signal(frozenset)

        def has_feature(self, name):
            return False

        def open_queue(self, depth):
            self.queue = FrameQueue(depth)
            return self.queue

        def start(self):
            pass

    source, cycles = Lossy(), []
    runner = Runner(source, SimRobot(teo.MODEL), lambda frame: None)
    runner.cycle_done.connect(lambda cycle, frame: cycles.append(frame))
    runner.start()
    try:
        until(lambda: cycles)
        broken = frame_of(np.zeros((8, 8), np.uint8))
        broken = dataclasses.replace(broken, status=FrameStatus.INCOMPLETE)
        begun = len(cycles)

        def lost():
            source.queue.put(broken)
            return len(cycles) > begun + 20

        until(lost)
        assert set(cycles) == {None}
    finally:
        runner.stop()


def test_the_detector_is_made_again_where_the_camera_bins():
    sizes = {"WidthMax": 64, "HeightMax": 48, "BinningHorizontal": 1, "BinningVertical": 1}
    source = ScriptedGrabber(
        Feature(name=name, kind=FeatureKind.INTEGER, access=AccessMode.READ_WRITE, value=value)
        for name, value in sizes.items()
    )
    made, noise = [], np.random.default_rng(1)

    def detector(frame):
        made.append(frame.frame_id)
        return Detector(types.SimpleNamespace(detect=lambda grey: []))

    def send(number):
        pixels = noise.integers(0, 256, (48, 64), np.uint8)
        source._fanout.put(dataclasses.replace(frame_of(pixels), frame_id=number))
        until(lambda: runner.images == number)

    runner = Runner(source, SimRobot(teo.MODEL), detector)
    runner.start()
    try:
        until(lambda: source._fanout.consumers)
        send(1)
        send(2)
        source.set("BinningVertical", 2)
        send(3)
        send(4)
        assert made == [1, 3]
    finally:
        runner.stop()


@pytest.fixture
def repeating(live):
    """A run whose camera sends the same pixels again and again from the moment on that `hang` is called."""
    runner, _, robot = live
    deliver, hung = runner._see, []

    def see(frame):
        if hung and hung[0] is None:
            hung[0] = frame
        return deliver(dataclasses.replace(hung[0], captured=frame.captured) if hung else frame)

    runner._see = see
    return runner, robot, lambda: hung.append(None)


def test_a_camera_that_sends_its_last_image_for_ever_moves_nothing(repeating):
    """The hand went on to where the marker had been, and the head turned after a face to its limit."""
    runner, robot, hang = repeating
    runner.start()
    until(lambda: runner.loop.machine.state is State.APPROACHING and robot.speed > 0.02)
    hang()
    until(lambda: runner.loop.machine.state is State.LOST)
    assert runner.loop.machine.reason == "the camera repeats its image"
    until(lambda: robot.speed == 0)
    images = runner.images
    time.sleep(0.2)
    assert runner.images == images


def test_the_report_of_a_run(tmp_path):
    recorder = report.RunRecorder(tmp_path / "out", closed_loop.calibration().scaled_to)
    for cycle in cycles_to_the_marker():
        recorder.add(cycle, None, None)
    written = recorder.finish({"true_error_mm": float("nan"), "limit_violations": 0})
    assert written["reached"]
    assert json.loads((tmp_path / "out/report.json").read_text())["true_error_mm"] is None
    assert written["seconds_to_reach"] > written["seconds_to_approach"]
    image = cv2.imread(str(tmp_path / "out/plots.png"))
    assert image.shape == (4 * plot_image.HEIGHT + plot_image.LEGEND, plot_image.WIDTH, 3)


def test_a_disk_that_is_full_costs_the_video_and_neither_run_nor_report(tmp_path, monkeypatch, caplog):
    recorder = report.RunRecorder(tmp_path, closed_loop.calibration().scaled_to)
    frame = frame_of(np.zeros((closed_loop.HEIGHT, closed_loop.WIDTH), np.uint8))

    def full(self, pixels, time):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(MovieFile, "add", full)
    for cycle in cycles_to_the_marker():
        recorder.add(cycle, frame, None)
    assert recorder.finish({})["reached"]
    assert json.loads((tmp_path / "report.json").read_text())["reached"]
    assert [record.message for record in caplog.records] == [
        "the report's video ends here: [Errno 28] No space left on device"
    ]


def test_plots_that_cannot_be_written_are_missed_aloud(tmp_path, caplog):
    recorder = report.RunRecorder(tmp_path, closed_loop.calibration().scaled_to)
    (tmp_path / "plots.png").mkdir()
    for cycle in cycles_to_the_marker():
        recorder.add(cycle, None, None)
    assert recorder.finish({})["reached"]
    assert [record.message for record in caplog.records] == [
        f"the report has no plots: [Errno 21] Is a directory: '{tmp_path / 'plots.png'}'"
    ]


def test_a_report_on_a_full_disk_is_named(tmp_path, monkeypatch):
    recorder = report.RunRecorder(tmp_path, closed_loop.calibration().scaled_to)

    def full(path, content):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(environment, "_write_and_rename", full)
    with pytest.raises(OSError, match="No space left") as failure:
        recorder.finish({})
    assert failure.value.filename == str(tmp_path / "report.json")


@pytest.mark.parametrize(
    ("output", "ends"), [("/dev/full", False), ("a pipe that nobody reads", True)], ids=["full", "closed"]
)
def test_states_that_cannot_be_printed_are_no_internal_error(output, ends, monkeypatch):
    """The loop ended with a traceback."""
    descriptor = os.open(output, os.O_WRONLY) if output == "/dev/full" else unread_pipe()
    outcome, cycle = command._Outcome(), cycles_to_the_marker()[0]
    with os.fdopen(descriptor, "w") as stdout:
        monkeypatch.setattr(sys, "stdout", stdout)
        outcome.note(cycle)
        monkeypatch.undo()
        os.dup2(os.open(os.devnull, os.O_WRONLY), descriptor)
    assert outcome.unread is ends


def unread_pipe():
    reader, writer = os.pipe()
    os.close(reader)
    return writer


def test_an_empty_run_has_a_report_too(tmp_path):
    recorder = report.RunRecorder(tmp_path, closed_loop.calibration().scaled_to)
    assert recorder.finish({})["reached"] is False
    assert not (tmp_path / "plots.png").exists()


def test_a_report_that_cannot_be_written_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match=r"cannot go to \S+: Not a directory$"):
        report.RunRecorder(tmp_path / "file" / "below", closed_loop.calibration().scaled_to)


def test_a_curve_is_drawn_where_its_values_are_and_gaps_stay_empty():
    values = [0.0] * 50 + [math.nan] * 50 + [10.0] * 50
    image = plot_image.sheet([plot_image.Plot("t", "u", (plot_image.Curve("c", values),))], range(150), [])
    red = image[30:190, :, 0].astype(int) - image[30:190, :, 1] > 60
    columns = red.any(axis=0)
    assert columns[80:350].mean() > 0.9
    assert not columns[380:640].any()
    assert columns[680:930].mean() > 0.9
    assert np.argmax(red[:, 100]) > np.argmax(red[:, 800])


def test_the_bands_colours_are_explained_once_each():
    red, blue = (230, 30, 30), (30, 30, 230)
    bands = [
        plot_image.Band(0, "lost", red),
        plot_image.Band(50, "found", blue),
        plot_image.Band(100, "lost", red),
    ]
    image = plot_image.sheet(
        [plot_image.Plot("t", "u", (plot_image.Curve("c", [0.0] * 150),))], range(150), bands
    )
    above, below = image[100], image[plot_image.HEIGHT + 10]
    for band in bands:
        shown = above[200 if band.name == "lost" else 500]
        place = np.flatnonzero((below == shown).all(axis=1))
        assert len(place) == 18
        assert np.ptp(place) == 17


@pytest.mark.parametrize(("low", "high"), [(0, 1), (-3, 250), (0.001, 0.0012), (5, 5)])
def test_ticks_are_round_and_few(low, high):
    marks = plot_image.ticks(low, high)
    assert 1 <= len(marks) <= 6
    assert all(low - 1e-9 <= mark <= high + 1e-9 for mark in marks)


def test_the_command_records_what_happens(tmp_path, capsys):
    folder = tmp_path / "out"
    for seconds in (2, 8, 30):  # a busy machine sees its first images late
        chosen = options("servo", "--headless", "--seconds", str(seconds), "--report", str(folder), "--steps")
        code = chosen.run(chosen)
        written = json.loads((folder / "report.json").read_text())
        if len(written["states"]) > 1:
            break
    assert (code == command.EXIT_NOT_REACHED) is not written["reached"]
    assert written["reached"] is False or seconds > 2, "in two seconds nothing can be reached"
    assert written["images"] > 0
    assert {step["state"] for step in written["states"]} >= {"lost", "centring"}
    video = cv2.VideoCapture(str(folder / "video.mp4"))
    assert video.get(cv2.CAP_PROP_FRAME_COUNT) > 0
    video.release()
    assert "centring" in capsys.readouterr().out


def test_a_command_that_ends_by_an_error_has_stopped_the_loop_before_it_closes_the_robot(monkeypatch):
    running = []

    def broken(runner):
        raise RuntimeError("no statistics")

    def closed(robot):
        running.extend(thread.name for thread in threading.enumerate() if thread.name.startswith("servo"))

    monkeypatch.setattr(command, "_timing", broken)
    monkeypatch.setattr(SimRobot, "close", closed)
    chosen = options("servo", "--headless", "--seconds", "0.1")
    with pytest.raises(RuntimeError, match="no statistics"):
        chosen.run(chosen)
    assert not running


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("--source", "sim:"), "is not calibrated"),
        (("--size", "0"), "0 m"),
        (("--dictionary", "3X3"), "no marker dictionary"),
    ],
)
def test_the_command_refuses_what_makes_no_sense(arguments, complaint):
    chosen = options("servo", "--headless", *arguments)
    with pytest.raises(UsageError, match=complaint):
        chosen.run(chosen)
