"""All rates, gains and limits with their defaults, and the `.ini` file that changes them.

Sections are the fields of `Config`, keys those of its parts, in YARP's `.ini` dialect. The shipped file,
`resources/servo/servo.ini`, documents every key with its default and unit.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from grabbergui.calibration.geometry import Vector
from grabbergui.calibration.marker_boards import BOARD_KINDS, MarkerBoard
from grabbergui.calibration.markers import check_marker
from grabbergui.config.ini_files import parse_ini, read_ini
from grabbergui.core.environment import expanded
from grabbergui.core.errors import UsageError
from grabbergui.servo.clearance import parse_boxes

_NEGATIVE = ("x_low", "x_high", "y_low", "y_high", "z_low", "z_high")
"The workspace's limits, each low one before its high one; no other number may be negative."


def _limited(default: float, low: float, high: float, unit: str = "") -> Any:
    """Return a field of a section with its lowest and highest value and their unit."""
    return field(default=default, metadata={"limits": (low, high, unit)})


def _check_limits(section: str, part: Any) -> None:
    """Raise UsageError for a value beyond its limits."""
    for entry in fields(part):
        low, high, unit = entry.metadata.get("limits", (-math.inf, math.inf, ""))
        value = getattr(part, entry.name)
        if isinstance(value, (int, float)) and not low <= value <= high:
            given = f"{value:g} {unit}".rstrip()
            raise UsageError(f"[{section}] {entry.name} of {given}; allowed: {low:g} to {high:g}")


@dataclass(frozen=True)
class MarkerConfig:
    """The marker, or the board of markers, that the arm goes to."""

    kind: str = "single"
    "`single`, or a board with one pose: `grid` (markers with gaps between them), `charuco`."
    dictionary: str = "4X4_50"
    "OpenCV's name, such as `5X5_100`, or an AprilTag family, such as `tag36h11`."
    id: int = 20
    "The single marker's number."
    size: float = 0.10
    "Metres along an edge of a marker's black square."
    standoff: float = _limited(0.10, 0.01, 1, "m")
    "Metres in front of the marker, or of the board's middle, at which the hand stops."
    columns: int = 4
    "Markers across a grid; squares across a ChArUco board."
    rows: int = 3
    pitch: float = 0.0
    "Metres from marker to marker of a grid, or of a square's edge; 0: a quarter more than `size`."
    first: int = 0
    "Number of a board's first marker."

    @property
    def target(self) -> int:
        """Return the number under which the single marker or the board is detected."""
        return self.id if self.kind == "single" else self.first

    @property
    def board(self) -> MarkerBoard | None:
        """Return the board; None for a single marker. Raises UsageError for an impossible one."""
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
        """Raise UsageError for an impossible marker. Not called on creation: a dialog's may be incomplete."""
        if not 0.001 <= self.size <= 10:
            raise UsageError(f"a marker of {self.size:g} m is impossible; allowed: 0.001 to 10")
        if self.kind not in ("single", *BOARD_KINDS):
            known = " and ".join(("single", *BOARD_KINDS))
            raise UsageError(f"[marker] kind is '{self.kind}'; there are {known}")
        if self.board is None:
            check_marker(self.dictionary, self.id)
        _check_limits("marker", self)


@dataclass(frozen=True)
class TrackConfig:
    """Conditions for a detection before the robot moves for it."""

    confirm: int = _limited(3, 1, 100, "images")
    "Number of images in a row that must show the target in the same place."
    jump: float = _limited(0.08, 0.001, 1, "m")
    "Metres between two images beyond which it counts as another target."
    jump_angle: float = _limited(20.0, 0.1, 180, "°")
    "The same in degrees."
    smoothing: float = _limited(0.04, 0.001, 1)
    "Weight of the newest image in a resting target's pose; a moving target is not smoothed."
    grace: float = _limited(0.3, 0, 2, "s")
    "Seconds at rest without a usable detection after which the target is lost."

    def __post_init__(self) -> None:
        _check_limits("track", self)


