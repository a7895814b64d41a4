"""Cameras that consist of a vendor's description over registers with plausible contents."""

from __future__ import annotations

import random
import threading
import time
from collections.abc import Callable
from contextlib import suppress

import numpy as np

from fakes import XmlDevice
from grabbergui.core import pfnc
from grabbergui.core.errors import DeviceStatusError, GrabberError
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.driver.device import FrameCounter, StreamRequest, check_payload_size
from grabbergui.driver.genapi.node_map import CameraNodeMap

WIDTH, HEIGHT = 64, 48
_LIMITS = ("SensorWidth", "SensorHeight", "WidthMax", "HeightMax")
_FORMATS = ("Mono8", "BayerRG8", "BayerGB8")
_REFUSED = (0x8003, 0x8006, 0x8007)


class VendorsCamera(XmlDevice):
    """Answers with `fill` where nothing was written, refuses some registers, and sends small frames."""

    def __init__(self, xml: bytes, fill: Callable[[int], int] = lambda address: 0, refusing: int = 0) -> None:
        """`refusing`: seed of the registers that are refused, one of twenty; 0: none."""
        super().__init__(xml)
        self._fill = fill
        self.refusing = refusing
        self.last: tuple[int, int] = (0, 4)

    def read(self, address: int, length: int) -> bytes:
        self.last = (address, length)
        if self.refusing and random.Random(address * 1000 + self.refusing).random() < 0.05:
            raise DeviceStatusError(f"no register at 0x{address:X}", _REFUSED[address // 4 % 3])
        return bytes(self.memory.get(address + at, self._fill(address + at)) for at in range(length))

    def open_stream(self, request: StreamRequest, deliver: Callable[[Frame], None]) -> None:
        check_payload_size(request.payload_size)
        self._receiving = _Stream(request.payload_size, deliver)


class _Stream:
    def __init__(self, size: int, deliver: Callable[[Frame], None]) -> None:
        self._counter = FrameCounter()
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, args=(size, deliver), daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._stopping.set()
        self._thread.join()

    def statistics(self) -> StreamStatistics:
        return self._counter.statistics()

    def _run(self, size: int, deliver: Callable[[Frame], None]) -> None:
        if size < WIDTH * HEIGHT:
            return  # as a camera whose frames are larger than it announces
        number = 0
        while not self._stopping.wait(0.002):
            number += 1
            payload = np.zeros(WIDTH * HEIGHT, np.uint8)
            self._counter.note_complete(payload.nbytes)
            stamp = number * 2_000_000
            deliver(Frame(payload, WIDTH, HEIGHT, pfnc.by_name("Mono8"), number, stamp, time.time_ns()))


def made_plausible(device: VendorsCamera) -> VendorsCamera:
    """Give the sensor and the image a size, and the image a format, where the description allows it."""
    nodes = CameraNodeMap(device, device.xml, lambda names: None)
    try:
        for name in _LIMITS:
            _put(nodes, device, name, 1024)
        for name, value in (("Width", WIDTH), ("Height", HEIGHT), ("PayloadSize", WIDTH * HEIGHT)):
            with suppress(GrabberError):
                if nodes.has(name) and nodes.feature(name).access.writable:
                    nodes.write(name, value)
            _put(nodes, device, name, value)
        if nodes.has("PixelFormat"):
            feature = nodes.feature("PixelFormat")
            entries = sorted(feature.entries, key=lambda entry: entry.name not in _FORMATS)
            with suppress(GrabberError):
                nodes.write("PixelFormat", entries[0].name if entries else "Mono8")
    finally:
        nodes.close()
    device.writes.clear()
    return device


def _put(nodes: CameraNodeMap, device: VendorsCamera, name: str, value: int) -> None:
    """Change the register that a feature is read from last, until the feature has the value."""
    if not nodes.has(name):
        return

    def current() -> object:
        nodes.invalidate(frozenset({name}))
        return nodes.value(name)

    if current() == value or device.last[1] > 8:
        return
    address, length = device.last
    before = dict(device.memory)
    for shift in range(0, length * 8 - 15):
        for order in ("big", "little"):
            content = ((value << shift) & (1 << 8 * length) - 1).to_bytes(length, order)  # type: ignore[arg-type]
            device.memory.update({address + at: byte for at, byte in enumerate(content)})
            if current() == value:
                return
    device.memory = before
    current()
