"""When a setting takes effect: the first frame that was exposed with what was written.

A camera acknowledges a write before its sensor obeys. The frame that is being exposed, and often one or two
after it, still have the old value. Two ways lead to the right frame:

- Chunk data (SFNC, chapter *Chunk Data Control*): the frame itself contains its exposure time and gain.
- Counting, for cameras without: the first `LATENCY` frames captured after the acknowledge are skipped.
"""

from __future__ import annotations

import contextlib
import logging
import math
from collections.abc import Iterator, Mapping

from grabbergui.core.errors import GrabberError
from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.features import FeatureValue
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.settings import SettingKey, ValueChange

log = logging.getLogger(__name__)

LATENCY = 4
"Frames after the acknowledge that may still have the old value; the sensors of most cameras take one or two."
CHUNK_TOLERANCE = 1e-3
"Relative; cameras round a value to lines or clock ticks once more when they expose."
MOST_REFUSED = 30
"Frames whose chunk data may differ from what was written before that is an error."


class SettingEffect:
    """Decides which frame is the first that was exposed with settings. Does no I/O.

    `values` are what the camera reported after the write, by feature name; `written` and `acknowledged` are
    moments of the monotonic clock, in seconds; `latency` is in frames.
    """

    def __init__(
        self,
        values: Mapping[str, FeatureValue],
        written: float,
        acknowledged: float,
        latency: int = LATENCY,
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


class ChunkData:
    """Switches on a camera's chunk data, in which each frame reports its exposure time and gain."""

    def __init__(self, grabber: FrameGrabber) -> None:
        self._grabber = grabber
        self._tried = False
        self._switched_on: list[SettingKey] = []

    def switch_on(self) -> None:
        """Enable exposure time and gain in the chunk data if offered; only the first call does."""
        if self._tried:
            return
        self._tried = True
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

    def undo(self) -> None:
        """Switch off the chunks that were switched on. Never raises."""
        switched, self._switched_on = self._switched_on, []
        with contextlib.suppress(GrabberError):
            if switched:
                self._grabber.stop()
            for key in reversed(switched):
                self._grabber.write_setting(key, False)


@contextlib.contextmanager
def restored(grabber: FeatureSource, key: SettingKey) -> Iterator[None]:
    """Restore a setting, and the automatic mode that writing it switches off, after the block.

    `key` has the selectors of the feature. Raises what reading and writing raise.
    """
    feature = grabber.read_setting(key)
    first: tuple[ValueChange, ...] = ()
    if feature.value is not None:
        first = grabber.write_setting(key, feature.value).written
    try:
        yield
    finally:
        for change in reversed(first):
            if change.before is not None:
                grabber.write_setting(change.key, change.before)