@dataclass(frozen=True)
class FaceConfig:
    """Detection of people."""

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
    """Control of the head."""

    mode: str = "velocity"
    """`velocity`; `direct`: short positions, the head rests at the last; or `steps`: relative moves of a
    fixed size, as the reference follower makes them."""
    gain: float = _limited(2.5, 0, 10, "1/s")
    "Rad/s per radian off centre."
    deadband: float = _limited(0.03, 0, 0.5, "rad")
    "Radians off centre within which the head rests."
    start: float = _limited(0.045, 0, 0.5, "rad")
    "Radians off centre at which a resting head starts again; not less than the deadband."
    fastest: float = _limited(40.0, 0, 120, "°/s")
    "Degrees per second."
    step: float = _limited(2.0, 0, 10, "°")
    "Size of a step, degrees."
    step_period: float = _limited(0.2, 0.02, 10, "s")
    "Seconds between steps."
    search: float = _limited(20.0, 0, 120, "°/s")
    "Degrees per second while searching."
    below: float = _limited(0.4, 0, 2, "m")
    "Metres below a person's face at which the head looks, so that the image shows the hands, too."

    def __post_init__(self) -> None:
        if self.mode not in ("velocity", "direct", "steps"):
            raise UsageError(f"[head] mode is '{self.mode}'; there are velocity, direct and steps")
        _check_limits("head", self)
        if self.start < self.deadband:
            raise UsageError("[head] start must not be less than deadband, or the head would never rest")
        if self.mode == "steps" and self.step > self.fastest * self.step_period:
            raise UsageError(
                f"[head] step of {self.step:g}° every {self.step_period:g} s (step_period) is faster than "
                f"fastest, {self.fastest:g} °/s"
            )


@dataclass(frozen=True)
class ArmConfig:
    """Control of the arm."""

    mode: str = "velocity"
    "`velocity`, or `direct`: short poses, the arm rests at the last."
    gain: float = _limited(1.5, 0, 10, "1/s")
    "1/s: twist per pose error."
    fastest: float = _limited(0.12, 0.001, 0.5, "m/s")
    "Metres per second."
    fastest_turn: float = _limited(35.0, 0.1, 180, "°/s")
    "Degrees per second."
    follow: float = _limited(0.0, 0, 0.5, "m/s")
    "Highest speed at which the hand follows a moving marker, metres per second; 0: it waits until it rests."
    acceleration: float = _limited(0.4, 0.01, 10, "m/s²")
    "Metres per second²; deceleration is half of it."
    turn_acceleration: float = _limited(120.0, 1, 2000, "°/s²")
    "Degrees per second²."
    deadband: float = 0.002
    "Metres of error within which the hand rests."
    deadband_turn: float = 0.5
    "The same in degrees."
    reached: float = _limited(0.006, 0.0005, 0.1, "m")
    "Metres of error at which the marker counts as reached."
    reached_turn: float = _limited(1.5, 0.1, 45, "°")
    "The same in degrees."
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
        _check_limits("arm", self)
        for reached, deadband in (("reached", "deadband"), ("reached_turn", "deadband_turn")):
            if getattr(self, reached) < 2 * getattr(self, deadband):
                raise UsageError(
                    f"[arm] {reached} must be at least twice {deadband}: within that a hand at rest stays at "
                    "rest, and would never count as at the marker"
                )

    @property
    def workspace(self) -> tuple[Vector, Vector]:
        """The low and the high corner of the workspace."""
        low, high = (self.x_low, self.y_low, self.z_low), (self.x_high, self.y_high, self.z_high)
        return np.array(low), np.array(high)


