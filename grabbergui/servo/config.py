"""All rates, gains and limits, with defaults, and how an `.ini` file changes them.

Sections are the fields of `Config`, keys those of its parts, in YARP's `.ini` dialect. The file that is
shipped, `resources/servo/servo.ini`, holds every key with its default.
"""

from __future__ import annotations

import difflib
import math
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from grabbergui.calibration.geometry import Vector
from grabbergui.calibration.markers import BOARD_KINDS, MarkerBoard, check_marker
from grabbergui.config import parse_ini
from grabbergui.core.environment import expanded
from grabbergui.core.errors import UsageError
from grabbergui.servo.kinematics import parse_boxes


@dataclass(frozen=True)
class MarkerConfig:
    """Which marker, or board of markers, the arm goes to."""

    kind: str = "single"
    "`single`, or a board with one pose: `grid` (markers with gaps between them), `charuco`."
    dictionary: str = "4X4_50"
    "OpenCV's name, as `5X5_100`, or an AprilTag family, as `tag36h11`."
    id: int = 20
    "The single marker's number."
    size: float = 0.10
    "Metres along an edge of a marker's black square."
    standoff: float = 0.10
    "Metres before the face of the marker, or of the board's middle, at which the hand stops."
    columns: int = 4
    "Markers across a grid; fields across a ChArUco board."
    rows: int = 3
    pitch: float = 0.0
    "Metres from marker to marker of a grid, or of a field's edge; 0: a quarter more than `size`."
    first: int = 0
    "Number of a board's first marker."

    @property
    def target(self) -> int:
        """Return the number under which the single marker or the board is detected."""
        return self.id if self.kind == "single" else self.first

    @property
    def board(self) -> MarkerBoard | None:
        """Return the board; None for a single marker. Raises UsageError for one that cannot be."""
        if self.kind == "single":
            return None
        return MarkerBoard(
            self.kind, self.columns, self.rows, self.size, self.dictionary, self.pitch, self.first
        )

    @property
    def extent(self) -> tuple[float, float]:
        """Return width and height of the pattern, metres."""
        board = self.board
        return (self.size, self.size) if board is None else board.extent

    def check(self) -> None:
        """Raise UsageError unless such a marker can be. Not on creation: a dialog has it half filled in."""
        if not 0.001 <= self.size <= 10:
            raise UsageError(f"a marker of {self.size:g} m is impossible; allowed: 0.001 to 10")
        if self.kind not in ("single", *BOARD_KINDS):
            known = " and ".join(("single", *BOARD_KINDS))
            raise UsageError(f"[marker] kind is '{self.kind}'; there are {known}")
        if self.board is None:
            check_marker(self.dictionary, self.id)


@dataclass(frozen=True)
class TrackConfig:
    """Conditions that a detection must meet before anything moves for it."""

    confirm: int = 3
    "Images in a row that must show the same thing in the same place."
    jump: float = 0.08
    "Metres from one image to the next beyond which it is another thing."
    jump_angle: float = 20.0
    "Degrees likewise."
    smoothing: float = 0.04
    "Weight of the newest image in the target's pose while it rests; one that moves is followed at once."
    grace: float = 0.3
    "Seconds without a usable detection, nothing moving, before the target is lost."

    def __post_init__(self) -> None:
        if self.confirm < 1:
            raise UsageError("[track] confirm must be 1 or more; nothing moves for what no picture shows")
        if not 0 < self.smoothing <= 1:
            smoothing = f"{self.smoothing:g}"
            raise UsageError(f"[track] smoothing is {smoothing}; it must be more than 0, at most 1")


@dataclass(frozen=True)
class FaceConfig:
    """How people are found."""

    detector: str = "auto"
    "`auto`: YuNet where the extra `faces` is installed, else `cascade`; or the path of YuNet's .onnx file."

    def __post_init__(self) -> None:
        known = self.detector in ("auto", "cascade")
        if not known and not expanded(self.detector).is_file():
            raise UsageError(
                f"[faces] detector is '{self.detector}'; it must be auto, cascade, or a YuNet model file"
            )


