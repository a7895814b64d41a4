"""The camera on a simulated robot's head, with faults; and a record of where the robot truly is."""

from __future__ import annotations

import threading
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from typing_extensions import override

from grabbergui.calibration.geometry import vector_from_pose
from grabbergui.core.component import Conversions
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameQueue, FrameSink
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.shared import SharedGrabber
from grabbergui.servo.robots.faults import ImageFaults
from grabbergui.servo.robots.simulated import SimRobot

RECORD_PERIOD = 0.01
"Seconds between two lines of a record."


class FaultyCamera(SharedGrabber):
    """A handle on an open camera whose frames suffer the faults of a robot."""

    def __init__(self, grabber: FrameGrabber, robot: SimRobot) -> None:
        super().__init__(grabber)
        self._robot = robot
        self._newest: Frame | None = None
        self._faults: ImageFaults[Frame] = ImageFaults(robot.faults, self._restamped, self._spoiled)
        self._random = np.random.default_rng(1)
        self._sink: FrameSink | None = None

    @override
    def open(self, access: Access = Access.CONTROL) -> None:
        super().open(access)
        self._sink = FrameSink(self._grabber, self._pass_on, name="faults of the camera", reopens=True)
        self._sink.start()

    @override
    def close(self) -> None:
        if self._sink is not None:
            self._sink.stop(5)
            self._sink = None
        self._fanout.close()
        super().close()

    @override
    def open_queue(self, depth: int = 2) -> FrameQueue:
        return self._fanout.open_queue(depth)

    def _pass_on(self, frame: Frame) -> None:
        # Held for a while, it must not occupy a buffer of the stream.
        self._newest = frame.detached() if self._robot.faults else frame
        for arrived in self._faults.pass_on(self._newest, self._robot.truth().time):
            self._fanout.put(arrived)

    def _restamped(self, frame: Frame, _: float) -> Frame:
        """Return a frame with the id and the stamps of the newest."""
        newest = frame if self._newest is None else self._newest
        return replace(
            frame,
            frame_id=newest.frame_id,
            timestamp_ns=newest.timestamp_ns,
            received_ns=newest.received_ns,
            captured=newest.captured,
        )

    def _spoiled(self, frame: Frame, fault: str) -> Frame:
        payload = frame.payload.copy()
        lines = payload[: payload.size - payload.size % frame.height].reshape(frame.height, frame.width, -1)
        if fault == "images-dark":
            lines[:] = 0
        elif fault == "images-mirrored":
            lines[:] = lines[:, ::-1].copy()
        else:
            lines[:] = self._random.integers(0, 256, lines.shape, np.uint8)
        return replace(frame, payload=payload, _conversions=Conversions())


class TruthRecorder:
    """Writes where a simulated robot truly is, on a thread of its own: lines of comma-separated values.

    They contain seconds on `time.monotonic`, the hand's position (metres) and rotation vector (radians) in
    the base, the faults that have begun (separated by spaces), and the joints of head and arm (radians).
    """

    def __init__(self, robot: SimRobot, file: Path) -> None:
        """Raises OSError if the file cannot be written."""
        self._robot = robot
        self._file = file.open("w", encoding="utf-8", buffering=1)
        names = (*robot.model.head.joint_names, *robot.model.arm.joint_names)
        self._file.write(",".join(("time", "x", "y", "z", "rx", "ry", "rz", "faults", *names)) + "\n")
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run, name="record of the truth", daemon=True)

    def start(self) -> None:
        """Begin to write."""
        self._thread.start()

    def close(self) -> None:
        """Write no more."""
        self._ending.set()
        self._thread.join()
        self._file.close()

    def _run(self) -> None:
        due = time.monotonic()
        while not self._ending.wait(max(due - time.monotonic(), 0.0)):
            due += RECORD_PERIOD
            self._file.write(self._line() + "\n")

    def _line(self) -> str:
        state = self._robot.truth()
        faults = " ".join(self._robot.faults.active(state.time))
        arm = () if state.arm is None else state.arm
        pose = ",".join(f"{value:.6f}" for value in vector_from_pose(state.hand))
        joints = ",".join(f"{angle:.6f}" for angle in (*state.head, *arm))
        return f"{state.time:.4f},{pose},{faults},{joints}"
