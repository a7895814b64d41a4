"""Stream of a remote frame grabber: decodes YARP images, and joins its further components to them."""

from __future__ import annotations

import itertools
import logging
import os
import secrets
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np
from typing_extensions import override

from grabbergui.core import pfnc
from grabbergui.core.component import ComponentKind
from grabbergui.core.errors import FrameTimeoutError, GrabberError, PixelFormatError, RemoteProtocolError
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import RateMeter, StreamStatistics
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.pfnc import by_name
from grabbergui.core.scan3d import FollowedScan3d
from grabbergui.net.component_joiner import MOST_COMPONENTS, ComponentJoiner, kind_of
from grabbergui.net.distances import in_camera_units
from grabbergui.net.sender_clock import SenderClock
from grabbergui.net.yarp.image import HEADER, ImageHeader
from grabbergui.net.yarp.os.bottle import Buffer
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.ports import InputPort
from grabbergui.net.yarp.os.stamp import Stamp

log = logging.getLogger(__name__)

FORMATS: Final = {
    **{
        "mono": "Mono8",
        "mo16": "Mono16",
        "dec": "Coord3D_C32f",
        "rgb": "RGB8",
        "bgr": "BGR8",
        "rgba": "RGBa8",
        "bgra": "BGRa8",
    },
    **{"grbg": "BayerGR8", "bggr": "BayerBG8", "gbrg": "BayerGB8", "rggb": "BayerRG8"},
    **{"gr16": "BayerGR16", "bg16": "BayerBG16", "gb16": "BayerGB16", "rg16": "BayerRG16"},
}
"""YARP's pixel codes and the PFNC names of the same layouts."""

_POLL = 0.5
_numbers = itertools.count(1)
_TOKEN: Final = secrets.token_hex(2)
"""Distinguishes programs in two containers, whose process numbers are often the same."""
_COORDINATES: Final = {"Mono16": "Coord3D_C16", "Mono8": "Coord3D_C8"}
"""Formats of distances that arrive without a scale."""


def to_frame(message: Buffer, envelope: str, received_ns: int) -> Frame:
    """Return the frame in an image message, which is not copied. Raises RemoteProtocolError."""
    header = ImageHeader.decode(message)
    name = FORMATS.get(header.code)
    if name is None:
        raise RemoteProtocolError(f"images with pixel code {header.code} cannot be shown")
    if not header.size:
        raise RemoteProtocolError(f"image of {header.width}×{header.height} pixels is empty")
    if len(message) < HEADER.size + header.size:
        raise RemoteProtocolError(f"image lacks {HEADER.size + header.size - len(message)} of its bytes")
    stamp = Stamp.decode(envelope) or Stamp(0, 0.0)
    return Frame(
        payload=np.frombuffer(message, np.uint8, header.size, HEADER.size),
        width=header.width,
        height=header.height,
        pixel_format=pfnc.by_name(name),
        frame_id=stamp.count,
        timestamp_ns=max(0, round(stamp.time * 1e9)),
        received_ns=received_ns,
        padding_x=header.row_bytes - header.depth * header.width,
    )