@dataclass(frozen=True)
class HeadConfig:
    """How the head keeps its target centred."""

    mode: str = "velocity"
    """`velocity`; `direct`: short positions, at the last of which the head rests; or `steps`: relative
    moves of a fixed size, as the reference follower makes them."""
    gain: float = 2.5
    "Rad/s per radian off centre."
    deadband: float = 0.03
    "Radians off centre within which nothing moves."
    start: float = 0.045
    "Radians off centre at which a resting head starts again; more than the deadband, so that it rests."
    fastest: float = 40.0
    "Degrees per second."
    step: float = 2.0
    "Degrees of a step."
    step_period: float = 0.2
    "Seconds from step to step."
    search: float = 20.0
    "Degrees per second while searching."
    below: float = 0.4
    "Metres below a person's face that are looked at, so that what the hands hold is in the image too."

    def __post_init__(self) -> None:
        if self.mode not in ("velocity", "direct", "steps"):
            raise UsageError(f"[head] mode is '{self.mode}'; there are velocity, direct and steps")
        if self.start < self.deadband:
            raise UsageError("[head] start must not be less than deadband, or the head would never rest")


MOST_FOLLOW = 0.5
"Metres per second beyond which no hand follows anything."
_NEGATIVE = ("x_low", "x_high", "y_low", "y_high", "z_low", "z_high")
"The corners of the workspace, each low one before its high one; nothing else may be negative."


@dataclass(frozen=True)
class ArmConfig:
    """How the hand approaches."""

    mode: str = "velocity"
    "`velocity`, or `direct`: short poses, at the last of which the arm rests."
    gain: float = 1.5
    "1/s: twist per pose error."
    fastest: float = 0.12
    "Metres per second."
    fastest_turn: float = 35.0
    "Degrees per second."
    follow: float = 0.0
    "Metres per second up to which the hand follows a marker that moves; 0: it comes when the marker rests."
    acceleration: float = 0.4
    "Metres per second²; the way down to rest is planned with half of it."
    turn_acceleration: float = 120.0
    "Degrees per second²."
    deadband: float = 0.002
    "Metres of error within which the hand rests."
    deadband_turn: float = 0.5
    "Degrees likewise."
    reached: float = 0.006
    "Metres of error at which the marker counts as reached."
    reached_turn: float = 1.5
    "Degrees likewise."
    x_low: float = 0.05
    "The workspace: a box in the robot's base, metres."
    x_high: float = 0.85
    y_low: float = -0.90
    y_high: float = 0.35
    z_low: float = -0.30
    z_high: float = 0.95

    def __post_init__(self) -> None:
        if self.mode not in ("velocity", "direct"):
            raise UsageError(f"[arm] mode is '{self.mode}'; there are velocity and direct")
        for low in _NEGATIVE[::2]:
            high = low.replace("_low", "_high")
            if not getattr(self, low) < getattr(self, high):
                raise UsageError(f"[arm] {low} must be less than {high}, or the workspace is empty")
        if self.follow > MOST_FOLLOW:
            raise UsageError(f"[arm] follow of {self.follow:g} m/s; allowed: 0 (off) to {MOST_FOLLOW:g}")

    @property
    def workspace(self) -> tuple[Vector, Vector]:
        """The low and the high corner of the workspace."""
        low, high = (self.x_low, self.y_low, self.z_low), (self.x_high, self.y_high, self.z_high)
        return np.array(low), np.array(high)


@dataclass(frozen=True)
class SafetyConfig:
    """When everything stands still."""

    picture_timeout: float = 0.15
    "Seconds since the newest image was exposed."
    robot_timeout: float = 0.15
    "Seconds since the robot's encoders were read."
    freeze: float = 0.3
    "Seconds of commanded motion for which new readings may repeat the old one: drives and slow encoders do."
    stuck: float = 3.0
    "Seconds of approaching in which the hand comes no nearer, after which it gives up."
    search_after: float = 2.0
    "Seconds after a loss before the head starts to search."
    command_timeout: float = 0.15
    "Seconds after which the watchdog stops a robot that gets no more commands."
    guardian_timeout: float = 0.08
    "Seconds after which the guardian process stops a robot whose program has fallen silent."
    clearance: float = 0.03
    "Metres that the arm keeps from the robot's body and from obstacles."
    obstacles: str = ""
    "Boxes in the robot's base that the arm keeps away from: `table 0.3 0.9 -0.5 0.5 -0.9 -0.2; …`, metres."

    def __post_init__(self) -> None:
        parse_boxes(self.obstacles)


