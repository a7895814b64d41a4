"""Blocks that lost packets: requested again, given up, delivered with holes; time is a number."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest

from block_bench import HEIGHT, LAST, SIZE, STRIDE, WIDTH, Bench, block, ids, image, is_image
from gige_transcripts import lines
from grabbergui.driver.gige.gvcp import PacketResend, Status
from grabbergui.driver.gige.gvsp import Trailer
from grabbergui.driver.gige.packet_header import PacketFormat, PacketHeader
from grabbergui.driver.gige.stream.block import Block
from grabbergui.driver.gige.stream.block_history import distance
from grabbergui.driver.gige.stream.frame_builder import FrameBuilder


def test_captured_losses_are_asked_for_and_mended() -> None:
    """viva-genicam's camera left out packets, its host asked, the camera sent them again."""
    bench = Bench(payload_size=64 * 48, stride=540)
    done, begun = [], bench.now
    for line in lines("viva-resend", "D"):
        done += bench.wait(max(0.0, begun + line.ms / 1000 - bench.now))
        done += bench.feed([line.data], 0)
    assert len(done) == 5 and all(each.complete for each in done), "a lost trailer costs no image"
    assert bench.statistics.packets_resent == 4


def test_incomplete_captured_stream_without_resend() -> None:
    bench = Bench(payload_size=64 * 48, stride=540, enabled=False)
    done = bench.feed((line.data for line in lines("aravis-lossy", "D")), 1e-3) + bench.wait(1.0)
    assert bench.requests == [], "a device that cannot resend is never asked"
    assert (
        bench.statistics.incomplete and len(done) + bench.statistics.incomplete + bench.statistics.lost >= 5
    )


@pytest.mark.parametrize("lost", [[0], [1], [5], [4, 5, 6], [LAST - 1], [LAST - 1, LAST], [0, 7, LAST]])
def test_lost_packets_are_asked_for_once_and_mend_the_block(lost: list[int]) -> None:
    bench = Bench()
    sent = block(1)
    done = bench.feed(datagram for index, datagram in enumerate(sent) if index not in lost)
    asked: list[PacketResend] = []

    def answer(request: PacketResend) -> list[bytes]:
        asked.append(request)
        return sent[request.first : request.last + 1]

    done += bench.wait(0.2, answer)
    assert ids(done) == [1] and is_image(done[0])
    packets = [packet for request in asked for packet in range(request.first, request.last + 1)]
    assert len(packets) == len(set(packets)) and set(lost) - {LAST} <= set(packets) <= {*lost, LAST}
    assert bench.statistics.packets_resent >= len(set(lost) - {LAST})
    assert bench.statistics.incomplete == 0


def test_a_dead_link_is_not_flooded() -> None:
    bench = Bench(max_tries=3)
    bench.feed(datagram for index, datagram in enumerate(block(1)) if index not in (3, 8))
    bench.wait(5.0)
    assert [(request.first, request.last) for request in bench.requests] == [(3, 3), (8, 8)] * 3
    assert (bench.statistics.incomplete, bench.statistics.packets_missing) == (1, 2)
    assert bench.assembler.timer() == float("inf")
    bench.feed(datagram for index, datagram in enumerate(block(2)) if index != 3)
    bench.wait(5.0)
    assert (bench.statistics.incomplete, bench.statistics.packets_missing) == (2, 3)


def test_a_block_that_lost_too_much_is_not_asked_for() -> None:
    bench = Bench(always_worth=2)
    sent = block(1)
    bench.feed([*sent[:2], *sent[13:]])
    assert bench.wait(5.0) == [] and bench.requests == []
    assert bench.statistics.packets_missing == 11


def test_what_the_device_no_longer_has_is_not_asked_for_again() -> None:
    bench = Bench()
    bench.feed(datagram for index, datagram in enumerate(block(1)) if index != 3)

    def gone(request: PacketResend) -> list[bytes]:
        return [PacketHeader(PacketFormat.PAYLOAD, 1, 3, Status.PACKET_UNAVAILABLE).encode()]

    counted: list[PacketResend] = []
    bench.wait(1.0, lambda request: counted.append(request) or gone(request))
    assert len(counted) == 1
    assert bench.statistics.incomplete == 1


def test_incomplete_blocks_are_delivered_by_choice_without_an_older_image_in_the_holes() -> None:
    bench = Bench(enabled=False, deliver_incomplete=True, buffers=1)
    assert len(bench.feed(block(1))) == 1
    done = bench.feed([datagram for index, datagram in enumerate(block(2)) if index not in (3, LAST - 1)])
    done += bench.wait(1.0)
    (broken,) = done
    assert not broken.complete and broken.missing_bytes == 100 + 36
    assert len(broken.payload) == SIZE
    assert not broken.payload[200:300].any() and not broken.payload[1500:].any()
    assert broken.payload[:200].tobytes() == image(2)[:200]


def test_a_frame_whose_leader_is_lost_has_no_timestamp_rather_than_that_of_the_frame_before() -> None:
    bench, builder = Bench(enabled=False, deliver_incomplete=True), FrameBuilder(1_000_000_000)
    (first,) = bench.feed(block(1))
    (second,) = bench.feed(block(2)[1:]) + bench.wait(1.0)
    frames = [builder.build(done) for done in (first, second)]
    assert [frame.timestamp_ns for frame in frames] == [1000, 0]
    assert frames[1].captured == pytest.approx(second.first_packet_at, abs=1e-6)


