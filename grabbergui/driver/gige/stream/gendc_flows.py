"""Where the data of a GenDC container's flows belongs (EMVA GenDC 1.1, GigE Vision 2.2). No I/O.

A packet has its place in a flow. The flow with the descriptor, usually the only one, is the container itself.
For the others the descriptor says which parts they carry, so their packets wait until it is complete.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.driver import gendc
from grabbergui.driver.gige.gvsp import GendcPosition

LONGEST_DESCRIPTOR = 1 << 16
"Bytes; some hundreds are usual."
_DESCRIPTOR_SIZE_AT = 48
_UINT32 = struct.Struct("<I")

Placed = tuple[int, int, memoryview]
"Packet id, offset in the container, data."


class Flows:
    """The flows of one container."""

    def __init__(self, most_bytes: int) -> None:
        """`most_bytes` that a container may have."""
        self._most_bytes = most_bytes
        self._descriptor_flow: int | None = None
        self._head: dict[int, bytes] = {}
        "The descriptor's pieces by their offsets, until it is complete."
        self._parts: tuple[gendc.PartHeader, ...] | None = None
        self._waiting: list[tuple[int, GendcPosition, bytes]] = []
        self._waiting_bytes = 0

    def take(self, packet_id: int, piece: GendcPosition, data: memoryview) -> Iterator[Placed]:
        """Give the places of a packet's data, and of data that waited for it. Raises RemoteProtocolError."""
        first = piece.offset == 0 and bytes(data[:4]) == gendc.SIGNATURE
        if self._descriptor_flow is None and (first or piece.flow == 0):
            self._descriptor_flow = piece.flow
            own = [late for late in self._waiting if late[1].flow == piece.flow]
            self._waiting = [late for late in self._waiting if late[1].flow != piece.flow]
            for late_id, late_piece, late_data in own:
                yield from self.take(late_id, late_piece, memoryview(late_data))
        if piece.flow == self._descriptor_flow:
            if piece.offset == 0:
                gendc.check_version(data)
            yield packet_id, piece.offset, data
            if self._parts is None and piece.offset < LONGEST_DESCRIPTOR:
                yield from self._read_descriptor(piece.offset, data)
        elif self._parts is not None:
            yield from self._places(packet_id, piece, data)
        else:
            self._waiting_bytes += len(data)
            if self._waiting_bytes > self._most_bytes:
                raise RemoteProtocolError("GenDC data of a frame's size came without a descriptor")
            self._waiting.append((packet_id, piece, bytes(data)))

    def _read_descriptor(self, offset: int, data: memoryview) -> Iterator[Placed]:
        self._head[offset] = bytes(data)
        head = b""
        while len(head) < LONGEST_DESCRIPTOR and (more := self._head.get(len(head))):
            head += more
        begun = len(head) >= _DESCRIPTOR_SIZE_AT + _UINT32.size
        if not begun or len(head) < _UINT32.unpack_from(head, _DESCRIPTOR_SIZE_AT)[0]:
            return
        self._head.clear()
        container = gendc.Container.decode(head, self._most_bytes)
        self._parts = tuple(part for component in container.components for part in component.parts)
        waiting, self._waiting = self._waiting, []
        for packet_id, piece, late in waiting:
            yield from self._places(packet_id, piece, memoryview(late))

    def _places(self, packet_id: int, piece: GendcPosition, data: memoryview) -> Iterator[Placed]:
        """Give the places of data of another flow, which may belong to several parts."""
        assert self._parts is not None
        begin, end = piece.offset, piece.offset + len(data)
        known = False
        for part in self._parts:
            first, last = max(begin, part.flow_offset), min(end, part.flow_offset + part.data_size)
            if part.flow == piece.flow and first < last:
                known = True
                at = part.data_offset + first - part.flow_offset
                yield packet_id, at, data[first - begin : last - begin]
        if not known and len(data):
            raise RemoteProtocolError(f"GenDC data in flow {piece.flow}, which the descriptor does not name")
