"""Closed-loop simulation: a simulated robot in a room, with a simulated camera on its head.

`mounted_camera` is the camera in real time, behind the usual grabber. `ClosedLoop` closes the same loop in
simulated time, so that a run can be repeated to the bit: through rendered frames and their detection, or, for
thousands of runs, through detections that are computed from the true poses.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from typing_extensions import override

from grabbergui.calibration import geometry
from grabbergui.calibration.geometry import Pose, Vector
from grabbergui.calibration.marker_pose import MarkerDetection
from grabbergui.calibration.markers import dictionary_number
from grabbergui.core.calibration import Calibration
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.pfnc import by_name
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim import rendered_scene
from grabbergui.driver.sim.device import SimulatedDevice
from grabbergui.driver.sim.memory import Register, RegisterValue
from grabbergui.driver.sim.model import CameraModel
from grabbergui.driver.sim.rendered_scene import RenderedScene, Things
from grabbergui.driver.sim.sensor import Sensor
from grabbergui.driver.sim.settings import FrameSettings, Optics
from grabbergui.servo.config import Config, MarkerConfig
from grabbergui.servo.detection import Detector, Sighting, marker_detector
from grabbergui.servo.face_detectors import face_detector
from grabbergui.servo.face_search import FaceSearch
from grabbergui.servo.gate import CommandGate
from grabbergui.servo.kinematics import Chain
from grabbergui.servo.loop import ControlCycle, ServoLoop
from grabbergui.servo.robots import teo
from grabbergui.servo.robots.faults import STRANGER_PERIOD, Faults, ImageFaults
from grabbergui.servo.robots.robot import KinematicModel, RobotState
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.state_machine import State

if TYPE_CHECKING:
    from grabbergui.driver.sim.gige.server import GigeCamera

BINNING = 4
WIDTH, HEIGHT = 608, 512
"Size of the images: the middle of the sensor, binned; 64° wide."
OFFSET_X = (reg.SENSOR_WIDTH // BINNING - WIDTH) // 2
OFFSET_Y = (reg.SENSOR_HEIGHT // BINNING - HEIGHT) // 2
EXPOSURE_US = 8000.0
DRAWN_AHEAD_S = 0.012
"""Seconds before its exposure ends at which an image is drawn, for where the robot will be by then.

Drawing takes half of that, and would otherwise come on top of what a real camera takes to deliver an image.
"""
AT_BOARD = (-0.42, 0.1)
"Pan and tilt, radians, at which TEO looks at the board that the person holds."
ON_HAND = geometry.pose(geometry.rotation_from_vector((0.1, -0.2, 0.3)), (0.03, -0.05, 0.04))
"Pose on the hand of a camera or a target."
IN_VIEW_M = 0.8
"Metres before the camera at which the simulated board is put into its view."
SHEET_PIXELS = 960
"Along the longer edge of a printed board's drawing."


def settings(pixel_format: str = "Mono8") -> FrameSettings:
    """Return the settings of the camera on the head."""
    ratios = (1.0, 1.0, 1.0) if pixel_format == "Mono8" else (1.6, 1.0, 1.3)
    optics = Optics(binning_horizontal=BINNING, binning_vertical=BINNING, ratios=ratios)
    return FrameSettings(
        WIDTH, HEIGHT, OFFSET_X, OFFSET_Y, by_name(pixel_format), optics, EXPOSURE_US, 0.0, 2.0
    )


def calibration() -> Calibration:
    """Return that camera's exact calibration."""
    return Calibration(
        WIDTH, HEIGHT, rendered_scene.pinhole(settings()), np.zeros(5), "camera on the simulated head"
    )


def things_for(marker: MarkerConfig, things: Things | None = None) -> Things:
    """The room's things, with the marker or the pattern that is looked for printed on the board."""
    things, board = things or Things(), marker.board
    if board is None:
        number = dictionary_number(marker.dictionary)
        things.sheet = rendered_scene.marker_sheet(number, marker.id, marker.size)
    else:
        things.sheet = rendered_scene.pattern_sheet(
            board.image(SHEET_PIXELS / max(board.extent)), *board.extent
        )
    return things


