"""Packets to frames, in memory: duplicate, late, foreign, malformed; time is a number."""

from __future__ import annotations

import random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from block_bench import (
    HEIGHT,
    LAST,
    SIZE,
    STRIDE,
    WIDTH,
    Bench,
    block,
    fuzz_headers,
    ids,
    image,
    is_image,
)
from gige_transcripts import lines
from grabbergui.driver.gige.gvsp import Leader, PayloadKind, Trailer
from grabbergui.driver.gige.packet_header import PacketFormat, PacketHeader
from grabbergui.driver.gige.stream.block_layout import MOST_PARTS
from grabbergui.driver.gige.stream.frame_builder import FrameBuilder


@pytest.mark.parametrize("extended", [False, True])
def test_blocks_come_out_as_they_were_sent(extended: bool) -> None:
    bench = Bench()
    done = bench.feed(datagram for block_id in (1, 2, 3) for datagram in block(block_id, extended=extended))
    assert ids(done) == [1, 2, 3] and all(map(is_image, done))
    assert [each.leader.timestamp for each in done] == [1000, 2000, 3000]
    assert bench.statistics.packets == 3 * (LAST + 1)
    assert (bench.statistics.frames, bench.statistics.bytes) == (3, 3 * SIZE)
    assert (
        bench.statistics.packets_duplicate == bench.statistics.packets_ignored == bench.statistics.lost == 0
    )
    assert bench.requests == []


@pytest.mark.parametrize(
    "name, count",
    [
        ("aravis-stream-576", 2),
        ("aravis-stream-1500", 2),
        ("viva-stream-576", 2),
        ("viva-event", 2),
        ("viva-chunk", 2),
        ("accept-extended-ids", 2),
        ("accept-block-id-wrap", 4),
    ],
)
def test_captured_streams_are_complete(name: str, count: int) -> None:
    bench = Bench(payload_size=8192, stride=540)
    done = bench.feed(line.data for line in lines(name, "D"))
    assert len(done) == count and all(each.complete for each in done)
    assert {(each.leader.width, each.leader.height) for each in done} == {(64, 48)}
    assert bench.statistics.lost == bench.statistics.packets_ignored == 0


@pytest.mark.parametrize("seed", range(5))
def test_any_order_and_any_copies_give_the_same_images(seed: int) -> None:
    shuffle = random.Random(seed)
    datagrams = [datagram for block_id in (1, 2, 3) for datagram in block(block_id) * 2]
    keyed = sorted(enumerate(datagrams), key=lambda pair: pair[0] + shuffle.uniform(0, 12))
    bench = Bench(initial_wait=0.01)
    done = bench.feed(datagram for _, datagram in keyed)
    assert ids(done) == [1, 2, 3] and all(map(is_image, done))
    assert bench.requests == []
    assert bench.statistics.packets_duplicate == 3 * (LAST + 1)
    assert bench.statistics.incomplete == bench.statistics.lost == 0


def test_a_leader_has_the_first_packet_id() -> None:
    bench = Bench()
    leader, *rest = block(1)
    bench.feed([PacketHeader(PacketFormat.LEADER, 1, 2).encode() + leader[8:], *rest])
    assert bench.statistics.packets_ignored == 1
    assert [is_image(done) for done in bench.feed([leader])] == [True]


def test_a_trailer_before_other_packets_is_no_end() -> None:
    bench = Bench()
    leader, _, *rest = block(1)
    early = PacketHeader(PacketFormat.TRAILER, 1, 2).encode() + Trailer(1, HEIGHT).encode()
    assert bench.feed([leader, early, rest[5]]) == [] and bench.wait(1.0) == []
    assert bench.statistics.frames == 0 and bench.statistics.incomplete == 1


def test_a_packet_id_that_no_block_can_have_takes_no_memory() -> None:
    bench = Bench()
    leader, first = block(1)[:2]
    bench.feed([leader, first])
    allowed = SIZE // STRIDE + MOST_PARTS
    for packet_id, ignored in ((allowed, 0), (allowed + 1, 1), (0xFFFFFF, 2)):
        bench.feed([PacketHeader(PacketFormat.TRAILER, 1, packet_id).encode() + Trailer(1, HEIGHT).encode()])
        assert bench.statistics.packets_ignored == ignored
        assert len(bench.assembler._open[0].received) <= 2 * allowed


