"""Detection of the calibration target in a camera's frames, for `hand_eye_run`."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import numpy as np

from grabbergui.calibration.fitted import CalibrationFor
from grabbergui.calibration.markers import MarkerDetection
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import FrameTimeoutError, GrabberError
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameSink
from grabbergui.core.grabber import FrameGrabber
from grabbergui.servo.config import MarkerConfig
from grabbergui.servo.detection import MarkerDetector, Sighting, marker_detector

FRAME_S = 5.0
"Seconds to wait for a frame."
SILENCE_S = 0.2
"Seconds to wait for a frame at a time; then `between` is called, and the watch may end."

Seen = Callable[[Frame, "MarkerDetection | None"], object]
"Gets each whole frame and the target in it, None if it is not visible; on the watch's thread."


class TargetWatch:
    """Detects the target in each frame of an open source, on a thread of its own, until it is closed."""

    def __init__(
        self,
        grabber: FrameGrabber,
        marker: MarkerConfig,
        calibration: CalibrationFor,
        *,
        seen: Seen = lambda frame, found: None,
        failed: Callable[[GrabberError], object] = lambda error: None,
        between: Callable[[], object] = lambda: None,
    ) -> None:
        """Start the source. Raises GrabberError if it cannot be started.

        `failed` and `between` (every 0.2 s at least) are called on the watch's thread.
        """
        self._marker, self._calibration_for = marker, calibration
        self._seen, self._failed = seen, failed
        self._calibration: Calibration | None = None
        self._detector: MarkerDetector | None = None
        self._newest: tuple[float, MarkerDetection | None] = (-np.inf, None)
        self._error: GrabberError | None = None
        self._news = threading.Condition()
        self._closed = False
        self._sink = FrameSink(
            grabber,
            self._consume,
            name="target watch",
            depth=1,
            wait=SILENCE_S,
            between=between,
            failed=self._on_failed,
        )
        grabber.start()
        self._sink.start()

    def close(self, timeout: float | None = None) -> bool:
        """End; return whether the thread ended within `timeout` seconds. May be called twice."""
        with self._news:
            self._closed = True
            self._news.notify_all()
        return self._sink.stop(timeout)

    @property
    def calibration(self) -> Calibration:
        """The calibration for frames of the source's size; waits for the first one.

        Raises FrameTimeoutError without a frame, UsageError if the calibration does not fit.
        """
        with self._news:
            self._await(lambda: self._calibration is not None or self._error is not None)
            if self._calibration is None:
                raise self._error or FrameTimeoutError(_no_frame())
            return self._calibration

    @property
    def nominal(self) -> bool:
        """Whether the calibration of the newest frame is only assumed. Does not wait."""
        return self._calibration is not None and self._calibration.nominal

    def __call__(self, after: float) -> MarkerDetection | None:
        """Return the target in the first whole frame exposed after `after` (monotonic seconds).

        Raises FrameTimeoutError if none comes, the detection's own error if it failed.
        """
        with self._news:
            self._await(lambda: self._newest[0] > after or self._error is not None)
            captured, found = self._newest
            if captured > after:
                return found
            raise self._error or FrameTimeoutError(_no_frame())

    def _await(self, condition: Callable[[], bool]) -> None:
        deadline = time.monotonic() + FRAME_S
        while not condition() and not self._closed:
            if not self._news.wait(max(deadline - time.monotonic(), 0)):
                return

    # -- the watch's thread ----------------------------------------------------------------------
    def _consume(self, frame: Frame) -> bool:
        if not frame.complete:
            return False
        calibration = self._calibration
        if calibration is None or (calibration.width, calibration.height) != (frame.width, frame.height):
            calibration = self._calibration_for(frame.width, frame.height)
            self._detector = marker_detector(self._marker, calibration)
        grey = np.asarray(frame.mono())
        markers = () if self._detector is None else tuple(self._detector.detect(grey))
        found = Sighting(frame.captured, markers).only(self._marker.target)
        with self._news:
            self._calibration, self._error = calibration, None
            self._newest = frame.captured, found
            self._news.notify_all()
        self._seen(frame, found)
        return True

    def _on_failed(self, error: Exception, frame: Frame) -> None:
        if not isinstance(error, GrabberError):
            error = GrabberError(f"frame {frame.frame_id} cannot be evaluated: {error}")
        with self._news:
            self._error = error
            self._news.notify_all()
        self._failed(error)


def _no_frame() -> str:
    return f"no image came within {FRAME_S:g} s: check camera and cable"
