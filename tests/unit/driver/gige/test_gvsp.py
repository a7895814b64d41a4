"""The stream protocol's codec against captured packets, both ways."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from every_case import every_case
from gige_transcripts import NAMES, lines
from grabbergui.core.errors import RemoteProtocolError
from grabbergui.driver.gige.gvcp import Status
from grabbergui.driver.gige.gvsp import (
    GendcPosition,
    Leader,
    PartPosition,
    PartType,
    PayloadKind,
    PayloadPart,
    Trailer,
    payload_stride,
)
from grabbergui.driver.gige.packet_header import EXTENDED, STANDARD, PacketFormat, PacketHeader, offset_of

STREAMS = [name for name in NAMES if any(lines(name, "D"))]


@every_case("name", STREAMS)
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


def test_payload_packets_and_images_have_these_sizes() -> None:
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


# Every number has its highest bit set, so that none is written or read as signed.
GEOMETRY = (0x80000001, 0x80000002, 0x80000003, 0x80000004, 0x8005, 0x8006)
GEOMETRY_BYTES = "80000001 80000002 80000003 80000004 8005 8006"
TIME = 1 << 63 | 7
TIME_BYTES = "8000000000000007"
IMAGE = PayloadPart(PartType.IMAGE_2D, 1 << 47, 0x81080001, GEOMETRY, source=1, purpose=0x8002, region=0x8003)
DEPTH = PayloadPart(PartType.CONFIDENCE, 5, 0x01080001, (1, 2, 3, 4, 5, 6))
DEPTH_BYTES = (
    "0009 000000000005 01080001 0000 00 00 00000000 0000 0000 00000001 00000002 00000003 00000004 0005 0006"
)

HEADERS = [
    (PacketHeader(PacketFormat.PAYLOAD, 0x8001, 0x800002, 0x8003), "8003 8001 03 800002"),
    (
        PacketHeader(PacketFormat.MULTI_PART, TIME, 0x80000002, 0x8003, True, 0x8004, 0x85),
        f"8003 8004 87 0000 85 {TIME_BYTES} 80000002",
    ),
]
LEADERS = [
    (
        Leader(PayloadKind.IMAGE, TIME, 0x81080001, *GEOMETRY),
        f"0000 0001 {TIME_BYTES} 81080001 {GEOMETRY_BYTES}",
    ),
    (
        Leader(PayloadKind.EXTENDED_CHUNK, TIME, 0x81080001, *GEOMETRY),
        f"0000 0005 {TIME_BYTES} 81080001 {GEOMETRY_BYTES}",
    ),
    (
        Leader(PayloadKind.MULTI_ZONE, TIME, 0x81080001, *GEOMETRY),
        f"0000 0009 {TIME_BYTES} 00000000 81080001 {GEOMETRY_BYTES}",
    ),
    (Leader(PayloadKind.RAW, TIME, size=1 << 63), f"0000 0002 {TIME_BYTES} 8000000000000000"),
    (
        Leader(PayloadKind.FILE, TIME, size=5, file_name="ä.txt"),
        f"0000 0003 {TIME_BYTES} 0000000000000005 c3a42e74787400",
    ),
    (Leader(PayloadKind.CHUNK, TIME), f"0000 0004 {TIME_BYTES}"),
    (Leader(PayloadKind.JPEG, TIME, size=1 << 63), f"0000 0006 {TIME_BYTES} 8000000000000000 {'00' * 12}"),
    (Leader(PayloadKind.JPEG2000, TIME, size=5), f"0000 0007 {TIME_BYTES} 0000000000000005 {'00' * 12}"),
    (Leader(PayloadKind.H264, size=1 << 63), f"0000 0008 8000000000000000 {'00' * 20}"),
    (
        Leader(PayloadKind.MULTI_PART, TIME, 0x81080001, *GEOMETRY, parts=(DEPTH, IMAGE)),
        f"0000 000a {TIME_BYTES} {DEPTH_BYTES} 00000000"
        f"0001 800000000000 81080001 0000 01 00 00000000 8002 8003 {GEOMETRY_BYTES} 00000000",
    ),
    (
        Leader(PayloadKind.MULTI_PART, TIME, parts=(DEPTH,)),
        f"0000 000a {TIME_BYTES} {DEPTH_BYTES} 00000000",
    ),
    (Leader(PayloadKind.GENDC, TIME, size=1 << 63), f"0000 000b {TIME_BYTES} 8000000000000000 {'00' * 8}"),
]
TRAILERS = [
    (Trailer(PayloadKind.IMAGE, 0x80000001), "0000 0001 80000001"),
    (Trailer(0x4001, 0x80000001, 0x80000002), "0000 4001 80000001 80000002 00000000"),
    (Trailer(PayloadKind.MULTI_ZONE, 0x80000001), "0000 0009 80000001"),
    (Trailer(PayloadKind.CHUNK, 0, 0x80000002), "0000 0004 80000002"),
    (Trailer(PayloadKind.EXTENDED_CHUNK, 0x80000001, 0x80000002), "0000 0005 80000002 80000001 00000000"),
    (Trailer(PayloadKind.RAW), "0000 0002"),
    (Trailer(PayloadKind.MULTI_PART), "0000 000a"),
]


@pytest.mark.parametrize(("header", "digits"), HEADERS)
def test_the_bytes_of_a_header(header: PacketHeader, digits: str) -> None:
    datagram = bytes.fromhex(digits)
    assert header.encode() == datagram and header.size == len(datagram)
    assert PacketHeader.decode(datagram) == PacketHeader.decode(datagram + b"body") == header
    for length in range(len(datagram)):
        need = 8 if length < 8 else 20
        with pytest.raises(RemoteProtocolError, match=f"of {length} bytes, need {need}"):
            PacketHeader.decode(datagram[:length])


def test_the_fields_of_a_header_begin_where_the_standard_puts_them() -> None:
    standard = {"status": 0, "block_id": 2, "format_and_packet_id": 4}
    extended = {"status": 0, "flags": 2, "format_and_parts": 4, "block_id": 8, "packet_id": 16}
    for layout, fields, size in ((STANDARD, standard, 8), (EXTENDED, extended, 20)):
        assert {name: offset_of(layout, name) for name in layout.names or ()} == fields
        assert layout.itemsize == size


def test_a_header_says_whether_its_packet_failed_or_was_sent_again() -> None:
    for status, flags, failed, again in (
        (0, 0, False, False),
        (Status.PACKET_RESEND, 0, False, True),
        (0, 1, False, True),
        (0, 2, False, False),
        (Status.PACKET_UNAVAILABLE, 0, True, False),
    ):
        header = PacketHeader(PacketFormat.PAYLOAD, 1, 1, status, True, flags)
        assert (header.failed, header.sent_again) == (failed, again)


@every_case(("leader", "digits"), LEADERS)
def test_the_bytes_of_a_leader(leader: Leader, digits: str) -> None:
    body = bytes.fromhex(digits)
    assert leader.encode() == body
    assert Leader.decode(body) == leader == Leader.decode(memoryview(body))
    with_chunks = body[:2] + bytes((body[2] | 0x40, body[3])) + body[4:]
    if leader.kind != PayloadKind.H264:
        assert Leader.decode(with_chunks) == replace(leader, payload_type=leader.payload_type | 0x4000)


@every_case(("leader", "digits"), LEADERS)
def test_a_leader_that_is_cut_off_is_refused(leader: Leader, digits: str) -> None:
    body = bytes.fromhex(digits)
    # What follows these bytes is optional, or not read.
    needed: dict[int, int] = {PayloadKind.H264: 12, PayloadKind.CHUNK: 12, PayloadKind.MULTI_PART: 12}
    needed |= {PayloadKind.IMAGE: 36, PayloadKind.EXTENDED_CHUNK: 36, PayloadKind.MULTI_ZONE: 40}
    for length in range(needed.get(leader.kind, 20)):
        with pytest.raises(RemoteProtocolError, match=f"leader of {length} bytes"):
            Leader.decode(body[:length])
    assert Leader.decode(body[: needed.get(leader.kind, 20)]).payload_type == leader.payload_type


def test_a_refused_leader_says_what_it_lacks() -> None:
    for digits, reason in (
        (f"0000 0001 {TIME_BYTES}", "image leader of 12 bytes, need 36"),
        (f"0000 0009 {TIME_BYTES}", "image leader of 12 bytes, need 40"),
        (f"0000 0003 {TIME_BYTES}", "leader of 12 bytes for a file, need 20"),
        ("0000 0008", "leader of 4 bytes for H.264 video, need 12"),
        ("0000 0001", "leader of 4 bytes, need 12"),
    ):
        with pytest.raises(RemoteProtocolError, match=reason):
            Leader.decode(bytes.fromhex(digits))


def test_leaders_of_other_payload_types() -> None:
    zones = bytes.fromhex(f"0000 0009 {TIME_BYTES} 80000000 81080001 {GEOMETRY_BYTES}")
    assert Leader.decode(zones) == Leader(PayloadKind.MULTI_ZONE, TIME, 0x81080001, *GEOMETRY)
    vendors = bytes.fromhex(f"0000 8001 {TIME_BYTES} 81080001 {GEOMETRY_BYTES}")
    assert Leader.decode(vendors) == Leader(0x8001, TIME), "of unknown kinds only the time is read"
    assert Leader(0x8001, TIME, 0x81080001, *GEOMETRY).encode() == vendors
    unnamed = bytes.fromhex(f"0000 0003 {TIME_BYTES} 0000000000000005 ff2e00 78")
    assert Leader.decode(unnamed).file_name == "\xff.", "Latin-1, as other texts of cameras"
    compressed = bytes.fromhex(f"0000 0006 {TIME_BYTES} 0000000000000005 {b'tick rate'.hex()} 000000")
    assert Leader.decode(compressed) == Leader(PayloadKind.JPEG, TIME, size=5)


def test_what_a_leader_says_of_its_block() -> None:
    for leader, image, chunks, known, payload in (
        (Leader(1, 0, 0x01080001, 8, 4), True, False, True, 32),
        (Leader(1, 0, 0x01080001, 8), True, False, True, None),
        (Leader(0x4001, 0, 0x01080001, 8, 4), True, True, True, None),
        (Leader(PayloadKind.CHUNK), False, True, True, None),
        (Leader(PayloadKind.EXTENDED_CHUNK, 0, 0x01080001, 8, 4), True, True, True, None),
        (Leader(PayloadKind.RAW, size=5), False, False, True, 5),
        (Leader(PayloadKind.RAW), False, False, True, None),
        (Leader(PayloadKind.MULTI_PART), False, False, False, None),
        (Leader(PayloadKind.MULTI_PART, parts=(DEPTH, IMAGE)), False, False, True, (1 << 47) + 5),
        (Leader(0x8001), False, False, False, None),
    ):
        assert (leader.is_image, leader.has_chunks, leader.is_known) == (image, chunks, known)
        assert leader.payload_bytes == payload


def test_each_kind_of_block_has_a_name() -> None:
    names = [Leader(kind).kind_name for kind in PayloadKind]
    assert len(set(names)) == len(PayloadKind) and Leader(0x4006).kind_name == "JPEG images"
    assert Leader(0x8001).kind_name == "an unknown kind of data"


@pytest.mark.parametrize(("trailer", "digits"), TRAILERS)
def test_the_bytes_of_a_trailer(trailer: Trailer, digits: str) -> None:
    body = bytes.fromhex(digits)
    assert trailer.encode() == body
    assert Trailer.decode(body) == trailer == Trailer.decode(memoryview(body + b"abc"))
    for length in range(4):
        with pytest.raises(RemoteProtocolError, match=f"trailer of {length} bytes, need 4"):
            Trailer.decode(body[:length])
    # Some cameras end it early.
    assert Trailer.decode(body[:4]) == Trailer(trailer.payload_type)


def test_a_trailer_of_part_of_its_words() -> None:
    assert Trailer(PayloadKind.CHUNK).encode() == bytes.fromhex("0000 0004 00000000")
    assert Trailer(PayloadKind.EXTENDED_CHUNK).encode() == bytes.fromhex("0000 0005") + bytes(12)
    assert Trailer.decode(bytes.fromhex("0000 4001 00000007")) == Trailer(0x4001, 7)
    assert Trailer.decode(bytes.fromhex("0000 4001 00000007 00000008")) == Trailer(0x4001, 7, 8)
    assert Trailer.decode(bytes.fromhex("0000 0005 00000008 00000007")) == Trailer(
        PayloadKind.EXTENDED_CHUNK, 7, 8
    )
    assert Trailer.decode(bytes.fromhex("0000 0001 00000007 00000008")) == Trailer(1, 7), "without chunks"
    assert Trailer.decode(bytes.fromhex("0000 0005 00000007")) == Trailer(PayloadKind.EXTENDED_CHUNK)


def test_the_bytes_of_positions() -> None:
    for position, digits in (
        (PartPosition(0x85, 1 << 47, True), "85 40 800000000000"),
        (PartPosition(1, 5), "01 00 000000000005"),
    ):
        assert position.encode() == bytes.fromhex(digits)
        assert PartPosition.decode(bytes.fromhex(digits) + b"data") == position
    assert not PartPosition.decode(bytes.fromhex("01 bf 000000000005")).last, "other bits are the zone's"
    container = bytes.fromhex("00000004 8000000000000002 83 84 8005")
    in_flow = GendcPosition(4, 1 << 63 | 2, 0x83, 0x84, 0x8005)
    assert in_flow.encode() == container
    assert GendcPosition.decode(container + b"data") == in_flow
    assert GendcPosition.decode(GendcPosition(0, 8).encode()) == GendcPosition(0, 8)
    with pytest.raises(RemoteProtocolError, match=r"announces 4 bytes, has 3$"):
        GendcPosition.decode(container + b"dat")
    for length in range(16):
        with pytest.raises(RemoteProtocolError, match=f"of {length} bytes, need 16"):
            GendcPosition.decode(container[:length])
        if length < 8:
            with pytest.raises(RemoteProtocolError, match=f"of {length} bytes, need 8"):
                PartPosition.decode(container[:length])


@given(st.binary(max_size=300))
def test_no_packet_crashes_a_parser(data: bytes) -> None:
    for parse in (
        PacketHeader.decode,
        Leader.decode,
        Trailer.decode,
        PartPosition.decode,
        GendcPosition.decode,
    ):
        try:
            parse(data)
        except RemoteProtocolError as error:
            assert str(error)
