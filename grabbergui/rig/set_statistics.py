"""Counters and skew of the sets of a rig."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

RECENT = 4096
"Sets whose skew decides median and p99."


@dataclass(frozen=True)
class SetCounts:
    """How the sets of a rig came out so far."""

    complete: int = 0
    late: int = 0
    incomplete: int = 0
    missing: dict[str, int] = field(default_factory=dict)
    "By camera, the sets without its frame."
    uncertain: int = 0
    "Frames left out because their camera's clock is not known well enough."
    overdue: int = 0
    "Frames that arrived after their set was given up."
    strays: int = 0
    "Frames that belong to no trigger."
    slips: int = 0
    "Times that a camera's numbers of triggers were put right by its clock."
    skew_median_ns: int = 0
    "Median skew of the recent complete sets."
    skew_p99_ns: int = 0
    skew_worst_ns: int = 0
    "Worst skew of all sets."

    @property
    def sets(self) -> int:
        """All sets."""
        return self.complete + self.late + self.incomplete

    def as_dict(self) -> dict[str, Any]:
        """All fields, for JSON."""
        return asdict(self)

    @property
    def brief(self) -> str:
        """The sets by their states, as display text."""
        return f"{self.complete} complete, {self.late} late, {self.incomplete} incomplete"

    def __str__(self) -> str:
        text = self.brief
        lost = ", ".join(f"{name} {count}" for name, count in self.missing.items() if count)
        if lost:
            text += f" (missing: {lost})"
        left_out = (
            (self.uncertain, "with an uncertain time"),
            (self.overdue, "too late for their set"),
            (self.strays, "of no trigger"),
        )
        text += "".join(f"; {count} frames {why}" for count, why in left_out if count)
        median, p99, worst = (
            value / 1000 for value in (self.skew_median_ns, self.skew_p99_ns, self.skew_worst_ns)
        )
        return f"{text}; skew {median:.1f} µs (median), {p99:.1f} µs (p99), {worst:.1f} µs (worst)"


class SetStatistics:
    """Counts sets. One thread counts; any thread may read `counts`."""

    def __init__(self, cameras: Iterable[str]) -> None:
        self.uncertain = 0
        self.overdue = 0
        self.strays = 0
        self.slips = 0
        self._states = {"complete": 0, "late": 0, "incomplete": 0}
        self._missing = dict.fromkeys(cameras, 0)
        self._recent: deque[int] = deque(maxlen=RECENT)
        self._worst = 0

    def count(self, state: str, skew_ns: int, missing: Sequence[str]) -> None:
        """Count a finished set."""
        self._states[state] += 1
        for name in missing:
            self._missing[name] += 1
        if not missing:
            self._recent.append(skew_ns)
        self._worst = max(self._worst, skew_ns)

    @property
    def recent_skews_ns(self) -> tuple[int, ...]:
        """The skew of the recent complete sets, oldest first."""
        return tuple(self._recent.copy())

    def counts(self) -> SetCounts:
        """Return a snapshot."""
        skews = sorted(self._recent.copy())
        return SetCounts(
            **self._states,
            missing=dict(self._missing),
            uncertain=self.uncertain,
            overdue=self.overdue,
            strays=self.strays,
            slips=self.slips,
            skew_median_ns=_rank(skews, 0.5),
            skew_p99_ns=_rank(skews, 0.99),
            skew_worst_ns=self._worst,
        )


def _rank(ordered: Sequence[int], part: float) -> int:
    """Return the smallest value that at least `part` of all do not exceed; 0 without any."""
    return ordered[max(0, math.ceil(part * len(ordered)) - 1)] if ordered else 0
