"""What the blocks of one stream share: sizes, and the faults that are reported once."""

from __future__ import annotations

import logging
from dataclasses import dataclass, field

log = logging.getLogger(__name__)

SHORT_PACKET = 512
"Bytes of data in the smallest packets that cameras send, of 576 bytes."
MOST_PARTS = 1024
"Packets of a block that may be shorter: each part ends with one."
MOST_WARNINGS = 16
"Different faults of one stream that are logged."


@dataclass
class BlockLayout:
    """Sizes that all blocks of a stream share."""

    stride: int
    "Image bytes in a full packet: as announced, until a packet shows otherwise."
    payload_size: int
    "Bytes of a buffer, the largest payload."
    relative_parts: bool = False
    "Whether positions in multi-part packets count from the start of their part: cameras differ."
    refusal: str = ""
    "Why the last block that was refused made no frame."
    _reported: set[str] = field(default_factory=set)

    @property
    def max_payload_packets(self) -> int:
        """Payload packets of the largest block."""
        return -(-self.payload_size // self.stride)

    @property
    def highest_id(self) -> int:
        """Highest packet id of a block, whose packets may be shorter than announced."""
        return self.payload_size // min(self.stride, SHORT_PACKET) + MOST_PARTS

    def warn_once(self, fault: str, details: str) -> None:
        """Log a fault that may recur with every packet once in a stream, and `MOST_WARNINGS` in all."""
        if fault not in self._reported and len(self._reported) < MOST_WARNINGS:
            self._reported.add(fault)
            log.warning("%s: %s", fault, details)
