"""The model of the hand–eye wizard, on robots in simulated time: accuracy, stops, faults, and its result."""

import threading

import numpy as np
import pytest

from grabbergui.calibration import geometry
from grabbergui.core.errors import FrameTimeoutError, SourceUnavailableError, UsageError
from grabbergui.servo.config import MarkerConfig
from grabbergui.servo.hand_eye import hand_eye_file
from grabbergui.servo.hand_eye import stand as hand_eye_stand
from grabbergui.servo.hand_eye.run import EYES, HandEyeRun, Progress, Skip, Step
from grabbergui.servo.models.hand_eye import HandEyeModel, Setup
from grabbergui.servo.models.hand_eye_text import (
    duration_text,
    plan_text,
    progress_text,
    roll_pitch_yaw,
    signed,
    with_spread,
)
from grabbergui.servo.robots import teo
from hand_eye_bench import Bench, BenchStand, Turnstile
from patience import until

VIEWS = 10
FEW = 5


class Stand:
    """A model on a bench, and all it says."""

    def __init__(self, bench, views=FEW):
        self.bench, self.stand = bench, BenchStand(bench)
        self.model = HandEyeModel(self.stand)
        self.happened, self.solved, self.ended, self.failed, self.published = [], [], [], [], []
        self.model.happened.connect(self.happened.append)
        self.model.solved.connect(self.solved.append)
        self.model.ended.connect(lambda text, enough: self.ended.append((text, enough)))
        self.model.failed.connect(self.failed.append)
        self.model.published.connect(self.published.append)
        self.model.open()
        self.model.choose(Setup(bench.eye, bench.config.marker, views))

    def run(self):
        self.model.start()
        while self.model.running:
            self._await_progress(self.bench.now)
        return self

    def _await_progress(self, now):
        """A minute of a robot with seven joints is seconds of computing, on a busy machine many."""
        until(lambda: not self.model.running or self.bench.now > now, "progress in simulated time")

    @property
    def problem(self):
        return until(lambda: self.ended)[-1][0]


@pytest.fixture
def stand():
    """Make stands, close them, and see that nothing of them goes on."""
    before, made = set(threading.enumerate()), []

    def make(bench, views=FEW):
        made.append(Stand(bench, views))
        return made[-1]

    yield make
    for one in made:
        assert one.model.close(60)
        assert one.bench.robot.speed < 1e-3
        one.stand.close()
    until(lambda: set(threading.enumerate()) <= before)


@pytest.mark.parametrize("eye", EYES)
def test_the_camera_is_found_within_a_millimetre_and_a_half(stand, eye):
    bench = Bench(eye, model=teo.MODEL, head=(-0.42, 0.1))
    wizard = stand(bench, VIEWS).run()
    assert not wizard.ended
    result, true = wizard.solved[0].result, bench.true_camera()
    metres, radians = geometry.distance(result.camera, true), geometry.angle_between(result.camera, true)
    assert 1e3 * metres < 1.5
    assert np.degrees(radians) < 0.15
    assert metres < 4 * result.uncertainty[0]
    assert len(wizard.solved[0].joints) == len(result.errors) == VIEWS
    assert bench.robot.limit_violations == 0
    assert bench.gate.halted, "nothing moves after a run"
    assert [event.step for event in wizard.happened].count(Step.VIEW) == VIEWS


@pytest.mark.parametrize("number", [1, 4], ids=["before it moves", "while it moves"])
def test_a_stop_ends_the_run_at_once(stand, number):
    bench = Bench("head")
    turnstile, wizard = Turnstile(bench, number), stand(bench)
    wizard.model.start()
    assert turnstile.reached.wait(60)
    wizard.model.stop()
    until(lambda: bench.gate.halted)
    sent = bench.gate.sent
    turnstile.left.set()
    assert wizard.problem.startswith(f"Stopped. The robot stands still. Poses taken: {number - 1};")
    assert bench.gate.sent == sent
    assert wizard.ended[0][1] is False


def test_a_stop_before_the_release_of_the_gate_holds(stand):
    bench = Bench("head")
    wizard = stand(bench)
    release = bench.gate.release

    def late(stops):
        wizard.model.stop()
        until(lambda: bench.gate.halted)
        release(stops)

    bench.gate.release = late
    wizard.run()
    assert "Stopped" in wizard.problem
    assert bench.gate.sent == 0


def test_a_stop_from_elsewhere_ends_the_run_and_names_its_reason(stand):
    bench = Bench("head")
    bench.on_observation = lambda number: number == 3 and bench.gate.halt("stopped over YARP")
    wizard = stand(bench).run()
    assert "stopped over YARP" in wizard.problem


