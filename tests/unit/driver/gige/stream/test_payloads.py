"""Blocks of every kind of payload, from their packets to the frames that are made of them."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
import pytest

from block_bench import Bench
from grabbergui.core.component import ComponentKind, PayloadType
from grabbergui.core.frame import FrameStatus
from grabbergui.driver import gendc
from grabbergui.driver.gige.gvsp import (
    GendcPosition,
    Leader,
    PartPosition,
    PartType,
    PayloadKind,
    PayloadPart,
    Trailer,
)
from grabbergui.driver.gige.packet_header import PacketFormat, PacketHeader
from grabbergui.driver.gige.stream.assembler import BlockAssembler
from grabbergui.driver.gige.stream.block import Block
from grabbergui.driver.gige.stream.frame_builder import FrameBuilder

MONO8, MONO16, CONFIDENCE8 = 0x01080001, 0x01100007, 0x010800C6
"Codes of the Pixel Format Naming Convention."


def packet(kind: PacketFormat, packet_id: int, body: bytes, block_id: int = 1) -> bytes:
    return PacketHeader(kind, block_id, packet_id).encode() + body


def packets(leader: Leader, data: bytes, trailer: Trailer, *, stride: int = 100) -> list[bytes]:
    """Return the datagrams of a block whose payload packets have no header of their own."""
    pieces = [data[at : at + stride] for at in range(0, len(data), stride)]
    return [
        packet(PacketFormat.LEADER, 0, leader.encode()),
        *(packet(PacketFormat.PAYLOAD, index, piece) for index, piece in enumerate(pieces, 1)),
        packet(PacketFormat.TRAILER, len(pieces) + 1, trailer.encode()),
    ]


def only_block(datagrams: Sequence[bytes], size: int, **options: object) -> Block:
    """Return the one block that some datagrams make, at once or when nothing more arrives."""
    bench = Bench(payload_size=size, stride=100, **options)
    (block,) = bench.feed(datagrams) + bench.wait(2.0)
    return block


def test_a_frame_has_the_leaders_geometry_and_the_streams_byte_order() -> None:
    leader = Leader(1, 2_500, MONO16, 6, 4, offset_x=32, offset_y=16, padding_x=4)
    lines = np.arange(0x0102, 0x0102 + 24, dtype=np.uint16).reshape(4, 6)
    data = b"".join(line.astype(">u2").tobytes() + bytes(4) for line in lines)
    bench = Bench(payload_size=200, stride=100)
    (block,) = bench.feed(packets(leader, data, Trailer(1, 4)))
    frame = FrameBuilder(1_000, big_endian=True, channel=3).build(block)
    assert (frame.width, frame.height, frame.offset_x, frame.offset_y) == (6, 4, 32, 16)
    assert (frame.pixel_format.name, frame.padding_x, frame.big_endian) == ("Mono16", 4, True)
    assert (frame.frame_id, frame.stream_channel, frame.timestamp_ns) == (1, 3, 2_500_000_000)
    assert (frame.status, frame.missing_bytes) == (FrameStatus.COMPLETE, 0)
    assert frame.captured == pytest.approx(100_000.0, abs=1e-6), "when its first packet arrived"
    assert np.array_equal(frame.raw(), lines)


@pytest.mark.parametrize(("lost", "begin", "end"), [(1, 0, 100), (2, 100, 200), (3, 200, 250)])
def test_an_incomplete_frame_says_so(lost: int, begin: int, end: int) -> None:
    leader, data = Leader(1, 5, MONO8, 25, 10), bytes(range(1, 251))
    datagrams = packets(leader, data, Trailer(1, 10))
    del datagrams[lost]
    frame = FrameBuilder(0).build(only_block(datagrams, 250, deliver_incomplete=True, enabled=False))
    assert (frame.status, frame.missing_bytes) == (FrameStatus.INCOMPLETE, end - begin)
    assert frame.timestamp_ns == 0, "the camera has no clock"
    assert frame.payload.tobytes() == data[:begin] + bytes(end - begin) + data[end:]


@pytest.mark.parametrize(
    ("kind", "payload_type", "name"),
    [
        (PayloadKind.RAW, PayloadType.RAW_DATA, ""),
        (PayloadKind.FILE, PayloadType.FILE, "spectrum.csv"),
        (PayloadKind.CHUNK, PayloadType.CHUNK, ""),
    ],
)
def test_a_payload_without_an_image(kind: PayloadKind, payload_type: PayloadType, name: str) -> None:
    data = bytes(range(150))
    leader = Leader(kind, 5, size=0 if kind is PayloadKind.CHUNK else 150, file_name=name)
    trailer = Trailer(kind, payload_bytes=150 if kind is PayloadKind.CHUNK else None)
    frame = FrameBuilder(0).build(only_block(packets(leader, data, trailer), 400))
    assert frame.payload_type is payload_type and frame.payload.tobytes() == data
    assert (frame.width, frame.height, frame.file_name, frame.components) == (0, 0, name, ())
    assert (frame.chunk_payload is not None) is (kind is PayloadKind.CHUNK)


@pytest.mark.parametrize("kind", [PayloadKind.JPEG, PayloadKind.JPEG2000])
def test_a_compressed_image(kind: PayloadKind) -> None:
    pixels = np.arange(64 * 48, dtype=np.uint8).reshape(48, 64)
    written, coded = cv2.imencode(".jpg" if kind is PayloadKind.JPEG else ".jp2", pixels)
    assert written
    data = coded.tobytes()
    leader = Leader(kind, 5, size=len(data))
    frame = FrameBuilder(0).build(only_block(packets(leader, data, Trailer(kind)), len(data) + 50))
    assert frame.payload_type is PayloadType[kind.name]
    assert (frame.width, frame.height) == (64, 48)
    assert np.array_equal(frame.raw(), cv2.imdecode(coded, cv2.IMREAD_UNCHANGED))


def test_an_all_in_packet_with_chunks_has_a_longer_trailer() -> None:
    """GigE Vision 2.0: with chunks the trailer of an image also has the payload's length and a layout id."""
    data = bytes(range(64)) + b"chunk" + bytes(3)
    leader, trailer = Leader(0x4001, 5, MONO8, 8, 8), Trailer(0x4001, 8, len(data))
    body = leader.encode() + trailer.encode() + data
    block = only_block([packet(PacketFormat.ALL_IN, 0, body)], 200)
    assert block.complete and block.payload.tobytes() == data
    assert block.trailer == trailer and FrameBuilder(0).build(block).height == 8


