"""Hand–eye calibration on a simulated robot, through the gate: joints off by 0.2°, corners by 0.5 px."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from grabbergui.calibration import geometry
from grabbergui.calibration.hand_eye_model import Guess, camera_from_target
from grabbergui.calibration.markers import MarkerDetection
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import SourceUnavailableError, UsageError
from grabbergui.driver.sim.rendered.scene import board_pose
from grabbergui.servo.config import Config
from grabbergui.servo.gate import CommandGate
from grabbergui.servo.hand_eye_run import EYES, HandEyeRun, arrangement
from grabbergui.servo.robots import teo
from grabbergui.servo.robots.simulated import SimRobot

CAMERA = Calibration.from_field_of_view(1280, 960, 62)
GRID = np.array([(0.025 * x, 0.025 * y, 0.0) for y in range(-2, 3) for x in range(-3, 4)])
VIEWS = 10
QUICK = Config(
    arm=replace(Config().arm, fastest=0.3, fastest_turn=80.0), loop=replace(Config().loop, rate=20.0)
)
"Faster, so that the simulation has fewer cycles."
FACING = np.diag([1.0, -1.0, -1.0])


class Bench:
    """TEO in simulated time, with a target that is projected as its joints really are, and noise."""

    def __init__(self, eye, seed=0, config=None):
        random = self.random = np.random.default_rng(seed)
        self.now = 0.0
        self.model = teo.MODEL
        self.robot = SimRobot(self.model, lambda: self.now, head=(-0.42, 0.1))
        self.arrangement = arrangement(eye, self.model)
        chain = self.arrangement.camera or self.arrangement.target
        self.off = np.radians(0.2) * random.choice((-1.0, 1.0), len(chain.low))
        start = self.robot.state()
        slip = np.concatenate((random.normal(0, 0.004, 3), random.normal(0, np.radians(1.5), 3)))
        on_hand = geometry.pose(geometry.rotation_from_vector((0.1, -0.2, 0.3)), (0.03, -0.05, 0.04))
        if eye == "head":
            camera, target = geometry.add_delta(teo.CAMERA_ON_HEAD, slip), board_pose()
        elif eye == "hand":
            camera, target = on_hand, start.hand @ on_hand @ geometry.pose(FACING, (0, 0, 0.45))
        else:
            target = on_hand
            camera = start.hand @ target @ geometry.inverse(geometry.pose(FACING, (0, 0, 0.6)))
        nothing = np.zeros(0)
        offsets = (nothing, self.off) if eye == "fixed" else (self.off, nothing)
        self.truth = Guess(camera, target, *offsets)
        self.eye, self.chain = eye, chain
        self.config = config or QUICK
        self.gate = CommandGate(self.robot, self.config)
        self.said = []
        self.run = HandEyeRun(
            eye, self.robot, self.gate, self.look, CAMERA, self.config,
            clock=lambda: self.now, pause=self.pause, report=self.said.append,
        )  # fmt: skip

    def pause(self, seconds):
        self.now += seconds
        self.gate.expire(self.now)

    def look(self, after):
        state, nothing = self.robot.state(), np.zeros(0)
        angles = state.head if self.eye == "head" else state.arm
        both = (nothing, angles) if self.eye == "fixed" else (angles, nothing)
        pose = camera_from_target(self.arrangement, self.truth, *both)
        if (GRID @ pose[:3, :3].T + pose[:3, 3])[:, 2].min() < 0.05:
            return None
        turn = geometry.vector_from_rotation(pose[:3, :3])
        pixels = cv2.projectPoints(GRID, turn, pose[:3, 3], CAMERA.matrix, np.zeros(5))[0].reshape(-1, 2)
        if (pixels < 0).any() or (pixels > (1280, 960)).any():
            return None
        noisy = pixels + self.random.normal(0, 0.5, pixels.shape)
        return MarkerDetection(0, pixels[[0, 6, 34, 28]], pose, points=GRID, pixels=noisy)

    def true_camera(self):
        """Where images can tell the camera to be: the offset that turns it alone is part of it."""
        only = np.zeros_like(self.off)
        place = 0 if self.eye == "fixed" else -1
        only[place] = self.off[place]
        at_rest, turned = self.chain.forward(0 * only), self.chain.forward(only)
        if self.eye == "fixed":
            return at_rest @ geometry.inverse(turned) @ self.truth.camera
        return geometry.inverse(at_rest) @ turned @ self.truth.camera


@pytest.mark.parametrize("eye", EYES)
def test_the_camera_is_found_by_a_robot_that_moves_itself(eye):
    bench = Bench(eye)
    result = bench.run.run(VIEWS)
    true = bench.true_camera()
    assert 1e3 * geometry.distance(result.camera, true) < 1.5
    assert np.degrees(geometry.angle_between(result.camera, true)) < 0.15
    assert geometry.distance(result.camera, true) < 4 * result.uncertainty[0]
    assert bench.robot.limit_violations == 0
    assert not bench.gate.expire(bench.now + 1), "it rests"
    assert bench.said[-1].views == VIEWS


def test_the_arm_keeps_away_from_obstacles_while_it_calibrates():
    table = "table 0.2 0.9 -0.9 0.3 -0.6 0.10"
    config = replace(QUICK, safety=replace(QUICK.safety, obstacles=table))
    bench = Bench("fixed", config=config)
    distances, pause = [], bench.run._pause

    def watch(seconds):
        pause(seconds)
        distances.append(bench.gate._nearest(teo.BODY, bench.robot.state().arm).distance)

    bench.run._pause = watch
    bench.run.run(7)
    assert min(distances) > 0
    assert any("table" in progress.text for progress in bench.said)


def test_poses_that_are_obstructed_are_named():
    gate = Bench("hand").gate
    assert gate.obstruction(teo.HOME) == ""
    assert "workspace" in gate.obstruction(np.zeros(6))


@pytest.mark.parametrize(
    ("end", "complaint"),
    [
        (lambda bench: bench.gate.halt("the button"), "stopped: the button"),
        (lambda bench: bench.run.cancel(), "cancelled"),
        (lambda bench: setattr(bench.robot, "state", lambda: None), "does not report its joints"),
    ],
    ids=["stop", "cancel", "silent"],
)
def test_a_run_that_is_ended_leaves_the_robot_at_rest(end, complaint):
    bench = Bench("head")
    look, looks = bench.look, []

    def count(after):
        looks.append(look(after))
        if len(looks) == 3:
            end(bench)
        return looks[-1]

    bench.run._look = count
    with pytest.raises(SourceUnavailableError, match=complaint):
        bench.run.run(VIEWS)
    assert bench.robot.speed < 1e-3
    assert not bench.gate._moving


def test_a_target_that_is_not_seen_is_asked_for_before_anything_moves():
    bench = Bench("hand")
    bench.run._look = lambda after: None
    with pytest.raises(UsageError, match="target is not seen"):
        bench.run.run(VIEWS)
    assert bench.gate.sent == 0


def test_an_arm_that_does_not_report_its_angles_is_refused():
    bench = Bench("fixed")
    state = bench.robot.state
    bench.robot.state = lambda: replace(state(), arm=None)
    with pytest.raises(UsageError, match="angles of its arm"):
        bench.run.run(VIEWS)


def test_a_place_that_cannot_be_is_refused():
    with pytest.raises(UsageError, match="head, hand, fixed"):
        arrangement("knee", teo.MODEL)
