"""One block (GVSP's word for what becomes a frame) from its first packet to the result that is delivered."""

from __future__ import annotations

import logging
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.driver.gige.gvsp import (
    CHUNK_BIT,
    POSITIONED,
    GendcPosition,
    Leader,
    PartPosition,
    PayloadKind,
    Trailer,
    kind_in,
)
from grabbergui.driver.gige.packet_header import EXTENDED, STANDARD, PacketFormat, PacketHeader
from grabbergui.driver.gige.stream.gendc_flows import Flows
from grabbergui.driver.gige.stream.id_runs import id_runs
from grabbergui.driver.gige.stream.packet_sorting import PacketRun
from grabbergui.driver.gige.stream.resend import PacketAccount

log = logging.getLogger(__name__)

SCATTERED = 4
"Mean length of runs of packets below which packets are copied by one indexed assignment, not run by run."
LEAST_STRIDE = 64
"Image bytes in a full packet, at least: a list of packets takes memory and time by their number."
SHORT_PACKET = 512
"Bytes of data in the smallest packets that cameras send, of 576 bytes."
MOST_PARTS = 1024
"Packets of a block that may be shorter: each part ends with one."
MOST_WARNINGS = 16
"Different faults of one stream that are logged."
TAIL = 8
"Packets requested behind the last that arrived, of a block whose end is unknown."
_ALL_IN_SIZES: dict[int, tuple[int, int]] = {
    PayloadKind.IMAGE: (36, 8),
    PayloadKind.RAW: (20, 4),
    PayloadKind.CHUNK: (12, 8),
    PayloadKind.EXTENDED_CHUNK: (36, 16),
    PayloadKind.JPEG: (32, 4),
    PayloadKind.JPEG2000: (32, 4),
}
"Bytes of leader and trailer in an all-in packet, without chunks."


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


@dataclass(frozen=True)
class Places:
    """Where a block's next packets belong if they arrive in order."""

    first: int
    "Id of the next packet; those from there on are missing."
    header_size: int
    "Bytes of a packet's header."
    lines: NDArray[np.uint8]
    "The data of all full packets, shape (packets, stride): of the packet with id 1 in the first line."

    @property
    def packet_length(self) -> int:
        """Bytes of a full packet."""
        return self.header_size + int(self.lines.shape[1])


