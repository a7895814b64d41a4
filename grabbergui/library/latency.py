"""How many frames a camera needs to obey: measured once per camera by the brightness of its frames."""

from __future__ import annotations

import json
import logging
import os
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from grabbergui.core import folders
from grabbergui.core.errors import FrameTimeoutError
from grabbergui.core.features import Feature
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.core.grabber import DeviceInfo, FrameGrabber
from grabbergui.core.selection import SettingKey, ValueChange
from grabbergui.core.sfnc import Role

log = logging.getLogger(__name__)

UNMEASURED_LATENCY = 4
"Frames to skip if the latency cannot be measured, as the picture does not change with the exposure time."
MARGIN = 1
"Frames added to the longest latency measured: the host knows the camera's clock to within one frame."
ROUNDS = 8
"Changes of the exposure time that a measurement makes, each at another moment of the frame period."
MOST_FRAMES = 12
"A change that shows in none of so many frames is not measurable."
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
            "%s: the picture does not change with the exposure time; %d frames are skipped after a write",
            grabber.info.title,
            UNMEASURED_LATENCY,
        )
        return UNMEASURED_LATENCY
    _Known.write({**known, name: measured + MARGIN})
    return measured + MARGIN


def measure_latency(grabber: FrameGrabber, *, timeout: float) -> int | None:
    """Return how many frames after an acknowledge still have the old exposure time, at most.

    None if that cannot be seen: there is no exposure time that can be written, or the picture is dark,
    saturated or changes by itself. Raises FrameTimeoutError if no frames arrive.
    """
    name = Role.EXPOSURE.find(grabber.has_feature)
    exposure = grabber.feature(name) if name is not None else None
    if exposure is None or not isinstance(exposure.value, int | float):
        return None
    queue = grabber.open_queue(depth=4)
    try:
        with _restored(grabber, exposure.name) as key:
            return _Measurement(grabber, key, queue, timeout).run(exposure)
    finally:
        queue.close()


@contextmanager
def _restored(grabber: FrameGrabber, name: str) -> Iterator[SettingKey]:
    """Put a setting, and the automatic mode that a write of it switches off, back behind the block."""
    key = grabber.setting(name)
    feature = grabber.feature(name)
    first: tuple[ValueChange, ...] = ()
    if feature.value is not None:
        first = grabber.write_setting(key, feature.value).written
    try:
        yield key
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
        standing = float(exposure.value or 0)
        low, high = float(exposure.minimum or 1), float(exposure.maximum or standing)
        for short, long in (
            (standing / 3, standing),
            (standing, standing * 3),
            (standing / 30, standing / 10),
        ):
            pair = (min(max(short, low), high), min(max(long, low), high))
            dark, bright = (self._level(value) for value in pair)
            if bright - dark >= LEAST_CONTRAST:
                return self._longest(pair, (dark, bright))
        return None

    def _level(self, value: float) -> float:
        acknowledged = self._write(value)
        frames = list(self._after(acknowledged, UNMEASURED_LATENCY + 3))
        return float(np.median([frame.mono().mean() for frame in frames[UNMEASURED_LATENCY:]]))

    def _longest(self, pair: tuple[float, float], levels: tuple[float, float]) -> int | None:
        """Change the value at different moments of the frame period; return the longest latency."""
        longest = 0
        for turn in range(ROUNDS):
            frame = self._queue.get(self._timeout)
            following = self._queue.get(self._timeout)
            time.sleep(max(0.0, following.captured - frame.captured) * turn / ROUNDS)
            which = turn % 2
            acknowledged = self._write(pair[which])
            old, new = levels[1 - which], levels[which]
            for count, seen in enumerate(self._after(acknowledged, MOST_FRAMES)):
                level = float(seen.mono().mean())
                if abs(level - new) < abs(level - old):
                    longest = max(longest, count)
                    break
            else:
                return None
        return longest

    def _write(self, value: float) -> float:
        self._grabber.write_setting(self._key, value)
        return time.monotonic()

    def _after(self, acknowledged: float, count: int) -> Iterator[Frame]:
        """The next complete frames that were captured after a moment."""
        deadline = time.monotonic() + self._timeout
        while count:
            frame = self._queue.get(self._timeout)
            if frame.complete and frame.captured > acknowledged:
                count -= 1
                yield frame
            elif time.monotonic() > deadline:
                raise FrameTimeoutError(f"no frame was captured within {self._timeout:g} s after a write")


class _Known:
    """Latencies by camera, kept in a file of the user's cache; a damaged one holds none."""

    @staticmethod
    def name_of(info: DeviceInfo) -> str:
        # Options of the URI belong to it: packets of another size arrive at another time.
        return " ".join((info.uri, info.vendor, info.model, info.serial, info.version))

    @staticmethod
    def path() -> Path:
        return folders.cache_home() / "grabbergui" / "latency.json"

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
        part = path.with_suffix(f".{os.getpid()}")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            part.write_text(json.dumps(dict(known), indent=1), encoding="utf-8")
            part.replace(path)
        except OSError as error:
            log.info("%s could not be written, so the latency is measured again next time: %s", path, error)
