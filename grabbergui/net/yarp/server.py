"""Shares a grabber on a YARP network, as frameGrabber_nws_yarp does.

A port for each further component of the frames (NAME/range, NAME/confidence) is an addition to YARP's.
"""

from __future__ import annotations

import logging
import shlex
import time
from collections.abc import Callable
from functools import partial

import numpy as np

from grabbergui.calibration.fitting import FittedCalibration
from grabbergui.config.allowed_addresses import EVERYBODY, AllowedAddresses
from grabbergui.core.errors import GrabberError
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameSink
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.requester import requested_by
from grabbergui.core.scan3d import CurrentScan3d
from grabbergui.net.component_joiner import MOST_COMPONENTS, components_of
from grabbergui.net.distances import in_metres
from grabbergui.net.readers import Reader
from grabbergui.net.tree import Terminal, no_terminal
from grabbergui.net.yarp import image
from grabbergui.net.yarp.grabber_image import MONO, PIXELS, Capability
from grabbergui.net.yarp.grabber_service import GrabberService
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.inputs import Reply, Request
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.port import Port
from grabbergui.net.yarp.os.ports import OutputPort, RpcServer
from grabbergui.net.yarp.os.stamp import Stamp
from grabbergui.net.yarp.os.values import item_text

log = logging.getLogger(__name__)

_POLL = 0.5
"""Seconds after which a publisher without frames checks whether it should stop."""

DEFAULT_NAME = "/grabber"


class YarpGrabberServer:
    """Ports NAME (images, and requests as well), NAME/rpc, and NAME/raw where asked.

    Frames with several components open a port for each further one: see `ComponentPorts`.

    Any thread may call. A reader that is slow or stuck holds up neither the camera nor another reader; while
    there are no readers, no image is converted.
    """

    def __init__(
        self,
        grabber: FrameGrabber,
        name: str = DEFAULT_NAME,
        *,
        names: NameClient | None = None,
        capabilities: Capability = Capability.COLOR,
        also_raw: bool = False,
        period: float = 0.0,
        normalised: bool = False,
        bind: str = "",
        allowed: AllowedAddresses = EVERYBODY,
        terminal: Terminal = no_terminal,
        calibration: FittedCalibration | None = None,
    ) -> None:
        """Prepare to share an open grabber.

        `period` is the least time between two images in seconds, 0 for all. With `normalised` the values
        of features go from 0 to 1. Without `names` the ports are reached as ``tcp://HOST:PORT/`` only.
        `terminal` runs the lines that arrive at NAME/terminal. Peers that are not `allowed` are not answered.
        Intrinsics and field of view are those of `calibration`, without it those that the source itself
        reports.
        """
        self.name = name = name.rstrip("/") or name  # /grabber/ would have its requests at /grabber//rpc
        self._grabber = grabber
        self._calibration = calibration or FittedCalibration(grabber)
        self._service = GrabberService(
            grabber, normalised=normalised, terminal=terminal, calibration=self._calibration
        )
        self._run_line = terminal
        self._rpc = RpcServer(f"{name}/rpc", self._answer, names, bind=bind, allowed=allowed)
        self._terminal = RpcServer(f"{name}/terminal", self._answer_line, names, bind=bind, allowed=allowed)
        images = OutputPort(name, names, handler=self._answer, bind=bind, allowed=allowed)
        self._publishers = [_Publisher(grabber, images, capabilities, period)]
        if also_raw:
            raw = OutputPort(f"{name}/raw", names, handler=self._answer, bind=bind, allowed=allowed)
            self._publishers.append(_Publisher(grabber, raw, Capability.RAW, period))
        self._components = ComponentPorts(
            grabber, name, partial(OutputPort, names=names, handler=self._answer, bind=bind, allowed=allowed)
        )
        self._started_stream = False

    def start(self) -> None:
        """Open the ports, and start the stream where it is off.

        Raises SourceUnavailableError without a name server, TransportError where an address is taken, and
        what `FrameGrabber.start` raises; nothing is left open then.
        """
        try:
            self._rpc.open()
            self._terminal.open()
            for publisher in self._publishers:
                publisher.start()
            self._components.start()
            if not self._grabber.streaming:
                self._grabber.start()
                self._started_stream = True
            self._calibration.assume_settings()
        except GrabberError:
            self.stop()
            raise
        log.info("%s is shared as %s", self._grabber.info.title, ", ".join(self.places()))

    def stop(self) -> None:
        """Close the ports, and stop the stream where we started it. May be called twice; never raises."""
        for port in self._ports():
            port.give_up_name()
        self._service.close()  # first, so that no port waits for requests that wait for a frame
        for publisher in self._publishers:
            publisher.stop()
        self._components.stop()
        self._rpc.close()
        self._terminal.close()
        if self._started_stream:
            self._started_stream = False
            try:
                self._grabber.stop()
            except GrabberError as error:
                log.warning("%s could not be stopped: %s", self._grabber.info.title, error)

    def __enter__(self) -> YarpGrabberServer:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def places(self) -> list[str]:
        """Return each port's name and address as display text: ``/grabber at tcp://127.0.0.1:10003/``."""
        return [f"{port.name} at {port.place()}" for port in self._ports()]

    def _ports(self) -> list[Port]:
        images = [publisher.port for publisher in self._publishers]
        return [*images, *self._components.ports, self._rpc, self._terminal]

    @property
    def readers(self) -> int:
        """The number of connected readers of images."""
        images = [publisher.port for publisher in self._publishers]
        return sum(port.connections for port in (*images, *self._components.ports))

    def connected(self) -> list[Reader]:
        """Return who takes images, and who only asks. Any thread."""
        images = [publisher.port for publisher in self._publishers]
        readers = [
            Reader(
                output.reader,
                f"{port.name} ({output.carrier_text})",
                output.address,
                output.messages,
                output.bytes,
            )
            for port in (*images, *self._components.ports)
            for output in port.outputs
        ]
        askers = [
            Reader(peer.peer, port.name, peer.address)
            for port in (self._rpc, self._terminal, *images)
            for peer in port.peers
        ]
        return [*readers, *askers]

    @property
    def published(self) -> int:
        """Number of images sent since the start, each counted once for all readers."""
        return sum(publisher.published for publisher in self._publishers)

    def _answer(self, request: Request) -> Reply:
        with requested_by(_author(request)):
            return self._service.answer(request.bottle())

    def _answer_line(self, request: Request) -> Reply:
        """Run a line from `yarp rpc` on the terminal; the reply's items are the lines of the answer."""
        try:
            words = [item_text(item) for item in request.bottle()]
            # A single string may be the whole line; of several each stays one word, whatever is in it.
            line = words[0] if len(words) == 1 else shlex.join(words)
            with requested_by(_author(request)):
                text = self._run_line(line)
        except GrabberError as error:
            return Bottle(["fail", str(error)])
        return Bottle(text.splitlines() or ["ok"])


