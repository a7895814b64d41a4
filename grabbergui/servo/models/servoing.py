"""Visual servoing as the window shows it, and its tuning."""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from psygnal import Signal

from grabbergui.calibration import geometry
from grabbergui.calibration.calibration_choice import CalibrationFor
from grabbergui.calibration.geometry import Pose, Vector
from grabbergui.core.calibration import Calibration
from grabbergui.core.drawing import Drawing
from grabbergui.core.errors import GrabberError
from grabbergui.core.frame import Frame
from grabbergui.core.pixels import DisplayImage, Region
from grabbergui.models.image.display_settings import DisplaySettings
from grabbergui.models.image.rendering import render
from grabbergui.models.language import translate
from grabbergui.servo import overlay
from grabbergui.servo.config import Config
from grabbergui.servo.loop import ControlCycle, Moment
from grabbergui.servo.models.servo_proxy import Run
from grabbergui.servo.motion import limits_of
from grabbergui.servo.state_machine import State

log = logging.getLogger(__name__)
PERIOD = 0.04
"Least seconds between two views."
PATIENCE = 0.1
"Seconds without an image after which a cycle is shown without one."
TAKE_WAIT = 0.5
"Seconds to wait for the window; a hidden window takes no views."
CURVE_SECONDS = 20.0
CURVE_RATE = 50.0
"Points per second that are kept of the curves."
SPEED_READINGS = 6
"Readings over which the hand's speed is computed: a tenth of a second."
ENTRIES = 200
"Most entries in the history of states."
_COLUMNS = 9
"Time, error (m, rad), twist (m/s, rad/s)."


@dataclass(frozen=True)
class Tuning:
    """The settings that an operator can change; all others are in the configuration file."""

    head_gain: float
    "Rad/s per radian off centre."
    head_fastest: float
    "Degrees per second."
    arm_gain: float
    "Twist per pose error, 1/s."
    arm_fastest: float
    "Millimetres per second."
    rate: float
    "Commands per second."
    speed: float
    "Percentage to which all motion is slowed down."

    @classmethod
    def of(cls, config: Config) -> Tuning:
        """Return the tuning of a configuration."""
        head, arm = config.head, config.arm
        return cls(
            head.gain, head.fastest, arm.gain, arm.fastest * 1e3, config.loop.rate, 1e2 * config.loop.speed
        )

    def applied_to(self, config: Config) -> Config:
        """Return the configuration with these values. Raises UsageError for an invalid combination."""
        return replace(
            config,
            head=replace(config.head, gain=self.head_gain, fastest=self.head_fastest),
            arm=replace(config.arm, gain=self.arm_gain, fastest=self.arm_fastest * 1e-3),
            loop=replace(config.loop, rate=self.rate, speed=1e-2 * self.speed),
        )


@dataclass(frozen=True, eq=False)
class Posture:
    """Robot, camera, marker and person in the robot's base frame, metres."""

    skeleton: list[NDArray[np.float64]]
    "Lines from joint to joint, each (n, 3)."
    hand: Pose
    camera: Pose
    sight: NDArray[np.float64]
    "(4, 3): directions through the image's corners in the camera's frame, z = 1; (0, 3) before an image."
    marker: Pose | None
    goal: Pose | None
    "Target pose of the hand for this marker."
    person: Vector | None
    marker_extent: tuple[float, float]
    "Width and height of the marker, or of the board, metres."
    workspace: tuple[Vector, Vector]
    "Its lowest and its highest corner."


@dataclass(frozen=True)
class Entry:
    """A state and the time of its beginning."""

    time: float
    "Seconds since the loop's first cycle (`ControlCycle.elapsed`)."
    state: State
    reason: str


@dataclass(frozen=True, eq=False)
class Shown:
    """One moment of the loop, ready to be painted."""

    cycle: ControlCycle
    image: DisplayImage | None
    "None without a new image."
    size: tuple[int, int]
    "Width and height of the whole image."
    drawing: Drawing
    posture: Posture | None
    "None until the robot has answered."
    nominal: bool = False
    "Whether the calibration is only assumed."
    limits: str = ""
    "What is measured of the hand, and its limits, as display text; empty without readings."


