"""The point cloud of the newest frame, drawn on a thread of its own while its window is open."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable

from psygnal import Signal

from grabbergui.core.errors import GrabberError
from grabbergui.core.frame import Frame
from grabbergui.core.pixels import DisplayImage
from grabbergui.core.point_cloud import PointCloud
from grabbergui.core.scan3d import Scan3d
from grabbergui.models.error_text import error_text
from grabbergui.models.picture.point_view import Viewpoint, draw

log = logging.getLogger(__name__)

PERIOD = 0.1
"Seconds between two looks for another frame."


class PointCloudModel:
    """Draws the points of what `newest` gives. Any thread may call; signals come from its own."""

    ready = Signal()
    """Another image can be had from `image`."""
    failed = Signal(str)
    """Reason for which there are no points, as display text."""

    def __init__(self, newest: Callable[[], Frame | None], scan: Callable[[], Scan3d]) -> None:
        self._newest, self._scan = newest, scan
        self._viewpoint = Viewpoint()
        self._size = (0, 0)
        self._again = threading.Event()
        self._stopping = threading.Event()
        self._thread: threading.Thread | None = None
        self.image: DisplayImage | None = None
        "Drawn last."

    def start(self, size: tuple[int, int]) -> None:
        """Draw from now on, on (width, height) pixels, as seen from the camera."""
        self._viewpoint, self._size = Viewpoint(), size
        if self._thread is None or self._stopping.is_set():  # one that ends draws no more
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
        """Look from farther right or up, in degrees."""
        self._viewpoint = self._viewpoint.turned(right, up)
        self._again.set()

    def zoom(self, factor: float) -> None:
        """Look from nearer (above 1) or farther."""
        self._viewpoint = self._viewpoint.zoomed(factor)
        self._again.set()

    def resize(self, width: int, height: int) -> None:
        """Draw on so many pixels."""
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
