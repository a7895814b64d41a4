"""Chunks behind images: the layout alone, and through the whole driver on the simulated camera's wire."""

import os

import pytest

from grabbergui import sources
from grabbergui.driver import acquisition
from grabbergui.driver.sim.gige.server import GigeCamera
from patience import PATIENCE


@pytest.fixture
def camera():
    """Ours on the wire, opened through the whole driver."""
    address = f"127.81.{os.getpid() % 250 + 1}.1"
    simulated = GigeCamera(address)
    grabber = sources.create(f"gige:{address}")
    try:
        grabber.open()
        grabber.write_feature("Width", 320)
        grabber.write_feature("Height", 240)
        yield grabber
    finally:
        grabber.close()
        simulated.close()


def test_frames_of_a_gige_camera_carry_their_chunks(camera):
    camera.write_feature("ExposureTime", 1500)
    camera.write_feature("ChunkModeActive", True)
    for chunk in ("FrameID", "Timestamp", "ExposureTime", "Gain"):
        camera.write_feature("ChunkSelector", chunk)
        camera.write_feature("ChunkEnable", True)
    queue = camera.open_queue()
    camera.start()
    frame = queue.get(PATIENCE)
    assert frame.raw().shape == (240, 320)
    assert frame.chunks["ChunkExposureTime"] == pytest.approx(1500)
    assert frame.chunks["ChunkTimestamp"] == frame.timestamp_ns
    assert frame.chunks.keys() == {"ChunkFrameID", "ChunkTimestamp", "ChunkExposureTime", "ChunkGain"}
    first = frame.chunks["ChunkFrameID"]
    assert queue.get(PATIENCE).chunks["ChunkFrameID"] > first


def test_a_stream_that_starts_again_does_not_parse_the_description_again(camera, monkeypatch):
    camera.write_feature("ChunkModeActive", True)
    queue = camera.open_queue()
    camera.start()
    assert queue.get(PATIENCE).chunks
    monkeypatch.setattr(acquisition, "ChunkReader", None)
    camera.write_feature("Width", 160)
    queue.clear()
    assert queue.get(PATIENCE).chunks


def test_only_enabled_chunks_come_and_none_once_they_are_off(camera):
    camera.write_feature("ChunkModeActive", True)
    camera.write_feature("ChunkSelector", "Gain")
    camera.write_feature("ChunkEnable", True)
    queue = camera.open_queue()
    camera.start()
    assert "ChunkGain" in queue.get(PATIENCE).chunks
    camera.write_feature("ChunkModeActive", False)  # while streaming: the stream starts again
    assert queue.get(PATIENCE).chunks == {}
