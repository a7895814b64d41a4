"""Streams of cameras that are a little wrong.

One id for all blocks, a PayloadSize that is too small, pixels in an order that they do not announce (aravis
921 and 1029).
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import ExitStack, closing

import numpy as np
import pytest

from grabbergui import sources
from grabbergui.core.frame import Frame
from grabbergui.driver import acquisition
from grabbergui.driver.gige import quirks
from grabbergui.driver.gige.gvsp import Leader, PayloadKind, Trailer
from grabbergui.driver.gige.packet_header import PacketFormat, PacketHeader
from grabbergui.driver.gige.quirks import KnownCamera, Quirk, known
from grabbergui.driver.gige.stream.assembler import BlockAssembler
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.enumerations import TestPattern
from grabbergui.driver.sim.gige.server import GigeCamera
from patience import PATIENCE

ADDRESS = f"127.15.{os.getpid() % 250 + 1}.1"
STRIDE = 100


@pytest.fixture
def stage() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


def datagrams(block_id: int, timestamp: int, value: int) -> list[bytes]:
    leader = Leader(PayloadKind.IMAGE, timestamp, 0x01080001, 20, 10)
    return [
        PacketHeader(PacketFormat.LEADER, block_id, 0).encode() + leader.encode(),
        *(PacketHeader(PacketFormat.PAYLOAD, block_id, i).encode() + bytes([value]) * STRIDE for i in (1, 2)),
        PacketHeader(PacketFormat.TRAILER, block_id, 3).encode() + Trailer(PayloadKind.IMAGE, 10).encode(),
    ]


@pytest.mark.parametrize("lost", [None, 2, 3])
def test_a_constant_block_id_is_named_and_the_frames_arrive(
    lost: int | None, caplog: pytest.LogCaptureFixture
) -> None:
    """They once were duplicates of the first."""
    assembler = BlockAssembler(STRIDE, 200, lambda: np.zeros(200, np.uint8))
    values = []
    for number in range(1, 6):
        for packet_id, datagram in enumerate(datagrams(7, number * 1000, number)):
            if number != 3 or packet_id != lost:
                assembler.receive(datagram, number / 10)
        values += [int(block.payload[0]) for block in assembler.finished()]
    # Without its trailer an image is whole, and one that lacks data is not delivered.
    assert values == ([1, 2, 4, 5] if lost == 2 else [1, 2, 3, 4, 5])
    assert caplog.text.count("the camera gives its frames one id (7)") == 1


def test_a_leader_that_was_sent_again_begins_no_block() -> None:
    assembler = BlockAssembler(STRIDE, 200, lambda: np.zeros(200, np.uint8))
    for _ in range(3):
        assembler.receive(datagrams(7, 1000, 1)[0], 0.0)
    for datagram in datagrams(7, 1000, 1):
        assembler.receive(datagram, 0.1)
    assert [block.complete for block in assembler.finished()] == [True]
    assembler.receive(datagrams(7, 1000, 1)[0], 0.2)
    assert not list(assembler.finished()) and assembler.statistics.lost == 0


def first_frame(stage: ExitStack, query: str = "", pixel_format: str = "Mono16") -> Frame:
    uri = f"gige:{ADDRESS}{query}"
    grabber = stage.enter_context(closing(sources.create(uri)))
    grabber.open()
    grabber.write_feature("PixelFormat", pixel_format)
    queue = stage.enter_context(closing(grabber.open_queue(1)))
    grabber.start()
    frame = queue.get(PATIENCE)
    grabber.close()
    return frame


@pytest.fixture
def camera(stage: ExitStack) -> GigeCamera:
    power_on = {
        reg.WIDTH: 64,
        reg.HEIGHT: 16,
        reg.FRAME_RATE: 100.0,
        reg.TEST_PATTERN: int(TestPattern.GREY_HORIZONTAL_RAMP),
    }
    return stage.enter_context(closing(GigeCamera(ADDRESS, power_on=power_on)))


def test_the_order_of_pixels_can_be_chosen_and_looked_up(
    camera: GigeCamera, stage: ExitStack, monkeypatch: pytest.MonkeyPatch
) -> None:
    little = first_frame(stage).raw()
    assert little[0, 0] < little[0, 40] < little[0, 63]
    assert np.array_equal(first_frame(stage, "?pixels=big").raw(), little.byteswap())
    row = KnownCamera(Quirk.BIG_ENDIAN_PIXELS, "grabbergui", "Simulated*", "this test")
    monkeypatch.setattr(quirks, "KNOWN_CAMERAS", (*quirks.KNOWN_CAMERAS, row))
    assert np.array_equal(first_frame(stage).raw(), little.byteswap())
    assert np.array_equal(first_frame(stage, "?pixels=little").raw(), little)


@pytest.mark.parametrize(("feature", "big"), [("Big", True), ("Little", False)])
def test_the_order_of_pixels_may_be_a_feature_without_the_bit_in_scps(
    camera: GigeCamera, stage: ExitStack, monkeypatch: pytest.MonkeyPatch, feature: str, big: bool
) -> None:
    little, read = first_frame(stage).raw(), acquisition._value_of
    monkeypatch.setattr(
        acquisition,
        "_value_of",
        lambda nodes, name: feature if name == acquisition.PIXEL_ORDER else read(nodes, name),
    )
    assert np.array_equal(first_frame(stage).raw(), little.byteswap() if big else little)


def test_cameras_that_others_saw_are_listed() -> None:
    assert known(Quirk.BIG_ENDIAN_PIXELS, "Point Grey Research", "Blackfly BFLY-PGE-31S4M")
    assert known(Quirk.BIG_ENDIAN_PIXELS, "FLIR", "A320G")
    assert not known(Quirk.BIG_ENDIAN_PIXELS, "FLIR", "Blackfly S BFS-PGE-13Y3M")


def test_a_payload_size_that_is_too_small_is_named_with_the_remedy(caplog: pytest.LogCaptureFixture) -> None:
    assembler = BlockAssembler(STRIDE, 150, lambda: np.zeros(150, np.uint8))
    for datagram in datagrams(1, 1000, 1):
        assembler.receive(datagram, 0.0)
    assert not list(assembler.finished())
    assert "PayloadSize is 150 bytes" in caplog.text and "payload_size=200" in caplog.text


def test_the_option_overrides_it(
    camera: GigeCamera, stage: ExitStack, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("grabbergui.driver.acquisition.payload_size", lambda nodes: 100)
    assert first_frame(stage, "?payload_size=2048").complete
