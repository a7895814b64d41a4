"""Heads by the cascade classifiers that opencv-python 4.x ships, or by YuNet where its model is given."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np

from grabbergui.calibration.markers import Grey
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import SourceUnavailableError, UsageError
from grabbergui.servo.detection import HeadDetection

SEARCH_WIDTH = 320
"Pictures are reduced to about this width: a head of a twelfth of it is still found."
HEAD_WIDTH = 0.19
"Metres that a cascade's box is wide at the head's place."
_SMALLEST = 24
_CASCADE = "haarcascade_frontalface_default.xml"


class CascadeFinder:
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

    def detect(self, grey: Grey) -> list[HeadDetection]:
        """All heads in a picture (rows, columns) uint8."""
        factor = max(1, round(grey.shape[1] / self._search_width))
        reduced = _reduced(grey, factor)
        boxes = self._cascade.detectMultiScale(
            reduced, scaleFactor=1.1, minNeighbors=4, minSize=(_SMALLEST, _SMALLEST)
        )
        return [_head(box, factor, self._calibration, grey) for box in np.reshape(boxes, (-1, 4))]


class YuNetFinder:
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

    def detect(self, grey: Grey) -> list[HeadDetection]:
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


def _head(box: np.ndarray, factor: int, calibration: Calibration, grey: Grey) -> HeadDetection:
    x, y, width, height = (round(float(value) * factor) for value in box)
    matrix = calibration.scaled_to(grey.shape[1], grey.shape[0]).matrix
    distance = float(matrix[0, 0]) * HEAD_WIDTH / max(width, 1)
    centre = np.array([[[x + width / 2 - 0.5, y + height / 2 - 0.5]]])
    along_x, along_y = np.ravel(cv2.undistortPoints(centre, matrix, calibration.distortion))
    return HeadDetection(
        (x, y, width, height), (float(along_x) * distance, float(along_y) * distance, distance)
    )
