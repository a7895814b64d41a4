"""A tuning run: adjusts features of a camera until a measurement of its frames reaches a target.

The run measures frames, and calls the camera on the camera's own thread. The search for a value is pure
logic. It only assumes that the measurement increases with the parameter, and so copes with a black level, a
gamma curve, saturation and a moving scene. Each proposal is a guess by the parameter's law, kept between the
values that were too small and too large.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable
from typing import TypeVar

from grabbergui.core.errors import FrameTimeoutError, GrabberError, TransportError
from grabbergui.core.frame import Frame
from grabbergui.core.frame_period import FRAME_WAIT, frame_period
from grabbergui.core.pixels import Region
from grabbergui.core.sfnc import is_on
from grabbergui.models.change_tracking import ChangeTrackingGrabber, write_values
from grabbergui.models.features.tree import FeatureTreeModel
from grabbergui.models.language import translate
from grabbergui.models.light import Light, measure_light
from grabbergui.models.undo_steps import Direction, UndoStep

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
    """The camera's settings and frames for one tuning, on its own thread.

    Once cancelled, all calls but `restore` and `close` raise TuningCancelledError.
    """

    def __init__(
        self,
        grabber: ChangeTrackingGrabber,
        features: FeatureTreeModel,
        step: UndoStep,
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
