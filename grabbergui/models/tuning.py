"""A tuning run: adjusts features of a camera until a measurement of its frames reaches a target.

The run measures frames, and calls the camera on the camera's own thread. The search for a value is pure
logic. It only assumes that the measurement increases with the parameter, and so copes with a black level, a
gamma curve, saturation and a moving scene. Each proposal is a guess by the parameter's law, kept between the
values that were too small and too large.
"""

from __future__ import annotations

import math
import queue
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import TypeVar

import numpy as np

from grabbergui.core.errors import FrameTimeoutError, GrabberError, TransportError
from grabbergui.core.features import Feature, FeatureValue
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.pixels import Region
from grabbergui.core.settings import SettingKey
from grabbergui.core.sfnc import (
    AUTO_ONCE,
    FRAME_WAIT,
    Role,
    automatic_mode_of,
    frame_period,
    is_on,
    switched_off,
)
from grabbergui.models.change_journal import Direction, Step
from grabbergui.models.change_tracking import ChangeTrackingGrabber, write_values
from grabbergui.models.features.numbers import nearest_allowed
from grabbergui.models.features.tree import FeatureTreeModel
from grabbergui.models.language import translate
from grabbergui.models.measuring import measurable, planes

# -- the search for a value ----------------------------------------------------------------------
STRONGEST = 8.0
"Largest factor by which one step changes the light."
NEARLY_BLACK = 0.01
"Fraction of white below which a measurement shows only that it is dark."
ROOM = 1e-3
"Relative distance below which the bounds are forgotten: the scene must have changed."
FLATTEST, STEEPEST = 0.25, 2.0
"Plausible range of the measured slope, light over parameter in logarithms."
LEAST_STEP = 0.02
"Smallest relative step whose effect stands out from noise."


class Law(Enum):
    """Dependence of the measurement on a parameter."""

    PROPORTIONAL = "proportional"
    "An exposure time, a ratio."
    DECIBEL = "dB"
    "A gain in decibels of amplitude."
    UNKNOWN = "unknown"
    "A gain in the vendor's own numbers: only its direction is known."


class ParameterSearch:
    """Proposes values for one parameter between `low` and `high`, starting at its current value."""

    def __init__(self, value: float, low: float, high: float, law: Law) -> None:
        self.value = value
        "The parameter's current value."
        self._low, self._high = low, high
        self._law = law
        self._last: tuple[float, float] | None = None
        "Logarithms of the light and of the factor at the previous step."
        self._too_small: float | None = None
        self._too_large: float | None = None

    def propose(self, factor: float) -> float | None:
        """Return a value that should multiply the measurement by `factor`; None at the end of the range."""
        factor = min(max(factor, 1 / STRONGEST), STRONGEST)
        if (self.value >= self._high) if factor > 1 else (self.value <= self._low):
            return None
        if factor > 1:
            self._too_small = self.value
        else:
            self._too_large = self.value
        self._forget_outdated_bounds()
        guess = min(max(self._between(self._guess(factor)), self._low), self._high)
        self.value = guess
        return guess

    def accept(self, value: float) -> None:
        """Set the value that the camera has after the proposal was written."""
        self.value = value

    def _guess(self, factor: float) -> float:
        if self._law is Law.UNKNOWN:
            end = self._high if factor > 1 else self._low
            return (self.value + end) / 2 if abs(end - self.value) > 1 else end
        if self._law is Law.DECIBEL:
            return self.value + _decibels(self._step(_nepers(self.value), math.log(factor)))
        # Zero cannot be multiplied.
        value = max(self.value, (self._high - self._low) * 1e-6)
        return value * math.exp(self._step(math.log(value), math.log(factor)))

    def _step(self, light: float, wanted: float) -> float:
        """Return the step as a logarithm: longer than `wanted` if the previous step had too little effect.

        A black level or a gamma curve makes every step fall short; two measurements show by how much.
        """
        slope = 1.0
        if self._last is not None:
            step, effect = light - self._last[0], self._last[1] - wanted
            if abs(step) > LEAST_STEP:
                slope = min(max(effect / step, FLATTEST), STEEPEST)
        self._last = light, wanted
        return min(max(wanted / slope, -math.log(STRONGEST)), math.log(STRONGEST))

    def _between(self, guess: float) -> float:
        small, large = self._too_small, self._too_large
        if small is None or large is None or small < guess < large:
            return guess
        if self._law is Law.PROPORTIONAL and small > 0:
            return math.sqrt(small * large)
        return (small + large) / 2

    def _forget_outdated_bounds(self) -> None:
        small, large = self._too_small, self._too_large
        if small is not None and large is not None and large - small <= ROOM * abs(large):
            self._too_small = self._too_large = None