def only_block(datagrams: Iterable[bytes]) -> Block:
    """The block of these packets, complete or not."""
    bench = Bench(enabled=False, deliver_incomplete=True)
    (done,) = bench.feed(datagrams) + bench.wait(1.0)
    return done


def test_an_incomplete_image_of_fewer_lines_shows_nothing_older_behind_its_end() -> None:
    """The trailer's place is between the lines that were sent and those that a higher image has."""
    lines = bytes(WIDTH * 10)  # 7 packets, the last of 40 bytes
    done = only_block([*(sent := block(2, data=lines, height=10))[:3], *sent[4:]])
    assert not done.complete and not done.payload.any()
    assert done.missing_bytes == STRIDE + SIZE - len(lines)


def test_what_a_short_packet_leaves_is_zero() -> None:
    sent = block(2, data=bytes(SIZE))
    done = only_block([*sent[:3], sent[3][:-8], *sent[4:]])
    assert done.complete and not done.payload.any()


def test_a_trailer_that_announces_more_than_was_sent_adds_nothing_older() -> None:
    *sent, _ = block(2, data=bytes(SIZE - STRIDE), payload_type=0x4001)
    trailer = PacketHeader(PacketFormat.TRAILER, 2, len(sent)).encode()
    done = only_block([*sent, trailer + Trailer(0x4001, HEIGHT, SIZE).encode()])
    assert done.complete and len(done.payload) == SIZE - STRIDE and not done.payload.any()


@pytest.mark.parametrize("stride", [64, 200])
def test_a_length_of_packets_that_shows_late_makes_no_false_image(stride: int) -> None:
    bench = Bench(deliver_incomplete=True)
    leader, first, *others = block(1, stride=stride)
    for done in bench.feed([leader, *others, first]) + bench.wait(1.0):
        assert not done.complete
        stored = np.flatnonzero(done.payload)
        assert (done.payload[stored] == np.frombuffer(image(1), np.uint8)[stored]).all()
    assert bench.statistics.incomplete == 1
    assert [is_image(done) for done in bench.feed(block(2, stride=stride))] == [True]


def test_a_new_length_of_packets_ends_blocks_that_wait_for_old_ones() -> None:
    bench = Bench()
    old = block(1)
    assert bench.feed([*old[:5], *old[6:], *block(2, stride=200)]) == []
    assert ids(bench.feed([old[5]])) == [2]
    assert bench.statistics.incomplete == 1


def test_packets_of_another_kind_of_data_make_no_image() -> None:
    sent = block(2, data=bytes(SIZE))
    pieces = [PacketHeader(PacketFormat.H264, 2, index).encode() + bytes(STRIDE) for index in range(5, 9)]
    done = only_block([*sent[:5], *pieces, *sent[9:]])
    assert not done.complete and not done.payload.any()


def test_a_lone_leader_waits_for_as_long_as_the_exposure_takes() -> None:
    bench = Bench()
    sent = block(1)
    assert bench.feed(sent[:1]) == bench.wait(60.0) == []
    assert bench.requests == [] and bench.statistics.incomplete == 0
    assert ids(bench.feed(sent[1:])) == [1]


def test_no_free_buffer_costs_the_block_and_is_counted() -> None:
    bench = Bench(buffers=2)
    held = bench.feed([*block(1), *block(2)])
    assert bench.feed([*block(3), *block(4)]) == [] and bench.statistics.underruns == 2
    held.clear()
    assert ids(bench.feed(block(5))) == [5]
    assert bench.statistics.lost == bench.statistics.incomplete == 0


def test_lost_blocks_are_counted_across_the_wrap_of_ids() -> None:
    bench = Bench()
    done = bench.feed(datagram for block_id in (65533, 65535, 1, 4) for datagram in block(block_id))
    assert ids(done) == [65533, 65535, 1, 4] and bench.statistics.lost == 3
    assert distance(65535, 1, False) == 1 and distance(1, 65535, False) == -1
    assert distance(0xFFFF, 0x10000, True) == 1


def test_a_large_jump_ahead_is_a_new_stream_and_a_smaller_one_a_loss() -> None:
    for jump, lost in ((10_000, 9_999), (10_001, 0)):
        bench = Bench()
        assert ids(bench.feed(block(1))) == [1]
        assert ids(bench.feed(block(1 + jump))) == [1 + jump]
        assert bench.statistics.lost == lost


def test_open_blocks_with_ids_far_apart_are_no_losses() -> None:
    bench = Bench(max_blocks=2)
    for block_id in (1, 1 << 30, 1 << 40, 1 << 50):
        bench.feed(block(block_id, extended=True)[:3])
    bench.wait(2.0)
    assert bench.statistics.incomplete == 4
    assert bench.statistics.lost == 0


def test_no_more_blocks_than_allowed_wait_for_their_packets() -> None:
    bench = Bench(max_blocks=2)
    bench.feed([*block(1)[:4], *block(2)[:4]])
    assert bench.statistics.incomplete == 0
    bench.feed(block(3)[:1])
    assert bench.statistics.incomplete == 1
    assert [waiting.block_id for waiting in bench.assembler._open] == [2, 3]


def test_a_lost_trailer_after_chunks_costs_nothing() -> None:
    data = image(1) + b"chunk data" + (0x1234).to_bytes(4, "big") + (10).to_bytes(4, "big")
    bench = Bench(payload_size=SIZE + 500, enabled=False)
    done = bench.feed(block(1, data=data, payload_type=0x4001)[:-1]) + bench.wait(1.0)
    assert [each.payload.tobytes() for each in done] == [data] and done[0].complete