@dataclass(frozen=True)
class SafetyConfig:
    """Conditions under which the robot stops. `Config` checks the times."""

    image_timeout: float = _limited(0.15, 0.02, 0.2, "s")
    "Age of the newest image, from its exposure, beyond which everything stops, seconds."
    robot_timeout: float = _limited(0.15, 0.02, 0.2, "s")
    "Age of the robot's newest reading beyond which everything stops, seconds."
    freeze: float = _limited(0.3, 0.1, 2, "s")
    "Seconds within which the readings must show a motion as it was commanded, or the robot is stopped."
    stuck: float = _limited(3.0, 0.1, 60, "s")
    "Seconds without progress after which an approach ends."
    search_after: float = _limited(2.0, 0, 3600, "s")
    "Seconds after a loss before the head starts to search."
    command_timeout: float = _limited(0.15, 0.02, 0.2, "s")
    "Seconds without a command after which the watchdog stops the robot."
    guardian_timeout: float = _limited(0.08, 0.04, 0.2, "s")
    "Seconds without a heartbeat after which the guardian stops the robot."
    clearance: float = _limited(0.03, 0, 0.5, "m")
    "Smallest distance of the arm from the robot's body and from obstacles, metres."
    obstacles: str = ""
    "Obstacles as boxes in the robot's base: `table 0.3 0.9 -0.5 0.5 -0.9 -0.2; …`, metres."

    def __post_init__(self) -> None:
        parse_boxes(self.obstacles)

    @property
    def lag(self) -> float:
        """Seconds by which readings may trail commands: drives, networks and busy computers are late."""
        return self.freeze / 2


@dataclass(frozen=True)
class LoopConfig:
    """The loop's rate and speed."""

    rate: float = _limited(50.0, 1, 1000, "Hz")
    "Commands per second."
    speed: float = _limited(1.0, 0.01, 1)
    "Factor on all speeds, 0.01 to 1."

    def __post_init__(self) -> None:
        _check_limits("loop", self)


@dataclass(frozen=True)
class Config:
    """The whole configuration."""

    marker: MarkerConfig = field(default_factory=MarkerConfig)
    track: TrackConfig = field(default_factory=TrackConfig)
    faces: FaceConfig = field(default_factory=FaceConfig)
    head: HeadConfig = field(default_factory=HeadConfig)
    arm: ArmConfig = field(default_factory=ArmConfig)
    safety: SafetyConfig = field(default_factory=SafetyConfig)
    loop: LoopConfig = field(default_factory=LoopConfig)

    def __post_init__(self) -> None:
        self.marker.check()
        if self.safety.image_timeout + 1 / self.loop.rate > 0.2:
            raise UsageError(
                f"[safety] image_timeout of {self.safety.image_timeout:g} s is too long: motion must end "
                f"within 0.2 s of the last image, one control cycle ({1 / self.loop.rate:g} s) included"
            )
        _check_limits("safety", self.safety)

    @classmethod
    def parse(cls, text: str, where: str = "configuration") -> Config:
        """Return the defaults, changed by a file's text. Raises UsageError with section, key and limits."""
        config, parts = cls(), {}
        for name, section in parse_ini(text, where).items():
            if not section.values:
                continue
            sections = [part.name for part in fields(cls)]
            known = ", ".join(f"[{section}]" for section in sections)
            if not name:
                stray = next(iter(section.values))
                raise UsageError(f"{where}: '{stray}' precedes the first section; there are {known}")
            if name not in sections:
                raise UsageError(f"{where} has a section [{name}]; there are {known}")
            changes = _changes(getattr(config, name), section.values, f"{where}, [{name}]")
            with _named(where):
                parts[name] = replace(getattr(config, name), **changes)
        with _named(where):
            return replace(config, **parts)

    @classmethod
    def load(cls, path: Path) -> Config:
        """Read a file. Raises UsageError, OSError."""
        return cls.parse(read_ini(path), str(path))


@contextmanager
def _named(where: str) -> Iterator[None]:
    """Put the name of the file before the error of a value that is out of range."""
    try:
        yield
    except UsageError as error:
        raise UsageError(f"{where}: {error}") from error


def _changes(part: Any, values: dict[str, str], where: str) -> dict[str, Any]:
    known = {entry.name: getattr(part, entry.name) for entry in fields(part)}
    changes: dict[str, Any] = {}
    for key, text in values.items():
        if key not in known:
            near = difflib.get_close_matches(key, known, n=1)
            hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(known)}"
            raise UsageError(f"{where} has no {key}; {hint}")
        changes[key] = _value(text, known[key], f"{where}: {key}", may_be_negative=key in _NEGATIVE)
    return changes


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
