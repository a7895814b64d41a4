"""Stream of a remote frame grabber: YARP images to frames."""

from __future__ import annotations

import itertools
import logging
import os
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Final, Protocol

import numpy as np
from typing_extensions import override

from grabbergui.core import pfnc
from grabbergui.core.errors import FrameTimeoutError, PixelFormatError, RemoteProtocolError
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import RateMeter
from grabbergui.core.grabber import StreamStatistics
from grabbergui.net.yarp.image import HEADER, ImageHeader
from grabbergui.net.yarp.os.bottle import Buffer
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.ports import InputPort
from grabbergui.net.yarp.os.values import Stamp

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


class ComponentPorts(Protocol):
    """What a stream needs of its components."""

    def image(self, frame: Frame) -> None:
        """Deliver a frame once its components are there, or are not waited for any more."""

    def expire(self, most: float) -> float:
        """Deliver what has waited long enough; return seconds until the next, at most `most`."""

    def look(self) -> None:
        """Find component ports."""

    def close(self) -> None:
        """Stop."""


def to_frame(message: Buffer, envelope: str, received_ns: int) -> Frame:
    """Return the frame in an image message, which is not copied. Raises RemoteProtocolError."""
    header = ImageHeader.decode(message)
    name = FORMATS.get(header.code)
    if name is None:
        raise RemoteProtocolError(f"pictures with pixel code {header.code} cannot be shown")
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
        self._port = InputPort(f"/grabbergui/{os.getpid()}/{next(_numbers)}{source}", names, bind=bind)
        self._refused = ""
        "Reason for which the last image could not be decoded; each reason is logged once."
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

    def connect(self) -> None:
        """Connect again. Raises as `open`."""
        self._port.connect(self._source, self._carrier)

    def reconnect(self) -> None:
        """Close the old connection and connect again. Raises as `open`."""
        self._port.remove_input(self._source)
        self.connect()

    def _run(self) -> None:
        while not self._stopping.is_set():
            try:
                message, envelope = self._port.read(self._pause())
            except FrameTimeoutError:
                continue
            try:
                self._deliver(to_frame(message, envelope, time.time_ns()))
            except (RemoteProtocolError, PixelFormatError) as error:
                self.ignored += 1
                if str(error) != self._refused:
                    self._refused = str(error)
                    log.warning("%s: %s", self._source, error)


class PictureStream(ImageReader):
    """A camera's images with their components, counted."""

    def __init__(
        self,
        source: str,
        names: NameClient,
        deliver: Callable[[Frame], None],
        *,
        carrier: str = "fast_tcp",
        bind: str = "",
        components: ComponentPorts | None = None,
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
        if self._components is not None:
            self._components.close()

    def look(self) -> None:
        """Connect to component ports that appeared, and leave those that are gone. Raises TransportError."""
        if self._components is not None:
            self._components.look()

    def statistics(self) -> StreamStatistics:
        """Return a snapshot of the counters."""
        rate, bandwidth = self._rate.rates()
        counters = self._counters
        return StreamStatistics(
            frames=counters.frames,
            lost=counters.lost,
            bytes=counters.bytes,
            packets_ignored=self.ignored,
            frame_rate=rate,
            bandwidth=bandwidth,
        )

    def _receive(self, frame: Frame) -> None:
        gap = frame.frame_id - self._last_id - 1
        if self._counters.frames and gap > 0:
            self._counters.lost += gap
        self._last_id = frame.frame_id
        self._counters.frames += 1
        self._counters.bytes += frame.payload.nbytes
        self._rate.add(frame.payload.nbytes)
        self._pass_on(frame)
