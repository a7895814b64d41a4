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
import json
import logging
import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from grabbergui.core import environment
from grabbergui.core.errors import FrameTimeoutError, GrabberError
from grabbergui.core.features import Feature, FeatureValue
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.json_text import to_json
from grabbergui.core.settings import SettingKey, ValueChange
from grabbergui.core.sfnc import Role

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

    def __init__(self, grabber: FrameGrabber) -> None:
        self.latency = 0
        "Frames to skip after a write, once `prepare` had to know it."
        self._grabber = grabber
        self._latency_known = False
        self._chunks_tried = False
        self._switched_on: list[SettingKey] = []

    def prepare(self, names: Sequence[str], start: Callable[[], None], timeout: float) -> None:
        """Start the stream with chunk data for these features; measure the latency if a frame lacks any.

        `start` starts the stream. Raises FrameTimeoutError if no frames arrive within `timeout` seconds.
        """
        if not self._chunks_tried:
            self._chunks_tried = True
            self._switch_chunks_on()
        start()
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
        """Switch off the chunks that were switched on. Never raises."""
        switched, self._switched_on = self._switched_on, []
        with contextlib.suppress(GrabberError):
            if switched:
                self._grabber.stop()
            for key in reversed(switched):
                self._grabber.write_setting(key, False)

    def _switch_chunks_on(self) -> None:
        """Enable exposure time and gain in the chunk data if the camera offers them."""
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


UNMEASURED_LATENCY = 4
"Frames to skip if the latency cannot be measured, as the image does not change with the exposure time."
MARGIN = 1
"Frames added to the longest latency measured: the host knows the camera's clock to within one frame."
ROUNDS = 8
"Changes of the exposure time that a measurement makes, each at another moment of the frame period."
MOST_FRAMES = 12
"Frames after which a change that shows in none of them is not measurable."
LEAST_CONTRAST = 4.0
"Difference of mean brightness (of 255) between the two exposure times that counts as visible."


def latency_of(grabber: FrameGrabber, *, timeout: float) -> int:
    """Return the frames to skip after a write; measure them if this camera's are not known yet.

    The camera must stream. A measurement changes the exposure time for about a second and puts it back.
    Raises FrameTimeoutError if no frames arrive.
    """
    known = _Known.read()
    name = _Known.name_of(grabber.info)
    if name in known:
        return known[name]
    measured = measure_latency(grabber, timeout=timeout)
    if measured is None:
        log.info(
            "%s: the image does not change with the exposure time; %d frames are skipped after a write",
            grabber.info.title,
            UNMEASURED_LATENCY,
        )
        return UNMEASURED_LATENCY
    _Known.write({**known, name: measured + MARGIN})
    return measured + MARGIN


def measure_latency(grabber: FrameGrabber, *, timeout: float) -> int | None:
    """Return how many frames after a write still have the old exposure time, at most.

    None if that cannot be seen: there is no exposure time that can be written, or the image is dark,
    saturated or changes by itself. Raises FrameTimeoutError if no frames arrive.
    """
    name = grabber.role(Role.EXPOSURE)
    exposure = grabber.feature(name) if name is not None else None
    if exposure is None or not isinstance(exposure.value, int | float):
        return None
    queue = grabber.open_queue(depth=4)
    try:
        key = grabber.setting(exposure.name)
        with restored(grabber, key):
            return _Measurement(grabber, key, queue, timeout).run(exposure)
    finally:
        queue.close()


@contextlib.contextmanager
def restored(grabber: FrameGrabber, key: SettingKey) -> Iterator[None]:
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


class _Measurement:
    def __init__(self, grabber: FrameGrabber, key: SettingKey, queue: FrameQueue, timeout: float) -> None:
        self._grabber = grabber
        self._key = key
        self._queue = queue
        self._timeout = timeout

    def run(self, exposure: Feature) -> int | None:
        current = float(exposure.value or 0)
        low, high = float(exposure.minimum or 1), float(exposure.maximum or current)
        for short, long in (
            (current / 3, current),
            (current, current * 3),
            (current / 30, current / 10),
        ):
            pair = (min(max(short, low), high), min(max(long, low), high))
            dark, bright = (self._level(value) for value in pair)
            if bright - dark >= LEAST_CONTRAST:
                return self._longest(pair, (dark, bright))
        return None

    def _level(self, value: float) -> float:
        frames = list(self._after(self._write(value), UNMEASURED_LATENCY + 3))
        return float(np.median([frame.mono().mean() for frame in frames[UNMEASURED_LATENCY:]]))

    def _longest(self, pair: tuple[float, float], levels: tuple[float, float]) -> int | None:
        """Change the value at different moments of the frame period; return the longest latency."""
        longest = 0
        for turn in range(ROUNDS):
            frame = self._queue.get(self._timeout)
            following = self._queue.get(self._timeout)
            time.sleep(max(0.0, following.captured - frame.captured) * turn / ROUNDS)
            which = turn % 2
            old, new = levels[1 - which], levels[which]
            lost = self._queue.dropped
            for count, seen in enumerate(self._after(self._write(pair[which]), MOST_FRAMES)):
                level = float(seen.mono().mean())
                if abs(level - new) < abs(level - old):
                    # A frame that was dropped may have had the old value as well.
                    longest = max(longest, count + self._queue.dropped - lost)
                    break
            else:
                return None
        return longest

    def _write(self, value: float) -> float:
        """Write the exposure time; return when.

        Frames are counted from then on. After an acknowledge that is late, as on a busy machine, too few
        would be left.
        """
        written = time.monotonic()
        self._grabber.write_setting(self._key, value)
        return written

    def _after(self, moment: float, count: int) -> Iterator[Frame]:
        """The next complete frames that were captured after a moment."""
        deadline = time.monotonic() + self._timeout
        while count:
            frame = self._queue.get(self._timeout)
            if frame.complete and frame.captured > moment:
                count -= 1
                yield frame
            elif time.monotonic() > deadline:
                raise FrameTimeoutError(f"no frame was captured within {self._timeout:.3g} s after a write")


class _Known:
    """Latencies by camera, kept in a file of the user's cache; a damaged one holds none."""

    @staticmethod
    def name_of(info: DeviceInfo) -> str:
        # Options of the URI belong to it: packets of another size arrive at another time.
        return " ".join((info.uri, info.vendor, info.model, info.serial, info.version))

    @staticmethod
    def path() -> Path:
        return environment.cache_home() / "grabbergui" / "latency.json"

    @classmethod
    def read(cls) -> dict[str, int]:
        try:
            found = json.loads(cls.path().read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return {}
        if not isinstance(found, dict):
            return {}
        return {
            name: frames for name, frames in found.items() if isinstance(frames, int) and 0 <= frames < 100
        }

    @classmethod
    def write(cls, known: Mapping[str, int]) -> None:
        path = cls.path()
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            environment.write_whole(path, to_json(dict(known), indent=1))
        except OSError as error:
            log.info("%s could not be written, so the latency is measured again next time: %s", path, error)
