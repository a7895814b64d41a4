"""Every payload over the loopback, with losses and resends, from the simulated camera to the driver."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator
from contextlib import ExitStack, closing
from dataclasses import replace

import av
import cv2
import numpy as np
import pytest

from grabbergui import sources
from grabbergui.core.component import ComponentKind, PayloadType
from grabbergui.core.errors import PixelFormatError
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import FrameGrabber
from grabbergui.driver import gendc
from grabbergui.driver.gige.gvsp import (
    Leader,
)
from grabbergui.driver.gige.packet_header import PacketHeader
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.contents import FILE_NAME, range_image
from grabbergui.driver.sim.enumerations import TestPattern
from grabbergui.driver.sim.gige.faults import GigeFaults
from grabbergui.driver.sim.gige.packets import FramePackets
from grabbergui.driver.sim.gige.server import GigeCamera
from grabbergui.driver.sim.model import CameraModel
from grabbergui.driver.sim.settings import settings_of
from patience import PATIENCE

WIDTH, HEIGHT = 256, 128
RAMP = np.tile(np.arange(256, dtype=np.uint8), (HEIGHT, 1))
SMALL = {
    reg.WIDTH: WIDTH,
    reg.HEIGHT: HEIGHT,
    reg.FRAME_RATE: 50.0,
    reg.EXPOSURE_TIME: 1000.0,
    reg.TEST_PATTERN: int(TestPattern.GREY_HORIZONTAL_RAMP),
}
LOSSES = [GigeFaults(), GigeFaults(loss=0.08, reorder=True, duplicate=True)]
_numbers = itertools.count(1)


@pytest.fixture
def stage() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


def receive(stage: ExitStack, faults: GigeFaults, count: int = 4, **features: object) -> list[Frame]:
    """Return the first complete frames of a camera with these features; `Range=True` enables a component."""
    address = f"127.21.{os.getpid() % 250 + 1}.{next(_numbers)}"
    stage.enter_context(closing(GigeCamera(address, power_on=SMALL, faults=faults)))
    grabber: FrameGrabber = stage.enter_context(closing(sources.create(f"gige:{address}")))
    grabber.open()
    for name, value in features.items():
        if name in ("Range", "Confidence"):
            grabber.write_feature("ComponentSelector", name)
            name = "ComponentEnable"
        grabber.write_feature(name, value)
    queue = stage.enter_context(closing(grabber.open_queue(count)))
    grabber.start()
    frames = [queue.get(PATIENCE) for _ in range(count)]
    assert all(frame.complete for frame in frames)
    statistics = grabber.statistics()
    # Without losses none; with them, a busy machine may answer a request later than a block is waited for.
    assert statistics.incomplete <= (2 if faults.loss else 0)
    assert faults.loss == 0 or statistics.packets_resent
    grabber.stop()
    return frames


@pytest.mark.parametrize("faults", LOSSES, ids=["clean", "lossy"])
def test_images_with_the_height_in_the_trailer(stage: ExitStack, faults: GigeFaults) -> None:
    for frame in receive(stage, replace(faults, height_in_trailer=True)):
        assert (frame.width, frame.height) == (WIDTH, HEIGHT)
        assert np.array_equal(frame.raw(), RAMP)


@pytest.mark.parametrize("faults", LOSSES, ids=["clean", "lossy"])
@pytest.mark.parametrize("kind", ["RawData", "File"])
def test_raw_data_and_files(stage: ExitStack, faults: GigeFaults, kind: str) -> None:
    for frame in receive(stage, faults, PayloadType=kind):
        assert frame.payload_type is (PayloadType.FILE if kind == "File" else PayloadType.RAW_DATA)
        assert frame.payload.tobytes() == RAMP.tobytes()
        assert frame.file_name == (FILE_NAME if kind == "File" else "")
        assert not frame.components
        with pytest.raises(PixelFormatError, match=f"no image: .*{frame.payload_type.value}"):
            frame.rgb()


@pytest.mark.parametrize("faults", LOSSES, ids=["clean", "lossy"])
def test_chunks_without_an_image_are_received(stage: ExitStack, faults: GigeFaults) -> None:
    for frame in receive(stage, faults, 30, ChunkModeActive=True, PayloadType="ChunkOnly"):
        assert frame.payload_type is PayloadType.CHUNK
        assert frame.chunks["ChunkFrameID"] == frame.frame_id
        assert frame.chunks["ChunkExposureTime"] == 1000.0


@pytest.mark.parametrize("faults", LOSSES, ids=["clean", "lossy"])
@pytest.mark.parametrize("pixel_format", ["Mono8", "RGB8"])
@pytest.mark.parametrize("kind", [PayloadType.JPEG, PayloadType.JPEG2000])
def test_compressed_images_are_decoded_to_what_was_sent(
    stage: ExitStack, faults: GigeFaults, kind: PayloadType, pixel_format: str
) -> None:
    features = {"PixelFormat": pixel_format, "ImageCompressionMode": kind.name, "ChunkModeActive": True}
    for frame in receive(stage, faults, 30, **features):
        assert frame.payload_type is kind
        assert frame.chunks["ChunkFrameID"] == frame.frame_id
        (component,) = frame.components
        expected = cv2.imdecode(component.data, cv2.IMREAD_UNCHANGED)
        assert np.array_equal(frame.raw(), expected)
        assert np.array_equal(component.raw(), expected)
        assert np.abs(frame.mono().astype(int) - RAMP).mean() < 8


@pytest.mark.parametrize("faults", LOSSES, ids=["clean", "lossy"])
def test_h264_as_pyav_decodes_it(stage: ExitStack, faults: GigeFaults) -> None:
    frames = receive(stage, faults, 16, ImageCompressionMode="H264")
    peer = av.CodecContext.create("h264", "r")
    decoded = [image for frame in frames for image in peer.decode(av.Packet(frame.parts[0].data.tobytes()))]
    expected = [image.to_ndarray(format="rgb24") for image in (*decoded, *peer.decode(None))]
    assert len(expected) == len(frames)
    for index in (15, 10, 12, 11):  # forwards from key frames, and back
        frame = frames[index]
        assert frame.payload_type is PayloadType.H264 and frame.timestamp_ns
        assert np.array_equal(frame.raw(), expected[index])
        assert np.abs(frame.mono().astype(int) - RAMP).mean() < 8


@pytest.mark.parametrize("faults", LOSSES, ids=["clean", "lossy"])
@pytest.mark.parametrize("chunks", [False, True], ids=["", "chunks"])
@pytest.mark.parametrize("ids", ["Off", "On"], ids=["16-bit", "64-bit"])
@pytest.mark.parametrize("kind", [PayloadType.MULTI_PART, PayloadType.GENDC])
def test_every_component_of_a_frame_is_received(
    stage: ExitStack, faults: GigeFaults, kind: PayloadType, ids: str, chunks: bool
) -> None:
    features: dict[str, object] = {"GevGVSPExtendedIDMode": ids}
    features |= {"Range": True, "Confidence": True, "ChunkModeActive": chunks}
    if kind is PayloadType.GENDC:
        features["GenDCStreamingMode"] = "On"
    for frame in receive(stage, faults, **features):
        assert frame.payload_type is kind
        intensity, distance, confidence = frame.components
        kinds = [component.kind for component in frame.components]
        assert kinds == [ComponentKind.INTENSITY, ComponentKind.RANGE, ComponentKind.CONFIDENCE]
        assert np.array_equal(frame.raw(), RAMP) and np.array_equal(intensity.raw(), RAMP)
        expected = range_image(settings_of(CameraModel(power_on=SMALL).memory), frame.frame_id)
        assert np.array_equal(distance.raw(), expected)
        assert np.array_equal(confidence.data.reshape(HEIGHT, WIDTH), (expected > 0) * np.uint8(255))
        assert np.shares_memory(distance.data, distance.raw())
        assert ("ChunkFrameID" in frame.chunks) is chunks
        if chunks:
            assert frame.chunks["ChunkFrameID"] == frame.frame_id


def test_a_container_as_gendc_python_reads_it(stage: ExitStack) -> None:
    peer = pytest.importorskip("gendc_python.gendc_separator.descriptor", reason="gendc-python is missing")
    (frame,) = receive(stage, GigeFaults(), 1, GenDCStreamingMode="On", Range=True, Confidence=True)
    intensity = frame.components[0]
    base = intensity.data.base
    while getattr(base, "base", None) is not None and isinstance(base.base, np.ndarray):
        base = base.base
    whole = np.asarray(memoryview(base)).view(np.uint8).reshape(-1).tobytes()
    theirs, ours = peer.Container(whole), gendc.Container.decode(whole)
    assert theirs.get_component_count() == len(ours.components) == 3
    assert theirs.get_descriptor_size() == ours.descriptor_size
    assert theirs.get_container_size() == ours.descriptor_size + ours.data_size
    for index, component in enumerate(frame.components):
        header = theirs.get_component_by_index(index)
        part = header.get_part_by_index(0)
        assert (header.get_type_id(), header.get("Format")) == (component.kind, component.pixel_format.code)
        assert part.get_dimension() == [component.width, component.height]
        assert part.get_data() == component.data.tobytes()


def test_the_leaders_header_counts_the_parts() -> None:
    """With 64-bit ids; Aravis reads no part without it."""
    model = CameraModel(power_on=SMALL | dict.fromkeys(reg.COMPONENT_ENABLE, 1))
    model.write(reg.ACQUISITION_START.address, (1).to_bytes(4, "big"))
    plan = model.next_frame(PATIENCE)
    assert plan is not None
    block = FramePackets(plan, np.zeros(plan.payload_bytes, np.uint8), 1500, extended=True)
    header = PacketHeader.decode(block.leader())
    assert (header.parts, len(Leader.decode(block.leader()[header.size :]).parts)) == (3, 3)
