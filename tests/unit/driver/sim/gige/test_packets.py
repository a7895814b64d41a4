"""Frames as packets, and packets on their way."""

import numpy as np
import pytest

from grabbergui.core.errors import UsageError
from grabbergui.core.pfnc import by_name
from grabbergui.driver.gige.gvcp import Status
from grabbergui.driver.gige.gvsp import Leader, Trailer
from grabbergui.driver.gige.packet_header import PacketFormat, PacketHeader
from grabbergui.driver.sim.enumerations import Chunk
from grabbergui.driver.sim.gige.faults import GigeFaults, PacketFaults
from grabbergui.driver.sim.gige.packets import FramePackets, test_packet, unavailable
from grabbergui.driver.sim.gige.server import counted
from grabbergui.driver.sim.model import FramePlan
from grabbergui.driver.sim.settings import FrameSettings, Optics

test_packet.__test__ = False  # a maker of test packets


def make_block(size=5000, packet_size=1500, extended=False, frame_id=1, chunks=()):
    settings = FrameSettings(100, 50, 8, 4, by_name("Mono8"), Optics(), 1000.0, 0.0, 0.0)
    plan = FramePlan(frame_id, 123_456_789_012, settings, dict.fromkeys(chunks, 1), size)
    payload = np.random.default_rng(1).integers(0, 256, size, np.uint8)
    return FramePackets(plan, payload, packet_size, extended)


@pytest.mark.parametrize("extended", [False, True])
@pytest.mark.parametrize("size", [1, 1464, 5000])
def test_packets_put_together_are_the_frame(extended, size):
    block = make_block(size, extended=extended, frame_id=0x1_2345_6789 if extended else 7)
    together = b""
    for index, header in enumerate(block.headers):
        decoded = PacketHeader.decode(header.tobytes())
        assert (decoded.format, decoded.packet_id) == (PacketFormat.PAYLOAD, index + 1)
        assert decoded.block_id == block.block_id and decoded.extended == extended
        together += block.payload[block.starts[index] :][: block.sizes[index]].tobytes()
    assert together == block.payload.tobytes()
    assert len(header.tobytes()) + block.sizes[0] + 28 <= 1500
    assert block.trailer_id == len(block.headers) + 1


def test_block_ids_of_16_bits_go_round_without_zero():
    assert [make_block(frame_id=n).block_id for n in (1, 65535, 65536, 131070, 131071)] == [
        1,
        65535,
        1,
        65535,
        1,
    ]


def test_leader_and_trailer_describe_the_frame():
    block = make_block(5000 + 24, chunks=(Chunk.FRAME_ID,))
    leader = Leader.decode(block.leader()[8:])
    assert (leader.payload_type, leader.width, leader.height) == (0x4001, 100, 50)
    assert (leader.offset_x, leader.offset_y, leader.timestamp) == (8, 4, 123_456_789_012)
    trailer = Trailer.decode(block.trailer()[8:])
    assert (trailer.height, trailer.payload_bytes) == (50, 5024)


@pytest.mark.parametrize("extended", [False, True])
def test_a_resent_packet_is_flagged(extended):
    block = make_block(extended=extended)
    again = block.packet(2)
    header = PacketHeader.decode(again)
    assert (header.status, header.packet_id, header.flags) == (0x0100, 2, int(extended))
    assert again[header.size :] == block.payload[block.stride : 2 * block.stride].tobytes()
    assert PacketHeader.decode(block.packet(0)).format == PacketFormat.LEADER
    assert PacketHeader.decode(block.packet(block.trailer_id)).format == PacketFormat.TRAILER


def test_an_unavailable_packet_is_a_header_with_its_status():
    assert unavailable(0x270F, 1, False, Status.PACKET_UNAVAILABLE).hex() == "800c270f03000001"
    assert unavailable(0x270F, 1, False, Status.PACKET_NOT_YET_AVAILABLE).hex() == "8010270f03000001"


def test_test_packets_have_their_size():
    packet = test_packet(1500)
    assert len(packet) == 1472
    assert PacketHeader.decode(packet).block_id == 0


def order(count=100_000, **faults):
    return PacketFaults(GigeFaults(**faults)).order(count)


def test_no_faults_leave_packets_alone():
    assert np.array_equal(order(50), np.arange(50))


def test_losses_are_as_many_as_asked_for():
    assert len(order(loss=0.01)) == pytest.approx(99_000, abs=200)
    assert len(order(loss=1.0)) == 0


def test_reordering_loses_nothing():
    shuffled = order(reorder=True)
    assert np.array_equal(np.sort(shuffled), np.arange(100_000))
    assert 0 < (np.diff(shuffled) < 0).mean() < 0.1


def test_duplicates_only_add():
    doubled = order(duplicate=True)
    values, counts = np.unique(doubled, return_counts=True)
    assert len(values) == 100_000
    assert (counts == 2).sum() == pytest.approx(1000, abs=150)


def test_all_together_and_always_the_same():
    faults = {"loss": 0.05, "reorder": True, "duplicate": True}
    assert np.array_equal(order(1000, **faults), order(1000, **faults))


@pytest.mark.parametrize(
    "wrong",
    [
        {"loss": 1.5},
        {"loss": -0.1},
        {"delay": -1.0},
        {"stall_after": -1},
        {"loss": float("nan")},
        {"delay": 60.0},
    ],
)
def test_faults_that_make_no_sense_are_refused(wrong):
    with pytest.raises(UsageError):
        GigeFaults(**wrong)


def test_further_cameras_get_the_next_serial_numbers():
    assert [counted("SIM009", n) for n in (0, 1)] == ["SIM009", "SIM010"]
    assert [counted("left", n) for n in (0, 1)] == ["left", "left-2"]
