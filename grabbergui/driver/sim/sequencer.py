"""When frames are exposed: acquisition modes, triggers, cadence. Decides, never waits.

Times are nanoseconds on whatever clock the caller uses.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

FRAME_START, BURST_START = 0, 1
"Indices of the triggers, as in TriggerSelector."

_LATE_PERIODS = 4


class Timing(NamedTuple):
    """What decides the cadence just now."""

    period_ns: int
    "From one exposure's start to the next one's."
    triggered: tuple[bool, bool]
    "Whether frames, and bursts, wait for their trigger."
    burst_frames: int = 1


@dataclass
class Sequencer:
    """The acquisition's state machine."""

    running: bool = False
    frames_taken: int = 0
    "Since the acquisition's start; the frame id of the last frame."
    _left: int | None = None
    _earliest: int = 0
    _burst_left: int = 0
    _trigger_at: list[int | None] | None = None

    def start(self, now: int, frames: int | None) -> None:
        """Begin an acquisition of so many frames, or without end."""
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
        """Whether the last frame of an acquisition of so many has been taken."""
        return self.running and self._left == 0

    def trigger(self, which: int, at: int) -> bool:
        """A trigger that acts at a time; False where it is lost, coming too early or without acquisition."""
        if not self.running or self._trigger_at is None:
            return False
        busy = self._trigger_at[which] is not None or at < self._earliest
        if busy or (which == BURST_START and self._burst_left):
            return False
        self._trigger_at[which] = at
        return True

    def due(self, timing: Timing) -> int | None:
        """When the next exposure starts; None where nothing is to come, as yet."""
        if not self.running or self._left == 0 or self._trigger_at is None:
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
        """The next frame's id and the start of its exposure, once `due` has come; ids count from 1.

        Where the caller has fallen behind by several frames, they are skipped, as a sensor would go on
        without waiting for its reader.
        """
        start = self.due(timing)
        if start is None or self._trigger_at is None:
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
