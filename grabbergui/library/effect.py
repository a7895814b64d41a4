"""When a setting takes effect: the first frame that was exposed with what was written.

A camera acknowledges a write before its sensor obeys. The frame that is being exposed, and often one or two
after it, still have the old value. Two ways lead to the right frame:

- Chunk data (SFNC, chapter *Chunk Data Control*): the frame itself says what it was exposed with.
- Counting: of the frames whose `captured` lies behind the acknowledge, the first `latency` are skipped. The
  latency depends on camera and interface and is measured once per camera, by changing the exposure time at
  different moments of the frame period and watching the brightness.
"""

from __future__ import annotations

import contextlib
import logging
import math
from collections.abc import Callable, Mapping, Sequence

from grabbergui.core.errors import GrabberError
from grabbergui.core.features import FeatureValue
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.selection import SettingKey
from grabbergui.library.latency import latency_of

log = logging.getLogger(__name__)

CHUNK_TOLERANCE = 1e-3
"Relative; cameras round a value to lines or clock ticks once more when they expose."
MOST_REFUSED = 30
"Frames whose chunk data may differ from what was written before that is an error."


class SettingEffect:
    """Decides which frame is the first that was exposed with settings. Does no I/O.

    `values` are what the camera reported after the write, by feature name; `written` and `acknowledged` are
    moments of the monotonic clock, in seconds.
    """

    def __init__(
        self, values: Mapping[str, FeatureValue], written: float, acknowledged: float, latency: int
    ) -> None:
        self._values = dict(values)
        self._written = written
        self._acknowledged = acknowledged
        self._latency = latency
        self._counted = 0
        self._refused = 0

    def accepts(self, frame: Frame) -> bool:
        """Return whether this frame, the next of the stream, was exposed with all settings.

        Raises GrabberError if the chunk data keep contradicting what the camera reported.
        """
        if not frame.complete or frame.captured < self._written:
            return False
        if frame.captured > self._acknowledged:
            self._counted += 1
        reported = {name: chunk_value(frame, name) for name in self._values}
        if self._values and None not in reported.values():
            return self._agrees(reported)
        if any(
            value is not None and not _close(value, self._values[name]) for name, value in reported.items()
        ):
            return False
        return self._counted > (self._latency if self._values else 0)

    def _agrees(self, reported: Mapping[str, FeatureValue | None]) -> bool:
        if all(_close(value, self._values[name]) for name, value in reported.items()):
            return True
        self._refused += 1
        if self._refused > MOST_REFUSED:
            wrong = ", ".join(
                f"{name} is {self._values[name]} and the chunk data say {value}"
                for name, value in reported.items()
            )
            raise GrabberError(f"no frame was exposed as the camera is set: {wrong}")
        return False


def chunk_value(frame: Frame, name: str) -> FeatureValue | None:
    """Return what the frame's chunk data say of a feature: `ChunkExposureTime` for `ExposureTime`."""
    value = frame.chunks.get(f"Chunk{name}")
    return value if isinstance(value, int | float | bool | str) else None


def _close(value: FeatureValue | None, wanted: FeatureValue) -> bool:
    if isinstance(value, int | float) and isinstance(wanted, int | float):
        return math.isclose(value, wanted, rel_tol=CHUNK_TOLERANCE, abs_tol=CHUNK_TOLERANCE)
    return value == wanted


class Effects:
    """Prepares a camera so that the effect of settings can be seen: its chunk data, or its latency."""

    def __init__(self, grabber: FrameGrabber, start: Callable[[], None]) -> None:
        self.latency = 0
        "Frames to skip after a write, once `prepare` had to know it."
        self._grabber = grabber
        self._start = start
        self._latency_known = False
        self._chunks_tried = False
        self._switched_on: list[SettingKey] = []

    def prepare(self, names: Sequence[str], timeout: float) -> None:
        """Start the stream with chunk data for these features; measure the latency if a frame lacks any.

        Raises FrameTimeoutError if no frames arrive within `timeout` seconds.
        """
        if not self._chunks_tried:
            self._chunks_tried = True
            self._switch_chunks_on()
        self._start()
        if self._latency_known:
            return
        frames = self._grabber.open_queue(depth=1)
        try:
            frame = frames.get(timeout)
        finally:
            frames.close()
        if any(chunk_value(frame, name) is None for name in names):
            self.latency = latency_of(self._grabber, timeout=timeout)
            self._latency_known = True

    def undo(self) -> None:
        """Switch off what was switched on. Never raises."""
        switched, self._switched_on = self._switched_on, []
        with contextlib.suppress(GrabberError):
            if switched:
                self._grabber.stop()
            for key in reversed(switched):
                self._grabber.write_setting(key, False)

    def _switch_chunks_on(self) -> None:
        """Have exposure time and gain in the chunk data, where the camera offers that."""
        grabber = self._grabber
        if not grabber.has_feature("ChunkModeActive") or not grabber.has_feature("ChunkSelector"):
            return
        mode = grabber.feature("ChunkModeActive")
        if not (mode.access.writable or grabber.pauses_for(mode.name)):
            return
        try:
            if mode.value is False:
                self._switched_on.append(SettingKey(mode.name))
                grabber.write_feature(mode.name, True)
            entries = {entry.name for entry in grabber.feature("ChunkSelector").entries if entry.available}
            for chunk in entries & {"ExposureTime", "Gain"}:
                key = SettingKey("ChunkEnable", (("ChunkSelector", chunk),))
                if grabber.read_setting(key).value is False:
                    self._switched_on.append(key)
                    grabber.write_setting(key, True)
        except GrabberError as error:
            log.info("%s sends no chunk data: %s", grabber.info.title, error)
