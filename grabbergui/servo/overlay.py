"""Overlays of the image: markers with their axes, heads, the deadband in the middle, the target.

`drawing` returns them as lines and labels in the image's pixels, which a window paints itself; `draw` paints
them into the image, for videos.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from grabbergui.core.drawing import BAD, GOOD, Colour, Drawing, Label, Points, Stroke, crosses

if TYPE_CHECKING:
    from grabbergui.calibration.marker_pose import MarkerDetection
    from grabbergui.core.calibration import Calibration
    from grabbergui.servo.config import HeadConfig
    from grabbergui.servo.detection import FaceDetection, Sighting
    from grabbergui.servo.loop import ControlCycle
    from grabbergui.servo.state_machine import State

Image = NDArray[np.uint8]

_COLOURS: dict[str, Colour] = {
    "SEARCHING": (150, 150, 150),
    "CENTRING": (240, 180, 40),
    "WAITING": (80, 160, 250),
    "APPROACHING": (250, 140, 30),
    "FOLLOWING": (60, 190, 190),
    "REACHED": (60, 200, 90),
    "STUCK": (170, 110, 50),
    "LOST": (200, 80, 200),
    "STOPPED": (230, 50, 50),
}
"By the name of the state."
AXIS_COLOURS: tuple[Colour, Colour, Colour] = ((230, 50, 50), (60, 200, 90), (70, 110, 250))
"Colours of x, y and z, as usual in robotics."
PERSON: Colour = (80, 160, 250)
MIDDLE: Colour = (255, 255, 255)
_FONT = cv2.FONT_HERSHEY_SIMPLEX
_AXIS_M = 0.05
_FAR = 30_000
"Limit of coordinates in pixels: painters cannot handle larger ones."


def colour_of(state: State) -> Colour:
    """Return a state's red, green, blue, the same in overlay and plots."""
    return _COLOURS[state.name]


def drawing(
    cycle: ControlCycle, sighting: Sighting | None, calibration: Calibration, head: HeadConfig | None = None
) -> Drawing:
    """Return the detections and the head's error as overlays; `calibration` is of images of this size.

    With `head`, also the deadband and the band within which a resting head stays at rest.
    """
    out = Drawing()
    for marker in sighting.markers if sighting else ():
        _add_marker(out, marker, calibration)
    for face in sighting.faces if sighting else ():
        _add_head(out, face)
    if head is not None:
        for angle, weight in ((head.deadband, 2), (head.start, 1)):
            side = math.tan(angle)
            corners = [(-side, -side, 1), (side, -side, 1), (side, side, 1), (-side, side, 1)]
            out.strokes.append(Stroke(_pixels(corners, calibration), MIDDLE, True, weight))
    _add_middle(out, cycle, calibration)
    return out


def draw(
    image: Image,
    cycle: ControlCycle,
    sighting: Sighting | None,
    calibration: Calibration,
    head: HeadConfig | None = None,
) -> Image:
    """Return a copy of an RGB image (rows, columns, 3) with the overlays, and the state at the top."""
    out: Image = np.array(image)
    thick = max(1, round(image.shape[1] / 600))
    made = drawing(cycle, sighting, calibration, head)
    for stroke in made.strokes:
        points = [np.rint(stroke.points).astype(np.int32)]
        cv2.polylines(out, points, stroke.closed, stroke.colour, stroke.weight * thick, cv2.LINE_AA)
    for label in made.labels:
        place = round(label.place[0]), round(label.place[1])
        cv2.putText(out, label.text, place, _FONT, 0.45 * thick, label.colour, thick, cv2.LINE_AA)
    _caption(out, cycle, thick)
    return out


def _add_marker(out: Drawing, marker: MarkerDetection, calibration: Calibration) -> None:
    colour = GOOD if marker.pose is not None else BAD
    out.strokes.append(Stroke(marker.corners, colour, closed=True))
    left, top = marker.corners.min(axis=0)
    text = f"id {marker.marker_id} {marker.problem}".strip()
    out.labels.append(Label(text, (float(left), float(top) - 5), colour))
    if marker.pose is not None:
        origin = marker.pose[:3, 3]
        pixels = _pixels(np.vstack((origin, origin + _AXIS_M * marker.pose[:3, :3].T)), calibration)
        for tip, axis in zip(pixels[1:], AXIS_COLOURS, strict=True):
            out.strokes.append(Stroke(np.array([pixels[0], tip]), axis, weight=2))


def _add_head(out: Drawing, face: FaceDetection) -> None:
    x, y, width, height = face.box
    corners = np.array([(x, y), (x + width, y), (x + width, y + height), (x, y + height)], np.float64)
    out.strokes.append(Stroke(corners, PERSON, closed=True))
    out.labels.append(Label(f"{face.position[2]:.1f} m", (x, y - 4), PERSON))


def _add_middle(out: Drawing, cycle: ControlCycle, calibration: Calibration) -> None:
    """Add a cross in the camera's middle, and a line from there to the head's target."""
    middle = _pixels([(0, 0, 1)], calibration)[0]
    arm = calibration.width / 60
    out.strokes.extend(crosses([middle], arm, MIDDLE))
    right, down = cycle.off_centre
    if math.isfinite(right) and max(abs(right), abs(down)) < 1.2:
        target = _pixels([(math.tan(right), math.tan(down), 1)], calibration)[0]
        colour = colour_of(cycle.state)
        out.strokes.append(Stroke(np.array([middle, target]), colour))
        turned = np.linspace(0, 2 * math.pi, 25)[:-1]
        ring = target + arm / 2 * np.column_stack((np.cos(turned), np.sin(turned)))
        out.strokes.append(Stroke(ring, colour, closed=True, weight=2))


def _pixels(points: ArrayLike, calibration: Calibration) -> Points:
    """Project points of the camera's frame, (n, 3) metres, to (n, 2) pixels."""
    seen, _ = cv2.projectPoints(
        np.asarray(points, np.float64),
        np.zeros(3),
        np.zeros(3),
        calibration.matrix,
        calibration.pinhole_distortion,
    )
    return np.clip(seen.reshape(-1, 2), -_FAR, _FAR).astype(np.float64)


def _caption(out: Image, cycle: ControlCycle, thick: int) -> None:
    height = 26 * thick
    out[:height] //= 3
    cv2.circle(out, (height // 2, height // 2), height // 4, colour_of(cycle.state), -1, cv2.LINE_AA)
    text = f"{cycle.state.value}"
    if math.isfinite(cycle.error[0]):
        text += f"   hand {1e3 * cycle.error[0]:.0f} mm  {math.degrees(cycle.error[1]):.1f} deg"
    place = (height, int(height * 0.7))
    cv2.putText(out, text, place, _FONT, 0.5 * thick, (255, 255, 255), thick, cv2.LINE_AA)
