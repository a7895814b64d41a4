"""Runs of consecutive packet ids among sorted ones."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray


def id_runs(ids: NDArray[np.intp]) -> Iterator[tuple[int, int]]:
    """Yield (first, last) of each run of consecutive ids among sorted ones."""
    if len(ids):
        breaks = np.flatnonzero(np.diff(ids) != 1)
        firsts = ids[np.concatenate([[0], breaks + 1])]
        lasts = ids[np.concatenate([breaks, [len(ids) - 1]])]
        yield from zip(firsts.tolist(), lasts.tolist(), strict=True)


def run_ends(ids: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return for each of sorted ids the first id after its run."""
    breaks = (ids[1:] - ids[:-1] != 1).nonzero()[0]
    if len(breaks) == len(ids) - 1:  # as mostly
        return ids + 1
    lasts = np.append(breaks, len(ids) - 1)
    return np.repeat(ids[lasts] + 1, np.diff(lasts, prepend=-1))
