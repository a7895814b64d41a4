"""The stream protocol's codec against captured packets, both ways."""

from __future__ import annotations

import pytest
from gige_transcripts import NAMES, lines
from hypothesis import given
from hypothesis import strategies as st

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.driver.gige.gvsp import (
    Leader,
    PacketFormat,
    PacketHeader,
    PartPosition,
    PayloadKind,
    Trailer,
    payload_stride,
)

STREAMS = [name for name in NAMES if any(lines(name, "D"))]


@pytest.mark.parametrize("name", STREAMS)
def test_captured_packets_are_read_and_written_byte_by_byte(name: str) -> None:
    for line in lines(name, "D"):
        header = PacketHeader.decode(line.data)
        body = line.data[header.size :]
        if not header.extended:  # crafted extended headers carry part counts where we write zeros
            assert header.encode() == line.data[: header.size]
        if header.block_id == 0 or header.failed:
            continue
        if header.format == PacketFormat.LEADER:
            leader = Leader.decode(body)
            assert (
                leader.width == 64 or leader.kind == PayloadKind.CHUNK or name == "viva-on-aravis-stream-576"
            )
            if leader.kind == PayloadKind.IMAGE:
                assert leader.encode() == body
        elif header.format == PacketFormat.TRAILER:
            trailer = Trailer.decode(body)
            if trailer.payload_type == PayloadKind.IMAGE:
                assert trailer.encode() == body
        else:
            assert header.format in (PacketFormat.PAYLOAD, PacketFormat.MULTI_PART)


def test_a_multi_part_leader_names_its_parts() -> None:
    first, second = list(lines("accept-multipart", "D"))[:2]
    header = PacketHeader.decode(first.data)
    leader = Leader.decode(first.data[header.size :])
    assert header.parts == 2 and [part.pixel_format for part in leader.parts] == [0x01080001, 0x01080001]
    assert leader.encode() == first.data[header.size :]
    assert leader.payload_bytes == sum(part.length for part in leader.parts)
    position = PartPosition.decode(second.data[header.size :])
    assert (position.part, position.offset, position.last) == (0, 0, False)
    assert position.encode() == second.data[header.size :][:8]


@pytest.mark.parametrize("name", ["aravis-stream-576", "accept-extended-ids", "accept-multipart"])
def test_truncated_packets_are_refused_or_smaller(name: str) -> None:
    for line in lines(name, "D"):
        for length in range(len(line.data)):
            try:
                header = PacketHeader.decode(line.data[:length])
                body = line.data[header.size : length]
                if header.format == PacketFormat.LEADER:
                    Leader.decode(body)
                elif header.format == PacketFormat.TRAILER:
                    Trailer.decode(body)
            except RemoteProtocolError:
                continue
            assert length >= header.size


def test_sizes() -> None:
    assert payload_stride(1500) == 1464 and payload_stride(1500, extended=True) == 1452
    packed = Leader(1, 0, 0x010C0006, 65, 3)
    assert packed.image_bytes == (65 * 3 * 12 + 7) // 8
    padded = Leader(1, 0, 0x01080001, 65, 3, padding_x=3, padding_y=10)
    assert padded.image_bytes == 68 * 3 + 10
    padded_and_packed = Leader(1, 0, 0x010C0006, 65, 3, padding_x=2)
    assert padded_and_packed.image_bytes == (98 + 2) * 3  # a line of 97.5 bytes begins its padding at a byte
    assert Leader(0x4001, 0, 0x01080001, 8, 8).payload_bytes is None


def test_the_bytes_of_a_leader_with_padding() -> None:
    padded = Leader(1, 5, 0x01080001, 640, 480, offset_x=16, offset_y=8, padding_x=3, padding_y=10)
    body = bytes.fromhex("0000 0001 0000000000000005 01080001 00000280 000001e0 00000010 00000008 0003 000a")
    assert padded.encode() == body
    assert Leader.decode(body) == padded
    assert Leader.decode(body).payload_bytes == 643 * 480 + 10


@given(st.binary(max_size=300))
def test_no_packet_crashes_a_parser(data: bytes) -> None:
    for parse in (PacketHeader.decode, Leader.decode, Trailer.decode, PartPosition.decode):
        try:
            parse(data)
        except RemoteProtocolError as error:
            assert str(error)
