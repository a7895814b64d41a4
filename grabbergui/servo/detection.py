"""Markers and faces found in one frame, in pixels and, with a calibration, in metres.

Positions are in the camera's optical frame: x right, y down, z forward. Faces are found by the cascade
classifiers that opencv-python 4.x ships, or by YuNet where its model is given.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import cv2
import numpy as np

from grabbergui.calibration.markers import Grey, MarkerDetection
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import SourceUnavailableError, UsageError


@dataclass(frozen=True)
class FaceDetection:
    """One head, seen from the front."""

    box: tuple[int, int, int, int]
    "x, y, width, height in pixels of the full picture."
    position: tuple[float, float, float]
    "Metres; the distance is told from the box's width, so it is rough."


@dataclass(frozen=True, eq=False)
class Sighting:
    """All that was found in one picture."""

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


class FaceDetector(Protocol):
    """Finds heads in a grey picture."""

    def detect(self, grey: Grey) -> list[FaceDetection]:
        """All faces, in no order."""
        ...


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


SEARCH_WIDTH = 320
"Pictures are reduced to about this width: a head of a twelfth of it is still found."
HEAD_WIDTH = 0.19
"Metres that a cascade's box is wide at the head's place."
_SMALLEST = 24
_CASCADE = "haarcascade_frontalface_default.xml"


class CascadeFaceDetector:
    """Frontal heads by a Haar cascade. Use from one thread."""

    def __init__(self, calibration: Calibration, search_width: int = SEARCH_WIDTH) -> None:
        """The calibration may be nominal: it only turns pixels into directions."""
        folder = getattr(getattr(cv2, "data", None), "haarcascades", "")
        path = Path(folder) / _CASCADE
        if not hasattr(cv2, "CascadeClassifier") or not path.is_file():
            raise SourceUnavailableError(
                f"this OpenCV ({cv2.__version__}) has no head cascade; install opencv-python-headless 4.x"
            )
        self._cascade = cv2.CascadeClassifier(str(path))
        self._calibration = calibration
        self._search_width = search_width

    def detect(self, grey: Grey) -> list[FaceDetection]:
        """All heads in a picture (rows, columns) uint8."""
        factor = max(1, round(grey.shape[1] / self._search_width))
        reduced = _reduced(grey, factor)
        boxes = self._cascade.detectMultiScale(
            reduced, scaleFactor=1.1, minNeighbors=4, minSize=(_SMALLEST, _SMALLEST)
        )
        return [_head(box, factor, self._calibration, grey) for box in np.reshape(boxes, (-1, 4))]


class YuNetFaceDetector:
    """Heads by OpenCV's FaceDetectorYN with a model file of its zoo. Use from one thread."""

    def __init__(self, model: Path, calibration: Calibration, search_width: int = SEARCH_WIDTH) -> None:
        if not model.is_file():
            raise UsageError(f"there is no head model {model}; YuNet's .onnx file is in OpenCV's model zoo")
        try:
            self._network: Any = cv2.FaceDetectorYN.create(str(model), "", (320, 320), 0.7)
        except cv2.error as error:
            raise UsageError(f"{model} is no YuNet model: {error}") from error
        self._calibration = calibration
        self._search_width = search_width

    def detect(self, grey: Grey) -> list[FaceDetection]:
        """All heads in a picture (rows, columns) uint8."""
        factor = max(1, round(grey.shape[1] / self._search_width))
        reduced = cv2.cvtColor(_reduced(grey, factor), cv2.COLOR_GRAY2BGR)
        self._network.setInputSize((reduced.shape[1], reduced.shape[0]))
        _, faces = self._network.detect(reduced)
        if faces is None:
            return []
        return [_head(face[:4], factor, self._calibration, grey) for face in faces]


def _reduced(grey: Grey, factor: int) -> Grey:
    if factor == 1:
        return grey
    size = grey.shape[1] // factor, max(1, grey.shape[0] // factor)
    reduced: Grey = cv2.resize(grey, size, interpolation=cv2.INTER_AREA)  # type: ignore[assignment]
    return reduced


def _head(box: np.ndarray, factor: int, calibration: Calibration, grey: Grey) -> FaceDetection:
    x, y, width, height = (round(float(value) * factor) for value in box)
    matrix = calibration.scaled_to(grey.shape[1], grey.shape[0]).matrix
    distance = float(matrix[0, 0]) * HEAD_WIDTH / max(width, 1)
    centre = np.array([[[x + width / 2 - 0.5, y + height / 2 - 0.5]]])
    along_x, along_y = np.ravel(cv2.undistortPoints(centre, matrix, calibration.distortion))
    return FaceDetection(
        (x, y, width, height), (float(along_x) * distance, float(along_y) * distance, distance)
    )
