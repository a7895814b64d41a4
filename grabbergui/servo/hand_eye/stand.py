"""The robot and the camera of a hand–eye calibration, and the watch for the target."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from grabbergui.calibration.calibration_choice import CalibrationFor, CalibrationWatch
from grabbergui.calibration.geometry import Pose
from grabbergui.calibration.marker_pose import MarkerDetection
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import FrameTimeoutError, GrabberError, UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameSink
from grabbergui.core.grabber import FrameGrabber
from grabbergui.net.ros2.camera_pose import StaticFrame
from grabbergui.servo.config import Config, MarkerConfig
from grabbergui.servo.detection import MarkerDetector, Sighting, marker_detector
from grabbergui.servo.gate import CommandGate
from grabbergui.servo.hand_eye import hand_eye_file
from grabbergui.servo.hand_eye.hand_eye_file import CameraMount
from grabbergui.servo.hand_eye.run import VIEWS
from grabbergui.servo.hand_eye.solver import HandEyeResult
from grabbergui.servo.robots.robot import ARM, HEAD, CameraPlace, Robot

FRAME_S = 5.0
"Seconds to wait for a frame."
SILENCE_S = 0.2
"Seconds to wait for a frame at a time; then `between` is called, and the watch may end."

Seen = Callable[[Frame, "MarkerDetection | None"], object]
"Gets each whole frame and the target in it, None if it is not visible; on the watch's thread."
Cameras = Callable[[str, MarkerConfig], FrameGrabber]
"Returns the open camera that sees a target for an entry of `hand_eye_run.EYES`."


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
        self._calibrations = CalibrationWatch(grabber)
        self._detector: MarkerDetector | None = None
        self._newest: tuple[float, MarkerDetection | None] = (-np.inf, None)
        self._error: tuple[float, GrabberError | None] = (-np.inf, None)
        "When the frame was exposed that failed since the last one that did not, and the failure."
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
        try:
            grabber.start()
        except BaseException:
            self._sink.stop()  # its queue would hold frames from then on
            raise
        self._sink.start()

    def close(self, timeout: float | None = None) -> bool:
        """End; return whether the thread ended within `timeout` seconds. May be called twice."""
        with self._news:
            self._closed = True
            self._news.notify_all()
        ended = self._sink.stop(timeout)
        self._calibrations.close()
        return ended

    @property
    def calibration(self) -> Calibration:
        """The calibration for frames of the source's size; waits for the first one.

        Raises FrameTimeoutError without a frame, UsageError if the calibration does not fit.
        """
        with self._news:
            self._await(lambda: self._calibration is not None or self._error[1] is not None)
            if self._calibration is None:
                raise self._error[1] or FrameTimeoutError(_no_frame())
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
            self._await(lambda: max(self._newest[0], self._error[0]) > after)
            captured, found = self._newest
            if captured > after:
                return found
            failed, error = self._error
            raise error if error is not None and failed > after else FrameTimeoutError(_no_frame())

    def _await(self, condition: Callable[[], bool]) -> None:
        deadline = time.monotonic() + FRAME_S
        while not condition() and not self._closed:
            if not self._news.wait(max(deadline - time.monotonic(), 0)):
                return

    def _consume(self, frame: Frame) -> bool:
        if not frame.complete:
            return False
        calibration, size = self._calibration, (frame.width, frame.height)
        another = self._calibrations.another(frame)
        if another or calibration is None or (calibration.width, calibration.height) != size:
            calibration = self._calibration_for(frame.width, frame.height)
            self._detector = marker_detector(self._marker, calibration)
        grey = np.asarray(frame.mono())
        markers = () if self._detector is None else tuple(self._detector.detect(grey))
        found = Sighting(frame.captured, markers).only(self._marker.target)
        with self._news:
            self._calibration, self._error = calibration, (-np.inf, None)
            self._newest = frame.captured, found
            self._news.notify_all()
        self._seen(frame, found)
        return True

    def _on_failed(self, error: Exception, frame: Frame) -> None:
        if not isinstance(error, GrabberError):
            error = GrabberError(f"frame {frame.frame_id} cannot be evaluated: {error}")
        with self._news:
            self._error = frame.captured, error
            self._news.notify_all()
        self._failed(error)


def _no_frame() -> str:
    return f"no image arrived within {FRAME_S:g} s: check camera and cable"


@dataclass(eq=False)
class HandEyeStand:
    """Robot and camera, opened and closed by others. `close` ends what was published."""

    robot: Robot
    gate: CommandGate
    "The one that every other stop of this robot goes through, too."
    config: Config
    cameras: Cameras
    calibration: CalibrationFor
    placement: Callable[[str], CameraMount]
    "Frames of tf for an entry of `hand_eye_run.EYES`."
    eye: str = "head"
    "Proposed place of the camera."
    views: int = VIEWS
    "Proposed number of views."
    file: Path | None = None
    "The robot's file: proposed for saving, and compared with."
    leave: Callable[[], None] = lambda: None
    "Closes a camera that `cameras` opened; called when a wizard ends."
    clock: Callable[[], float] = time.monotonic
    pause: Callable[[float], None] = time.sleep

    def __post_init__(self) -> None:
        self._frame: StaticFrame | None = None

    def watch(
        self,
        eye: str,
        marker: MarkerConfig,
        seen: Seen,
        failed: Callable[[GrabberError], object],
        between: Callable[[], object],
    ) -> TargetWatch:
        """Start to detect a target. Raises GrabberError; for the callbacks see `TargetWatch`."""
        grabber = self.cameras(eye, marker)
        return TargetWatch(grabber, marker, self.calibration, seen=seen, failed=failed, between=between)

    def why_not(self, eye: str) -> str:
        """Return why the camera cannot be calibrated there, as display text; empty if it can."""
        if self.gate.dry_run:
            return "this is a dry run, in which the robot does not move: start without --dry-run"
        part = HEAD if eye == "head" else ARM
        if part not in self.robot.parts:
            return f"the {part} of {self.robot.name} is not driven"
        state = self.robot.state()
        if state is None:
            return f"{self.robot.name} does not report its joints"
        if part == ARM and state.arm is None:
            return f"{self.robot.name} does not report the angles of its arm"
        return ""

    def in_use(self, eye: str) -> tuple[str, Pose] | None:
        """Return the origin (`robot`, `model` or a file's path) and the camera's pose that hold at present.

        The pose is on the chain's tool, or in the base; None if there is none.
        """
        if eye == "head" and self.robot.placed is not None:
            return "robot", self.robot.placed.camera
        if self.file is not None and self.file.is_file():
            try:
                result, placed = hand_eye_file.load(self.file), hand_eye_file.placement(self.file)
            except (UsageError, OSError):
                result, placed = None, None
            if result is not None and placed is not None and placed.eye == eye:
                return str(self.file), result.camera
        return ("model", self.robot.model.camera) if eye == "head" else None

    def use(self, result: HandEyeResult) -> CameraPlace | None:
        """Let servoing take the camera on the head from a result; return what it used before."""
        before = self.robot.placed
        self.robot.placed = CameraPlace(result.camera, result.camera_offsets)
        return before

    def use_again(self, before: CameraPlace | None) -> None:
        """Undo `use`."""
        self.robot.placed = before

    def publish(self, placement: CameraMount, camera: Pose) -> None:
        """Publish the camera's frame on `/tf_static` instead of the one before.

        Raises SourceUnavailableError without ROS 2 or tf's messages.
        """
        self.withdraw()
        frame = StaticFrame(placement.mount, placement.frame, placement.on_mount(camera))
        frame.open()
        self._frame = frame

    def withdraw(self) -> None:
        """Publish no frame any more."""
        frame, self._frame = self._frame, None
        if frame is not None:
            frame.close()

    @property
    def published(self) -> bool:
        """Whether a frame is published."""
        return self._frame is not None

    def close(self) -> None:
        """Withdraw what was published. May be called twice."""
        self.withdraw()
