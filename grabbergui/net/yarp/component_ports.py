"""A port for each further component of a camera's frames: NAME/range, NAME/confidence."""

from __future__ import annotations

import logging
from collections.abc import Callable

import numpy as np

from grabbergui.core.frame import Frame
from grabbergui.core.frame_sink import FrameSink
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.scan3d import CurrentScan3d, components_of, in_metres
from grabbergui.net.yarp import image
from grabbergui.net.yarp.image import Capability
from grabbergui.net.yarp.os.ports import OutputPort
from grabbergui.net.yarp.os.values import Stamp

log = logging.getLogger(__name__)

_POLL = 0.5
"""Seconds after which the thread without frames looks whether it shall stop."""
MOST_PORTS = 16
"""A camera that names more components is not believed."""


class ComponentPorts:
    """Opens a port when a frame first has the component, and sends it there from a thread of its own.

    Range images are [dec], metres, NaN where nothing was measured; others as the sensor has them. While
    nobody reads a port, nothing is converted for it.
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
        if name not in self._ports and len(self._ports) < MOST_PORTS:
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