class Block(PacketAccount):
    """The packets of one block. Packet ids: 0 is the leader, then payload packets, the trailer is last.

    `store` and `store_rows` copy packets into the buffer, the account counts them. When no more packets
    are expected, `close` and `extract_payload` set the result: `leader`, `payload`, `height`, `complete`,
    `missing_bytes`.
    """

    def __init__(
        self, header: PacketHeader, layout: BlockLayout, buffer: NDArray[np.uint8] | None, now: float
    ) -> None:
        """Begin the block of a packet. `buffer` is None if none was free: the block is then only counted."""
        super().__init__(header.block_id, header.extended, layout.max_payload_packets + 2, now)
        self.layout = layout
        self._stride = layout.stride
        "That of the packets stored so far."
        self.buffer = buffer
        self.leader: Leader | None = None
        "For an incomplete block this may be the leader of the previous block."
        self.trailer: Trailer | None = None
        self.trailer_id: int | None = None
        "Packet id of the trailer, once received."
        self.refused = False
        "True if the block is no image or exceeds the buffer: nothing is stored, no resend is requested."
        self.extent = 0
        "End of the data received, in bytes from the start of the payload."
        self.ended_short = False
        "Whether the packet at `extent` was shorter than a full one, so nothing follows it."
        self.clipped = 0
        "Packets with padding beyond the end of the payload."
        self.complete = False
        "Whether every byte arrived; set by `close`."
        self.payload: NDArray[np.uint8] = np.zeros(0, np.uint8)
        "In `buffer`: the whole payload; set by `extract_payload`."
        self.height = 0
        "Lines that the camera sent; set by `extract_payload`."
        self.missing_bytes = 0
        "Bytes of `payload` that did not arrive and are zero; set by `extract_payload`."
        self.timestamp = 0
        "Device ticks of an H.264 image, which its leader does not have."
        self._flows: Flows | None = None
        "Of a GenDC container."
        self._pieces: list[tuple[int, int, int]] = []
        "Packet id, begin and end of the data in packets that carry their position."
        self._unfilled: list[tuple[int, int]] = []
        "Begin and end of what a short packet, or the trailer, left of its place in the buffer as it was."

    def store(self, header: PacketHeader, body: memoryview) -> None:
        """Copy a packet's content to where it belongs. Raises RemoteProtocolError."""
        packet_id = header.packet_id
        if header.format == PacketFormat.PAYLOAD:
            self._check_length(packet_id, len(body))
            offset = self._offset_of(packet_id)
            self._place(offset, self._without_padding(offset, body))
            if len(body) < self.layout.stride:
                self.ended_short = True
                self._unfilled.append((offset + len(body), offset + self.layout.stride))
        elif packet_id != 0 and header.format in (PacketFormat.LEADER, PacketFormat.ALL_IN):
            raise RemoteProtocolError(f"a leader with packet_id {packet_id}, its id is 0")
        elif header.format == PacketFormat.LEADER:
            self._take_leader(body)
        elif header.format == PacketFormat.TRAILER:
            self._take_trailer(packet_id, body)
        elif header.format in (PacketFormat.MULTI_PART, PacketFormat.MULTI_ZONE):
            position = PartPosition.decode(body)
            self._place_piece(packet_id, self._offset_in_block(position), body[PartPosition.SIZE :])
        elif header.format == PacketFormat.GENDC:
            self._take_gendc(packet_id, body)
        elif header.format == PacketFormat.H264:
            # Packets may be short, so each has a slot of its own until all are joined.
            self.timestamp = int.from_bytes(body[:8], "big")
            self._place_piece(packet_id, self._offset_of(packet_id), body[8:])
        elif header.format == PacketFormat.ALL_IN:
            self._take_all_in(body)
        else:
            raise RemoteProtocolError(f"a packet of format {header.format}, which carries no image")

    def store_in_order(self, first: int, bodies: NDArray[np.uint8]) -> None:
        """Copy full payload packets that follow each other from the `first` id on. The last must fit."""
        self.note_placed(first + len(bodies))
        if self.buffer is not None and not self.refused:
            stride = bodies.shape[1]
            end = (first - 1 + len(bodies)) * stride
            self.buffer[:end].reshape(-1, stride)[first - 1 :] = bodies

    def next_places(self) -> Places | None:
        """Return where the next packets belong, as long as full packets of an image are expected."""
        packets, stride = self.payload_packets(), self.layout.stride
        if packets is None or self.buffer is None or self.trailer_id is not None or self.highest < 0:
            return None
        full = min(packets, self.layout.payload_size // stride)
        if self.highest >= full:
            return None
        size = (EXTENDED if self.extended else STANDARD).itemsize
        return Places(self.highest + 1, size, self.buffer[: full * stride].reshape(full, stride))

    def note_placed(self, end: int) -> None:
        """Note that full packets lie in their places, up to the id before `end`."""
        self.extent = max(self.extent, (end - 1) * self.layout.stride)

    def store_rows(self, run: PacketRun, rows: NDArray[np.uint8], at: NDArray[np.intp]) -> None:
        """Copy full payload packets, the i-th of the run from `rows[at[i]]`. The highest must fit."""
        if run.consecutive and at[-1] - at[0] == len(at) - 1:
            self.store_in_order(run.lowest, rows[at[0] : at[-1] + 1])
            return
        ids, stride = run.ids, rows.shape[1]
        end = run.highest * stride
        self.extent = max(self.extent, end)
        if self.buffer is None or self.refused:
            return
        lines = self.buffer[:end].reshape(-1, stride)
        breaks = ((ids[1:] - ids[:-1] != 1) | (at[1:] - at[:-1] != 1)).nonzero()[0]
        begins = [0, *(breaks + 1).tolist()]
        if SCATTERED * len(begins) > len(ids):
            lines[ids - 1] = rows[at]
            return
        for begin, stop in zip(begins, [*begins[1:], len(ids)], strict=True):
            line, row, count = int(ids[begin]) - 1, int(at[begin]), stop - begin
            lines[line : line + count] = rows[row : row + count]

    def _take_leader(self, body: memoryview) -> None:
        self.leader = leader = Leader.decode(body)
        if not leader.is_known:
            self._refuse(
                f"the camera sends {leader.kind_name} (payload type 0x{leader.payload_type:04X})",
                "no frame can be made of it; let the camera send images, by ComponentEnable, PayloadType or"
                " a plain PixelFormat",
            )
        elif max(leader.image_bytes, leader.payload_bytes or 0) > self.layout.payload_size:
            needed = max(leader.image_bytes, leader.payload_bytes or 0)
            size = f"{leader.width}x{leader.height}, pixel format 0x{leader.pixel_format:08X}"
            self._refuse(
                "the camera sends a frame that does not fit",
                f"payload type 0x{leader.payload_type:04X}, {size if leader.is_image else leader.kind_name},"
                f" {leader.payload_bytes or leader.image_bytes} bytes; PayloadSize is"
                f" {self.layout.payload_size} bytes: stop the stream and start it again; if that does not"
                f" help, the camera reports it wrongly: open it with payload_size={needed}",
            )

    def _refuse(self, fault: str, details: str) -> None:
        """Store and request nothing more of the block."""
        self.refused = True
        self.layout.refusal = f"{fault}: {details}"
        self.layout.warn_once(fault, details)

    def _take_trailer(self, packet_id: int, body: memoryview) -> None:
        trailer = Trailer.decode(body)
        if packet_id < max(self.highest, 1):
            raise RemoteProtocolError(f"trailer with packet_id {packet_id} after packet {self.highest}")
        self.trailer, self.trailer_id = trailer, packet_id
        offset = self._offset_of(packet_id)
        self._unfilled.append((offset, offset + self.layout.stride))

    def _take_gendc(self, packet_id: int, body: memoryview) -> None:
        piece = GendcPosition.decode(body)
        data = body[GendcPosition.FORMAT.size :][: piece.size]
        if self.refused:
            return
        if self._flows is None:
            self._flows = Flows(self.layout.payload_size)
        try:
            for known_id, offset, placed in self._flows.take(packet_id, piece, data):
                self._place_piece(known_id, offset, placed)
        except RemoteProtocolError as error:
            self._refuse("a GenDC container", str(error))

    def _offset_of(self, packet_id: int) -> int:
        """Return where the data of a packet without a position of its own belongs."""
        return (packet_id - 1) * self.layout.stride

    def _offset_in_block(self, position: PartPosition) -> int:
        parts = self.leader.parts if self.leader is not None else ()
        start = sum(part.length for part in parts[: position.part])
        if position.offset < start:
            self.layout.relative_parts = True
        return position.offset + (start if self.layout.relative_parts else 0)

    def _take_all_in(self, body: memoryview) -> None:
        payload_type = int.from_bytes(body[2:4], "big")
        sizes = _ALL_IN_SIZES.get(kind_in(payload_type))
        if sizes is None:
            raise RemoteProtocolError(f"an all-in packet of payload type 0x{payload_type:04X}")
        leader_size, trailer_size = sizes
        if payload_type & CHUNK_BIT:
            trailer_size += 8
        self._take_leader(body[:leader_size])
        self.trailer = Trailer.decode(body[leader_size : leader_size + trailer_size])
        self.trailer_id = 0
        self._place(0, self._without_padding(0, body[leader_size + trailer_size :]))

    def _check_length(self, packet_id: int, length: int) -> None:
        """Learn the stride from an image's first packet: it may differ from the register's value."""
        stride, leader = self.layout.stride, self.leader
        size = 0 if leader is None else max(leader.payload_bytes or 0, leader.image_bytes)
        if packet_id == 1 and LEAST_STRIDE <= length < size and length != stride:
            log.info("packets carry %d bytes instead of %d", length, stride)
            self.layout.stride = length
            if not self.extent:
                self._stride = length
        elif not 0 < length <= stride:
            raise RemoteProtocolError(f"a packet with {length} bytes of payload, {stride} are a full one")

    def _without_padding(self, offset: int, body: memoryview) -> memoryview:
        """Cut the padding that some cameras add to the last packet, beyond the end of the payload."""
        room = self.layout.payload_size - offset
        if not 0 < room < len(body):
            return body
        self.clipped += 1
        return body[:room]

    def _place(self, offset: int, data: memoryview) -> None:
        end = offset + len(data)
        if offset < 0 or end > self.layout.payload_size:
            raise RemoteProtocolError(f"data up to byte {end} of a payload of {self.layout.payload_size}")
        if self.buffer is not None and not self.refused:
            self.buffer[offset:end] = data
        self.extent = max(self.extent, end)

    def _place_piece(self, packet_id: int, offset: int, data: memoryview) -> None:
        data = self._without_padding(offset, data)
        self._place(offset, data)
        self._pieces.append((packet_id, offset, offset + len(data)))

    @property
    def only_leader(self) -> bool:
        """Whether only the leader was received: some devices send one when acquisition starts."""
        return self.received_count == 1 and self.leader is not None and self.trailer is None

    def payload_packets(self) -> int | None:
        """Return the number of the block's payload packets; None while unknown."""
        if self.trailer_id is not None:
            return self.trailer_id - 1
        leader = self.leader
        if leader is None or self.refused:  # a refused leader may announce any number
            return None
        if leader.kind in POSITIONED or leader.payload_bytes is None:
            return None
        return -(-leader.payload_bytes // self.layout.stride)

    def last_packet_id(self) -> int:
        """Return the trailer's packet id, or an upper bound until leader or trailer determine it."""
        if self.trailer_id is not None:
            return self.trailer_id
        packets, leader, stride = self.payload_packets(), self.leader, self.layout.stride
        if packets is None:
            packets = self.layout.max_payload_packets
            if leader is not None and leader.payload_bytes:
                # Each packet has a header of its own, and a part begins with a packet.
                length = min(leader.payload_bytes, self.layout.payload_size)
                packets = -(-length // max(stride - GendcPosition.FORMAT.size, 1)) + len(leader.parts)
            elif leader is not None and not leader.is_image:
                # Data of any length, such as chunks or a compressed image: look a little beyond what arrived.
                packets = min(packets, max(self.highest + TAIL, -(-leader.size // stride)))
        return packets + 1

    def all_received(self) -> bool:
        """Return whether the block is complete; a trailer without information of its own may be missing."""
        if self.leader is None or self.refused:
            return False
        if self.trailer_id is not None:
            return self.received_count == self.trailer_id + 1 > self.highest
        packets = self.payload_packets()
        return packets is not None and self.received_count == packets + 1 and self.highest == packets

    def _ends_without_trailer(self) -> bool:
        """Return whether a short last packet shows where chunks end, as a lost trailer would have."""
        leader = self.leader
        return (
            leader is not None
            and not self.refused
            and self.trailer_id is None
            and leader.payload_bytes is None
            and leader.kind not in POSITIONED
            and self.ended_short
            and self.extent >= leader.image_bytes
            and self.received_count == self.highest + 1
        )

    def close(self) -> None:
        """Decide whether the block is complete; no packet is stored afterwards."""
        if self._stride != self.layout.stride:  # packets are in wrong places
            self.refused = True
        foreign = bool(self._pieces) and self.leader is not None and self.leader.kind not in POSITIONED
        self.complete = not foreign and (self.all_received() or self._ends_without_trailer())

    def extract_payload(self, leader: Leader) -> None:
        """Make `payload` of a closed block that has a buffer; `leader` is its own, or if lost a similar one.

        What did not arrive is zero, so that no earlier image shows through.
        """
        assert self.buffer is not None
        if leader.kind == PayloadKind.H264:
            self._join_pieces()
        end = self._payload_end(leader, len(self.buffer))
        self.height = leader.height
        lines = self.trailer.height if self.trailer is not None else 0
        if not leader.height and leader.is_image:
            self.height = lines or end // max(leader.line_bytes, 1)
        elif self.complete and 0 < lines < leader.height:
            self.height = lines
        if not self.complete:
            end = min(max(end, leader.image_bytes, leader.payload_bytes or 0), len(self.buffer))
            if leader.kind in POSITIONED or self._pieces:
                self.missing_bytes = self._blank_gaps(self.buffer[:end])
            else:
                self.missing_bytes = self._blank_missing(self.buffer[:end])
        elif leader.kind not in POSITIONED:
            _blank(self.buffer[:end], self._unfilled)
        self.leader, self.payload = leader, self.buffer[:end]

    def _payload_end(self, leader: Leader, size: int) -> int:
        """Return where in the buffer the payload ends."""
        if self.trailer is not None and self.trailer.payload_bytes and not leader.parts:
            return min(self.trailer.payload_bytes, self.extent if self.complete else size)
        if leader.payload_bytes and not leader.is_image and self.complete:
            return min(leader.payload_bytes, self.extent)  # a last packet may be padded
        return self.extent

    def _join_pieces(self) -> None:
        """Move the data of packets, each in its slot, together."""
        assert self.buffer is not None
        end = 0
        pieces = sorted(self._pieces)
        self._pieces = []
        for packet_id, first, last in pieces:
            self.buffer[end : end + last - first] = self.buffer[first:last].copy()
            self._pieces.append((packet_id, end, end + last - first))
            end += last - first
        self.extent = end

    def _blank_gaps(self, payload: NDArray[np.uint8]) -> int:
        """Zero the gaps between packets with positions; return their number of bytes."""
        at = blanked = 0
        for first, last in sorted((first, last) for _, first, last in self._pieces):
            if first > at:
                payload[at:first] = 0
                blanked += first - at
            at = max(at, last)
        payload[at:] = 0
        return blanked + max(len(payload) - at, 0)

    def _blank_missing(self, payload: NDArray[np.uint8]) -> int:
        """Zero the missing packets; return their number of bytes."""
        stride = self.layout.stride
        ids = self.missing(-(-len(payload) // stride))
        runs = id_runs(ids[ids > 0])  # 0 is the leader
        missing = [((first - 1) * stride, last * stride) for first, last in runs]
        return _blank(payload, missing + self._unfilled)


def _blank(payload: NDArray[np.uint8], places: Iterable[tuple[int, int]]) -> int:
    """Zero what lies between each begin and end; return the number of bytes."""
    blanked = 0
    for begin, end in places:
        place = payload[begin:end]
        place[:] = 0
        blanked += len(place)
    return blanked
