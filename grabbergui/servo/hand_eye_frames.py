"""Detection of the calibration target in a camera's frames, for `hand_eye_run`."""

from __future__ import annotations

import time

import numpy as np

from grabbergui.calibration.fitted import CalibrationFor
from grabbergui.calibration.markers import MarkerDetection
from grabbergui.core.errors import FrameTimeoutError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.servo import closed_loop
from grabbergui.servo.config import Config
from grabbergui.servo.detection import Sighting

FRAME_S = 5.0
"Seconds to wait for a frame."


class TargetDetector:
    """Detects the configured target in the frames of an open source. Use from one thread."""

    def __init__(self, grabber: FrameGrabber, config: Config, calibration: CalibrationFor) -> None:
        """Start the source and wait for its first frame. Raises FrameTimeoutError, UsageError."""
        self._queue = grabber.open_queue(1)
        grabber.start()
        first = self._queue.get(FRAME_S)
        self.calibration = calibration(first.width, first.height)
        "Calibration for frames of this size."
        self._detector = closed_loop.detector(config, self.calibration).markers
        self._target = config.marker.target

    def close(self) -> None:
        """Stop receiving frames."""
        self._queue.close()

    def __call__(self, after: float) -> MarkerDetection | None:
        """Return the target in the first whole frame exposed after `after` (monotonic seconds)."""
        deadline = time.monotonic() + FRAME_S
        while time.monotonic() < deadline:
            frame = self._queue.get(FRAME_S)
            if frame.complete and frame.captured > after:
                grey = np.asarray(frame.mono())
                return Sighting(frame.captured, tuple(self._detector.detect(grey))).only(self._target)
        raise FrameTimeoutError(f"no whole frame came within {FRAME_S:g} s")