class ServoModel:
    """Follows a runner. `take`, `curves` and `entries` may be called from any thread and never wait."""

    ready = Signal()
    """`take` returns a new view. On the display thread."""
    entered = Signal(Entry)
    """The loop entered another state. On the loop's thread."""

    def __init__(self, runner: Run, calibration: CalibrationFor) -> None:
        self._runner = runner
        self._calibration = calibration
        self._newest: Moment | None = None
        self._frame: Frame | None = None
        self._offer: Shown | None = None
        self._view: tuple[Region | None, tuple[int, int] | None] = (None, None)
        self._sight = np.zeros((0, 3))
        self._fresh, self._taken = threading.Event(), threading.Event()
        self._open = False
        self._thread: threading.Thread | None = None
        self._lock = threading.Lock()
        self._state: State | None = None
        self._rows = np.full((round(CURVE_SECONDS * CURVE_RATE), _COLUMNS), np.nan)
        self._count = 0
        self._entries: deque[Entry] = deque(maxlen=ENTRIES)
        self._hands: deque[tuple[float, Pose]] = deque(maxlen=SPEED_READINGS)
        "The newest readings of the hand, and their times."

    def open(self) -> None:
        """Begin to follow the runner."""
        self._open = True
        self._runner.cycle_done.connect(self._on_cycle)
        self._thread = threading.Thread(target=self._show, name="servo display", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Release the runner, and wait for the display thread to end. May be called twice."""
        self._open = False
        self._runner.cycle_done.disconnect(self._on_cycle, missing_ok=True)
        self._fresh.set()
        self._taken.set()
        if self._thread is not None:
            self._thread.join()

    @property
    def entries(self) -> list[Entry]:
        """The states so far, the newest last."""
        with self._lock:
            return list(self._entries)

    def curves(self) -> NDArray[np.float64]:
        """Return (n, 9), the newest last: seconds up to 0, error in m and rad, twist in m/s and rad/s."""
        with self._lock:
            length = len(self._rows)
            rows = np.roll(self._rows, -(self._count % length), axis=0)[max(length - self._count, 0) :]
        rows[:, 0] -= rows[-1, 0] if len(rows) else 0.0
        return rows

    def set_viewport(self, region: Region | None, size: tuple[int, int] | None) -> None:
        """Set the viewport: a region of the image (None: all of it), in `size` screen pixels."""
        self._view = region, size

    def take(self) -> Shown | None:
        """Return the newest view, once; None without a new one."""
        with self._lock:
            offer, self._offer = self._offer, None
        self._taken.set()
        return offer

    def _on_cycle(self, cycle: ControlCycle, frame: Frame | None) -> None:
        self._newest = self._runner.loop.moment(cycle)
        if frame is not None:
            self._frame = frame
            self._fresh.set()
        entry = self._note(cycle)
        if entry is not None:
            self.entered.emit(entry)

    def _note(self, cycle: ControlCycle) -> Entry | None:
        with self._lock:
            row = self._rows[(self._count - 1) % len(self._rows)]
            if cycle.robot is not None and (not self._hands or cycle.robot.time > self._hands[-1][0]):
                self._hands.append((cycle.robot.time, cycle.robot.hand))
            if not self._count or cycle.time - row[0] >= 0.9 / CURVE_RATE:
                row = self._rows[self._count % len(self._rows)]
                row[0], row[1:3], row[3:] = cycle.time, cycle.error, cycle.command.hand
                self._count += 1
            if cycle.state is self._state:
                return None
            self._state = cycle.state
            entry = Entry(cycle.elapsed, cycle.state, cycle.reason)
            self._entries.append(entry)
            return entry

    def _show(self) -> None:
        while self._open:
            began = time.monotonic()
            self._fresh.wait(PATIENCE)
            self._fresh.clear()
            frame, self._frame = self._frame, None
            newest = self._newest
            if newest is None or not self._open:
                continue
            try:
                shown = self._shown(newest, frame)
            except (GrabberError, ArithmeticError) as error:
                log.warning("a moment of the loop cannot be shown: %s", error)
                continue
            with self._lock:
                self._taken.clear()
                self._offer = shown
            self.ready.emit()
            self._taken.wait(TAKE_WAIT)
            time.sleep(max(0.0, began + PERIOD - time.monotonic()))

    def _shown(self, newest: Moment, frame: Frame | None) -> Shown:
        cycle, image, size = newest.cycle, None, (0, 0)
        drawing, nominal = Drawing(), False
        if frame is not None:
            size = frame.width, frame.height
            image = render(frame, *self._view, DisplaySettings())
            calibration = self._calibration(*size)
            drawing = overlay.drawing(cycle, newest.sighting, calibration, self._runner.config.head)
            nominal = calibration.nominal
            self._sight = _sight(calibration)
        return Shown(cycle, image, size, drawing, self._posture(newest), nominal, self._limits())

    def _limits(self) -> str:
        with self._lock:
            hands = list(self._hands)
        if len(hands) < 2:
            return ""
        (begin, before), (end, now) = hands[0], hands[-1]
        config = self._runner.config
        low, high = config.arm.workspace
        limits = limits_of(config)
        values = (
            1e3 * geometry.distance(before, now) / (end - begin),
            1e3 * limits.speed,
            np.degrees(geometry.angle_between(before, now)) / (end - begin),
            np.degrees(limits.turn),
            1e3 * np.minimum(now[:3, 3] - low, high - now[:3, 3]).min(),
        )
        text = translate("Servoing", "Hand: {0} of {1} mm/s, {2} of {3} °/s, {4} mm inside its workspace")
        return text.format(*(f"{value:.0f}" for value in values))

    def _posture(self, newest: Moment) -> Posture | None:
        state = newest.cycle.robot
        if state is None:
            return None
        robot, config = self._runner.robot, self._runner.config
        return Posture(
            robot.skeleton(state),
            state.hand,
            robot.camera_pose(state.head),
            self._sight,
            newest.marker,
            newest.goal,
            newest.person,
            config.marker.extent,
            config.arm.workspace,
        )


def state_text(state: State) -> str:
    """Return a state in the user's language."""
    return {
        State.SEARCHING: translate("Servoing", "searching"),
        State.CENTRING: translate("Servoing", "centring"),
        State.WAITING: translate("Servoing", "waiting for the marker"),
        State.APPROACHING: translate("Servoing", "approaching"),
        State.FOLLOWING: translate("Servoing", "following"),
        State.REACHED: translate("Servoing", "reached"),
        State.STUCK: translate("Servoing", "stuck"),
        State.LOST: translate("Servoing", "lost"),
        State.STOPPED: translate("Servoing", "stopped"),
    }[state]


def _sight(calibration: Calibration) -> NDArray[np.float64]:
    """Return the directions through the image's corners, without distortion, which is invisible here."""
    corners = [
        (x, y, 1.0)
        for x, y in (
            (-0.5, -0.5),
            (calibration.width - 0.5, -0.5),
            (calibration.width - 0.5, calibration.height - 0.5),
            (-0.5, calibration.height - 0.5),
        )
    ]
    directions: NDArray[np.float64] = np.array(corners) @ np.linalg.inv(calibration.matrix).T
    return directions