def detector(config: Config, of: Calibration, *, real_time: bool = False) -> Detector:
    """Return the detector of the configured markers or the board, and of faces.

    In real time whole images are searched for faces on a thread of its own.
    """
    faces = face_detector(of, config.faces.detector)
    if real_time:
        faces = FaceSearch(faces, face_detector(of, config.faces.detector))
    return Detector(marker_detector(config.marker, of), faces)


def mounted_camera(
    robot: SimRobot,
    things: Things,
    fps: float = 30.0,
    camera_at: Callable[[float], Pose] | None = None,
) -> FrameGrabber:
    """Return a simulated camera in real time, like any other grabber.

    It is on the robot's head unless `camera_at` gives its pose in the room at a time.
    """
    from grabbergui.driver.device_grabber import DeviceGrabber

    scene = RenderedScene(things)
    model = CameraModel(scene=scene, power_on=_power_on(fps))
    _mount(scene, camera_at or robot.camera_at, lambda: model)
    info = DeviceInfo(uri="sim:scene", model="Camera on the simulated head", bus="Simulated")
    return DeviceGrabber(SimulatedDevice(info, model))


def gige_camera(
    address: str, things: Things, camera_at: Callable[[float], Pose], fps: float = 30.0
) -> GigeCamera:
    """Return the same camera as a GigE Vision device at an address; close it.

    `camera_at` gives its pose in the room at a time. Raises SourceUnavailableError if the address is taken.
    """
    from grabbergui.driver.sim.gige.server import GigeCamera

    scene = RenderedScene(things)
    # Pacing wakes the interpreter for every few packets, and the robots are simulated in the same one. The
    # small frames fit into the receiver's buffer without.
    power_on = {**_power_on(fps), reg.PIXEL_FORMAT: by_name("BayerRG8").code}
    camera = GigeCamera(address, power_on=power_on, scene=scene, bandwidth=0, segmentation=True)
    _mount(scene, camera_at, lambda: camera.model)
    return camera


def _power_on(fps: float) -> dict[Register, RegisterValue]:
    chosen = settings()
    return {
        reg.BINNING_HORIZONTAL: BINNING,
        reg.BINNING_VERTICAL: BINNING,
        reg.OFFSET_X: chosen.offset_x,
        reg.OFFSET_Y: chosen.offset_y,
        reg.WIDTH: chosen.width,
        reg.HEIGHT: chosen.height,
        reg.PIXEL_FORMAT: by_name("RGB8").code,
        reg.FRAME_RATE: fps,
        reg.EXPOSURE_TIME: min(EXPOSURE_US, 0.9e6 / fps),
    }


def _mount(
    scene: RenderedScene, camera_at: Callable[[float], Pose], model: Callable[[], CameraModel]
) -> None:
    def pose(device_ns: int) -> Pose:
        # The device's clock is another than the robot's, and may be set: only its differences count.
        age = (model().timestamp() - device_ns) * 1e-9
        return camera_at(time.monotonic() - age + EXPOSURE_US * 0.5e-6)

    scene.mount(pose, DRAWN_AHEAD_S)


def hand_eye_camera(
    robot: SimRobot, marker: MarkerConfig, eye: str, *, in_view: bool = False
) -> FrameGrabber:
    """A simulated camera on head or hand, or standing, with a target before it: for hand–eye calibration.

    For the head it is the board that the person holds; `in_view`, it is where the head looks now.
    """
    stands, hand = robot.model.stands, robot.state().hand
    before = geometry.pose(np.diag([1.0, -1.0, -1.0]), (0.0, 0.0, 0.45))
    if eye == "head":
        board = rendered_scene.board_pose()
        if in_view:
            tilted = geometry.pose(geometry.rotation_from_vector((0.3, 0.25, 0.0)))
            ahead = geometry.pose(before[:3, :3], (0.0, 0.0, IN_VIEW_M))
            board = robot.camera_at(math.inf) @ ahead @ tilted
        return mounted_camera(robot, things_for(marker, Things(lambda _: None, lambda _: board)))
    if eye == "hand":
        board = stands @ hand @ ON_HAND @ before
        things = things_for(marker, Things(lambda _: None, lambda _: board))
        return mounted_camera(robot, things, camera_at=lambda _: stands @ robot.state().hand @ ON_HAND)
    camera = stands @ hand @ ON_HAND @ geometry.inverse(before)
    held = Things(lambda _: None, lambda _: stands @ robot.state().hand @ ON_HAND)
    return mounted_camera(robot, things_for(marker, held), camera_at=lambda _: camera)