def _nepers(decibels: float) -> float:
    return decibels / 20 * math.log(10)


def _decibels(nepers: float) -> float:
    return nepers * 20 / math.log(10)


def light_factor(mean: float, saturated: float, target: float) -> float:
    """Return the factor by which the light has to change, estimated from one measurement.

    Saturated pixels hide how bright they are, so an image with many of them is darkened by more.
    """
    if mean < NEARLY_BLACK:
        return STRONGEST if target > mean else 1 / STRONGEST
    factor = target / mean
    return factor * (1 - saturated) ** 2 if factor < 1 else factor


# -- parameters of a camera ----------------------------------------------------------------------
@dataclass
class TuningParameter:
    """A number feature, perhaps behind a selector, and the search for its value."""

    feature: Feature
    search: ParameterSearch
    key: SettingKey

    @classmethod
    def of(
        cls,
        feature: Feature,
        law: Law,
        *,
        highest: float | None = None,
        key: SettingKey | None = None,
    ) -> TuningParameter | None:
        """Return a parameter over the feature's range, or up to `highest`; None without a range or value.

        Without a `key` it is the instance that is selected at present.
        """
        low, high = feature.minimum, feature.maximum
        if low is None or high is None or not isinstance(feature.value, int | float):
            return None
        if highest is not None:
            step = feature.increment or 0
            highest = low + (highest - low) // step * step if step else highest
            high = max(min(high, highest), feature.value)
        return cls(feature, ParameterSearch(feature.value, low, high, law), key or SettingKey(feature.name))

    def proposed(self, factor: float) -> FeatureValue | None:
        """Return the value to write for `factor` times the light; None at the end of the range."""
        before = self.search.value
        wanted = self.search.propose(factor)
        if wanted is None:
            return None
        allowed = nearest_allowed(self.feature, wanted)
        if allowed == before:
            # The increment is coarse: propose the next value on that side, if there is one.
            step = self.feature.increment or 0
            allowed = nearest_allowed(self.feature, before + (step if factor > 1 else -step))
        self.search.accept(before)
        return None if allowed == before else allowed


def switch_to_manual(grabber: FrameGrabber, name: str) -> Feature:
    """Switch a feature's automatic mode off, and return the feature."""
    auto = automatic_mode_of(name, grabber.has_feature)
    if auto is not None and (off := switched_off(grabber.feature(auto))) is not None:
        grabber.write_feature(*off)
    return grabber.feature(name)


def automatic_once(grabber: FrameGrabber, role: Role) -> str | None:
    """Return the automatic mode of a role's feature if it can run once."""
    name = grabber.role(role)
    auto = automatic_mode_of(name, grabber.has_feature) if name is not None else None
    if auto is None:
        return None
    mode = grabber.feature(auto)
    can = mode.access.writable and any(e.name == AUTO_ONCE and e.available for e in mode.entries)
    return auto if can else None


# -- measuring light -----------------------------------------------------------------------------
NEARLY_WHITE = 0.98
"Fraction of the highest value from which a pixel counts as saturated: some sensors do not reach the top."


@dataclass(frozen=True)
class Light:
    """A measurement of brightness; all values are fractions of white."""

    mean: float
    saturated: float
    "Fraction of the samples that are white or nearly white."
    channels: dict[str, float]
    "Mean of `R`, `G` and `B`; of `grey` or `Y` without colour."

    @property
    def coloured(self) -> bool:
        """Whether red, green and blue were measured."""
        return self.channels.keys() >= {"R", "G", "B"}