@dataclass(frozen=True)
class LoopConfig:
    """The loop itself."""

    rate: float = 50.0
    "Commands per second."
    speed: float = 1.0
    "Factor by which all motion is slowed down, 0.01 to 1."

    def __post_init__(self) -> None:
        if not 1 <= self.rate <= 1000:
            raise UsageError(f"[loop] rate of {self.rate:g} Hz; allowed: 1 to 1000")
        if not 0.01 <= self.speed <= 1:
            raise UsageError(f"[loop] speed of {self.speed:g}; allowed: 0.01 to 1")


@dataclass(frozen=True)
class Config:
    """Everything."""

    marker: MarkerConfig = field(default_factory=MarkerConfig)
    track: TrackConfig = field(default_factory=TrackConfig)
    faces: FaceConfig = field(default_factory=FaceConfig)
    head: HeadConfig = field(default_factory=HeadConfig)
    arm: ArmConfig = field(default_factory=ArmConfig)
    safety: SafetyConfig = field(default_factory=SafetyConfig)
    loop: LoopConfig = field(default_factory=LoopConfig)

    def __post_init__(self) -> None:
        self.marker.check()
        if self.safety.picture_timeout + 1 / self.loop.rate > 0.2:
            raise UsageError(
                f"[safety] picture_timeout of {self.safety.picture_timeout:g} s is too long: motion must end "
                f"within 0.2 s of the last picture, one turn of the loop ({1 / self.loop.rate:g} s) included"
            )
        if self.safety.command_timeout > 0.2:
            raise UsageError("[safety] command_timeout must not be more than 0.2 s")
        if not 0.04 <= self.safety.guardian_timeout <= 0.2:
            raise UsageError(
                f"[safety] guardian_timeout of {self.safety.guardian_timeout:g} s; allowed: 0.04 to 0.2"
            )

    @classmethod
    def parse(cls, text: str, where: str = "configuration") -> Config:
        """Change the defaults by a file's text. Raises UsageError with section, key and allowed values."""
        config, parts = cls(), {}
        for name, section in parse_ini(text, where).items():
            if not section.values:
                continue
            sections = [part.name for part in fields(cls)]
            known = ", ".join(f"[{section}]" for section in sections)
            if not name:
                stray = next(iter(section.values))
                raise UsageError(f"{where}: '{stray}' stands before any section; there are {known}")
            if name not in sections:
                raise UsageError(f"{where} has a section [{name}]; there are {known}")
            parts[name] = _changed(getattr(config, name), section.values, f"{where}, [{name}]")
        return replace(config, **parts)

    @classmethod
    def load(cls, path: Path) -> Config:
        """Read a file. Raises UsageError, OSError."""
        return cls.parse(path.read_text("utf-8", "replace"), str(path))


def _changed(part: Any, values: dict[str, str], where: str) -> Any:
    known = {entry.name: getattr(part, entry.name) for entry in fields(part)}
    changes: dict[str, Any] = {}
    for key, text in values.items():
        if key not in known:
            near = difflib.get_close_matches(key, known, n=1)
            hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(known)}"
            raise UsageError(f"{where} has no {key}; {hint}")
        changes[key] = _value(text, known[key], f"{where}: {key}", may_be_negative=key in _NEGATIVE)
    return replace(part, **changes)


def _value(text: str, default: Any, where: str, *, may_be_negative: bool) -> Any:
    if isinstance(default, str):
        return text
    try:
        number = int(text) if isinstance(default, int) else float(text)
    except ValueError:
        raise UsageError(f"{where} is '{text}', not a number") from None
    if not math.isfinite(number) or (number < 0 and not may_be_negative):
        limits = "finite" if may_be_negative else "finite and not negative"
        raise UsageError(f"{where} is {text}; it must be {limits}")
    return number
