"""Packets to frames, in memory: lost, late, duplicate, foreign, malformed; time is a number."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable

import numpy as np
import pytest
from gige_transcripts import lines
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from grabbergui.core.frame import BufferPool
from grabbergui.driver.gige.gvcp import PacketResend, Status
from grabbergui.driver.gige.gvsp import Leader, PacketFormat, PacketHeader, PayloadKind, Trailer
from grabbergui.driver.gige.stream.assembler import BlockAssembler
from grabbergui.driver.gige.stream.block import Block
from grabbergui.driver.gige.stream.frame_builder import FrameBuilder
from grabbergui.driver.gige.stream.packet_sorting import distance
from grabbergui.driver.gige.stream.resend import ResendPolicy

STRIDE = 100
WIDTH, HEIGHT = 64, 24
SIZE = WIDTH * HEIGHT
LAST = -(-SIZE // STRIDE) + 1
"Packet id of the trailer: 16 payload packets, the last of 36 bytes."


def picture(block_id: int) -> bytes:
    return bytes((block_id * 7 + i) % 251 for i in range(SIZE))


def block(
    block_id: int,
    *,
    extended: bool = False,
    data: bytes | None = None,
    payload_type: int = 1,
    height: int = HEIGHT,
    stride: int = STRIDE,
) -> list[bytes]:
    """The datagrams of one picture."""
    data = picture(block_id) if data is None else data
    leader = Leader(payload_type, 1000 * block_id, 0x01080001, WIDTH, HEIGHT)
    pieces = [data[at : at + stride] for at in range(0, len(data), stride)]
    trailer = Trailer(payload_type, height, len(data) if payload_type & 0x4000 else None)

    def packet(kind: PacketFormat, packet_id: int, body: bytes) -> bytes:
        return PacketHeader(kind, block_id, packet_id, extended=extended).encode() + body

    return [
        packet(PacketFormat.LEADER, 0, leader.encode()),
        *(packet(PacketFormat.PAYLOAD, index, piece) for index, piece in enumerate(pieces, 1)),
        packet(PacketFormat.TRAILER, len(pieces) + 1, trailer.encode()),
    ]


class Bench:
    """An assembler with a clock of its own and a pool of buffers."""

    def __init__(
        self, *, payload_size: int = SIZE, stride: int = STRIDE, buffers: int = 8, **options: object
    ) -> None:
        self.pool = BufferPool(payload_size, buffers)
        deliver_incomplete = bool(options.pop("deliver_incomplete", False))
        self.assembler = BlockAssembler(
            stride,
            payload_size,
            self._take,
            ResendPolicy(**options),  # type: ignore[arg-type]
            deliver_incomplete=deliver_incomplete,
        )
        self.statistics = self.assembler.statistics
        self.now = 100_000.0
        "Seconds, as on a machine that has been up for a day."
        self.requests: list[PacketResend] = []

    def _take(self) -> NDArray[np.uint8] | None:
        """A buffer with something old in it, the same in each run."""
        buffer = self.pool.take()
        if buffer is not None:
            buffer[:] = 0xAA
        return buffer

    def feed(self, datagrams: Iterable[bytes], period: float = 1e-5) -> list[Block]:
        done: list[Block] = []
        for datagram in datagrams:
            self.assembler.receive(datagram, self.now)
            self.now += period
            done += self.tick()
        return done

    def tick(self) -> list[Block]:
        self.assembler.handle_timer(self.now)
        self.requests += self.assembler.resend_requests()
        return list(self.assembler.finished())

    def wait(
        self, seconds: float, answer: Callable[[PacketResend], Iterable[bytes]] | None = None
    ) -> list[Block]:
        """Let time pass; `answer` makes a device's datagrams for each request."""
        end = self.now + seconds
        done = self.tick()
        while True:
            while answer is not None and self.requests:
                done += self.feed(answer(self.requests.pop(0)))
            if self.assembler.timer() > end:
                self.now = max(self.now, end)
                return done
            self.now = max(self.now, self.assembler.timer())
            done += self.tick()


def ids(done: Iterable[Block]) -> list[int]:
    return [each.block_id for each in done]


def is_picture(done: Block) -> bool:
    return done.complete and done.payload.tobytes() == picture(done.block_id)


@pytest.mark.parametrize("extended", [False, True])
def test_blocks_come_out_as_they_were_sent(extended: bool) -> None:
    bench = Bench()
    done = bench.feed(datagram for block_id in (1, 2, 3) for datagram in block(block_id, extended=extended))
    assert ids(done) == [1, 2, 3] and all(map(is_picture, done))
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


def test_captured_losses_are_asked_for_and_mended() -> None:
    """viva-genicam's camera left out packets, its host asked, the camera sent them again."""
    bench = Bench(payload_size=64 * 48, stride=540)
    done, begun = [], bench.now
    for line in lines("viva-resend", "D"):
        done += bench.wait(max(0.0, begun + line.ms / 1000 - bench.now))
        done += bench.feed([line.data], 0)
    assert len(done) == 5 and all(each.complete for each in done), "a lost trailer costs no picture"
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
    assert ids(done) == [1] and is_picture(done[0])
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


@pytest.mark.parametrize("seed", range(5))
def test_any_order_and_any_copies_give_the_same_images(seed: int) -> None:
    shuffle = random.Random(seed)
    datagrams = [datagram for block_id in (1, 2, 3) for datagram in block(block_id) * 2]
    keyed = sorted(enumerate(datagrams), key=lambda pair: pair[0] + shuffle.uniform(0, 12))
    bench = Bench(initial_wait=0.01)
    done = bench.feed(datagram for _, datagram in keyed)
    assert ids(done) == [1, 2, 3] and all(map(is_picture, done))
    assert bench.requests == []
    assert bench.statistics.packets_duplicate == 3 * (LAST + 1)
    assert bench.statistics.incomplete == bench.statistics.lost == 0


