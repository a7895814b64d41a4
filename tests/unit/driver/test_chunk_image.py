"""Frames whose payload is chunks (type 4), with the image in one of them: a picture."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from fakes import XmlDevice
from grabbergui.core.component import PayloadType
from grabbergui.core.frame import Frame, FrameStatus
from grabbergui.core.pfnc import PixelFormat, by_name
from grabbergui.driver.chunk_image import take_image
from grabbergui.driver.device import DataLayout
from grabbergui.driver.device_grabber import DeviceGrabber
from patience import PATIENCE

WIDTH, HEIGHT = 6, 4
PIXELS = np.arange(WIDTH * HEIGHT, dtype=np.uint8)
HEAD = """<?xml version="1.0" encoding="utf-8"?>
<RegisterDescription xmlns="http://www.genicam.org/GenApi/Version_1_1" ModelName="V" VendorName="V"
 ToolTip="" StandardNameSpace="None" SchemaMajorVersion="1" SchemaMinorVersion="1" SchemaSubMinorVersion="0"
 MajorVersion="1" MinorVersion="0" SubMinorVersion="0" ProductGuid="1" VersionGuid="1">
<Port Name="Device"/>"""
FEATURES = (
    "ChunkModeActive ChunkWidth ChunkHeight ChunkPixelFormat AcquisitionStart AcquisitionStop PayloadSize"
)


def chunk(name: str, chunk_id: int) -> str:
    return (
        f'<IntReg Name="{name}"><Address>0</Address><Length>4</Length><AccessMode>RO</AccessMode>'
        f"<pPort>{name}Port</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>"
        f'<Port Name="{name}Port"><ChunkID>{chunk_id:X}</ChunkID></Port>'
    )


def command(name: str) -> str:
    return f'<Command Name="{name}"><Value>0</Value><CommandValue>1</CommandValue></Command>'


XML = (
    f'{HEAD}<Category Name="Root">{"".join(f"<pFeature>{name}</pFeature>" for name in FEATURES.split())}'
    '</Category><Boolean Name="ChunkModeActive"><Value>1</Value><OnValue>1</OnValue><OffValue>0</OffValue>'
    '</Boolean><Integer Name="PayloadSize"><Value>500</Value></Integer>'
    '<Enumeration Name="ChunkPixelFormat"><EnumEntry Name="Mono8"><Value>0x01080001</Value></EnumEntry>'
    '<EnumEntry Name="RGB8Packed"><Value>0x02180014</Value></EnumEntry><pValue>Format</pValue></Enumeration>'
    f"{command('AcquisitionStart')}{command('AcquisitionStop')}"
    f"{chunk('ChunkWidth', 0x11)}{chunk('ChunkHeight', 0x12)}{chunk('Format', 0x13)}</RegisterDescription>"
)


class Sender(XmlDevice):
    """Delivers what the test gives it."""

    chunk_layout = DataLayout.GIGE_VISION

    def open_stream(self, request, deliver):
        self.deliver = deliver

    def close_stream(self):
        pass


def payload_of(*chunks: tuple[int, bytes]) -> np.ndarray:
    laid_out = (data + struct.pack(">II", key, len(data)) for key, data in chunks)
    return np.frombuffer(b"".join(laid_out), np.uint8)


def number(chunk_id: int, value: int) -> tuple[int, bytes]:
    return chunk_id, value.to_bytes(4, "big")


def frame_of(payload: np.ndarray, **more) -> Frame:
    """Return a frame as the transports deliver chunk data: without size and format."""
    alone = PixelFormat(PayloadType.CHUNK.value, 0)
    return Frame(payload, 0, 0, alone, payload_type=PayloadType.CHUNK, chunk_payload=payload, **more)


@pytest.mark.parametrize(
    ("code", "name", "pixels"), [(0x01080001, "Mono8", PIXELS), (0x02180014, "RGB8", np.tile(PIXELS, 3))]
)
def test_the_image_in_a_chunk_is_the_frames_own(code, name, pixels):
    camera = DeviceGrabber(Sender(XML.encode()))
    camera.open()
    queue = camera.open_queue()
    try:
        camera.start()
        camera.device.deliver(
            frame_of(
                payload_of(
                    (0x10, pixels.tobytes()), number(0x11, WIDTH), number(0x12, HEIGHT), number(0x13, code)
                )
            )
        )
        frame = queue.get(PATIENCE)
    finally:
        queue.close()
        camera.close()

    assert frame.has_image
    assert (frame.width, frame.height, frame.pixel_format) == (WIDTH, HEIGHT, by_name(name))
    assert np.array_equal(frame.raw().reshape(-1), pixels)
    assert frame.chunks["ChunkWidth"] == WIDTH


SETTINGS = {"Width": WIDTH, "Height": HEIGHT, "PixelFormat": "Mono8"}


def test_what_no_chunk_says_is_as_the_camera_was_set():
    frame = frame_of(payload_of(number(1, 7), (2, PIXELS.tobytes())))

    assert take_image(frame, DataLayout.GIGE_VISION, SETTINGS)
    assert np.array_equal(frame.raw(), PIXELS.reshape(HEIGHT, WIDTH))


@pytest.mark.parametrize(
    ("payload", "settings"),
    [
        (payload_of(number(1, 7)), SETTINGS),
        (payload_of((2, PIXELS.tobytes())), {}),
        (payload_of((2, PIXELS.tobytes())), {**SETTINGS, "PixelFormat": "Mono8HB"}),
        (payload_of((2, PIXELS.tobytes())), {**SETTINGS, "Width": 1 << 40}),
        (payload_of((2, PIXELS.tobytes()))[1:], SETTINGS),
    ],
    ids=["no image", "no size", "unknown format", "larger than the payload", "damaged"],
)
def test_chunks_without_a_picture_stay_chunks(payload, settings):
    frame = frame_of(payload)

    assert not take_image(frame, DataLayout.GIGE_VISION, settings)
    assert (frame.has_image, frame.payload_type) == (False, PayloadType.CHUNK)


def test_an_incomplete_frame_is_left_alone():
    frame = frame_of(payload_of((2, PIXELS.tobytes())), status=FrameStatus.INCOMPLETE)
    assert not take_image(frame, DataLayout.GIGE_VISION, SETTINGS)
