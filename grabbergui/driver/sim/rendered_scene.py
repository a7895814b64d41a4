"""Scenes in perspective: `sim:scene`, a person who holds a marker, and `sim:board`, one who shows a board.

The camera may be mounted on something that moves (`mount`), as on a robot's head. Every frame is drawn for
itself by a pinhole of `FOCAL_LENGTH`, so that exposure, gain, binning and regions act as on any scene.

The ChArUco board moves from pose to pose and rests at each: in every part of the image, near and far,
tilted. The lens is perfect, so a good calibration finds no distortion, and the focal length of `pinhole`.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from dataclasses import astuple, dataclass, field
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.driver.sim import person
from grabbergui.driver.sim import rendered_world as world
from grabbergui.driver.sim.registers import SENSOR_HEIGHT, SENSOR_WIDTH
from grabbergui.driver.sim.rendered_world import Matrix, Panel, Texture, draw
from grabbergui.driver.sim.scene import Scene, SceneView
from grabbergui.driver.sim.settings import FrameSettings

FOCAL_LENGTH = 1959.0
"Pixels without binning: the whole width of the sensor sees 92.5°, the region after power-on 34.7°."

_SMALLER = 16
"How many times smaller than the sensor is an image that is drawn for its textures alone."

Poses = Callable[[float], "Matrix | None"]
"Seconds on the device's clock to a pose; None while the thing is not there."
COLUMNS, ROWS, SQUARE, MARKER = 8, 6, 0.030, 0.022
"Squares across and down, edges of a square and of a marker in metres."
DICTIONARY = cv2.aruco.DICT_5X5_100
BORDER = 0.015
"Metres of white around."
MOVE_S, REST_S = 0.5, 0.9
"Seconds for the move between two poses, and at each pose."
_CAMERA = np.array([[0, 0, 1.0, 0.1], [-1.0, 0, 0, 0], [0, -1.0, 0, 0.75], [0, 0, 0, 1.0]])
"Pose of the camera; it looks straight ahead."
_HALF_X, _HALF_Y = 0.625, 0.525
"Half of the image's width and height at a metre's distance, with the sensor's region as after power-on."


def at(x: float, y: float, z: float, yaw: float = 0.0, pitch: float = 0.0, roll: float = 0.0) -> Matrix:
    """Return the pose of a panel at a place that faces −x, towards the robot.

    Turned, in degrees, about the vertical, then tipped about its own x and y.
    """
    upright = np.array([[0, 0, -1.0], [-1.0, 0, 0], [0, 1.0, 0]])
    turned = _about("z", yaw) @ upright @ _about("x", pitch) @ _about("z", roll)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turned, (x, y, z)
    return pose


def _about(axis: str, degrees: float) -> Matrix:
    cosine, sine = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    if axis == "z":
        return np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1.0]])
    return np.array([[1.0, 0, 0], [0, cosine, -sine], [0, sine, cosine]])


def sensor_pinhole() -> Matrix:
    """Return the whole sensor's camera matrix (3, 3) in pixels, without binning."""
    middle_x, middle_y = (SENSOR_WIDTH - 1) / 2, (SENSOR_HEIGHT - 1) / 2
    return np.array([[FOCAL_LENGTH, 0, middle_x], [0, FOCAL_LENGTH, middle_y], [0, 0, 1.0]])


