"""Numbers over time, in bounded memory."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from datetime import datetime, timezone

import numpy as np
from numpy.typing import NDArray

MOST_SAMPLES = 36_000
"Of one value: an hour at ten a second. The oldest make way."


class ValueHistory:
    """Samples of one value, the oldest first. One thread at a time."""

    def __init__(self, most: int = MOST_SAMPLES) -> None:
        self._most = most
        # Twice the room, so that the newest can be moved to the front once in a while instead of always.
        self._samples: NDArray[np.float64] = np.empty((2, min(2 * most, 256)))
        self._begin = self._end = 0

    def __len__(self) -> int:
        return self._end - self._begin

    def add(self, moment: float, value: float) -> None:
        """Note a sample: seconds since the epoch, and NaN where there was no value."""
        if self._end == self._samples.shape[1]:
            self._make_room()
        self._samples[:, self._end] = moment, value
        self._end += 1
        self._begin = max(self._begin, self._end - self._most)

    def since(self, moment: float = -np.inf) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Times and values (n,) from a moment on. Views: valid until the next `add`."""
        times, values = self._samples[:, self._begin : self._end]
        first = int(np.searchsorted(times, moment))
        return times[first:], values[first:]

    def _make_room(self) -> None:
        kept = self._samples[:, self._begin : self._end]
        length = min(2 * self._most, max(256, 2 * kept.shape[1]))
        larger = np.empty((2, length))
        larger[:, : kept.shape[1]] = kept
        self._samples, self._begin, self._end = larger, 0, kept.shape[1]


def to_csv(histories: Mapping[str, ValueHistory]) -> str:
    """One line a moment, one column a value; empty where a value was not read at that moment."""
    rows: dict[float, dict[str, float]] = {}
    for name, history in histories.items():
        for moment, value in zip(*history.since(), strict=True):
            if np.isfinite(value):
                rows.setdefault(float(moment), {})[name] = float(value)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["time", *histories])
    for moment in sorted(rows):
        when = datetime.fromtimestamp(moment, timezone.utc).isoformat(timespec="milliseconds")
        writer.writerow([when, *(rows[moment].get(name, "") for name in histories)])
    return text.getvalue()