FACING = math.cos(math.radians(75))
"Cosine of the largest angle between a marker's normal and the line of sight at which it is detected."


def computed_sighting(camera: Pose, board: Pose | None, marker: MarkerConfig, captured: float) -> Sighting:
    """Return what a perfect detector finds in an image of that camera: the single marker, if it is visible.

    `camera` and `board` are poses in the room; `board` is None while there is none.
    """
    if board is None:
        return Sighting(captured)
    seen, half = geometry.inverse(camera) @ board, marker.size / 2
    printed = np.array([[-half, half, 0, 1], [half, half, 0, 1], [half, -half, 0, 1], [-half, -half, 0, 1]])
    corners = printed @ seen.T[:, :3]
    facing = -float(seen[:3, 2] @ seen[:3, 3]) / float(np.linalg.norm(seen[:3, 3]))
    if (corners[:, 2] <= 0).any() or facing < FACING:
        return Sighting(captured)
    projected = corners @ rendered_scene.pinhole(settings()).T
    pixels = projected[:, :2] / projected[:, 2:]
    if ((pixels < 0) | (pixels > (WIDTH - 1, HEIGHT - 1))).any():
        return Sighting(captured)
    return Sighting(captured, (MarkerDetection(marker.id, pixels, seen),))


def looking_at(model: KinematicModel, thing: Pose) -> tuple[float, float]:
    """Return pan and tilt, radians, that bring something in the base nearest to the middle of the image."""
    head = model.head

    def off(pan: float, tilt: float) -> float:
        seen = geometry.inverse(model.camera_pose(np.array((pan, tilt)))) @ thing[:, 3]
        return math.acos(min(max(seen[2] / float(np.linalg.norm(seen[:3])), -1.0), 1.0))

    directions = [(float(pan), float(tilt)) for pan in _spread(head, 0) for tilt in _spread(head, 1)]
    return min(directions, key=lambda direction: off(*direction))


def _spread(head: Chain, joint: int) -> Vector:
    return np.linspace(head.low[joint], head.high[joint], 25)


def in_base(robot: SimRobot, thing: Pose) -> Pose:
    """Return a pose in the room as seen from the robot's base."""
    return geometry.inverse(robot.model.stands) @ thing


class _HeardRobot(SimRobot):
    """A simulated robot as its client hears it: a stranger's readings arrive among its own."""

    HEARD = 1 / 3
    "Share of its own readings: it sends 100 a second, the stranger 200."

    @override
    def state(self) -> RobotState:
        own = super().state()
        false = self.faults.false_reading(own.time)
        return own if false is None or self.faults.random.random() < self.HEARD else false