def test_incomplete_blocks_are_delivered_by_choice_without_an_older_image_in_the_holes() -> None:
    bench = Bench(enabled=False, deliver_incomplete=True, buffers=1)
    assert len(bench.feed(block(1))) == 1
    done = bench.feed([datagram for index, datagram in enumerate(block(2)) if index not in (3, LAST - 1)])
    done += bench.wait(1.0)
    (broken,) = done
    assert not broken.complete and broken.missing_bytes == 100 + 36
    assert len(broken.payload) == SIZE
    assert not broken.payload[200:300].any() and not broken.payload[1500:].any()
    assert broken.payload[:200].tobytes() == picture(2)[:200]


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


def test_packets_of_another_kind_of_data_make_no_image() -> None:
    sent = block(2, data=bytes(SIZE))
    pieces = [PacketHeader(PacketFormat.H264, 2, index).encode() + bytes(STRIDE) for index in range(5, 9)]
    done = only_block([*sent[:5], *pieces, *sent[9:]])
    assert not done.complete and not done.payload.any()


def test_a_leader_has_the_first_packet_id() -> None:
    bench = Bench()
    leader, *rest = block(1)
    bench.feed([PacketHeader(PacketFormat.LEADER, 1, 2).encode() + leader[8:], *rest])
    assert bench.statistics.packets_ignored == 1
    assert [is_picture(done) for done in bench.feed([leader])] == [True]


def test_a_trailer_before_other_packets_is_no_end() -> None:
    bench = Bench()
    leader, _, *rest = block(1)
    early = PacketHeader(PacketFormat.TRAILER, 1, 2).encode() + Trailer(1, HEIGHT).encode()
    assert bench.feed([leader, early, rest[5]]) == [] and bench.wait(1.0) == []
    assert bench.statistics.frames == 0 and bench.statistics.incomplete == 1


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


def test_a_packet_id_that_no_block_can_have_takes_no_memory() -> None:
    bench = Bench()
    leader, first = block(1)[:2]
    bench.feed([leader, first])
    allowed = SIZE // 16 + 64
    for packet_id, ignored in ((allowed, 0), (allowed + 1, 1), (0xFFFFFF, 2)):
        bench.feed([PacketHeader(PacketFormat.TRAILER, 1, packet_id).encode() + Trailer(1, HEIGHT).encode()])
        assert bench.statistics.packets_ignored == ignored
        assert len(bench.assembler._open[0].received) <= 2 * allowed


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
    padded = picture(1) + bytes(-SIZE % STRIDE)
    (done,) = bench.feed(block(1, data=padded))
    assert is_picture(done) and done.complete
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
    assert caplog.text.count("the camera sends an unknown kind of data (payload type 0x8001)") == 1


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


def test_a_device_that_sends_other_sizes_than_it_says_is_followed() -> None:
    bench = Bench(stride=STRIDE + 36)
    done = bench.feed([*block(1), *block(2)])
    assert ids(done) == [1, 2] and all(map(is_picture, done))


def test_a_double_is_one_though_a_block_has_more_packets_than_were_announced() -> None:
    bench = Bench(stride=STRIDE + 36)
    (done,) = bench.feed(datagram for datagram in block(1) for _ in range(2))
    assert is_picture(done) and bench.statistics.packets_duplicate == LAST + 1


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


def test_no_more_blocks_than_allowed_wait_for_their_packets() -> None:
    bench = Bench(max_blocks=2)
    bench.feed([*block(1)[:4], *block(2)[:4]])
    assert bench.statistics.incomplete == 0
    bench.feed(block(3)[:1])
    assert bench.statistics.incomplete == 1
    assert [waiting.block_id for waiting in bench.assembler._open] == [2, 3]


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
    data = picture(1) + b"chunk data" + (0x1234).to_bytes(4, "big") + (10).to_bytes(4, "big")
    bench = Bench(payload_size=SIZE + 500)
    (done,) = bench.feed(block(1, data=data, payload_type=0x4001))
    assert done.payload.tobytes() == data and done.leader.has_chunks


def test_a_lost_trailer_after_chunks_costs_nothing() -> None:
    data = picture(1) + b"chunk data" + (0x1234).to_bytes(4, "big") + (10).to_bytes(4, "big")
    bench = Bench(payload_size=SIZE + 500, enabled=False)
    done = bench.feed(block(1, data=data, payload_type=0x4001)[:-1]) + bench.wait(1.0)
    assert [each.payload.tobytes() for each in done] == [data] and done[0].complete


def test_a_shorter_image_has_fewer_lines() -> None:
    bench = Bench()
    (done,) = bench.feed(block(1, data=picture(1)[: WIDTH * 10], height=10))
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


def fuzz_headers() -> st.SearchStrategy[bytes]:
    small = st.sampled_from([0, 1, 2, 3, 5, LAST, LAST + 1, 1000, 0xFFFFFF])
    header = st.builds(
        PacketHeader,
        st.integers(0, 9),
        st.sampled_from([0, 1, 2, 3, 4, 9, 200, 65535]),
        small,
        st.sampled_from([0, 0x100, 0x800C, 0x8012]),
        st.booleans(),
    )
    body = st.one_of(
        st.binary(max_size=120),
        st.sampled_from(
            [Leader(1, 0, 0x01080001, WIDTH, HEIGHT).encode(), Trailer(1, HEIGHT).encode(), bytes(100)]
        ),
        st.just(b"\0\0\0\x0a" + bytes(8 + 48)),
    )
    return st.builds(lambda head, data: head.encode() + data, header, body)


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
