"""Components of frames: views of what arrived, decoded on demand; a frame without an image says so."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from grabbergui.core import encoded_image, pfnc
from grabbergui.core.component import Component, ComponentKind, PayloadType
from grabbergui.core.encoded_image import StillImage, StillImageHeader
from grabbergui.core.errors import PixelFormatError
from grabbergui.core.frame import BufferPool, EncodedFrame, Frame, FrameStatus

MONO8, MONO16 = pfnc.by_name("Mono8"), pfnc.by_name("Mono16")
JPEG_OF_4_BY_3 = StillImage("JPEG", StillImageHeader(4, 3, MONO8))
RANDOM = np.random.default_rng(3)


def test_a_plain_frame_is_its_only_component():
    frame = Frame(np.arange(12, dtype=np.uint8), 4, 3, MONO8, offset_x=7)
    (component,) = frame.components
    assert component.kind is ComponentKind.INTENSITY
    assert (component.width, component.height, component.offset_x) == (4, 3, 7)
    assert np.shares_memory(component.raw(), frame.payload)
    assert np.array_equal(component.rgb(), frame.rgb())


def test_the_parts_of_a_frame_look_into_its_block():
    block = np.arange(36, dtype=np.uint8)
    parts = (
        Component(block[:12], 4, 3, MONO8),
        Component(block[12:], 4, 3, MONO16, ComponentKind.RANGE, region=1, source=2, purpose=3),
    )
    frame = Frame(parts[0].data, 4, 3, MONO8, payload_type=PayloadType.MULTI_PART, parts=parts)
    assert frame.components == parts
    assert np.shares_memory(frame.components[1].raw(), block)
    assert frame.components[1].raw().dtype == np.uint16
    alone = frame.of_component(frame.components[1])
    assert np.array_equal(alone.raw(), parts[1].raw())
    assert (alone.frame_id, alone.captured) == (frame.frame_id, frame.captured)
    kept = frame.detached()
    block[:] = 0
    assert kept.raw()[0, 1] == 1
    assert kept.payload is kept.components[0].data
    assert kept.components[1].data[0] == 12


@pytest.mark.parametrize("encoding", [None, JPEG_OF_4_BY_3])
def test_a_detached_frame_with_chunk_data_keeps_no_buffer_of_the_stream(encoding):
    pool = BufferPool(36)
    block = pool.take()
    part = Component(block[:12], 4, 3, MONO8, encoding=encoding)
    frame = Frame(part.data, 4, 3, MONO8, parts=(part,), chunks={"ChunkGain": 1.0}, chunk_payload=block[12:])
    kept = (frame if encoding is None else EncodedFrame.of(frame, part)).detached()
    del block, part, frame
    assert pool.in_use == 0 and kept.chunks == {"ChunkGain": 1.0}


@pytest.mark.parametrize(
    ("kind", "content"),
    [
        (PayloadType.RAW_DATA, "raw data"),
        (PayloadType.FILE, "a file"),
        (PayloadType.CHUNK, "chunk data alone"),
        (PayloadType.JPEG2000, "a damaged JPEG 2000 image"),
        (PayloadType.H264, "H.264 video"),
    ],
)
def test_a_frame_without_an_image_says_what_it_is(kind, content):
    frame = Frame(np.zeros(100, np.uint8), 0, 0, pfnc.by_code(0), payload_type=kind)
    assert frame.components == ()
    with pytest.raises(
        PixelFormatError, match=f"no image: the camera sends {content} \\(100 bytes\\);.*PayloadType"
    ):
        frame.rgb()


def test_every_kind_of_payload_can_be_the_object_of_a_sentence():
    assert all(kind.as_object for kind in PayloadType)


def test_frames_are_described_in_a_line():
    half = Frame(np.zeros(12, np.uint8), 4, 3, MONO8, 7, status=FrameStatus.INCOMPLETE, missing_bytes=5)
    assert repr(half) == "<Frame 7: 4×3 Mono8, 12 bytes, 5 of them missing>"
    raw = Frame(np.zeros(100, np.uint8), 0, 0, pfnc.by_code(0), 8, payload_type=PayloadType.RAW_DATA)
    assert repr(raw) == "<Frame 8: raw data, 100 bytes>"
    damaged = Component(np.zeros(9, np.uint8), 4, 3, MONO8, ComponentKind.RANGE, encoding=JPEG_OF_4_BY_3)
    assert repr(damaged) == "<Component range: 4×3 Mono8>"
    parts = (damaged, Component(np.zeros(12, np.uint8), 4, 3, MONO8))
    assert repr(Frame(parts[1].data, 4, 3, MONO8, 9, parts=parts)) == (
        "<Frame 9: 4×3 Mono8 of 2 components, 12 bytes>"
    )
    encoded = EncodedFrame.of(Frame(damaged.data, 4, 3, MONO8, 10, parts=(damaged,)), damaged)
    assert repr(encoded) == "<Frame 10: 4×3 Mono8, 9 bytes>", "nothing is decoded for it"


def test_a_notebook_shows_the_image_of_a_frame():
    wide = Frame(np.full(2000 * 100, 128, np.uint8), 2000, 100, MONO8)
    shown = cv2.imdecode(np.frombuffer(wide._repr_jpeg_(), np.uint8), cv2.IMREAD_COLOR)
    assert shown.shape == (48, encoded_image.SHOWN_WIDTH, 3) and abs(int(shown[20, 20, 0]) - 128) < 3
    tall = Frame(np.full(8 * 131_000, 128, np.uint8), 8, 131_000, MONO8)
    shown = cv2.imdecode(np.frombuffer(tall._repr_jpeg_(), np.uint8), cv2.IMREAD_COLOR)
    assert shown.shape == (65_500, 4, 3), "of a line scan camera"
    damaged = Component(np.zeros(9, np.uint8), 4, 3, MONO8, encoding=JPEG_OF_4_BY_3)
    assert damaged._repr_jpeg_() is None
    assert Frame(np.zeros(9, np.uint8), 0, 0, pfnc.by_code(0))._repr_jpeg_() is None


IMAGES = [
    ("JPEG", ".jpg", (64, 96, 3), np.uint8, "BGR8"),
    ("JPEG", ".jpg", (64, 96), np.uint8, "Mono8"),
    ("JPEG 2000", ".jp2", (64, 96, 3), np.uint8, "BGR8"),
    ("JPEG 2000", ".jp2", (64, 96), np.uint8, "Mono8"),
    ("JPEG 2000", ".jp2", (64, 96), np.uint16, "Mono16"),
]


@pytest.mark.parametrize(("name", "suffix", "shape", "dtype", "pixel_format"), IMAGES)
def test_compressed_images_are_decoded_bit_for_bit_as_opencv_does(name, suffix, shape, dtype, pixel_format):
    values = RANDOM.integers(0, np.iinfo(dtype).max, shape).astype(dtype)
    data = np.asarray(cv2.imencode(suffix, values)[1]).reshape(-1)
    header = (encoded_image.jpeg_header if suffix == ".jpg" else encoded_image.jpeg2000_header)(
        data.tobytes()
    )
    assert (header.width, header.height, header.pixel_format.name) == (96, 64, pixel_format)
    part = Component(data, 96, 64, header.pixel_format, encoding=StillImage(name, header))
    frame = EncodedFrame.of(Frame(data, 96, 64, header.pixel_format, parts=(part,)), part)
    expected = cv2.imdecode(data, cv2.IMREAD_UNCHANGED)
    assert np.array_equal(frame.raw(), expected)
    assert np.array_equal(frame.components[0].raw(), expected)
    assert frame.nbytes == data.nbytes
    assert np.array_equal(frame.detached().raw(), expected)
    if expected.ndim == 3:
        assert np.array_equal(frame.rgb(), expected[:, :, ::-1])


@pytest.mark.parametrize("suffix", [".jpg", ".jp2"])
def test_damaged_images_are_refused_and_nothing_else(suffix):
    data = bytearray(np.asarray(cv2.imencode(suffix, np.zeros((64, 64), np.uint8))[1]).tobytes())
    read = encoded_image.jpeg_header if suffix == ".jpg" else encoded_image.jpeg2000_header
    header = read(bytes(data))
    for length in range(len(data)):
        cut = bytes(data[:length])
        try:
            read(cut)
        except PixelFormatError:
            continue
    for _ in range(100):
        damaged = np.frombuffer(bytes(data), np.uint8).copy()
        damaged[RANDOM.integers(0, len(damaged), 8)] = RANDOM.integers(0, 256, 8)
        try:
            StillImage("image", header).decode(damaged)
        except PixelFormatError as error:
            assert "image" in str(error)
    with pytest.raises(PixelFormatError, match="damaged"):
        StillImage("JPEG", header).decode(np.zeros(20, np.uint8))
