"""The camera in time: its clock, when frames are exposed, how warm it gets. Nothing here waits.

Times are nanoseconds.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.derived_registers import fastest_rate, unoverlapped_period_us
from grabbergui.driver.sim.enumerations import TriggerOverlap
from grabbergui.driver.sim.memory import RegisterMemory

Clock = Callable[[], int]
FRAME_START, BURST_START = 0, 1
"Indices of the triggers, as in TriggerSelector."
_LATE_PERIODS = 4
_AMBIENT = 24.0
_TIME_CONSTANT_S = 90.0


class SimulatedClock:
    """Turns the host's monotonic time into the device's and back. All in nanoseconds."""

    def __init__(
        self, monotonic: Clock = time.monotonic_ns, master: Clock = time.time_ns, drift: float = 0.0
    ) -> None:
        """`master` is the network's time, which PTP follows; `drift` is how fast the clock is otherwise.

        A drift of 50e-6 gains 50 µs a second.
        """
        self.monotonic = monotonic
        self._master = master
        self._drift = drift
        self._epoch = monotonic()
        self._following = False

    @property
    def following(self) -> bool:
        """Whether PTP sets the clock."""
        return self._following

    @property
    def _pace(self) -> float:
        return 1.0 if self._following else 1.0 + self._drift

    def follow(self, on: bool) -> None:
        """Switch PTP on or off; the clock continues from its present time."""
        moment = self.monotonic()  # once, or the clock would lose what a busy machine takes in between
        present = self.to_device(moment)
        self._following = on
        self._epoch = moment - self._scaled(present, 1 / self._pace)
        self.discipline()

    def discipline(self) -> None:
        """Set the clock by its master again, if it has one."""
        if self._following:
            self._epoch = self.monotonic() - self._master()

    def reset(self) -> None:
        """Start from zero."""
        self._epoch = self.monotonic()

    def now(self) -> int:
        """Return the device's time."""
        return self.to_device(self.monotonic())

    def offset_from_master(self) -> int:
        """Return the clock's offset from its master in ns (positive: ahead); 0 without a master."""
        return self.now() - self._master() if self._following else 0

    def to_device(self, monotonic: int) -> int:
        """Convert the host's monotonic time (ns) to the device's clock."""
        return self._scaled(monotonic - self._epoch, self._pace)

    def to_monotonic(self, device: int) -> int:
        """Convert a time of the device's clock (ns) to the host's monotonic time."""
        return self._epoch + self._scaled(device, 1 / self._pace)

    @staticmethod
    def _scaled(duration: int, pace: float) -> int:
        # The difference alone is rounded: a time since 1970 has more digits than a float.
        return duration + round(duration * (pace - 1.0))


class Timing(NamedTuple):
    """The settings that decide the cadence at the moment."""

    period_ns: int
    "Time between the starts of two exposures."
    triggered: tuple[bool, bool]
    "Whether frames wait for their trigger, and whether bursts do."
    burst_frames: int = 1


def asked_rate(memory: RegisterMemory) -> float:
    """Return the frame rate (Hz) in AcquisitionFrameRate, as far as the camera reaches it."""
    return min(float(memory.stored(reg.FRAME_RATE)), fastest_rate(memory))


def resulting_rate(memory: RegisterMemory) -> float:
    """Return the frame rate (Hz) without triggers."""
    return asked_rate(memory) if memory.integer(reg.FRAME_RATE_ENABLE) else fastest_rate(memory)


def timing_of(memory: RegisterMemory) -> Timing:
    """Return the cadence that the registers ask for at the moment."""
    frame, burst = (bool(memory.integer(mode)) for mode in reg.TRIGGER_MODE)
    # A trigger sets the pace itself; only the sensor bounds it.
    rate = fastest_rate(memory) if frame else resulting_rate(memory)
    period = 1e9 / rate
    if frame and memory.integer(reg.TRIGGER_OVERLAP[FRAME_START]) == TriggerOverlap.OFF:
        period = max(period, unoverlapped_period_us(memory) * 1000)
    return Timing(int(period), (frame, burst), memory.integer(reg.BURST_FRAME_COUNT))


@dataclass
class Sequencer:
    """The acquisition's state machine."""

    running: bool = False
    frames_taken: int = 0
    "Since the acquisition's start; the frame id of the last frame."
    _left: int | None = None
    _earliest: int = 0
    _burst_left: int = 0
    _trigger_at: list[int | None] = field(default_factory=lambda: [None, None])

    def start(self, now: int, frames: int | None) -> None:
        """Begin an acquisition of a number of frames, or a continuous one."""
        self.running = True
        self.frames_taken = 0
        self._left = frames
        self._earliest = now
        self._burst_left = 0
        self._trigger_at = [None, None]

    def stop(self) -> None:
        """End the acquisition; triggers not yet served are forgotten."""
        self.running = False

    @property
    def finished(self) -> bool:
        """Whether a bounded acquisition has delivered its last frame."""
        return self.running and self._left == 0

    def trigger(self, which: int, at: int) -> bool:
        """Record a trigger at a time; return False if it is lost: too early, or no acquisition."""
        if not self.running:
            return False
        busy = self._trigger_at[which] is not None or at < self._earliest
        if busy or (which == BURST_START and self._burst_left):
            return False
        self._trigger_at[which] = at
        return True

    def due(self, timing: Timing) -> int | None:
        """Return the start of the next exposure; None while none is scheduled."""
        if not self.running or self._left == 0:
            return None
        start = self._earliest
        for which in (FRAME_START, BURST_START):
            if not timing.triggered[which] or (which == BURST_START and self._burst_left):
                continue
            at = self._trigger_at[which]
            if at is None:
                return None
            start = max(start, at)
        return start

    def take(self, timing: Timing, now: int) -> tuple[int, int] | None:
        """Return the next frame's id and the start of its exposure once it is due; ids count from 1.

        If the caller has fallen behind by several frames, they are skipped: a sensor does not wait for its
        reader.
        """
        start = self.due(timing)
        if start is None:
            return None
        if now - start > _LATE_PERIODS * timing.period_ns and not any(timing.triggered):
            start = now - timing.period_ns
        if timing.triggered[BURST_START]:
            self._burst_left = (self._burst_left or timing.burst_frames) - 1
        self._trigger_at = [None, None]
        self._earliest = start + timing.period_ns
        self.frames_taken += 1
        if self._left is not None:
            self._left -= 1
        return self.frames_taken, start


class Thermometer:
    """One place in the camera. Times in nanoseconds on any one clock."""

    def __init__(self, now: int, idle: float, streaming: float) -> None:
        self._idle = idle
        "Degrees above the surroundings at rest."
        self._streaming = streaming
        "Degrees more while streaming."
        self._rise = 0.7 * idle
        self._since = now
        self._load = 0.0

    def set_streaming(self, streaming: bool, now: int) -> None:
        """Change the load: streaming warms the sensor."""
        self._rise = self._now(now)
        self._since = now
        self._load = 1.0 if streaming else 0.0

    def read(self, now: int) -> float:
        """Return the temperature in degrees Celsius."""
        return round(_AMBIENT + self._now(now), 2)

    def _now(self, now: int) -> float:
        goal = self._idle + self._load * self._streaming
        decay = math.exp(-(now - self._since) * 1e-9 / _TIME_CONSTANT_S)
        return goal + (self._rise - goal) * decay
