"""Readers of the ports that a camera's further components have, and their images joined with the first."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Final

from grabbergui.core.component import ComponentKind
from grabbergui.core.errors import GrabberError
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.pfnc import by_name
from grabbergui.core.scan3d import FollowedScan3d, in_camera_units
from grabbergui.net.component_joiner import MOST_COMPONENTS, ComponentJoiner, kind_of
from grabbergui.net.yarp.client_stream import ImageReader
from grabbergui.net.yarp.os.name_client import NameClient

log = logging.getLogger(__name__)

_COORDINATES: Final = {"Mono16": "Coord3D_C16", "Mono8": "Coord3D_C8"}
"""Formats that distances without a scale arrive in."""


class ComponentReaders:
    """One input port and thread for each component port of a camera. All methods from any thread.

    Frames are delivered on the thread whose image completed them, one at a time and in order.
    """

    def __init__(
        self,
        grabber: FrameGrabber,
        source: str,
        names: NameClient,
        deliver: Callable[[Frame], None],
        *,
        carrier: str,
        bind: str,
    ) -> None:
        """`grabber` reports what distances mean; `source` is the camera's first port."""
        self._grabber = grabber
        self._source = source
        self._names = names
        self._deliver = deliver
        self._carrier = carrier if carrier != "mjpeg" else "fast_tcp"  # distances do not survive JPEG
        self._bind = bind
        self._joiner = ComponentJoiner()
        self._lock = threading.Lock()
        self._readers: dict[str, ImageReader] = {}
        self._scan: FollowedScan3d | None = None
        self._closed = False

    def image(self, frame: Frame) -> None:
        """Deliver a frame once its components are there, or are not waited for any more."""
        with self._lock:
            self._send(self._joiner.image(frame, time.monotonic()))

    def expire(self, most: float) -> float:
        """Deliver what has waited long enough; return seconds until the next, at most `most`."""
        with self._lock:
            now = time.monotonic()
            self._send(self._joiner.due(now))
            deadline = self._joiner.deadline
        return most if deadline is None else min(most, max(0.0, deadline - now))

    def look(self) -> None:
        """Connect to component ports that appeared, and leave those that are gone. Raises TransportError."""
        prefix = f"{self._source}/"
        present = {
            contact.name.removeprefix(prefix)
            for contact in self._names.list(prefix)
            if contact.name.startswith(prefix)
        }
        wanted = sorted(name for name in present if kind_of(name) is not None)[:MOST_COMPONENTS]
        for name in [name for name in self._readers if name not in wanted]:
            self._readers.pop(name).close()
            with self._lock:
                self._send(self._joiner.forget(name))
        for name in wanted:
            try:
                self._read(name)
            except GrabberError as error:
                log.debug("%s%s: %s", prefix, name, error)

    def close(self) -> None:
        """Stop all. May be called twice; never raises."""
        self._closed = True
        for reader in self._readers.values():
            reader.close()
        self._readers.clear()
        if self._scan is not None:
            self._scan.close()

    def _read(self, name: str) -> None:
        reader = self._readers.get(name)
        if reader is not None:
            if not reader.connected:
                reader.connect()
            return
        if self._scan is None:
            self._scan = FollowedScan3d(self._grabber)
        reader = ImageReader(
            f"{self._source}/{name}",
            self._names,
            self._receiver(name),
            carrier=self._carrier,
            bind=self._bind,
        )
        reader.open()
        self._readers[name] = reader
        if self._closed:
            reader.close()

    def _receiver(self, name: str) -> Callable[[Frame], None]:
        distances = kind_of(name) in (ComponentKind.RANGE, ComponentKind.DISPARITY)

        def receive(frame: Frame) -> None:
            if distances and frame.pixel_format.name in _COORDINATES:
                frame = replace(frame, pixel_format=by_name(_COORDINATES[frame.pixel_format.name]))
            if self._scan is not None:
                frame = in_camera_units(frame, self._scan.value)
            with self._lock:
                self._send(self._joiner.component(name, frame, time.monotonic()))

        return receive

    def _send(self, frames: list[Frame]) -> None:
        for frame in frames:
            self._deliver(frame)