def test_a_stop_from_elsewhere_keeps_its_reason_if_the_user_stops_too(stand):
    bench = Bench("head")
    turnstile, wizard = Turnstile(bench, 3), stand(bench)
    wizard.model.start()
    assert turnstile.reached.wait(60)
    bench.gate.halt("stopped over YARP")
    wizard.model.stop()
    until(lambda: bench.gate.stops == 2)
    turnstile.left.set()
    assert wizard.problem.startswith("the robot is stopped: stopped over YARP. The robot stands still.")
    assert bench.gate.halted == "stopped over YARP"


def test_a_fault_keeps_its_reason_if_the_user_stops_too(stand):
    bench = Bench("head")
    wizard = stand(bench)

    def fail(number):
        wizard.model.stop()
        until(lambda: bench.gate.halted)
        raise FrameTimeoutError("no image arrived within 5 s: check camera and cable")

    bench.on_observation = fail
    assert wizard.run().problem.startswith("no image arrived within 5 s: check camera and cable.")


def test_the_views_of_a_stopped_run_can_be_computed(stand):
    bench = Bench("head")
    turnstile, wizard = Turnstile(bench, FEW + 3), stand(bench, 12)
    wizard.model.start()
    assert turnstile.reached.wait(60)
    wizard.model.stop()
    turnstile.left.set()
    assert "compute from them" in wizard.problem
    assert wizard.ended[0][1] is True
    wizard.model.compute()
    until(lambda: wizard.solved)
    assert len(wizard.solved[0].joints) >= FEW


def test_a_computation_that_fails_ends_with_a_sentence(stand, monkeypatch):
    def fail(run):
        raise ZeroDivisionError("oops")

    monkeypatch.setattr(HandEyeRun, "solve", fail)
    wizard = stand(Bench("head")).run()
    wizard.model.compute()
    until(lambda: len(wizard.ended) == 2)
    for sentence, _ in wizard.ended:
        assert sentence.startswith("internal error, see the log: oops. The robot stands still.")
    assert not wizard.model.running


def _lost_images(bench):
    def fail(number):
        if number == 3:
            raise FrameTimeoutError("no image arrived within 5 s: check camera and cable")

    bench.on_observation = fail


def _lost_robot(bench):
    observe = bench.observe

    def observe_last(after):
        found = observe(after)
        if bench.observations == 3:
            bench.robot.state = lambda: None
        return found

    bench.observe = observe_last


def _no_target(bench):
    bench.observe = lambda after: None


def _no_guardian(bench):
    def refuse(stops):
        raise SourceUnavailableError("the guardian ended")

    bench.gate.release = refuse


def _fault(bench):
    def fail(number):
        raise ZeroDivisionError("oops")

    bench.on_observation = fail


@pytest.mark.parametrize(
    ("spoil", "sentence"),
    [
        (
            _lost_images,
            "no image arrived within 5 s: check camera and cable. The robot stands still. Poses taken: 1;",
        ),
        (_lost_robot, "simulated TEO does not report its joints. The robot stands still."),
        (_no_target, "the target is not seen: bring it into the middle of the image first. The robot stands"),
        (_no_guardian, "the guardian ended. The robot stands still."),
        (_fault, "internal error, see the log: oops"),
    ],
)
def test_every_fault_ends_with_a_sentence_and_a_robot_at_rest(stand, spoil, sentence):
    bench = Bench("head")
    spoil(bench)
    wizard = stand(bench).run()
    assert wizard.problem.startswith(sentence)
    assert bench.gate.halted


def test_too_few_poses_that_show_the_target_are_a_sentence(stand):
    bench = Bench("head")
    observe = bench.observe
    bench.observe = lambda after: observe(after) if bench.observations == 0 else None
    wizard = stand(bench).run()
    assert "only 0 of 5 views were possible" in wizard.problem
    assert "needed: 5. Start again" in wizard.problem
    skipped = [event for event in wizard.happened if event.step is Step.SKIPPED]
    assert skipped[0].text == "skipped: the target is not seen reliably"


def test_closing_while_the_robot_moves_stops_it(stand):
    bench = Bench("head")
    turnstile, wizard = Turnstile(bench, 3), stand(bench)
    wizard.model.start()
    assert turnstile.reached.wait(60)
    wizard.model.close()
    until(lambda: bench.gate.halted)
    sent = bench.gate.sent
    turnstile.left.set()
    assert wizard.model.close(60)
    assert bench.gate.sent == sent