class ImageReader:
    """Receives one port's images on a thread of its own. `connect` may be called again after a loss."""

    def __init__(
        self,
        source: str,
        names: NameClient,
        deliver: Callable[[Frame], None],
        *,
        carrier: str,
        bind: str,
        pause: Callable[[], float] = lambda: _POLL,
    ) -> None:
        """`pause` returns the seconds for which to wait for the next image."""
        self.ignored = 0
        "Images that could not be decoded."
        self._source = source
        self._carrier = carrier
        self._deliver = deliver
        self._pause = pause
        own = f"/grabbergui/{os.getpid()}-{_TOKEN}/{next(_numbers)}{source}"
        self._port = InputPort(own, names, bind=bind)
        self._refused = ""
        "Reason for which the last image could not be decoded; each reason is logged once."
        self._clock = SenderClock()
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"yarp frames of {source}", daemon=True)

    def open(self) -> None:
        """Register, connect and begin to receive.

        Raises SourceNotFoundError, SourceUnavailableError, TransportError; nothing is left open then.
        """
        self._port.open()
        try:
            self.connect()
        except BaseException:
            self._port.close()
            raise
        self._thread.start()

    def close(self) -> None:
        """Disconnect and stop. May be called twice; never raises."""
        self._stopping.set()
        self._port.close()
        if self._thread.ident is not None and self._thread is not threading.current_thread():
            self._thread.join(5)

    @property
    def connected(self) -> bool:
        """Whether the source is connected to us at the moment."""
        return self._source in self._port.sources

    def silence(self) -> str:
        """Return the state of the connection over which no images arrive, as display text."""
        carrier = self._port.carriers(outgoing=False).get(self._source)
        if carrier is None:
            return f"{self._source} is not connected to this program at the moment"
        if self.ignored:
            return f"{self._source} sends messages that are no images ({self._refused})"
        return f"{self._source} is connected over {carrier} and sends nothing"

    def connect(self) -> None:
        """Connect again. Raises as `open`."""
        self._clock = SenderClock()  # the source may have moved to another computer
        self._port.connect(self._source, self._carrier)

    def disconnect(self) -> None:
        """Close the connection, even if it is dead already. Never raises."""
        self._port.remove_input(self._source)

    def _run(self) -> None:
        while not self._stopping.is_set():
            try:
                message, envelope = self._port.read(self._pause())
            except FrameTimeoutError:
                continue
            arrived, now = time.monotonic_ns(), time.time_ns()
            try:
                frame = to_frame(message, envelope, now)
                age = self._clock.age(frame.timestamp_ns, arrived, now)
                self._deliver(replace(frame, received_ns=now - age, captured=(arrived - age) * 1e-9))
            except (RemoteProtocolError, PixelFormatError) as error:
                self.ignored += 1
                if str(error) != self._refused:
                    self._refused = str(error)
                    log.warning("%s: %s", self._source, error)


class ImageStream(ImageReader):
    """A camera's images with their components, counted."""

    def __init__(
        self,
        source: str,
        names: NameClient,
        deliver: Callable[[Frame], None],
        *,
        carrier: str = "fast_tcp",
        bind: str = "",
        components: ComponentReaders | None = None,
    ) -> None:
        """`components` adds what other ports of the camera send."""
        self._components = components
        self._pass_on = deliver if components is None else components.image
        self._rate = RateMeter()
        self._counters = StreamStatistics()
        self._last_id = -1
        pause = (lambda: _POLL) if components is None else partial(components.expire, _POLL)
        super().__init__(source, names, self._receive, carrier=carrier, bind=bind, pause=pause)

    @override
    def close(self) -> None:
        super().close()
        self._rate.clear()
        if self._components is not None:
            self._components.close()

    def reconnect(self) -> None:
        """Close the old connections and connect again. Raises as `open`.

        A machine that lost its power did not close its connections, so they look alive when it is back.
        `look` connects to the component ports.
        """
        if self._components is not None:
            self._components.disconnect()
        self.disconnect()
        self.connect()

    def look(self) -> None:
        """Connect to new component ports, and close those that disappeared. Raises TransportError."""
        if self._components is not None:
            self._components.look()

    def statistics(self) -> StreamStatistics:
        """Return a snapshot of the counters."""
        snapshot = self._counters.snapshot(self._rate)
        snapshot.packets_ignored = self.ignored
        return snapshot

    def _receive(self, frame: Frame) -> None:
        gap = frame.frame_id - self._last_id - 1
        if self._counters.frames and gap > 0:
            self._counters.lost += gap
        self._last_id = frame.frame_id
        self._counters.frames += 1
        self._counters.bytes += frame.payload.nbytes
        self._rate.add(frame.payload.nbytes)
        self._pass_on(frame)


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
        """Deliver a frame once its components have arrived or their time is over."""
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
        """Connect to new component ports, and close those that disappeared. Raises TransportError."""
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
            if self._closed:
                return
            try:
                self._read(name)
            except GrabberError as error:
                log.debug("%s%s: %s", prefix, name, error)

    def disconnect(self) -> None:
        """Close all connections; the next `look` connects again."""
        for reader in [*self._readers.values()]:
            reader.disconnect()

    def close(self) -> None:
        """Stop all. May be called twice; never raises."""
        self._closed = True
        for reader in [*self._readers.values()]:
            reader.close()
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
