"""Frames as packets, and packets on their way."""

import socket

import numpy as np
import pytest

from grabbergui.core.pfnc import by_name
from grabbergui.driver.sim.gige.datagram_batch import DatagramBatch
from grabbergui.driver.sim.gige.packets import FramePackets
from grabbergui.driver.sim.model import FramePlan
from grabbergui.driver.sim.settings import FrameSettings, Optics
from patience import PATIENCE


def make_block(size=5000, packet_size=1500, extended=False, frame_id=1, chunks=()):
    settings = FrameSettings(100, 50, 8, 4, by_name("Mono8"), Optics(), 1000.0, 0.0, 0.0)
    plan = FramePlan(frame_id, 123_456_789_012, settings, dict.fromkeys(chunks, 1), size)
    payload = np.random.default_rng(1).integers(0, 256, size, np.uint8)
    return FramePackets(plan, payload, packet_size, extended)


@pytest.mark.parametrize("segmentation", [True, False])
@pytest.mark.parametrize("packet_size", [576, 8192])
@pytest.mark.parametrize("supported", [True, False], ids=["here", "elsewhere"])
def test_a_batch_delivers_every_packet_as_it_is(segmentation, packet_size, supported, monkeypatch):
    if not supported:
        monkeypatch.setattr("grabbergui.driver.sim.gige.datagram_batch.SUPPORTED", False)
    block = make_block(60_001, packet_size)
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender,
    ):
        receiver.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        receiver.bind(("127.0.0.1", 0))
        receiver.settimeout(PATIENCE)
        batch = DatagramBatch(sender, receiver.getsockname(), segmentation=segmentation)
        for first in range(0, block.payload_packets, 20):
            part = slice(first, first + 20)
            batch.send(block.headers[part], block.payload, block.starts[part], block.sizes[part])
            for index in range(first, min(first + 20, block.payload_packets)):
                datagram = receiver.recv(65535)
                assert datagram[:8] == block.headers[index].tobytes()
                start = int(block.starts[index])
                assert datagram[8:] == block.payload[start : start + block.sizes[index]].tobytes()
