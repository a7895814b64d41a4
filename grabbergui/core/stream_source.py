"""The stream of a source."""

from __future__ import annotations

from abc import ABC, abstractmethod

from grabbergui.core.calibration import Calibration
from grabbergui.core.coord3d import Scan3d
from grabbergui.core.frame_queue import FrameFanout, FrameQueue, StreamStatistics


class StreamSource(ABC):
    """Delivers frames to any number of queues while its stream is on.

    `start` and `stop` take as long as the device or the network does; other calls never wait.
    """

    def __init__(self) -> None:
        self._fanout = FrameFanout()

    @abstractmethod
    def start(self, *, keep_trigger: bool = False) -> None:
        """Start the stream; do nothing if it is on.

        A local camera is set to AcquisitionMode Continuous and, unless `keep_trigger`, TriggerMode Off;
        nothing else is written.
        """

    @abstractmethod
    def stop(self) -> None:
        """Stop the stream; do nothing if it is off. Queues stay open."""

    @property
    @abstractmethod
    def streaming(self) -> bool:
        """Whether the stream is on."""

    @abstractmethod
    def statistics(self) -> StreamStatistics:
        """Return a snapshot of the counters. Any thread; never waits."""

    def calibration(self) -> Calibration | None:
        """Return the calibration of the current images; None if the source does not report it.

        Any thread; never waits.
        """
        return None

    def silence(self) -> str:
        """Return, while no images arrive, from where they should, as display text; empty if unknown.

        Any thread; never waits.
        """
        return ""

    def recorded_coordinates(self) -> Scan3d | None:
        """Return the meaning of 3D data as it was recorded with them; None if the features report it.

        Any thread; never waits. `read_scan3d` prefers it to the features.
        """
        return None

    def open_queue(self, depth: int = 2) -> FrameQueue:
        """Return a queue for a new consumer of the stream.

        Any thread; also before `start`, and it stays open across restarts.
        """
        return self._fanout.open_queue(depth)
