"""What is found in one frame: markers and faces, in pixels and, with a calibration, in metres.

Positions are in the camera's optical frame: x right, y down, z forward. Markers are detected by
`calibration.markers`, faces by `face_detectors`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from grabbergui.calibration.marker_boards import BoardDetector
from grabbergui.calibration.marker_pose import MarkerDetection
from grabbergui.calibration.markers import ArucoDetector, Grey
from grabbergui.core.calibration import Calibration
from grabbergui.servo.config import MarkerConfig

Box = tuple[int, int, int, int]
"x, y, width, height in pixels of the full image."


@dataclass(frozen=True)
class FaceDetection:
    """One face, seen from the front."""

    box: Box
    position: tuple[float, float, float]
    "Metres; the distance is estimated from the box's width, so it is rough."


@dataclass(frozen=True, eq=False)
class Sighting:
    """Markers and faces found in one image."""

    captured: float
    "Time of the image's exposure, seconds on the loop's clock."
    markers: tuple[MarkerDetection, ...] = ()
    faces: tuple[FaceDetection, ...] = ()
    frame_id: int = 0

    def only(self, marker_id: int) -> MarkerDetection | None:
        """Return the marker with this id; None if it is not visible, or visible more than once."""
        found = [marker for marker in self.markers if marker.marker_id == marker_id]
        return found[0] if len(found) == 1 else None

    def duplicates(self, marker_id: int) -> bool:
        """Return whether several markers have this id, so that the target is ambiguous."""
        return sum(marker.marker_id == marker_id for marker in self.markers) > 1

    @property
    def nearest_face(self) -> FaceDetection | None:
        """The face that looks largest."""
        return max(self.faces, key=lambda face: face.box[2] * face.box[3], default=None)


class MarkerDetector(Protocol):
    """Finds markers in a grey image."""

    def detect(self, grey: Grey) -> list[MarkerDetection]:
        """Return all markers of the dictionary."""
        ...


def marker_detector(marker: MarkerConfig, of: Calibration) -> MarkerDetector:
    """Return the detector of the configured marker or board. Raises UsageError for an impossible one."""
    board = marker.board
    return ArucoDetector(marker.dictionary, marker.size, of) if board is None else BoardDetector(board, of)


class FaceDetector(Protocol):
    """Finds faces in a grey image. Use from one thread."""

    def detect(self, grey: Grey, near: Box | None = None) -> list[FaceDetection]:
        """Return the faces in an image (rows, columns) uint8, in any order; with `near`, those around it."""
        ...

    def close(self) -> None:
        """End the detector's threads, if it has any. May be called twice."""
        return


@dataclass
class Detector:
    """Markers and faces together."""

    markers: MarkerDetector
    faces: FaceDetector | None = None
    faces_with_markers: bool = False
    "Whether to search faces also while a marker is visible, which takes time and changes nothing."

    def detect(self, grey: Grey, captured: float, frame_id: int = 0) -> Sighting:
        """Return the markers and faces in an image (rows, columns) uint8."""
        markers = tuple(self.markers.detect(grey))
        faces: tuple[FaceDetection, ...] = ()
        if self.faces is not None and (self.faces_with_markers or not markers):
            faces = tuple(self.faces.detect(grey))
        return Sighting(captured, markers, faces, frame_id)

    def close(self) -> None:
        """Close the detectors. May be called twice."""
        if self.faces is not None:
            self.faces.close()