def _author(request: Request) -> str:
    """Return the port that asked, or where it is: programs without a port call themselves `anon_rpc`."""
    info = request.info
    return info.peer if info.peer.startswith("/") else info.place


class _Publisher:
    """Sends frames on one port, on a thread of its own."""

    def __init__(
        self, grabber: FrameGrabber, port: OutputPort, capability: Capability, period: float
    ) -> None:
        self.port = port
        self.published = 0
        self._capability = capability
        self._period = period
        self._due = 0.0
        self._sink = FrameSink(
            grabber,
            self._offer,
            name=f"yarp {port.name} images",
            depth=1,
            wait=_POLL,
            reopens=True,
            realtime=True,
        )

    def start(self) -> None:
        self.port.open()
        self._sink.start()

    def stop(self) -> None:
        self._sink.stop(5)
        self.port.close()

    def _offer(self, frame: Frame) -> bool:
        """Send a frame; return whether it was due."""
        now = time.monotonic()
        if not self.port.connections or now < self._due:
            return False
        # Count from the due time to keep the rate, whenever frames arrive.
        self._due += self._period
        if self._due <= now:
            self._due = now + self._period
        stamp = Stamp(self.published, frame.received_ns / 1e9).encode()
        for layout in self.port.asked_for(PIXELS):
            header, pixels = self._capability.encode(frame, mono=layout == MONO)
            self.port.write(header, pixels, stamp, only=(PIXELS, layout))
        self.published += 1
        return True


class ComponentPorts:
    """Opens a port when a frame first has the component, and sends it there from a thread of its own.

    Range images are [dec], metres, NaN where nothing was measured; others as the sensor has them. While
    a port has no readers, nothing is converted for it.
    """

    def __init__(self, grabber: FrameGrabber, name: str, make_port: Callable[[str], OutputPort]) -> None:
        """`make_port` makes a port, not yet open, of a name."""
        self._name = name
        self._make_port = make_port
        self._scan = CurrentScan3d(grabber)
        self._ports: dict[str, OutputPort] = {}
        self._sent = 0
        self._sink = FrameSink(
            grabber, self._offer, name=f"yarp {name} components", depth=1, wait=_POLL, reopens=True
        )

    def start(self) -> None:
        """Begin with the next frame."""
        self._sink.start()

    def stop(self) -> None:
        """Close the ports. May be called twice."""
        self._sink.stop(5)
        self._scan.close()
        for port in self.ports:
            port.close()
        self._ports.clear()

    @property
    def ports(self) -> tuple[OutputPort, ...]:
        """The open ports."""
        return tuple(self._ports.values())

    def _offer(self, frame: Frame) -> bool:
        if not frame.parts and not frame.pixel_format.is_coordinate:
            return False
        sent = False
        for name, part in components_of(frame):
            port = self._port(name)
            if port is not None and port.connections:
                header, pixels = _encoded(in_metres(frame.of_component(part), self._scan.value))
                port.write(header, pixels, Stamp(self._sent, frame.received_ns / 1e9).encode())
                sent = True
        self._sent += sent
        return sent

    def _port(self, name: str) -> OutputPort | None:
        if name not in self._ports and len(self._ports) < MOST_COMPONENTS:
            port = self._make_port(f"{self._name}/{name}")
            port.open()
            log.info("%s is at %s", name, port.place())
            self._ports[name] = port
        return self._ports.get(name)


def _encoded(frame: Frame) -> tuple[bytes, memoryview]:
    pixels = frame.raw()
    if pixels.dtype == np.float32 and pixels.ndim == 2:
        return image.encode(pixels, "dec")
    return Capability.RAW.encode(frame)
