"""One tuning run: measures frames, and calls the camera on its own thread."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from grabbergui.core.errors import FrameTimeoutError, GrabberError, TransportError
from grabbergui.core.frame import Frame
from grabbergui.core.pixels import Region
from grabbergui.models.changes.history import Direction, Step
from grabbergui.models.changes.tracking import ChangeTrackingGrabber, write_values
from grabbergui.models.features.tree import FeatureTreeModel
from grabbergui.models.language import translate
from grabbergui.models.measuring import measurable, planes

NEARLY_WHITE = 0.98
"Part of the highest value from which a pixel counts as saturated: not every sensor reaches the top."


@dataclass(frozen=True)
class Light:
    """A measurement, all values as parts of white."""

    mean: float
    saturated: float
    "Fraction of the samples that are white, or nearly."
    channels: dict[str, float]
    "Mean of `R`, `G` and `B`; of `grey` or `Y` without colour."

    @property
    def coloured(self) -> bool:
        """Whether red, green and blue were measured."""
        return self.channels.keys() >= {"R", "G", "B"}


def measure_light(frame: Frame, region: Region | None = None) -> Light:
    """Measure the sensor's own values in a region of the frame, or in all of it. Raises PixelFormatError."""
    region = region or Region(0, 0, frame.width, frame.height)
    region = _whole_cells(region.clipped(frame.width, frame.height), frame)
    raw, pixel_format = measurable(frame, region)
    white = (1 << pixel_format.depth) - 1
    sums: dict[str, float] = {}
    counts: dict[str, int] = {}
    saturated = 0
    for name, values in planes(raw, pixel_format):
        sums[name] = sums.get(name, 0.0) + float(values.sum(dtype=np.float64))
        counts[name] = counts.get(name, 0) + values.size
        saturated += int(np.count_nonzero(values >= NEARLY_WHITE * white))
    samples = max(1, sum(counts.values()))
    return Light(
        sum(sums.values()) / samples / white,
        saturated / samples,
        {name: sums[name] / max(1, counts[name]) / white for name in sums},
    )


def _whole_cells(region: Region, frame: Frame) -> Region:
    """Begin on an even line and column and hold each colour of a Bayer pattern at least once."""
    x, y = region.x & ~1, region.y & ~1
    right, bottom = min(max(region.right, x + 2), frame.width), min(max(region.bottom, y + 2), frame.height)
    return Region(x, y, right - x, bottom - y)


T = TypeVar("T")

STALE_FRAMES = 3
"Frames after a write that may have been exposed before it: one exposing, one being read out, one on its way."
MOST_FRAMES = 6
"Most frames compared until two are alike; under flickering light none are."
STEADY = 0.01
"Difference of two frames' means, as a part of white, that counts as none."
FRAME_PATIENCE = 5.0
"Seconds to wait for a frame."
CALL_PATIENCE = 20.0
"Seconds to wait for the camera's thread: longer than any call of a camera takes."
LOOK = 0.05
"Seconds between checks whether it was cancelled."


class TuningError(GrabberError):
    """A tuning did not reach its target."""


class TuningCancelledError(TuningError):
    """The user cancelled the tuning."""


class TuningRun:
    """The context of one tuning, on its own thread. Once cancelled, calls raise TuningCancelledError."""

    def __init__(
        self,
        grabber: ChangeTrackingGrabber,
        features: FeatureTreeModel,
        step: Step,
        say: Callable[[float, str], None],
    ) -> None:
        """`say` is called with the progress (0 … 1) and the state as display text."""
        self.title = grabber.info.title
        self.say = say
        self.cancelled = threading.Event()
        self._grabber = grabber
        self._features = features
        self._step = step
        self._frames = grabber.plain.open_queue(depth=2)

    def close(self) -> None:
        """Stop taking frames."""
        self._frames.close()

    def call(self, job: Callable[[ChangeTrackingGrabber], T]) -> T:
        """Run a job on the camera's own thread and wait for it; its writes are one undo step.

        Writes that the operator requested before are sent before.
        """
        self._check()
        return self._call(job)

    def wait(self, seconds: float) -> None:
        """Wait while the camera works. Raises TuningCancelledError."""
        self.cancelled.wait(seconds)
        self._check()

    def light(self, region: Region | None) -> Light:
        """Measure a frame exposed after the last call. Raises FrameTimeoutError, PixelFormatError."""
        self._frames.clear()
        for _ in range(STALE_FRAMES):
            self._frame()
        light = measure_light(self._frame(), region)
        for _ in range(MOST_FRAMES):
            before, light = light, measure_light(self._frame(), region)
            if abs(light.mean - before.mean) < STEADY:
                break
        return light

    def restore(self) -> list[str]:
        """Restore all values, also when cancelled; return what could not be restored, a sentence each."""
        values = dict(self._step.values(Direction.UNDO))
        return list(self._call(lambda grabber: write_values(grabber, values)).values())

    def _frame(self) -> Frame:
        deadline = time.monotonic() + FRAME_PATIENCE
        while time.monotonic() < deadline:
            self._check()
            try:
                return self._frames.get(LOOK)
            except FrameTimeoutError:
                if self._frames.closed:
                    break
        raise FrameTimeoutError(
            translate("Tuning", "no frame came to measure; start the camera, or its trigger, first")
        )

    def _call(self, job: Callable[[ChangeTrackingGrabber], T]) -> T:
        answers: queue.Queue[tuple[T | None, GrabberError | None]] = queue.Queue()

        def noted() -> T:
            with self._grabber.journal.within(self._step):
                return job(self._grabber)

        if not self._features.run(
            noted,
            done=lambda result: answers.put((result, None)),
            failed=lambda error: answers.put((None, error)),
        ):
            raise TuningCancelledError(translate("Tuning", "the camera was closed"))
        try:
            result, error = answers.get(timeout=CALL_PATIENCE)
        except queue.Empty:
            text = translate("Tuning", "{0} did not answer within {1:g} s")
            raise TransportError(text.format(self.title, CALL_PATIENCE)) from None
        if error is not None:
            raise error
        return result  # type: ignore[return-value]  # a result, as there is no error

    def _check(self) -> None:
        if self.cancelled.is_set():
            raise TuningCancelledError("cancelled")