def test_an_all_in_packet_of_another_kind_is_dropped() -> None:
    bench = Bench(payload_size=200, stride=100)
    for payload_type in (0x0009, 0x8001, 0x0101):
        body = Leader(payload_type, 5, MONO8, 8, 8).encode() + bytes(100)
        assert bench.feed([packet(PacketFormat.ALL_IN, 0, body)]) == []
    assert bench.statistics.packets_ignored == 3
    raw = Leader(PayloadKind.RAW, 5, size=64).encode() + Trailer(PayloadKind.RAW).encode() + bytes(range(64))
    (block,) = bench.feed([packet(PacketFormat.ALL_IN, 0, raw, block_id=2)]) + bench.wait(2.0)
    assert block.payload.tobytes() == bytes(range(64))


def part(data_type: PartType, length: int, code: int = 0, *numbers: int, purpose: int = 1) -> PayloadPart:
    return PayloadPart(data_type, length, code, (*numbers, *(0,) * (6 - len(numbers))), 2, purpose, 3)


def test_each_part_of_a_block_becomes_a_component_of_its_kind() -> None:
    written, coded = cv2.imencode(".jpg", np.full((8, 16), 90, np.uint8))
    assert written
    contents = [bytes(range(1, 41)), bytes(range(60)), b"\xff" * 12, bytes(8), bytes(4), coded.tobytes()]
    parts = (
        part(PartType.IMAGE_2D, 40, MONO16, 2, 5, 6, 8, 4),
        part(PartType.CONFIDENCE, 60, MONO8, 10, 6),
        part(PartType.CHUNK, 12),
        part(PartType.IMAGE_2D, 8, MONO8, 8),
        part(PartType.IMAGE_3D, 4, MONO16, 2, 1, purpose=4),
        part(PartType.JPEG, len(contents[5])),
    )
    leader = Leader(PayloadKind.MULTI_PART, 5, MONO16, 2, 5, parts=parts)
    datagrams = [packet(PacketFormat.LEADER, 0, leader.encode())]
    begin = 0
    for index, data in enumerate(contents):
        for at in range(0, len(data), 92):
            body = PartPosition(index, begin + at).encode() + data[at : at + 92]
            datagrams.append(packet(PacketFormat.MULTI_PART, len(datagrams), body))
        begin += len(data)
    trailer = Trailer(PayloadKind.MULTI_PART).encode()
    datagrams.append(packet(PacketFormat.TRAILER, len(datagrams), trailer))
    frame = FrameBuilder(0, big_endian=True).build(only_block(datagrams, begin))
    assert frame.payload_type is PayloadType.MULTI_PART
    assert frame.chunk_payload is not None and frame.chunk_payload.tobytes() == contents[2]
    image, confidence, distance, jpeg = frame.components
    assert [each.data.tobytes() for each in frame.components] == [contents[at] for at in (0, 1, 4, 5)]
    assert distance.kind is ComponentKind.RANGE, "its purpose says so (SFNC: ComponentIDValue)"
    assert (image.width, image.height, image.offset_x, image.offset_y, image.padding_x) == (2, 5, 6, 8, 4)
    assert (image.kind, image.pixel_format.name, image.big_endian) == (
        ComponentKind.INTENSITY,
        "Mono16",
        True,
    )
    assert image.raw()[0].tolist() == [0x0102, 0x0304]
    assert (confidence.kind, confidence.width, confidence.height) == (ComponentKind.CONFIDENCE, 10, 6)
    assert (jpeg.width, jpeg.height) == (16, 8)
    for component in frame.components:
        assert (component.source, component.region) == (2, 3)
        assert component.purpose == (4 if component is distance else 1)


