"""Point clouds as images: viewpoint, drawing, and a thread that draws the points of the newest frame."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from psygnal import Signal

from grabbergui.core.coord3d import Scan3d
from grabbergui.core.errors import GrabberError
from grabbergui.core.frame import Frame
from grabbergui.core.pixels import DisplayImage, Region
from grabbergui.core.point_cloud import PointCloud
from grabbergui.models.error_text import error_text
from grabbergui.models.image.quantities import ColourScale

log = logging.getLogger(__name__)

PERIOD = 0.1
"Seconds between two checks for a new frame."
MOST_POINTS = 150_000
"Most points drawn; of a larger cloud every second, third … point is drawn."
BACKGROUND = 34
"Grey value of the background."
_FAR = 2.2
"Distance of the eye from the centre of the cloud, in radii of the cloud."


@dataclass(frozen=True)
class Viewpoint:
    """Viewpoint on the cloud, by default the camera's."""

    yaw: float = 0.0
    "Degrees to the right."
    pitch: float = 0.0
    "Degrees up."
    zoom: float = 1.0

    def turned(self, right: float, up: float) -> Viewpoint:
        """Return the viewpoint rotated by degrees, up to ±89° of pitch."""
        return replace(self, yaw=(self.yaw + right) % 360, pitch=min(max(self.pitch + up, -89.0), 89.0))

    def zoomed(self, factor: float) -> Viewpoint:
        """Return the viewpoint closer (`factor` above 1) or farther."""
        return replace(self, zoom=min(max(self.zoom * factor, 0.1), 20.0))

    def rotation(self) -> NDArray[np.float32]:
        """Return the rotation from the camera's axes to the view's, (3, 3)."""
        yaw, pitch = np.radians([self.yaw, self.pitch])
        around_y = [[np.cos(yaw), 0, np.sin(yaw)], [0, 1, 0], [-np.sin(yaw), 0, np.cos(yaw)]]
        around_x = [[1, 0, 0], [0, np.cos(pitch), -np.sin(pitch)], [0, np.sin(pitch), np.cos(pitch)]]
        return (np.array(around_x) @ np.array(around_y)).astype(np.float32)


def draw(cloud: PointCloud, view: Viewpoint, size: tuple[int, int]) -> DisplayImage:
    """Draw the points on (width, height) pixels, coloured by themselves or by z. Any thread.

    The median of the cloud is at the centre of the image.
    """
    width, height = size
    image = np.full((height * width, 3), BACKGROUND, np.uint8)
    every = max(1, -(-len(cloud.points) // MOST_POINTS))
    points = cloud.points[::every]
    if len(points):
        middle = np.median(points, axis=0)
        apart = points - middle
        radius = max(float(np.percentile(np.abs(apart), 98)), 1e-6)
        seen = apart @ view.rotation().T / np.float32(radius)
        depth = seen[:, 2] + np.float32(_FAR)
        ahead = depth > 0.05
        factor = np.float32(min(width, height) * 0.5 * _FAR * 0.8 * view.zoom) / np.where(ahead, depth, 1)
        column = (seen[:, 0] * factor + width / 2).astype(np.int64)
        line = (seen[:, 1] * factor + height / 2).astype(np.int64)
        shown = ahead & (column >= 0) & (column < width) & (line >= 0) & (line < height)
        # Farthest first: the last point drawn on a pixel remains.
        order = np.flatnonzero(shown)[np.argsort(-depth[shown], kind="stable")]
        image[line[order] * width + column[order]] = _colours(cloud, points, every)[order]
    return DisplayImage(image.reshape(height, width, 3), Region(0, 0, width, height))


def _colours(cloud: PointCloud, points: NDArray[np.float32], every: int) -> NDArray[np.uint8]:
    if cloud.colours is not None:
        return cloud.colours[::every]
    low, high = float(points[:, 2].min()), float(points[:, 2].max())
    place = np.clip((points[:, 2] - low) / max(high - low, 1e-6) * 255, 0, 255).astype(np.uint8)
    return np.asarray(ColourScale(low, high, "", "Turbo").colours[place], np.uint8)


class PointCloudModel:
    """Draws the points of the frame that `newest` returns.

    Any thread may call; signals come from the model's own thread, which runs from `start` to `stop`.
    """

    ready = Signal()
    """`image` is new."""
    failed = Signal(str)
    """Why there are no points, as display text."""

    def __init__(self, newest: Callable[[], Frame | None], scan: Callable[[], Scan3d]) -> None:
        self._newest, self._scan = newest, scan
        self._viewpoint = Viewpoint()
        self._size = (0, 0)
        self._again = threading.Event()
        self._stopping = threading.Event()
        self._thread: threading.Thread | None = None
        self.image: DisplayImage | None = None
        "The latest drawing."

    def start(self, size: tuple[int, int]) -> None:
        """Start to draw on (width, height) pixels, from the camera's viewpoint."""
        self._viewpoint, self._size = Viewpoint(), size
        if self._thread is None or self._stopping.is_set():  # a stopping thread draws no more
            self._stopping = threading.Event()
            stopping = self._stopping
            self._thread = threading.Thread(target=self._run, args=(stopping,), name="points", daemon=True)
            self._thread.start()

    def stop(self, timeout: float = 0.0) -> bool:
        """Stop drawing; return whether the thread ended within `timeout` seconds."""
        self._stopping.set()
        self._again.set()
        if self._thread is None:
            return True
        self._thread.join(timeout)
        return not self._thread.is_alive()

    def turn(self, right: float, up: float) -> None:
        """Move the viewpoint right and up by degrees."""
        self._viewpoint = self._viewpoint.turned(right, up)
        self._again.set()

    def zoom(self, factor: float) -> None:
        """Move the viewpoint closer (`factor` above 1) or farther."""
        self._viewpoint = self._viewpoint.zoomed(factor)
        self._again.set()

    def resize(self, width: int, height: int) -> None:
        """Set the size of the drawing in pixels."""
        self._size = (width, height)
        self._again.set()

    def _run(self, stopping: threading.Event) -> None:
        last: Frame | None = None
        cloud: PointCloud | None = None
        while not stopping.is_set():
            again = self._again.is_set()
            self._again.clear()
            frame = self._newest()
            try:
                if frame is not None and frame is not last:
                    last, again = frame, True
                    cloud = None
                    cloud = PointCloud.of(frame, self._scan())
                if again and cloud is not None and min(self._size) > 0:
                    self.image = draw(cloud, self._viewpoint, self._size)
                    self.ready.emit()
            except GrabberError as error:
                self.failed.emit(error_text(error))
            except Exception as error:
                log.exception("a point cloud could not be drawn")
                self.failed.emit(str(error))
            self._again.wait(PERIOD)