@pytest.mark.parametrize("length, stride", [(1, 1400), (63, 1400), (64, 64), (700, 700)])
def test_a_few_packets_make_no_long_lists_of_others(length: int, stride: int) -> None:
    size = 4000 * 1250
    bench = Bench(payload_size=size, stride=1400)
    leader = Leader(1, 1, 0x01080001, 4000, 1250).encode()
    bench.feed(
        [
            PacketHeader(PacketFormat.LEADER, 1, 0).encode() + leader,
            PacketHeader(PacketFormat.PAYLOAD, 1, 1).encode() + bytes(length),
        ]
    )
    assert bench.assembler.stride == stride
    for packet_id in (size // 1400, size // 512, size // 64, size // 16, size):
        trailer = PacketHeader(PacketFormat.TRAILER, 1, packet_id).encode() + Trailer(1, 1250).encode()
        bench.feed([trailer])
        (waiting,) = bench.assembler._open
        for packets in (waiting.received, waiting._requests.tries):
            assert len(packets) <= 2 * (size // min(stride, 512) + MOST_PARTS + 1)


def test_a_camera_that_finds_ever_new_faults_does_not_fill_the_log(caplog: pytest.LogCaptureFixture) -> None:
    bench = Bench()
    for number in range(1, 200):
        leader = Leader(0x3000 + number, number, 0x01080001, WIDTH, HEIGHT).encode()
        bench.feed([PacketHeader(PacketFormat.LEADER, number, 0).encode() + leader])
    assert "payload type 0x3001" in caplog.text
    assert len(caplog.records) == 16


@pytest.mark.parametrize("restart", [1, 4950, 3])
def test_ids_that_start_again_are_a_new_stream(restart: int) -> None:
    bench = Bench()
    before = 5000 if restart != 3 else 40
    assert len(bench.feed(block(before))) == 1
    later = bench.feed(datagram for block_id in range(restart, restart + 5) for datagram in block(block_id))
    assert len(later) >= 4 and ids(later)[-1] == restart + 4
    assert bench.statistics.lost == 0


def test_packets_of_finished_blocks_are_late_not_new() -> None:
    bench = Bench()
    sent = block(1)
    assert len(bench.feed(sent[:-1])) == 1, "complete without its trailer"
    assert bench.feed([sent[-1], sent[4], *block(2), sent[5]]) != []
    assert bench.statistics.packets_duplicate == 2 and bench.statistics.packets_ignored == 0


@pytest.mark.parametrize("deliver_incomplete", [False, True])
def test_a_camera_that_lies_about_its_size_is_refused(deliver_incomplete: bool) -> None:
    bench = Bench(payload_size=SIZE // 2, deliver_incomplete=deliver_incomplete)
    assert bench.feed(block(1)) == bench.wait(1.0) == []
    assert bench.statistics.incomplete == 1 and bench.pool.in_use == 0


@pytest.mark.parametrize("deliver_incomplete", [False, True])
def test_padding_beyond_the_end_of_the_payload_is_clipped_counted_and_the_frame_kept(
    deliver_incomplete: bool,
) -> None:
    bench = Bench(deliver_incomplete=deliver_incomplete)
    padded = image(1) + bytes(-SIZE % STRIDE)
    (done,) = bench.feed(block(1, data=padded))
    assert is_image(done) and done.complete
    bench.feed(block(2, data=padded))
    assert bench.statistics.packets_clipped == 2
    assert bench.statistics.packets_ignored == bench.statistics.incomplete == 0


def test_a_payload_type_that_is_unknown_is_named_and_not_asked_for(caplog: pytest.LogCaptureFixture) -> None:
    bench = Bench()
    for block_id in (1, 2):
        _leader, *rest = block(block_id)
        vendors = PacketHeader(PacketFormat.LEADER, block_id, 0).encode() + bytes((0, 0, 0x80, 1)) + bytes(8)
        assert bench.feed([vendors, *rest[:3], *rest[6:8]]) == []
    assert bench.wait(1.0) == [] and bench.requests == []
    fault = "the camera sends an unknown kind of data (payload type 0x8001)"
    assert caplog.text.count(fault) == 1
    assert bench.assembler.refusal.startswith(f"{fault}: no frame can be made of it")


def test_test_packets_and_foreign_formats_are_dropped(caplog: pytest.LogCaptureFixture) -> None:
    bench = Bench()
    (probe,) = [line.data for line in lines("viva-test-packet", "D")]
    assert bench.feed([probe, PacketHeader(9, 1, 0).encode() + bytes(40), b"", bytes(5)]) == []
    assert bench.statistics.packets_ignored == 3
    assert caplog.messages == ["a malformed stream packet: a packet of format 9, which carries no image"]


def test_what_a_source_drops_is_counted() -> None:
    bench = Bench()
    for packets in (2, 3):
        bench.assembler.ignore(packets)
        bench.assembler.note_overrun()
    assert (bench.statistics.packets_ignored, bench.statistics.overruns) == (5, 2)
    assert bench.statistics.packets_foreign == 5


def test_nothing_is_requested_of_what_was_discarded_after_an_overrun() -> None:
    bench = Bench(deliver_incomplete=True)
    assert bench.feed(block(1)[:-2]) == []
    bench.assembler.note_overrun()
    assert ids(bench.wait(1.0)) == [1] and bench.requests == []
    assert ids(bench.feed(block(3))) == [3] and bench.statistics.lost == 1


def test_a_device_that_sends_other_sizes_than_it_says_is_followed() -> None:
    bench = Bench(stride=STRIDE + 36)
    done = bench.feed([*block(1), *block(2)])
    assert ids(done) == [1, 2] and all(map(is_image, done))


def test_a_double_is_one_though_a_block_has_more_packets_than_were_announced() -> None:
    bench = Bench(stride=STRIDE + 36)
    (done,) = bench.feed(datagram for datagram in block(1) for _ in range(2))
    assert is_image(done) and bench.statistics.packets_duplicate == LAST + 1


def test_blocks_that_begin_in_another_order_come_out_in_theirs() -> None:
    bench = Bench()
    sent = {block_id: block(block_id) for block_id in (1, 2, 3)}
    assert bench.feed(sent[block_id][0] for block_id in (1, 3, 2)) == []
    assert ids(bench.feed(datagram for each in (3, 2, 1) for datagram in sent[each][1:])) == [1, 2, 3]


def test_extended_ids_that_are_far_apart_have_an_order() -> None:
    bench = Bench()
    near, far = block(1, extended=True), block(0x9001, extended=True)
    assert bench.feed([near[0], far[0], *far[1:]]) == []
    assert ids(bench.feed(near[1:])) == [1, 0x9001]


def test_packets_from_long_ago_are_ignored() -> None:
    bench = Bench()
    bench.feed(block(40))
    bench.feed(block(3)[1:3])
    assert bench.statistics.packets_ignored == 2 and bench.assembler.timer() == float("inf")


def test_late_packets_of_the_last_64_blocks_are_known() -> None:
    bench = Bench()
    sent = {block_id: block(block_id) for block_id in range(1, 66)}
    for datagrams in sent.values():
        bench.feed(datagrams)
    bench.feed(sent[2][3:4])
    assert (bench.statistics.packets_duplicate, bench.statistics.packets_ignored) == (1, 0)
    bench.feed(sent[1][3:4])
    assert (bench.statistics.packets_duplicate, bench.statistics.packets_ignored) == (1, 1)


def test_a_packet_without_data_is_malformed() -> None:
    bench = Bench()
    leader, *rest = block(1)
    bench.feed([leader, PacketHeader(PacketFormat.PAYLOAD, 1, 1).encode()])
    assert bench.statistics.packets_ignored == 1
    (done,) = bench.feed(rest)
    assert is_image(done)


def test_an_incomplete_image_keeps_the_chunks_behind_it() -> None:
    data = image(1) + bytes(range(164))
    sent = block(1, data=data, payload_type=0x4001)
    del sent[2]
    bench = Bench(payload_size=SIZE + 500, enabled=False, deliver_incomplete=True)
    (done,) = bench.feed(sent) + bench.wait(2.0)
    assert done.payload.tobytes() == data[:STRIDE] + bytes(STRIDE) + data[2 * STRIDE :]
    assert (done.complete, done.missing_bytes) == (False, STRIDE)


def test_how_many_packets_are_still_to_come() -> None:
    bench = Bench()
    sent = block(1)
    assert bench.assembler.expected() == 0 and not bench.assembler.block_in_progress, "nothing is known yet"
    bench.feed(sent[:1])
    assert bench.assembler.expected() == LAST - 1 and bench.assembler.block_in_progress
    bench.feed(sent[1:6])
    assert bench.assembler.expected() == LAST - 1 - 5
    bench.feed(sent[6:-1])
    assert bench.assembler.expected() == LAST - 1 and not bench.assembler.block_in_progress, (
        "of the next block"
    )


def test_a_block_that_waits_for_what_it_lost_ends_at_any_moment() -> None:
    bench = Bench()
    bench.feed(datagram for index, datagram in enumerate(block(1)) if index != 5)
    assert bench.assembler.expected() == 0 and not bench.assembler.block_in_progress


def test_a_block_with_chunks_is_expected_to_be_as_long_as_the_last() -> None:
    bench = Bench(payload_size=SIZE + 250)
    data = bytes(SIZE + 250)
    first, second = (block(index, data=data, payload_type=0x4001) for index in (1, 2))
    bench.feed(first[:3])
    assert bench.assembler.expected() == 0, "only the trailer says how many"
    bench.feed(first[3:])
    bench.feed(second[:3])
    assert bench.assembler.expected() == len(second) - 2 - 2 and bench.assembler.block_in_progress


def test_chunks_stay_at_the_end_of_the_payload() -> None:
    data = image(1) + b"chunk data" + (0x1234).to_bytes(4, "big") + (10).to_bytes(4, "big")
    bench = Bench(payload_size=SIZE + 500)
    (done,) = bench.feed(block(1, data=data, payload_type=0x4001))
    assert done.payload.tobytes() == data and done.leader.has_chunks


def test_a_shorter_image_has_fewer_lines() -> None:
    bench = Bench()
    (done,) = bench.feed(block(1, data=image(1)[: WIDTH * 10], height=10))
    assert done.complete and done.height == 10 and len(done.payload) == WIDTH * 10


def test_all_in_one_packet() -> None:
    body = Leader(1, 5, 0x01080001, 8, 8).encode() + Trailer(1, 8).encode() + bytes(range(64))
    bench = Bench()
    (done,) = bench.feed([PacketHeader(PacketFormat.ALL_IN, 1, 0).encode() + body])
    assert done.complete and done.payload.tobytes() == bytes(range(64)) and done.leader.timestamp == 5


def test_the_parts_of_a_multi_part_block() -> None:
    """Two parts, which the Aravis host accepted."""
    bench = Bench(payload_size=8192, stride=528)
    (done,) = bench.feed(line.data for line in lines("accept-multipart", "D"))
    leader = done.leader
    assert leader.kind == PayloadKind.MULTI_PART and len(leader.parts) == 2
    frame = FrameBuilder(0).build(done)
    assert done.complete and len(frame.payload) == leader.parts[0].length == leader.width * leader.height
    assert frame.payload[:4].tobytes() == bytes.fromhex("00030609")
    first, second = frame.components
    assert first.data is frame.payload and second.data.nbytes == leader.parts[1].length
    assert (first.purpose, second.width, second.height) == (1, 64, 24)
    assert np.shares_memory(second.data, done.payload)


@settings(max_examples=300)
@given(st.lists(st.one_of(st.binary(max_size=80), fuzz_headers()), max_size=60), st.booleans())
def test_no_datagram_crashes_the_assembler_or_grows_memory(datagrams: list[bytes], deliver: bool) -> None:
    bench = Bench(deliver_incomplete=deliver, buffers=16)
    done = bench.feed(datagrams, 1e-3) + bench.wait(1.0)
    bench.assembler.flush()
    done += bench.tick()
    payloads: list[NDArray[np.uint8]] = [each.payload for each in done]
    assert all(len(payload) <= SIZE for payload in payloads)
    assert sum(request.last - request.first + 1 for request in bench.requests) < 60 * 5 * 200
    done.clear()
    payloads.clear()
    assert bench.pool.in_use == 0