def test_parts_of_a_block_whose_leader_is_lost_lie_at_their_own_positions() -> None:
    parts = tuple(part(PartType.IMAGE_2D, 50, MONO8, 10, 5) for _ in range(2))
    leader = Leader(PayloadKind.MULTI_PART, 5, MONO8, 10, 5, parts=parts)
    bench = Bench(payload_size=100, stride=100, enabled=False, deliver_incomplete=True)
    blocks: list[Block] = []
    for block_id in (1, 2):
        bodies = [
            PartPosition(index, 50 * index).encode() + bytes([block_id + index]) * 50 for index in (0, 1)
        ]
        datagrams = [
            packet(PacketFormat.LEADER, 0, leader.encode(), block_id),
            *(packet(PacketFormat.MULTI_PART, index, body, block_id) for index, body in enumerate(bodies, 1)),
            packet(PacketFormat.TRAILER, 3, Trailer(PayloadKind.MULTI_PART).encode(), block_id),
        ]
        blocks += bench.feed(datagrams[block_id - 1 :])
    blocks += bench.wait(2.0)
    assert [block.complete for block in blocks] == [True, False]
    assert [block.payload.tobytes() for block in blocks] == [
        b"\1" * 50 + b"\2" * 50,
        b"\2" * 50 + b"\3" * 50,
    ]