def measure_light(frame: Frame, region: Region | None = None) -> Light:
    """Measure the sensor's values in a region of the frame, by default all of it. Raises PixelFormatError."""
    region = _whole_cells(Region.of(frame, region), frame)
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
    """Return a region that begins on an even line and column and has every colour of a Bayer pattern."""
    x, y = region.x & ~1, region.y & ~1
    right, bottom = min(max(region.right, x + 2), frame.width), min(max(region.bottom, y + 2), frame.height)
    return Region(x, y, right - x, bottom - y)


# -- the run -------------------------------------------------------------------------------------
T = TypeVar("T")

STALE_FRAMES = 3
"Frames after a write that may be from before: one being exposed, one being read out, one in transit."
MOST_COMPARED = 6
"Most frames compared until two are alike; under flickering light none are."
STEADY = 0.01
"Difference of the means of two frames, as a fraction of white, that counts as none."
SILENT = 2.0
"Seconds without a frame, besides two frame periods, after which a stream is dead that runs free."
CALL_PATIENCE = 20.0
"Seconds to wait for the camera's thread: longer than any call of a camera takes."
CANCEL_PERIOD = 0.05
"Seconds between checks whether the run was cancelled."


class TuningError(GrabberError):
    """A tuning did not reach its target."""


class TuningCancelledError(TuningError):
    """The user cancelled the tuning."""


class TuningRun:
    """What a tuning uses, on its own thread. Once cancelled, all calls but two raise TuningCancelledError.

    `restore` and `close` still work then.
    """

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
        self.period = 0.0
        "Frame period in seconds at the last call of `patience`."

    def close(self) -> None:
        """Stop taking frames."""
        self._frames.close()

    def call(self, job: Callable[[ChangeTrackingGrabber], T]) -> T:
        """Run a job on the camera's own thread and wait for it; all writes of the run form one undo step.

        Writes that the operator requested before are sent first.
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
        patience = self.patience()
        for _ in range(STALE_FRAMES):
            self.frame(patience)
        light = measure_light(self.frame(patience), region)
        for _ in range(MOST_COMPARED):
            before, light = light, measure_light(self.frame(patience), region)
            if abs(light.mean - before.mean) < STEADY:
                break
        return light

    def restore(self) -> list[str]:
        """Restore all values; return a sentence for each that could not be restored."""
        values = dict(self._step.values(Direction.UNDO))
        return list(self._call(lambda grabber: write_values(grabber, values)).values())

    def patience(self) -> float:
        """Return the seconds that the next frame may take, by the camera's settings now and before."""
        before, (self.period, least) = self.period, self.call(_frame_period)
        return least + 2 * max(before, self.period)  # the frame that is being exposed began before a change

    def frame(self, patience: float) -> Frame:
        """Return the next frame. Raises FrameTimeoutError after `patience` seconds."""
        deadline = time.monotonic() + patience
        while time.monotonic() < deadline:
            self._check()
            try:
                return self._frames.get(CANCEL_PERIOD)
            except FrameTimeoutError:
                if self._frames.closed:
                    break
        raise FrameTimeoutError(
            translate("Tuning", "no frame arrived to measure; start the camera, or its trigger, first")
        )

    def _call(self, job: Callable[[ChangeTrackingGrabber], T]) -> T:
        answers: queue.Queue[tuple[T | None, GrabberError | None]] = queue.Queue()

        def recorded() -> T:
            with self._grabber.journal.within(self._step):
                return job(self._grabber)

        if not self._features.run(
            recorded,
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


def _frame_period(grabber: ChangeTrackingGrabber) -> tuple[float, float]:
    """Return the frame period, and the seconds beside two of them after which no frame is to be expected.

    Triggers, and servers that send fewer images than their camera takes, may need more time.
    """
    period = frame_period(grabber)
    triggered = grabber.has_feature("TriggerMode") and is_on(grabber.feature("TriggerMode").value)
    return period, SILENT if period and not triggered and not grabber.plain.shared else FRAME_WAIT
