"""A camera made of a report: its memory, its commands, and frames as it sent them.

Frames have the size and pixel format that its features have at the moment, and the rate, ids and time stamps
that were recorded; instead of the scene they show a ramp, or the recorded pixels if the report has them.
"""

from __future__ import annotations

import itertools
import logging
import statistics
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grabbergui.core import pfnc
from grabbergui.core.errors import GrabberError
from grabbergui.core.features import FeatureKind
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import Access
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.pfnc import PixelFormat
from grabbergui.driver.device import Device, StreamRequest
from grabbergui.driver.genapi.node_map import CameraNodeMap
from grabbergui.driver.sim.model import FramePlan
from grabbergui.driver.sim.settings import FrameSettings, Optics
from grabbergui.driver.twin.memory import TwinMemory
from grabbergui.driver.twin.report_file import CameraReport, FrameRecord

log = logging.getLogger(__name__)

START, STOP = "AcquisitionStart", "AcquisitionStop"
_USUAL_PERIOD = 0.1
"Seconds between frames if the report has too few."
_SHORTEST_PERIOD, _LONGEST_PERIOD = 0.002, 5.0
WIDEST = 1 << 20
"Pixels of a frame's width or height; beyond it the size of the last recorded frame is taken."
LARGEST_FRAME = 128 << 20
"Bytes; a report that asks for more comes from no camera."
_GEOMETRY = ("Width", "Height", "PixelFormat", "PayloadSize")


@dataclass(frozen=True)
class _Layout:
    width: int
    height: int
    pixel_format: PixelFormat
    payload_bytes: int