@pytest.mark.parametrize(("lost", "missing"), [((2,), 80), ((2, 4), 150), ((1, 5), 150), ((5,), 70)], ids=str)
def test_gaps_between_parts_are_zero_and_counted(lost: tuple[int, ...], missing: int) -> None:
    sizes = (80, 80, 70, 70, 70)
    starts = [sum(sizes[:index]) for index in range(5)]
    parts = tuple(part(PartType.IMAGE_2D, size, MONO8, size, 1) for size in sizes)
    leader = Leader(PayloadKind.MULTI_PART, 5, MONO8, 80, 1, parts=parts)
    datagrams = [packet(PacketFormat.LEADER, 0, leader.encode())]
    for packet_id, (size, start) in enumerate(zip(sizes, starts, strict=True), 1):
        body = PartPosition(packet_id - 1, start).encode() + bytes([packet_id]) * size
        datagrams.append(packet(PacketFormat.MULTI_PART, packet_id, body))
    datagrams.append(packet(PacketFormat.TRAILER, 6, Trailer(PayloadKind.MULTI_PART).encode()))
    received = [datagram for index, datagram in enumerate(datagrams) if index not in lost]
    block = only_block(received, sum(sizes), enabled=False, deliver_incomplete=True)
    expected = b"".join(bytes([0 if index in lost else index]) * sizes[index - 1] for index in range(1, 6))
    assert (block.payload.tobytes(), block.missing_bytes) == (expected, missing)


def test_a_container_of_an_unknown_version_is_refused_and_asks_for_no_resends(
    caplog: pytest.LogCaptureFixture,
) -> None:
    container = bytearray(gendc.Container((), 1, 400, 56, 56, (2, 0, 0)).encode().ljust(456, b"\0"))
    memory = np.zeros(1000, np.uint8)
    assembler = BlockAssembler(200, len(memory), lambda: memory)
    for block_id in (1, 2, 3):
        leader = Leader(PayloadKind.GENDC, 5, size=len(container)).encode()
        pieces = [bytes(container[at : at + 184]) for at in range(0, len(container), 184)]
        assembler.receive(PacketHeader(PacketFormat.LEADER, block_id, 0).encode() + leader, block_id)
        for index, data in enumerate(pieces, 1):
            if index != 2:  # lost
                position = GendcPosition(len(data), (index - 1) * 184).encode()
                header = PacketHeader(PacketFormat.GENDC, block_id, index).encode()
                assembler.receive(header + position + data, block_id)
    for now in range(4, 9):
        assembler.handle_timer(now)
    assert list(assembler.resend_requests()) == [] == list(assembler.finished())
    fault = "the camera sends GenDC version 2.0, known are 1.0 and 1.1; set GenDCStreamingMode=Off"
    assert caplog.text.count(fault) == 1


def test_parts_whose_positions_count_from_their_own_start() -> None:
    """Cameras differ; the standard can be read either way."""
    parts = tuple(PayloadPart(PartType.IMAGE_2D, 200, 0x01080001, (20, 10, 0, 0, 0, 0)) for _ in range(2))
    leader = Leader(PayloadKind.MULTI_PART, 5, parts=parts).encode()
    memory = np.zeros(400, np.uint8)
    assembler = BlockAssembler(200, len(memory), lambda: memory)
    assembler.receive(PacketHeader(PacketFormat.LEADER, 1, 0).encode() + leader, 0.0)
    for packet_id, (part, offset) in enumerate([(0, 0), (0, 150), (1, 0), (1, 150)], 1):
        data = bytes([packet_id]) * (150 if offset == 0 else 50)
        header = PacketHeader(PacketFormat.MULTI_PART, 1, packet_id).encode()
        assembler.receive(header + PartPosition(part, offset).encode() + data, 0.0)
    trailer = Trailer(PayloadKind.MULTI_PART).encode()
    assembler.receive(PacketHeader(PacketFormat.TRAILER, 1, 5).encode() + trailer, 0.0)
    (block,) = assembler.finished()
    first, second = FrameBuilder(0).build(block).components
    assert first.data.tobytes() == b"\1" * 150 + b"\2" * 50
    assert second.data.tobytes() == b"\3" * 150 + b"\4" * 50


