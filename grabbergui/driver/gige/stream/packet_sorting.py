"""Batches of packets sorted into runs: numpy compares their headers, so that they are handled by the run."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grabbergui.driver.gige.packet_header import decode_rows

Ids = slice | NDArray[np.intp]
"Packet ids, or rows: a `slice` of consecutive ones is faster."


class PacketRun(NamedTuple):
    """Neighbouring rows whose headers differ only in the packet id and in being resent."""

    begin: int
    end: int
    ids: NDArray[np.intp]
    "Packet ids in the order of arrival."
    resent: NDArray[np.bool_]
    "True for each packet that the device flags as resent."
    lowest: int
    highest: int
    increasing: bool
    "Whether each id is higher than the one before."

    @classmethod
    def of(cls, begin: int, end: int, ids: NDArray[np.intp], resent: NDArray[np.bool_]) -> PacketRun:
        """Make a run of any ids."""
        if (ids[1:] > ids[:-1]).all():
            return cls(begin, end, ids, resent, int(ids[0]), int(ids[-1]), True)
        return cls(begin, end, ids, resent, int(ids.min()), int(ids.max()), False)

    @property
    def consecutive(self) -> bool:
        """Whether each id is one more than the one before."""
        return self.increasing and self.highest - self.lowest + 1 == len(self.ids)

    def places(self) -> Ids:
        """Return the ids as an index, a slice where they are consecutive."""
        return slice(self.lowest, self.highest + 1) if self.consecutive else self.ids

    def chosen(self, which: NDArray[np.bool_] | slice) -> PacketRun:
        """Return the run with some of the packets only."""
        return PacketRun.of(self.begin, self.end, self.ids[which], self.resent[which])

    def first_occurrences(self) -> NDArray[np.bool_]:
        """Return which packets are not duplicates of earlier ones in the run."""
        first = np.zeros(len(self.ids), np.bool_)
        first[np.unique(self.ids, return_index=True)[1]] = True
        return first


def packet_runs(rows: NDArray[np.uint8]) -> Iterator[PacketRun]:
    """Divide rows (n, length), which begin with a standard header at least, into runs."""
    ids, resent, differs = decode_rows(rows)
    breaks = (differs.nonzero()[0] + 1).tolist()
    for begin, end in zip([0, *breaks], [*breaks, len(rows)], strict=True):
        yield PacketRun.of(begin, end, ids[begin:end], resent[begin:end])
