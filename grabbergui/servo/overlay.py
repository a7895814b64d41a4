"""What is drawn over a picture: markers with their axes, heads, the state, how far it is."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core.calibration import Calibration
from grabbergui.servo.detection import MarkerDetection, Sighting
from grabbergui.servo.loop import Turn
from grabbergui.servo.state_machine import State

Picture = NDArray[np.uint8]

_COLOURS = {
    State.SEARCHING: (150, 150, 150),
    State.CENTRING: (240, 180, 40),
    State.WAITING: (80, 160, 250),
    State.APPROACHING: (250, 140, 30),
    State.REACHED: (60, 200, 90),
    State.LOST: (200, 80, 200),
    State.STOPPED: (230, 50, 50),
}
"Red, green, blue."
_FONT = cv2.FONT_HERSHEY_SIMPLEX
_AXIS_M = 0.05


def colour_of(state: State) -> tuple[int, int, int]:
    """Red, green, blue of a state, the same in overlay and plots."""
    return _COLOURS[state]


def draw(picture: Picture, turn: Turn, sighting: Sighting | None, calibration: Calibration) -> Picture:
    """A copy of an RGB picture (rows, columns, 3) with everything drawn on it.

    The calibration is of pictures of this size.
    """
    out: Picture = np.array(picture)
    thick = max(1, round(picture.shape[1] / 600))
    for marker in sighting.markers if sighting else ():
        _marker(out, marker, calibration, thick)
    for head in sighting.heads if sighting else ():
        x, y, width, height = head.box
        cv2.rectangle(out, (x, y), (x + width, y + height), (80, 160, 250), thick, cv2.LINE_AA)
        cv2.putText(out, f"{head.position[2]:.1f} m", (x, y - 4), _FONT, 0.45 * thick, (80, 160, 250), thick)
    middle = picture.shape[1] // 2, picture.shape[0] // 2
    cv2.drawMarker(out, middle, (255, 255, 255), cv2.MARKER_CROSS, 20 * thick, thick)
    _caption(out, turn, thick)
    return out


def _marker(out: Picture, marker: MarkerDetection, calibration: Calibration, thick: int) -> None:
    colour = (60, 200, 90) if marker.pose is not None else (230, 50, 50)
    corners = np.rint(marker.corners).astype(np.int32)
    cv2.polylines(out, [corners], True, colour, thick, cv2.LINE_AA)
    text = f"id {marker.marker_id} {marker.problem}".strip()
    place = int(corners[:, 0].min()), int(corners[:, 1].min()) - 5
    cv2.putText(out, text, place, _FONT, 0.45 * thick, colour, thick, cv2.LINE_AA)
    if marker.pose is not None:
        rotation, _ = cv2.Rodrigues(marker.pose[:3, :3])
        ends, _ = cv2.projectPoints(
            np.vstack((np.zeros(3), _AXIS_M * np.eye(3))),
            rotation,
            marker.pose[:3, 3],
            calibration.matrix,
            calibration.distortion,
        )
        points = np.rint(np.clip(ends.reshape(-1, 2), -30_000, 30_000)).astype(int)
        for end, axis in zip(points[1:], ((230, 50, 50), (60, 200, 90), (70, 110, 250)), strict=True):
            cv2.line(out, tuple(map(int, points[0])), tuple(map(int, end)), axis, 2 * thick, cv2.LINE_AA)


def _caption(out: Picture, turn: Turn, thick: int) -> None:
    height = 26 * thick
    out[:height] //= 3
    cv2.circle(out, (height // 2, height // 2), height // 4, colour_of(turn.state), -1, cv2.LINE_AA)
    text = f"{turn.state.value}"
    if math.isfinite(turn.error[0]):
        text += f"   hand {1e3 * turn.error[0]:.0f} mm  {math.degrees(turn.error[1]):.1f} deg"
    place = (height, int(height * 0.7))
    cv2.putText(out, text, place, _FONT, 0.5 * thick, (255, 255, 255), thick, cv2.LINE_AA)