def test_a_lost_piece_of_a_part_is_zero_and_counted() -> None:
    parts = tuple(PayloadPart(PartType.IMAGE_2D, 200, 0x01080001, (20, 10, 0, 0, 0, 0)) for _ in range(2))
    leader = Leader(PayloadKind.MULTI_PART, 5, parts=parts).encode()
    memory = np.full(400, 9, np.uint8)
    assembler = BlockAssembler(200, len(memory), lambda: memory, deliver_incomplete=True)
    assembler.receive(PacketHeader(PacketFormat.LEADER, 1, 0).encode() + leader, 0.0)
    for packet_id, (part, offset) in enumerate([(0, 0), (0, 150), (1, 200), (1, 350)], 1):
        if packet_id != 3:
            data = b"\1" * (150 if packet_id == 1 else 50)
            header = PacketHeader(PacketFormat.MULTI_PART, 1, packet_id).encode()
            assembler.receive(header + PartPosition(part, offset).encode() + data, 0.0)
    assembler.flush()
    (block,) = assembler.finished()
    frame = FrameBuilder(0).build(block)
    assert (frame.complete, frame.missing_bytes) == (False, 150)
    assert frame.components[1].data.tobytes() == bytes(150) + b"\1" * 50


def test_h264_goes_on_where_16_bit_ids_begin_again() -> None:
    key, follower = b"\0\0\1\x67\x42\0\x0a\xf8\x41\xa2\0\0\1\x65\1\2", b"\0\0\1\x41\1\2"
    memory = np.zeros(100, np.uint8)
    assembler, builder = BlockAssembler(100, len(memory), lambda: memory), FrameBuilder(0)
    shown = []
    for block_id, data in ((65534, key), (65535, follower), (1, follower), (3, follower), (4, key)):
        leader = Leader(PayloadKind.H264, size=len(data)).encode()
        trailer = Trailer(PayloadKind.H264).encode()
        body = bytes(8) + data  # behind its timestamp
        for packet_id, (kind, content) in enumerate(
            [(PacketFormat.LEADER, leader), (PacketFormat.H264, body), (PacketFormat.TRAILER, trailer)]
        ):
            assembler.receive(PacketHeader(kind, block_id, packet_id).encode() + content, 0.0)
        shown += [block_id for block in assembler.finished() if builder.build(block).parts]
    assert shown == [65534, 65535, 1, 4], "only an image behind a lost one waits for a key frame"


def test_raw_data_whose_last_packet_is_padded() -> None:
    leader = Leader(PayloadKind.RAW, 5, size=250).encode()
    memory = np.zeros(300, np.uint8)
    assembler = BlockAssembler(100, len(memory), lambda: memory)
    assembler.receive(PacketHeader(PacketFormat.LEADER, 1, 0).encode() + leader, 0.0)
    for packet_id in (1, 2, 3):
        header = PacketHeader(PacketFormat.PAYLOAD, 1, packet_id).encode()
        assembler.receive(header + bytes([packet_id]) * 100, 0.0)
    trailer = Trailer(PayloadKind.RAW).encode()
    assembler.receive(PacketHeader(PacketFormat.TRAILER, 1, 4).encode() + trailer, 0.0)
    (block,) = assembler.finished()
    frame = FrameBuilder(0).build(block)
    assert frame.payload.tobytes() == b"\1" * 100 + b"\2" * 100 + b"\3" * 50


