"""The usual packets, full payload packets of the newest block, are stored by compiled loops.

`fast_path_loops` reads packets and stores them without Python until something else happens. Before, the
assembler writes here which packets these are and where they belong (`FastPath.open`); afterwards it reads
here which were stored. The loops decide nothing about the protocol.
"""

from __future__ import annotations

import socket
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.compiled import CompiledLoops
from grabbergui.driver.gige.gvsp import EXTENDED_BIT, PacketFormat, PacketHeader
from grabbergui.driver.gige.stream.block import Block

LOOPS = CompiledLoops("grabbergui.driver.gige.stream.fast_path_loops")

# Why the loops return.
EMPTY = 0
"No packet waits."
ENDED = 1
"All packets of the block are there, or the last of them."
OTHER = 2
"The next packet is one that they do not store."
MORE = 3
"More packets wait, but timers should have their turn."
FAILED = 4
"Sockets can be read, it is said, but give nothing."

# Places in `Lane.state`.
KIND = 0
"A header's first bytes, up to the packet id, without the marks of a resent packet."
BLOCK_ID = 1
"64 bits, of an extended header."
HEADER, STRIDE = 2, 3
"Bytes of a header, and of the payload behind it; negative if no packet is to be stored."
LAST = 4
"The highest packet id to store."
END = 5
"The packet id that arrives last, as far as is known."
HIGHEST, TOP = 6, 7
"The highest packet id received, and the highest that the loops stored."
MISSING = 8
"How many of the packets up to LAST were not received."
TAKEN, NOTED = 9, 10
"How many packets the loops stored, and how many of them they noted."
GAPS = 11
"Whether packet ids were skipped."
SOURCES = 12
"How many sockets packets come from."

# Places in `Lane.times`, in seconds.
NOW = 0
"When packets were read last."
PERIOD = 1
"Between two packets; 0 while unknown."
LONGEST = 2
"The longest pause in which packets may gather; 0 for none."
PATIENCE, GAP_AT = 3, 4
"How long the loops stay after a gap, and when it was found."
LATE = 5
"By how much a pause ended late, at most."
LOOKED = 6
"When they looked for packets last."

MOST_NOTED = 512
_ENDLESS = 1 << 30


class Lane(NamedTuple):
    """Arguments and results of the loops."""

    state: NDArray[np.int64]
    times: NDArray[np.float64]
    received: NDArray[np.uint8]
    "The block's: 1 for each packet received, by packet id."
    buffer: NDArray[np.uint8]
    "The block's; empty if nothing is to be stored."
    noted_ids: NDArray[np.int64]
    "Of packets that came late or are flagged as resent."
    noted_at: NDArray[np.float64]
    noted_resent: NDArray[np.uint8]
    clock: NDArray[np.int64]
    "A `struct timespec`."


_NOTHING = np.zeros(0, np.uint8)
_POLLIN = 1
"Linux's; the select module of some other systems lacks it."


def polls(sockets: Iterable[socket.socket]) -> NDArray[np.int64]:
    """Return sockets as the loops wait for them, each a `struct pollfd`."""
    return np.array([each.fileno() | _POLLIN << 32 for each in sockets], np.int64)


class FastPath:
    """What the loops may store. One thread."""

    def __init__(self) -> None:
        self.lane = Lane(
            np.zeros(13, np.int64),
            np.zeros(7),
            _NOTHING,
            _NOTHING,
            np.zeros(MOST_NOTED, np.int64),
            np.zeros(MOST_NOTED),
            np.zeros(MOST_NOTED, np.uint8),
            np.zeros(2, np.int64),
        )

    def close(self) -> None:
        """Let the loops store nothing: there is no block."""
        self.lane.state[:] = 0
        self.lane.state[STRIDE] = -1  # of no packet
        self.lane.state[END] = _ENDLESS

    def open(self, block: Block, payload_size: int, remaining: int, patience: float) -> None:
        """Let the loops store packets of this block, of which `remaining` arrive until its end.

        After a gap they return within `patience` seconds.
        """
        stride, packets = block.layout.stride, block.payload_packets()
        last = payload_size // stride
        if packets is not None:
            last = min(last, packets)
        block.make_room(last + 1)
        missing = _ENDLESS
        if packets is not None:
            highest = min(block.highest, last)
            missing = last - max(highest, 0)
            if block.received_count <= highest:  # there are gaps
                missing += int(np.count_nonzero(block.received[1 : highest + 1] == 0))
        size = PacketHeader.EXTENDED.size if block.extended else PacketHeader.STANDARD.size
        kind = PacketFormat.PAYLOAD | EXTENDED_BIT if block.extended else PacketFormat.PAYLOAD
        if not block.extended:
            kind |= block.block_id << 8
        end = block.highest + remaining
        identity = block.block_id if block.block_id < 1 << 63 else block.block_id - (1 << 64)
        state = self.lane.state
        state[[KIND, BLOCK_ID, HEADER, STRIDE]] = kind, identity, size, stride
        state[[LAST, END, HIGHEST, MISSING]] = last, end, block.highest, missing
        state[[TOP, TAKEN, NOTED, GAPS]] = -1, 0, 0, 0
        self.lane.times[PATIENCE] = patience
        buffer = _NOTHING if block.buffer is None or block.refused else block.buffer
        self.lane = self.lane._replace(received=block.received, buffer=buffer)

    # -- results ---------------------------------------------------------------------------------
    @property
    def stored(self) -> int:
        """Packets that the loops stored."""
        return int(self.lane.state[TAKEN])

    @property
    def highest(self) -> int:
        """The highest packet id received."""
        return int(self.lane.state[HIGHEST])

    @property
    def top(self) -> int:
        """The highest packet id that the loops stored."""
        return int(self.lane.state[TOP])

    @property
    def gaps(self) -> bool:
        """Whether ids were skipped, perhaps for a moment only."""
        return bool(self.lane.state[GAPS])

    @property
    def disorder(self) -> bool:
        """Whether any packet came out of order, or is flagged as resent."""
        return bool(self.lane.state[GAPS] or self.lane.state[NOTED])

    @property
    def last_read_at(self) -> float:
        """When packets were read last, in seconds of the monotonic clock."""
        return float(self.lane.times[NOW])

    @property
    def looked_at(self) -> float:
        """When the loops looked for packets last; they took all that had arrived by then."""
        return float(self.lane.times[LOOKED])

    def noted(self) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.bool_]]:
        """Return packets that came late or are flagged as resent: ids, times, and the flags."""
        count = self.lane.state[NOTED]
        lane = self.lane
        return lane.noted_ids[:count], lane.noted_at[:count], lane.noted_resent[:count] != 0
