"""What is handed over of a block: its picture, and what is missing in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grabbergui.driver.gige.block import Block, runs
from grabbergui.driver.gige.gvsp import Leader


@dataclass(frozen=True)
class FinishedBlock:
    """A block, complete or given up."""

    block_id: int
    leader: Leader
    payload: NDArray[np.uint8]
    "In the caller's buffer: the whole payload, or of a multi-part block its first picture."
    height: int
    "Lines that were really sent."
    missing_bytes: int
    complete: bool
    began: float
    "When its first packet came."


def finish(block: Block, leader: Leader, stride: int, *, complete: bool) -> FinishedBlock:
    """The result of a block that has a buffer. `leader` is its own or, where that was lost, another's.

    What did not arrive is zeros.
    """
    assert block.buffer is not None
    size = len(block.buffer)
    begin, end = _extent(block, leader, size)
    height = leader.height
    lines = block.trailer.height if block.trailer is not None else 0
    if 0 < lines < height and complete:
        height = lines
    missing_bytes = 0
    if not complete:
        end = min(max(end, begin + leader.image_bytes), size)
        missing_bytes = _blank_missing(block, block.buffer[:end], stride)
    payload = block.buffer[begin:end]
    return FinishedBlock(block.block_id, leader, payload, height, missing_bytes, complete, block.began)


def _extent(block: Block, leader: Leader, size: int) -> tuple[int, int]:
    """Where in the buffer the result begins and ends."""
    before = 0
    for part in leader.parts:
        if part.is_picture:
            return before, min(before + part.length, size)
        before += part.length
    if block.trailer is not None and block.trailer.payload_bytes and not leader.parts:
        return 0, min(block.trailer.payload_bytes, size)
    return 0, block.extent


def _blank_missing(block: Block, payload: NDArray[np.uint8], stride: int) -> int:
    """Zero what did not arrive, so that no earlier picture shines through; how many bytes that was."""
    if block.leader is not None and block.leader.parts:
        return 0
    blanked = 0
    packets = -(-len(payload) // stride)
    came = np.zeros(packets + 1, np.uint8)
    known = block.received[: packets + 1]
    came[: len(known)] = known
    for first, last in runs(np.flatnonzero(came[1:] == 0)):
        hole = payload[first * stride : (last + 1) * stride]
        hole[:] = 0
        blanked += len(hole)
    return blanked