@dataclass
class ClosedLoop:
    """A run in simulated time. Set it up, then `run`."""

    model: KinematicModel = teo.MODEL
    config: Config = field(default_factory=Config)
    things: Things = field(default_factory=Things)
    head: tuple[float, float] = (0.0, 0.0)
    "First pan and tilt, radians."
    arm: Vector | None = None
    fps: float = 25.0
    latency: float = 0.04
    "Seconds from the middle of an exposure until its detections are known."
    now: float = 0.0
    loss: float = 0.0
    "Share of the frames that are lost."
    light: Callable[[float], float] = lambda seconds: 1.0
    "Brightness of the room at a time, relative to the exposure's."
    seed: int = 0
    "Seed of the lost frames."
    rendered: bool = True
    """Whether frames are rendered and searched. Otherwise the single marker's pose is computed, and there are
    no faces: an approach then takes a tenth of a second instead of three."""
    faults: Faults = field(default_factory=Faults)
    "Injected faults of the robot, its camera and strangers."

    def __post_init__(self) -> None:
        things = things_for(self.config.marker, self.things)
        self.robot = _HeardRobot(self.model, lambda: self.now, self.head, self.arm, self.faults)
        self.loop = ServoLoop(self.config, self.robot)
        self.gate = CommandGate(self.robot, self.config)
        self.camera_runs = True
        self.cycles: list[ControlCycle] = []
        if self.rendered:
            self._settings = settings()
            scene = RenderedScene(things)
            scene.mount(lambda time_ns: self.robot.camera_at(time_ns * 1e-9))
            self._sensor = Sensor(scene)
            self._detector = detector(self.config, calibration())
        self._next_frame, self._frames = self.now, 0
        self._random = np.random.default_rng(self.seed)
        self._on_the_way: list[tuple[float, Sighting]] = []
        self._image_faults: ImageFaults[Sighting] = ImageFaults(
            self.faults,
            lambda sighting, now: replace(sighting, captured=now),
            # A detector finds no marker in any of these images.
            lambda sighting, _: Sighting(sighting.captured),
        )

    def run(self, seconds: float, until: object = None) -> ControlCycle:
        """Let time pass, or run until the state is `until`; return the last cycle."""
        end = self.now + seconds
        while self.now < end - 1e-9:
            cycle = self.cycle()
            if until is not None and cycle.state is until:
                break
        return self.cycles[-1]

    def cycle(self) -> ControlCycle:
        """Run one control cycle and let its period pass; return it."""
        if self.now >= self._next_frame - 1e-9:
            self._expose(self._next_frame)
        while self._on_the_way and self._on_the_way[0][0] <= self.now + 1e-9:
            self.loop.see(self._on_the_way.pop(0)[1])
        cycle = self.loop.cycle(self.now, self.robot.state())
        if cycle.state is State.STOPPED and not self.gate.halted:
            self.gate.halt(cycle.reason)
        self.gate.send(cycle.command, self.now)
        self.loop.held_back(self.gate.hindrance)
        if self.gate.halted:
            self.loop.machine.stop(self.now, self.gate.halted)
        self.cycles.append(cycle)
        self._pass(1 / self.config.loop.rate)
        self.gate.expire(self.now)
        self.gate.beat(self.now)
        return cycle

    def _pass(self, seconds: float) -> None:
        """Let time pass, in which a second master may send commands."""
        end = self.now + seconds
        while self.now < end - STRANGER_PERIOD:
            self.now += STRANGER_PERIOD
            twist = self.faults.master_twist(self.now)
            if twist is not None:
                self.robot.obey_stranger(twist)
        self.now = end

    def true_error(self) -> tuple[float, float]:
        """Return metres and radians from the hand to the goal of the board's true pose."""
        board = self.things.board(self.now)
        if board is None:
            return math.nan, math.nan
        goal, hand = self.loop.arm.goal(in_base(self.robot, board)), self.robot.truth().hand
        return geometry.distance(hand, goal), geometry.angle_between(hand, goal)

    def _expose(self, moment: float) -> None:
        self._frames += 1
        self._next_frame += 1 / self.fps
        if not self.camera_runs or self._random.random() < self.loss:
            return
        for sighting in self._image_faults.pass_on(self._sighting(moment), moment):
            self._on_the_way.append((moment + self.latency, sighting))

    def _sighting(self, moment: float) -> Sighting:
        """Return the detections of a frame that is exposed at a moment."""
        if not self.rendered:
            board, camera = self.things.board(moment), self.robot.camera_at(moment)
            return computed_sighting(camera, board, self.config.marker, moment)
        out = np.empty(self._settings.image_bytes, np.uint8)
        # Light and exposure time have the same effect on a sensor.
        chosen = replace(self._settings, exposure_us=self._settings.exposure_us * self.light(moment))
        grey = self._sensor.render(chosen, self._frames, int(moment * 1e9), out)
        return self._detector.detect(grey, moment, self._frames)