def pinhole(settings: FrameSettings) -> Matrix:
    """Return the camera matrix (3, 3) of a frame, after binning, mirroring and cropping."""
    matrix = sensor_pinhole()
    for row, binning, size, mirrored, offset in (
        (0, settings.optics.binning_horizontal, SENSOR_WIDTH, settings.optics.reverse_x, settings.offset_x),
        (1, settings.optics.binning_vertical, SENSOR_HEIGHT, settings.optics.reverse_y, settings.offset_y),
    ):
        # Pixel centres are whole numbers, so that the edge of the first lies at −0.5.
        matrix[row] = matrix[row] / binning + matrix[2] * (0.5 / binning - 0.5)
        if mirrored:
            matrix[row] = matrix[2] * (size // binning - 1) - matrix[row]
        matrix[row] -= matrix[2] * offset
    return matrix


@dataclass(frozen=True, eq=False)
class Sheet:
    """The board that the person holds, with its pattern."""

    texture: Texture
    width: float
    "Metres, with the white margin."
    height: float


def marker_sheet(dictionary: int = cv2.aruco.DICT_4X4_50, marker_id: int = 20, size: float = 0.10) -> Sheet:
    """Return a board with one marker, 1.6 times as wide as its black square, whose edge is `size` metres."""
    return Sheet(world.marker_board(dictionary, marker_id), 1.6 * size, 1.6 * size)


def pattern_sheet(pattern: NDArray[np.uint8], width: float, height: float, margin: float = 0.02) -> Sheet:
    """Return a board with a grey (rows, columns) pattern of `width` × `height` metres in a white `margin`."""
    border = round(margin * pattern.shape[1] / width)
    margins = margin, border * height / pattern.shape[0]
    return Sheet(world.printed(pattern, border), width + 2 * margins[0], height + 2 * margins[1])


def swaying(x: float = 1.35, y: float = -0.1, z: float = 0.80) -> Poses:
    """Return a person who shifts from one foot to the other."""

    def pose(seconds: float) -> Matrix:
        return at(x, y + 0.10 * math.sin(0.7 * seconds), z + 0.015 * math.sin(1.4 * seconds))

    return pose


def board_pose() -> Matrix:
    """Return the place of the board, within reach of the robot's right hand."""
    return at(0.70, -0.32, 0.36, yaw=4, pitch=-8)


@dataclass
class Things:
    """Poses of everything in the scene; None means that it is not in the room."""

    face: Poses = field(default_factory=swaying)
    board: Poses = lambda seconds: board_pose()
    sheet: Sheet = field(default_factory=marker_sheet)


class RenderedScene(Scene):
    """The room. `mount` and `rendered` may be called from different threads."""

    def __init__(self, things: Things | None = None) -> None:
        self.things = things or Things()
        self._room = _room()
        self._lock = threading.Lock()
        rest = np.array([[0, -0.26, 0.97, 0.1], [-1, 0, 0, 0], [0, -0.97, -0.26, 0.72], [0, 0, 0, 1.0]])
        self._camera: Callable[[int], Matrix] = lambda time_ns: rest
        self._seen: tuple[tuple[bytes, bytes, tuple[int, ...]], NDArray[np.uint16]] | None = None
        "The empty room as it was seen last, and from where."

    def mount(self, camera_pose: Callable[[int], Matrix], ahead: float = 0.0) -> None:
        """Put the camera on something: device time in ns → pose (z forward, x right, y down).

        `ahead` is how many seconds before an exposure's end its pose may be asked for.
        """
        with self._lock:
            self._camera, self.ahead = camera_pose, ahead

    def prepare(self) -> None:
        """Prepare the textures by a small image; the whole sensor's takes a tenth of a second, unseen."""
        shape = (SENSOR_HEIGHT // _SMALLER, SENSOR_WIDTH // _SMALLER, 3)
        self._drawn(0, shape, np.diag([1 / _SMALLER, 1 / _SMALLER, 1]) @ sensor_pinhole())

    def view(self, time_ns: int) -> SceneView:
        """Return the whole sensor's image."""
        return SceneView(self._drawn(time_ns, (SENSOR_HEIGHT, SENSOR_WIDTH, 3), sensor_pinhole()))

    def rendered(self, time_ns: int, settings: FrameSettings, *, grey: bool = False) -> NDArray[np.uint16]:
        """Render only the part that one frame shows."""
        shape = (settings.height, settings.width) if grey else (settings.height, settings.width, 3)
        return self._drawn(time_ns, shape, pinhole(settings))

    def _drawn(self, time_ns: int, shape: tuple[int, ...], matrix: Matrix) -> NDArray[np.uint16]:
        with self._lock:
            camera = self._camera
        pose = camera(time_ns)
        view = np.eye(4)
        view[:3, :3] = pose[:3, :3].T
        view[:3, 3] = -pose[:3, :3].T @ pose[:3, 3]
        image = self._empty_room(view, matrix, shape)
        panels = self._panels(time_ns * 1e-9)
        for panel in sorted(panels, key=lambda panel: -panel.distance_from(pose[:3, 3])):
            draw(panel, image, view, matrix)
        return image

    def _empty_room(self, view: Matrix, matrix: Matrix, shape: tuple[int, ...]) -> NDArray[np.uint16]:
        """Draw the room, or copy it while the camera rests."""
        key = view.tobytes(), matrix.tobytes(), shape
        seen = self._seen
        if seen is None or seen[0] != key:
            drawn = np.zeros(shape, np.uint16)
            for panel in self._room:
                draw(panel, drawn, view, matrix)
            self._seen = seen = key, drawn
        return seen[1].copy()

    def _panels(self, seconds: float) -> list[Panel]:
        panels = []
        face, board = self.things.face(seconds), self.things.board(seconds)
        if face is not None:
            panels.append(Panel(face, 0.24, 0.24, person.face(), fine=True))
            below = face @ _shift(0.0, -0.33, -0.03)
            panels.append(Panel(below, 0.52, 0.52, person.torso(), fine=True))
        if board is not None:
            sheet = self.things.sheet
            panels.append(Panel(board, sheet.width, sheet.height, sheet.texture, fine=True))
        return panels


def _shift(x: float, y: float, z: float) -> Matrix:
    pose = np.eye(4)
    pose[:3, 3] = (x, y, z)
    return pose


def _room() -> list[Panel]:
    """Return floor, ceiling and four walls, 5.2 m long, 5 m wide, 2.7 m high around the robot."""
    front, back, side, floor, ceiling = 3.2, -2.0, 2.5, -0.95, 1.75
    middle_x, middle_z, high, long = (front + back) / 2, (floor + ceiling) / 2, ceiling - floor, front - back
    wall = world.plaster((0.52, 0.54, 0.50), 1)
    lying, hanging = at(middle_x, 0, floor), at(middle_x, 0, ceiling)
    lying[:3, :3] = [[0, 1.0, 0], [-1.0, 0, 0], [0, 0, 1.0]]
    hanging[:3, :3] = [[0, -1.0, 0], [-1.0, 0, 0], [0, 0, -1.0]]
    return [
        Panel(lying, 2 * side, long, world.planks()),
        Panel(hanging, 2 * side, long, world.plaster((0.62, 0.62, 0.60), 3)),
        Panel(at(front, 0, middle_z), 2 * side, high, wall),
        Panel(at(back, 0, middle_z, yaw=180), 2 * side, high, wall),
        Panel(at(middle_x, side, middle_z, yaw=90), long, high, world.plaster((0.50, 0.46, 0.40), 2)),
        Panel(at(middle_x, -side, middle_z, yaw=-90), long, high, world.plaster((0.42, 0.47, 0.52), 4)),
    ]


@dataclass(frozen=True)
class Hold:
    """Place and tilt of the board in the person's hands."""

    across: float
    "−1 to 1: as far to the left or right as it can be seen whole, or nearly."
    down: float
    distance: float
    "Metres."
    yaw: float = 0.0
    "Degrees; its left edge comes nearer."
    pitch: float = 0.0
    "Degrees; its upper edge comes nearer."
    roll: float = 0.0

    def towards(self, other: Hold, part: float) -> Hold:
        """Return the pose on the way to another."""
        smooth = part * part * (3 - 2 * part)
        return Hold(*(a + (b - a) * smooth for a, b in zip(astuple(self), astuple(other), strict=True)))

    @property
    def pose(self) -> Matrix:
        """In the camera's frame; the board's x to its right, y up, z out of its face."""
        yaw, pitch, roll = (math.radians(angle) for angle in (self.yaw, self.pitch, self.roll))
        rotation, _ = cv2.Rodrigues(np.array([0.0, yaw, 0.0]))
        tipped, _ = cv2.Rodrigues(np.array([pitch, 0.0, 0.0]))
        turned, _ = cv2.Rodrigues(np.array([0.0, 0.0, roll]))
        reach_x = 0.95 * _HALF_X * self.distance - SQUARE * (COLUMNS / 2 - 1)
        reach_y = 0.95 * _HALF_Y * self.distance - SQUARE * (ROWS / 2 - 1)
        pose = np.eye(4)
        pose[:3, :3] = rotation @ tipped @ turned @ np.diag([1.0, -1.0, -1.0])
        pose[:3, 3] = (self.across * reach_x, self.down * reach_y, self.distance)
        return pose


def holds() -> list[Hold]:
    """Return a round of poses that alternates image regions and tilts, for coverage with few views."""
    places = [
        Hold(across, down, 0.48, yaw, pitch)
        for across, down, yaw, pitch in (
            (0, 0, 0, 0), (-1, -1, 8, -8), (1, -1, -8, -8), (1, 1, -8, 8), (-1, 1, 8, 8),
            (0, -1, 0, -10), (0, 1, 0, 10), (-1, 0, 10, 0), (1, 0, -10, 0),
        )
    ]  # fmt: skip
    tilts = [
        Hold(0.2, 0.0, 0.45, 33), Hold(-0.2, 0.1, 0.45, -33), Hold(0.1, -0.1, 0.45, 0, 33),
        Hold(0.0, 0.2, 0.45, 0, -33), Hold(-0.3, -0.2, 0.5, 28, 24), Hold(0.3, 0.2, 0.5, -28, -24),
        Hold(0.0, 0.0, 0.28, 12, -6), Hold(0.0, 0.0, 0.29, -10, 10, 6),
        Hold(-0.6, 0.4, 0.75, -20, 12), Hold(0.7, -0.5, 0.8, 25, -10, -8), Hold(0.0, 0.6, 0.7, 18, -25),
        Hold(-0.8, -0.7, 0.5, 30, 10), Hold(0.8, 0.7, 0.5, -30, -12), Hold(0.5, -0.8, 0.42, 15, 28),
    ]  # fmt: skip
    both = [hold for pair in zip(places, tilts, strict=False) for hold in pair]
    return [*both, *tilts[len(places) :]]


class BoardScene(RenderedScene):
    """The room with a person who shows the board."""

    def __init__(self) -> None:
        super().__init__(Things(face=swaying(z=0.7), board=lambda seconds: None))
        self._holds = holds()
        self.mount(lambda time_ns: _CAMERA)

    def hold_at(self, seconds: float) -> Hold:
        """Return the board's pose at a time on the device's clock."""
        turn, since = divmod(seconds, MOVE_S + REST_S)
        here = self._holds[int(turn) % len(self._holds)]
        if since <= REST_S:
            return here
        return here.towards(self._holds[(int(turn) + 1) % len(self._holds)], (since - REST_S) / MOVE_S)

    def _panels(self, seconds: float) -> list[Panel]:
        pose = _CAMERA @ self.hold_at(seconds).pose
        width, height = COLUMNS * SQUARE + 2 * BORDER, ROWS * SQUARE + 2 * BORDER
        return [*super()._panels(seconds), Panel(pose, width, height, _texture(), fine=True)]


@cache
def _texture(pixels: int = 3600) -> Texture:
    """Return the board as it is printed, `pixels` per metre."""
    board = cv2.aruco.CharucoBoard(
        (COLUMNS, ROWS), SQUARE, MARKER, cv2.aruco.getPredefinedDictionary(DICTIONARY)
    )
    field, border = round(SQUARE * pixels), round(BORDER * pixels)
    drawn = board.generateImage((COLUMNS * field, ROWS * field))
    return world.printed(np.asarray(drawn, np.uint8), border)
