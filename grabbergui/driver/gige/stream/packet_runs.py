"""Many packets at once: which of them belong together, told by comparing their headers with numpy."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grabbergui.driver.gige.gvcp import Status
from grabbergui.driver.gige.gvsp import EXTENDED_BIT, FLAG_RESEND, PacketHeader

_WORD = slice(0, 8)
"Standard: status, block id, format, packet id. Extended: status, flags, format, parts and no id."
_BLOCK_ID = slice(8, 16)
_PACKET_ID = slice(16, 20)
_ID_BITS = np.uint64(24)
_ID_MASK = np.uint64((1 << 24) - 1)
_EXTENDED = np.uint64(EXTENDED_BIT << 24)
_MARK = np.uint64(Status.PACKET_RESEND << 48)
"The status of a packet that is sent again."
_EXTENDED_MARK = np.uint64(Status.PACKET_RESEND << 48 | FLAG_RESEND << 32)
"The same, or the flag that says it."


class PacketRun(NamedTuple):
    """Neighbouring rows whose headers differ in the packet id and the mark of what is sent again only."""

    begin: int
    end: int
    ids: NDArray[np.intp]
    "Packet ids, in the order in which they came."
    marked: NDArray[np.bool_]
    "Which of them the device says that it sent again."


def in_turn(rows: NDArray[np.uint8]) -> bool:
    """Whether rows, as in `packet_runs`, differ in their packet id only, each by one more than the last."""
    words = _numbers(rows[:, _WORD], ">u8")
    extended = bool(words[0] & _EXTENDED)
    if (words[1:] - words[:-1] != (0 if extended else 1)).any():
        return False
    if not extended:
        return True
    return (
        rows.shape[1] >= PacketHeader.EXTENDED.size
        and not np.diff(_numbers(rows[:, _BLOCK_ID], ">u8")).any()
        and bool((np.diff(_numbers(rows[:, _PACKET_ID], ">u4")) == 1).all())
    )


def packet_runs(rows: NDArray[np.uint8]) -> Iterator[PacketRun]:
    """All rows, run by run.

    `rows` (n, length) begin with the headers of stream packets of equal length, standard ones at least.
    """
    words = _numbers(rows[:, _WORD], ">u8")
    extended = (words & _EXTENDED).astype(bool)
    if extended.any():
        ids, marks, differs = _extended(rows, words, extended)
    else:
        ids, marks = words & _ID_MASK, words & _MARK
        kinds = (words ^ marks) >> _ID_BITS
        differs = kinds[1:] != kinds[:-1]
    packet_ids, marked = ids.astype(np.intp), marks.astype(bool)
    breaks = (differs.nonzero()[0] + 1).tolist()
    for begin, end in zip([0, *breaks], [*breaks, len(rows)], strict=True):
        yield PacketRun(begin, end, packet_ids[begin:end], marked[begin:end])


def _extended(
    rows: NDArray[np.uint8], words: NDArray[np.uint64], extended: NDArray[np.bool_]
) -> tuple[NDArray[np.uint64], NDArray[np.uint64], NDArray[np.bool_]]:
    """Packet ids, marks, and which rows differ from the one before, where some have extended headers."""
    marks = words & np.where(extended, _EXTENDED_MARK, _MARK)
    kinds = (words ^ marks) >> _ID_BITS
    differs = kinds[1:] != kinds[:-1]
    if rows.shape[1] < PacketHeader.EXTENDED.size:
        return words & _ID_MASK, marks, differs | extended[1:]
    ids = np.where(extended, _numbers(rows[:, _PACKET_ID], ">u4"), words & _ID_MASK)
    other_block = np.diff(_numbers(rows[:, _BLOCK_ID], ">u8")) != 0
    return ids, marks, differs | (extended[1:] & other_block)


def _numbers(columns: NDArray[np.uint8], kind: str) -> NDArray[np.uint64]:
    """A big-endian number from each row."""
    return columns.view(kind)[:, 0].astype(np.uint64)
