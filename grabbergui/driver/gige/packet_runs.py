"""Many packets at once: which of them follow each other, told by comparing their headers with numpy."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from grabbergui.driver.gige.gvsp import EXTENDED_BIT, PacketHeader

_WORD = slice(0, 8)
"Standard: status, block id, format, packet id. Extended: status, flags, format and no id."
_BLOCK_ID = slice(8, 16)
_PACKET_ID = slice(16, 20)
_EXTENDED = np.uint64(EXTENDED_BIT << 24)


def packet_runs(rows: NDArray[np.uint8]) -> Iterator[tuple[int, int]]:
    """Stretches, as (begin, end), of packets that differ in their packet id only, each by one more.

    `rows` (n, length) are stream packets of equal length, one a row, each with at least a standard header.
    """
    if len(rows) < 2:
        yield 0, len(rows)
        return
    words = _numbers(rows[:, _WORD], ">u8")
    steps = words[1:] - words[:-1]
    follows = steps == 1
    extended = (words[1:] & _EXTENDED).astype(bool)
    if extended.any():
        follows &= ~extended
        if rows.shape[1] >= PacketHeader.EXTENDED.size:
            same = (steps == 0) & (np.diff(_numbers(rows[:, _BLOCK_ID], ">u8")) == 0)
            follows |= extended & same & (np.diff(_numbers(rows[:, _PACKET_ID], ">u4")) == 1)
    if follows.all():
        yield 0, len(rows)
        return
    breaks = (np.flatnonzero(~follows) + 1).tolist()
    yield from zip([0, *breaks], [*breaks, len(rows)], strict=True)


def _numbers(columns: NDArray[np.uint8], kind: str) -> NDArray[np.uint64]:
    """A big-endian number from each row."""
    return columns.view(kind)[:, 0].astype(np.uint64)
