"""A robot in simulated time whose camera sees a projected target, with noise: for hand–eye calibration."""

import threading
from dataclasses import replace

import cv2
import numpy as np

from grabbergui.calibration import geometry
from grabbergui.calibration.marker_pose import MarkerDetection
from grabbergui.core.calibration import Calibration
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import by_name
from grabbergui.driver.sim.rendered_scene import board_pose
from grabbergui.servo.config import Config
from grabbergui.servo.gate import CommandGate
from grabbergui.servo.hand_eye.hand_eye_file import CameraMount
from grabbergui.servo.hand_eye.measurement import Guess, camera_from_target
from grabbergui.servo.hand_eye.run import HandEyeRun, arrangement
from grabbergui.servo.hand_eye.stand import HandEyeStand
from grabbergui.servo.robots import teo
from grabbergui.servo.robots.simulated import SimRobot

CAMERA = Calibration.from_field_of_view(1280, 960, 62)
GRID = np.array([(0.025 * x, 0.025 * y, 0.0) for y in range(-2, 3) for x in range(-3, 4)])
QUICK = Config(
    arm=replace(Config().arm, fastest=0.3, fastest_turn=80.0), loop=replace(Config().loop, rate=20.0)
)
"Faster, so that the simulation has fewer cycles."
FACING = np.diag([1.0, -1.0, -1.0])


class Bench:
    """Projects a target from the true joint angles, which are off by 0.2°; corners have 0.5 px of noise."""

    def __init__(self, eye, seed=0, config=None, model=teo.MODEL, head=(-0.42, 0.1)):
        random = self.random = np.random.default_rng(seed)
        self.now = 0.0
        self.model = model
        self.robot = SimRobot(self.model, lambda: self.now, head=head)
        self.arrangement = arrangement(eye, self.model)
        chain = self.arrangement.camera or self.arrangement.target
        self.off = np.radians(0.2) * random.choice((-1.0, 1.0), len(chain.low))
        start = self.robot.state()
        slip = np.concatenate((random.normal(0, 0.004, 3), random.normal(0, np.radians(1.5), 3)))
        on_hand = geometry.pose(geometry.rotation_from_vector((0.1, -0.2, 0.3)), (0.03, -0.05, 0.04))
        if eye == "head":
            camera = geometry.add_delta(model.camera, slip)
            target = board_pose() if model is teo.MODEL else _before(model.camera_pose(start.head))
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
        self.on_observation = lambda number: None
        "Called with how often the camera was asked, before it answers."
        self.observations = 0
        self.run = HandEyeRun(
            eye, self.robot, self.gate, self.observe, CAMERA, self.config,
            clock=lambda: self.now, pause=self.pause, report=self.said.append,
        )  # fmt: skip

    def pause(self, seconds):
        self.now += seconds
        self.gate.expire(self.now)

    def observe(self, after):
        self.observations += 1
        self.on_observation(self.observations)
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
        """The camera's pose as images can show it: the offset of the last joint is part of it."""
        only = np.zeros_like(self.off)
        place = 0 if self.eye == "fixed" else -1
        only[place] = self.off[place]
        at_rest, turned = self.chain.forward(0 * only), self.chain.forward(only)
        if self.eye == "fixed":
            return at_rest @ geometry.inverse(turned) @ self.truth.camera
        return geometry.inverse(at_rest) @ turned @ self.truth.camera


def _before(camera):
    """A board half a metre before a camera, tilted."""
    tilted = geometry.pose(geometry.rotation_from_vector((0.3, 0.25, 0.0)))
    return camera @ geometry.pose(FACING, (0.0, 0.0, 0.6)) @ tilted


class BenchWatch:
    """Stands in for a `TargetWatch`: each observation shows a frame."""

    calibration, nominal = CAMERA, False

    def __init__(self, bench, seen):
        self.bench, self._seen, self.closed = bench, seen, False
        self._show(MarkerDetection(0, np.float64([(10, 10), (90, 10), (90, 70), (10, 70)])))

    def __call__(self, after):
        found = self.bench.observe(after)
        self._show(found)
        return found

    def _show(self, found):
        self._seen(Frame(np.zeros(80 * 60, np.uint8), 80, 60, by_name("Mono8"), 1), found)

    def close(self, timeout=None):
        self.closed = True
        return True


class BenchStand(HandEyeStand):
    """A stand in the bench's time."""

    def __init__(self, bench):
        self.bench = bench
        super().__init__(
            bench.robot, bench.gate, bench.config, None, None, lambda eye: CameraMount(eye, "mount", "eye"),
            bench.eye, clock=lambda: bench.now, pause=bench.pause,
        )  # fmt: skip

    def watch(self, eye, marker, seen, failed, between):
        return BenchWatch(self.bench, seen)


class Turnstile:
    """Holds the robot at one observation, by its number, until `left` is set."""

    def __init__(self, bench, number):
        self.reached, self.left, self._number = threading.Event(), threading.Event(), number
        bench.on_observation = self._wait

    def _wait(self, number):
        if number == self._number:
            self.reached.set()
            self.left.wait(60)
