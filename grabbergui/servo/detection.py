"""Markers and faces found in one frame, in pixels and, with a calibration, in metres.

Positions are in the camera's optical frame: x right, y down, z forward. `servo.faces` has the face detectors,
`calibration.markers` those of markers.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

from grabbergui.calibration.markers import ArucoDetector, BoardDetector, Grey, MarkerDetection
from grabbergui.core.calibration import Calibration
from grabbergui.servo.config import MarkerConfig

Box = tuple[int, int, int, int]
"x, y, width, height in pixels of the full picture."


@dataclass(frozen=True)
class FaceDetection:
    """One head, seen from the front."""

    box: Box
    position: tuple[float, float, float]
    "Metres; the distance is estimated from the box's width, so it is rough."


@dataclass(frozen=True, eq=False)
class Sighting:
    """Markers and faces found in one picture."""

    captured: float
    "Seconds on the loop's clock at which the picture was exposed."
    markers: tuple[MarkerDetection, ...] = ()
    faces: tuple[FaceDetection, ...] = ()
    frame_id: int = 0

    def only(self, marker_id: int) -> MarkerDetection | None:
        """The marker with this id; None where it is not seen, or seen more than once."""
        found = [marker for marker in self.markers if marker.marker_id == marker_id]
        return found[0] if len(found) == 1 else None

    def duplicates(self, marker_id: int) -> bool:
        """Whether several markers have this id, so that none of them can be meant."""
        return sum(marker.marker_id == marker_id for marker in self.markers) > 1

    @property
    def nearest_face(self) -> FaceDetection | None:
        """The head that looks largest."""
        return max(self.faces, key=lambda head: head.box[2] * head.box[3], default=None)


class MarkerDetector(Protocol):
    """Finds markers in a grey picture."""

    def detect(self, grey: Grey) -> list[MarkerDetection]:
        """All markers of the dictionary."""
        ...


def marker_detector(marker: MarkerConfig, of: Calibration) -> MarkerDetector:
    """Return the detector of the configured marker or board. Raises UsageError for one that cannot be."""
    board = marker.board
    return ArucoDetector(marker.dictionary, marker.size, of) if board is None else BoardDetector(board, of)


class FaceDetector(Protocol):
    """Finds faces in a grey image. Use from one thread."""

    def detect(self, grey: Grey, near: Box | None = None) -> list[FaceDetection]:
        """Return all faces in an image (rows, columns) uint8, in no order; with `near`, those around it."""
        ...

    def close(self) -> None:
        """End what runs beside the calls, if anything does. May be called twice."""
        return


@dataclass
class Detector:
    """Markers and heads together."""

    markers: MarkerDetector
    faces: FaceDetector | None = None
    faces_with_markers: bool = field(default=False)
    "Whether heads are looked for also while a marker is seen, which costs time and changes nothing."

    def detect(self, grey: Grey, captured: float, frame_id: int = 0) -> Sighting:
        """Everything in a picture (rows, columns) uint8."""
        markers = tuple(self.markers.detect(grey))
        faces: tuple[FaceDetection, ...] = ()
        if self.faces is not None and (self.faces_with_markers or not markers):
            faces = tuple(self.faces.detect(grey))
        return Sighting(captured, markers, faces, frame_id)

    def close(self) -> None:
        """Release what the detectors hold. May be called twice."""
        if self.faces is not None:
            self.faces.close()
