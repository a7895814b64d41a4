"""The stream of a camera model in this process: a thread that renders what the model plans."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.frame import BufferPool, Frame
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.driver.device import FrameCounter, deliver_or_log
from grabbergui.driver.sim.model import FramePlan

_POLL_S = 0.1


class FrameModel(Protocol):
    """The calls by which a stream uses the model of a camera."""

    def next_frame(self, timeout: float) -> FramePlan | None:
        """Wait for the next frame; None after `timeout` seconds, or once woken."""

    def wake(self) -> None:
        """End a wait for the next frame. Any thread."""

    def render(self, plan: FramePlan, out: NDArray[np.uint8]) -> int:
        """Write a frame's payload and return its length."""


class PlannedStream(ABC):
    """Renders frames straight into the pool's buffers on its own thread, from construction until `close`."""

    def __init__(self, model: FrameModel, payload_size: int, deliver: Callable[[Frame], None]) -> None:
        """Start. `payload_size` bytes are the largest frame; `deliver` must return at once."""
        self._plans = model
        self._deliver = deliver
        self._pool = BufferPool(max(payload_size, 1))
        self._counter = FrameCounter()
        self._stopping = False
        self._thread = threading.Thread(target=self._run, name="simulated camera", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop. Nothing is delivered after return."""
        self._stopping = True
        self._plans.wake()
        self._thread.join()

    def statistics(self) -> StreamStatistics:
        """Return a snapshot of the counters. Any thread."""
        return self._counter.statistics()

    @abstractmethod
    def _frame(self, plan: FramePlan, payload: NDArray[np.uint8]) -> Frame:
        """Return the frame of a rendered payload."""

    def _run(self) -> None:
        while not self._stopping:
            plan = self._plans.next_frame(_POLL_S)
            if plan is None:
                continue
            if plan.payload_bytes > self._pool.size:
                # The stream was opened for smaller frames, as if packets beyond the buffer were dropped.
                self._counter.counts.incomplete += 1
                continue
            buffer = self._pool.take()
            if buffer is None:
                self._counter.counts.underruns += 1
                continue
            used = self._plans.render(plan, buffer)
            self._counter.note_complete(used)
            frame = self._frame(plan, buffer[:used])
            del buffer
            deliver_or_log(self._deliver, frame)
            del frame  # else its buffer would be in use until the next one is made