@pytest.mark.parametrize("order", ["in order", "backwards"])
@pytest.mark.parametrize("flows", [(5, 5, 5), (0, 1, 2), (3, 1, 1)], ids=str)
def test_data_of_a_container_in_other_flows_than_0(flows: tuple[int, int, int], order: str) -> None:
    """Flows of the descriptor and of two parts; those of one flow follow each other."""
    sizes = (300, 200)
    begin = gendc.descriptor_size([1, 1])
    starts = (begin, begin + sizes[0])
    used: dict[int, int] = {flows[0]: begin}
    offsets = []
    for flow, size in zip(flows[1:], sizes, strict=True):
        offsets.append(used.get(flow, 0))
        used[flow] = offsets[-1] + size
    parts = [
        gendc.PartHeader(gendc.HeaderType.IMAGE_2D, 0x01080001, size, start, size, 1, 0, 0, flow, offset)
        for size, start, flow, offset in zip(sizes, starts, flows[1:], offsets, strict=True)
    ]
    components = tuple(gendc.ComponentHeader(1, 0x01080001, (part,)) for part in parts)
    head = gendc.Container(components, 7, sum(sizes), begin, begin).encode()
    whole = head + bytes(range(250)) * 2
    pieces = [(flows[0], at, at, min(at + 184, begin)) for at in range(0, begin, 184)]
    for flow, start, offset, size in zip(flows[1:], starts, offsets, sizes, strict=True):
        pieces += [(flow, offset + at, start + at, start + min(at + 184, size)) for at in range(0, size, 184)]
    datagrams = [
        PacketHeader(PacketFormat.GENDC, 1, index).encode()
        + GendcPosition(last - first, at, 0, 0, flow).encode()
        + whole[first:last]
        for index, (flow, at, first, last) in enumerate(pieces, 1)
    ]
    memory = np.full(len(whole), 0xEE, np.uint8)
    assembler = BlockAssembler(200, len(memory), lambda: memory)
    leader = Leader(PayloadKind.GENDC, 5, size=len(whole)).encode()
    assembler.receive(PacketHeader(PacketFormat.LEADER, 1, 0).encode() + leader, 0.0)
    for datagram in datagrams if order == "in order" else reversed(datagrams):
        assembler.receive(datagram, 0.0)
    end = PacketHeader(PacketFormat.TRAILER, 1, len(datagrams) + 1).encode()
    assembler.receive(end + Trailer(PayloadKind.GENDC).encode(), 0.0)
    (block,) = assembler.finished()
    assert block.complete and block.payload.tobytes() == whole


def test_an_h264_image_is_its_packets_behind_each_other_in_whatever_order() -> None:
    """The payload packets may be short; each begins with the timestamp, which the leader does not have."""
    data = b"\0\0\1\x67\x42\0\x0a\xf8\x41\xa2\0\0\1\x65" + bytes(range(1, 80))
    pieces = [data[:40], data[40:47], data[47:]]
    datagrams = [packet(PacketFormat.LEADER, 0, Leader(PayloadKind.H264, size=len(data)).encode())]
    for index, piece in enumerate(pieces, 1):
        datagrams.append(packet(PacketFormat.H264, index, (7_000).to_bytes(8, "big") + piece))
    datagrams.append(packet(PacketFormat.TRAILER, 4, Trailer(PayloadKind.H264).encode()))
    for order in ((0, 1, 2, 3, 4), (0, 3, 1, 2, 4), (2, 3, 0, 1, 4)):
        block = only_block([datagrams[index] for index in order], 400)
        frame = FrameBuilder(1_000).build(block)
        assert block.complete and frame.timestamp_ns == 7_000_000_000
        assert frame.payload_type is PayloadType.H264 and frame.parts[0].data.tobytes() == data


def test_gendc_data_without_a_descriptor_takes_no_more_memory_than_a_frame() -> None:
    bench = Bench(payload_size=300, stride=120)
    bench.feed([packet(PacketFormat.LEADER, 0, Leader(PayloadKind.GENDC, 5, size=300).encode())])
    for packet_id in range(1, 4):
        piece = GendcPosition(100, (packet_id - 1) * 100, 0, 0, flow=1).encode() + bytes(100)
        bench.feed([packet(PacketFormat.GENDC, packet_id, piece)])
    assert bench.assembler.refusal == ""
    piece = GendcPosition(1, 300, 0, 0, flow=1).encode() + bytes(1)
    bench.feed([packet(PacketFormat.GENDC, 4, piece)])
    assert bench.assembler.refusal.endswith("GenDC data of a frame's size came without a descriptor")