def test_a_result_is_compared_saved_and_used(stand, tmp_path):
    bench = Bench("head")
    wizard = stand(bench).run()
    model, solution = wizard.model, wizard.solved[0]
    origin, metres, _ = solution.compared
    assert origin == "model"
    assert metres == pytest.approx(geometry.distance(bench.model.camera, solution.result.camera))
    saved = []
    model.saved.connect(saved.append)
    model.save(tmp_path / "robot.yaml", solution.placement)
    until(lambda: saved)
    assert hand_eye_file.load(saved[0]).camera == pytest.approx(solution.result.camera)
    assert hand_eye_file.load(saved[0]).method == solution.result.method != ""
    assert wizard.stand.in_use("head")[0] == str(saved[0])
    assert wizard.stand.in_use("hand") is None
    model.use(True)
    assert bench.robot.placed.camera is solution.result.camera
    assert wizard.stand.in_use("head")[0] == "robot"
    model.use(False)
    assert bench.robot.placed is None
    model.save(tmp_path / "missing" / "robot.yaml", solution.placement)
    assert "could not be saved" in until(lambda: wizard.failed)[0]


def test_a_result_is_published_until_it_is_withdrawn(stand, monkeypatch):
    frames = []

    class Frame:
        def __init__(self, *arguments):
            self.arguments, self.opened = arguments, None
            frames.append(self)

        def open(self):
            if len(frames) > 1:
                raise SourceUnavailableError("the ROS 2 package tf2_msgs is not installed")
            self.opened = True

        def close(self):
            self.opened = False

    monkeypatch.setattr(hand_eye_stand, "StaticFrame", Frame)
    wizard = stand(Bench("head")).run()
    placement = wizard.solved[0].placement
    wizard.model.publish(True, placement)
    until(lambda: wizard.published == [True])
    assert frames[0].arguments[:2] == ("mount", "eye")
    assert frames[0].opened
    wizard.model.publish(False, placement)
    until(lambda: wizard.published == [True, False])
    assert frames[0].opened is False
    wizard.model.publish(True, placement)
    until(lambda: wizard.published == [True, False, False])
    assert "tf2_msgs" in wizard.failed[0]


def test_a_board_that_cannot_be_is_refused_and_a_dry_run_does_not_begin(stand):
    bench = Bench("head")
    wizard = stand(bench)
    with pytest.raises(UsageError, match="overlap"):
        wizard.model.choose(Setup("head", MarkerConfig(kind="charuco", size=0.05, pitch=0.02)))
    bench.gate._dry_run = True
    assert "dry run" in wizard.model.why_not()
    assert "dry run" in wizard.run().problem


def test_the_plan_tells_what_the_robot_will_do(stand):
    head, hand = stand(Bench("head"), 18).model, stand(Bench("hand"), 18).model
    text = plan_text(head.plan(), "simulated TEO")
    assert "<b>Simulated TEO will move by itself</b> to 18 poses" in text
    assert "Pan stays within −73° to 73°" in text
    assert "the arm rests" in text
    text = plan_text(hand.plan(), "TEO", nominal=True)
    assert "Each joint stays within 40°" in text
    assert "6 small moves of at most 7°" in text
    assert "z −0.30 to 0.95 m" in text
    assert "30 mm away from body" in text
    assert "not calibrated" in text


def test_events_and_figures_are_written_for_people():
    skip = Progress(1, 9, "", Step.SKIPPED, Skip.OBSTRUCTED, "it would be outside the workspace")
    assert progress_text(skip) == "skipped: it would be outside the workspace"
    assert progress_text(Progress(1, 9, "", Step.SKIPPED, Skip.NOT_REACHED)) == "skipped: it was not reached"
    known = Progress(6, 9, "", Step.KNOWN, known=(0.0012, 0.001))
    assert progress_text(known) == "known to 1.2 mm and 0.06°"
    assert [duration_text(seconds) for seconds in (2, 31, 70, 200)] == [
        "about 5 s", "about 30 s", "about 1 min", "about 3 min",
    ]  # fmt: skip
    assert [signed(value, 1) for value in (-0.01, 0.04, -2.0)] == ["0.0", "0.0", "−2.0"]
    spreads = (0.4, 0.06, 0.0001, 0.0, 12.0)
    assert [with_spread(30.0123, spread, 1).replace("\u00a0", " ") for spread in spreads] == [
        "30.0 ± 0.4", "30.01 ± 0.06", "30.012 ± 0.000", "30.0 ± 0.0", "30.0 ± 12.0",
    ]  # fmt: skip
    turned = geometry.pose(geometry.rotation_from_vector((0, 0, np.pi / 2)))
    assert roll_pitch_yaw(turned) == pytest.approx((0, 0, 90))