class TwinModel:
    """The camera behind its registers; `next_frame` and `render` are for one thread, the stream's."""

    def __init__(self, report: CameraReport) -> None:
        self.report = report
        self.memory = TwinMemory((*report.bootstrap, *report.registers), report.stream.accesses)
        triggered = any(
            row.get("name") == "TriggerMode" and row.get("value") == "On" for row in report.features
        )
        received = any(frame.complete for frame in report.stream.frames)
        self.silent = report.stream.started and not received and not triggered
        "Whether the original was started, did not wait for a trigger, and sent no whole frame."
        self._changed = threading.Condition()
        self._woken = False
        self._count = 0
        self._due = 0.0
        self._period = _period(report.stream.frames)
        self._inside = _Inside(self.memory)
        self._nodes = self._load()
        self._switches: list[tuple[int, bytes, bool]] = []
        "Address and bytes of writes that start (True) and stop the acquisition."
        self._running = False
        if self._nodes is not None:
            self._find_commands(self._nodes)
        self._running = not self._starts()
        self.memory.on_written = self._on_written

    def close(self) -> None:
        """Release the description. May be called twice."""
        nodes, self._nodes = self._nodes, None
        if nodes is not None:
            nodes.close()

    def read(self, address: int, length: int) -> bytes:
        """Return register bytes. Raises what the original raised."""
        return self.memory.read(address, length)

    def write(self, address: int, data: bytes) -> None:
        """Write registers. Raises what the original raised."""
        self.memory.write(address, data)

    def stop(self) -> None:
        """End the acquisition, as when control is lost."""
        with self._changed:
            self._running = not self._starts()
            self._changed.notify_all()

    def timestamp(self) -> int:
        """Return the device's clock in nanoseconds."""
        return time.monotonic_ns()

    def trigger_action(self, at: int | None = None) -> bool:
        """Do nothing: a report does not show what an action does."""
        return False

    def next_frame(self, timeout: float) -> FramePlan | None:
        """Wait for the next frame; None after `timeout` seconds without, or after `wake`."""
        deadline = time.monotonic() + timeout
        with self._changed:
            while True:
                now = time.monotonic()
                sends = self._running and not self.silent
                if sends and now >= self._due:
                    self._due = max(self._due + self._period, now)
                    break
                if now >= deadline or self._woken:
                    self._woken = False
                    return None
                self._changed.wait((min(deadline, self._due) if sends else deadline) - now)
            self._count += 1
            count = self._count
        layout = self._layout()
        settings = FrameSettings(
            layout.width, layout.height, 0, 0, layout.pixel_format, Optics(), 0.0, 0.0, 0.0
        )
        return FramePlan(self._id(count), self._stamp(count), settings, {}, layout.payload_bytes)

    def wake(self) -> None:
        """Let `next_frame` return at once. Any thread."""
        with self._changed:
            self._woken = True
            self._changed.notify_all()

    def render(self, plan: FramePlan, out: NDArray[np.uint8]) -> int:
        """Write a frame's payload into `out`, and return its length."""
        size = plan.payload_bytes
        pixels = self.report.pixels
        fitting = [payload for payload in pixels if len(payload) >= size]
        if fitting:
            out[:size] = np.frombuffer(fitting[self._count % len(fitting)], np.uint8, size)
            return size
        line = min(max(plan.settings.pixel_format.line_bytes(plan.settings.width), 1), size)
        ramp = (np.arange(line) * 256 // line + self._count).astype(np.uint8)
        out[:size] = np.resize(ramp, size)
        return size

    def _id(self, count: int) -> int:
        frames = self.report.stream.frames
        first = frames[0].frame_id if frames else 1
        steps = [after.frame_id - before.frame_id for before, after in _pairs(frames)]
        step = statistics.mode(steps) if steps else 1
        return max(first + step * (count - 1), 1)

    def _stamp(self, count: int) -> int:
        frames = self.report.stream.frames
        steps = [after.timestamp_ns - before.timestamp_ns for before, after in _pairs(frames)]
        step = int(statistics.median(steps)) if steps else int(self._period * 1e9)
        first = frames[0].timestamp_ns if frames else 0
        return max(first + step * (count - 1), 0) & (1 << 63) - 1

    def _layout(self) -> _Layout:
        """Return the size of the next frame, by the features at the moment, or else by the last one."""
        last = self.report.stream.frames[-1:]
        width, height, code = (last[0].width, last[0].height, last[0].pixel_format) if last else (0, 0, 0)
        size = last[0].payload_bytes if last else 0
        values = self._values()
        wide, high = values.get("Width"), values.get("Height")
        if isinstance(wide, int) and isinstance(high, int) and 0 < wide <= WIDEST and 0 < high <= WIDEST:
            width, height = wide, high
        pixel_format = pfnc.by_code(code) if code else pfnc.by_name("Mono8")
        with suppress(KeyError):  # a name of the vendor's
            pixel_format = pfnc.by_name(str(values["PixelFormat"]))
        payload = values.get("PayloadSize")
        largest = int(payload) if isinstance(payload, int) and payload > 0 else LARGEST_FRAME
        largest = min(largest, LARGEST_FRAME)
        if width <= 0 or height <= 0:
            return _Layout(0, 0, pixel_format, min(max(size, 1), largest))
        line = max(pixel_format.line_bytes(width), 1)
        height = min(height, max(largest // line, 1))
        return _Layout(width, height, pixel_format, min(pixel_format.image_bytes(width, height), largest))

    def _values(self) -> dict[str, object]:
        nodes = self._nodes
        if nodes is None:
            return {}
        present = [name for name in _GEOMETRY if nodes.has_node(name)]
        nodes.invalidate(frozenset(present))
        return dict(nodes.values(present))

    def _load(self) -> CameraNodeMap | None:
        if not self.report.description:
            return None
        try:
            return CameraNodeMap(self._inside, self.report.description, lambda names: None)
        except GrabberError as error:
            log.info("%s: %s", self.report.info.uri, error)
            return None

    def _find_commands(self, nodes: CameraNodeMap) -> None:
        """Find out which write each command is, by executing it without storing anything."""
        for description in nodes.root.descriptions():
            if description.kind is not FeatureKind.COMMAND:
                continue
            self._inside.noted = []
            try:
                nodes.execute(description.name, wait=False)
            except GrabberError as error:
                log.debug("%s: %s", description.name, error)
            for address, data in self._inside.noted:
                self.memory.restore_after(address, data)
                if description.name in (START, STOP):
                    self._switches.append((address, data, description.name == START))
        self._inside.noted = None

    def _starts(self) -> bool:
        """Return whether it is known how the acquisition is started; otherwise it always runs."""
        return any(start for _, _, start in self._switches)

    def _switched(self, address: int, data: bytes) -> bool | None:
        """Return whether a write starts the acquisition (True) or stops it; None if it does neither.

        Start and stop may be bits of one register, with settings beside them; then the bits in which the two
        commands differ decide.
        """
        known = [(content, start) for at, content, start in self._switches if at == address]
        kinds = {start for _, start in known}
        if len(kinds) < 2:
            return kinds.pop() if kinds else None
        number = int.from_bytes(data, "big")
        start, stop = (
            int.from_bytes(next(content for content, each in known if each is kind), "big")
            for kind in (True, False)
        )
        differing = start ^ stop
        if number & differing == start & differing:
            return True
        return False if number & differing == stop & differing else None

    def _on_written(self, address: int, data: bytes) -> None:
        switch = self._switched(address, data)
        if switch is None:
            return
        with self._changed:
            if switch and not self._running:
                self._count = 0
                self._due = time.monotonic()
            self._running = switch
            self._changed.notify_all()


class _Inside(Device):
    """The camera's own access to its memory."""

    def __init__(self, memory: TwinMemory) -> None:
        super().__init__(DeviceInfo("twin:"))
        self._memory = memory
        self.noted: list[tuple[int, bytes]] | None = None
        "Writes that are only noted."

    def open(self, access: Access) -> Access:
        return access

    def close(self) -> None:
        pass

    def read(self, address: int, length: int) -> bytes:
        return self._memory.read(address, length)

    def write(self, address: int, data: bytes) -> None:
        if self.noted is not None:
            self.noted.append((address, data))

    def description(self) -> bytes:
        return b""

    def open_stream(self, request: StreamRequest, deliver: Callable[[Frame], None]) -> None:
        pass


def _pairs(frames: Sequence[FrameRecord]) -> list[tuple[FrameRecord, FrameRecord]]:
    return list(itertools.pairwise(frames))


def _period(frames: Sequence[FrameRecord]) -> float:
    """Return the usual time between two frames in seconds."""
    steps = [after.received_ns - before.received_ns for before, after in _pairs(frames)]
    usual = statistics.median(steps) / 1e9 if steps else _USUAL_PERIOD
    return min(max(usual, _SHORTEST_PERIOD), _LONGEST_PERIOD)
