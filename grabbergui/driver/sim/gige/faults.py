"""Faults of the simulated GigE Vision camera on request."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.errors import UsageError

_REORDERED = 0.02
"Share of the packets that swap places if reordering is enabled."
_DUPLICATED = 0.01
_LONGEST_DELAY_S = 10.0


@dataclass(frozen=True)
class GigeFaults:
    """Faults on request; none by default."""

    loss: float = 0.0
    "Part of the stream's packets that never leave, 0 to 1; packets sent again are lost like any other."
    reorder: bool = False
    "Some packets leave later than those behind them."
    duplicate: bool = False
    "Some packets leave twice."
    delay: float = 0.0
    "Seconds that every datagram takes longer."
    stall_after: int = 0
    "Frames after which the stream falls silent until it is started again; 0 means never."
    reboot_after: float = 0.0
    "Seconds after which the camera vanishes for `REBOOT_S` and comes back as after power-on; 0 means never."
    height_in_trailer: bool = False
    "Leaders announce no height, as line-scan cameras do."
    seed: int = 1
    "Seed of the random numbers, so that a run can be repeated."

    def __post_init__(self) -> None:
        # Written so that NaN is refused as well.
        if not 0 <= self.loss <= 1:
            raise UsageError(f"a loss of {self.loss:g} makes no sense; allowed: 0 to 1, or 0% to 100%")
        if not min(self.delay, self.stall_after, self.reboot_after) >= 0:
            raise UsageError("delays and counts of faults cannot be negative")
        if not self.delay <= _LONGEST_DELAY_S:
            raise UsageError(f"a delay of {self.delay:g} s is too long; at most {_LONGEST_DELAY_S:g} s")

    @property
    def disturbs_packets(self) -> bool:
        """Whether single packets are touched."""
        return bool(self.loss or self.reorder or self.duplicate)


class PacketFaults:
    """Decides packet by packet. Use from one thread, or under a lock."""

    def __init__(self, faults: GigeFaults) -> None:
        self._faults = faults
        self._random = np.random.default_rng(faults.seed)

    def order(self, count: int) -> NDArray[np.intp]:
        """Return the indices of those of `count` packets that are sent, in the order of sending."""
        faults = self._faults
        order = np.arange(count)
        if faults.duplicate:
            again = order[self._random.random(count) < _DUPLICATED]
            order = np.insert(order, np.minimum(again + 1, len(order)), again)
        if faults.reorder:
            late = np.flatnonzero(self._random.random(len(order)) < _REORDERED)
            place = order.astype(np.float64)
            position = np.arange(len(order), dtype=np.float64)
            position[late] += self._random.integers(2, 20, len(late)) + 0.5
            order = place[np.argsort(position, kind="stable")].astype(np.intp)
        if faults.loss:
            order = order[self._random.random(len(order)) >= faults.loss]
        return order
