"""Images that others sent as files: what their headers announce, and what is refused unread."""

import struct
import tracemalloc
import zlib

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grabbergui.core import encoded_image
from grabbergui.core.errors import PixelFormatError, RemoteProtocolError

IMAGE = np.arange(21 * 13 * 3, dtype=np.uint16).astype(np.uint8).reshape(13, 21, 3)
KINDS = (".png", ".jpg", ".bmp", ".tiff")


def encoded(kind, *parameters):
    return cv2.imencode(kind, IMAGE, parameters)[1].reshape(-1)


def png_of(width, height):
    header = b"IHDR" + struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    pixels = b"IDAT" + zlib.compress(bytes(1000))
    parts = (header, pixels, b"IEND")
    chunks = (struct.pack(">I", len(p) - 4) + p + struct.pack(">I", zlib.crc32(p)) for p in parts)
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)


def jpeg_of(width, height):
    file = encoded(".jpg").tobytes()
    at = file.index(b"\xff\xc0")
    return file[: at + 5] + struct.pack(">HH", height, width) + file[at + 9 :]


def bmp_of(width, height):
    file = encoded(".bmp").tobytes()
    return file[:18] + struct.pack("<ii", width, height) + file[26:]


@pytest.mark.parametrize("kind", [*KINDS[:3], ".progressive"])
def test_headers_announce_the_size(kind):
    progressive = kind == ".progressive"
    file = encoded(".jpg", cv2.IMWRITE_JPEG_PROGRESSIVE, 1) if progressive else encoded(kind)
    assert encoded_image.announced_size(file.tobytes()) == (21, 13)


@pytest.mark.parametrize("kind", KINDS)
def test_images_are_decoded(kind):
    image = encoded_image.decode(encoded(kind))
    assert image.shape == IMAGE.shape
    assert kind == ".jpg" or np.array_equal(image, IMAGE)


@pytest.mark.parametrize(
    ("file", "size"),
    [
        (png_of(30000, 30000), "30000×30000"),
        (png_of(2**32 - 1, 1), "4294967295×1"),
        (jpeg_of(65500, 65500), "65500×65500"),
        (bmp_of(20000, -20000), "20000×20000"),
    ],
)
def test_a_file_that_announces_too_large_an_image_is_refused_before_memory_is_allocated(file, size):
    tracemalloc.start()
    try:
        with pytest.raises(RemoteProtocolError, match=size):
            encoded_image.decode(np.frombuffer(file, np.uint8))
        assert tracemalloc.get_traced_memory()[1] < 1 << 20
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(
    ("width", "height", "reason"),
    [
        (30000, 30000, "announces 30000×30000 pixels; at most 268435456 in all"),
        (0, 480, "announces 0×480 pixels, so it is empty"),
    ],
)
def test_a_camera_image_whose_size_cannot_be_decoded_is_refused_with_the_reason(width, height, reason):
    with pytest.raises(PixelFormatError, match=reason):
        encoded_image.jpeg_header(jpeg_of(width, height))


def test_a_camera_image_with_too_long_a_side_is_refused_with_the_reason():
    size = struct.pack(">IIII", 70000, 10, 0, 0)
    header = b"\xff\x4f\xff\x51" + bytes(4) + size + bytes(16) + struct.pack(">HB", 1, 7) + bytes(4)
    with pytest.raises(PixelFormatError, match="announces 70000×10 pixels; a side has at most 65536"):
        encoded_image.jpeg2000_header(header)


@pytest.mark.parametrize("chunk", [b"IDAT", b"tEXt", b"IEND"])
def test_a_png_whose_chunk_announces_more_than_the_file_has_is_refused_at_once(chunk):
    file = bytearray(encoded(".png").tobytes())
    at = file.index(b"IDAT")
    file[at - 4 : at] = b"\xff\xff\xff\xf0"
    file[at : at + 4] = chunk
    with pytest.raises(RemoteProtocolError, match="of a PNG image that was cut short"):
        encoded_image.decode(np.frombuffer(bytes(file), np.uint8))


def test_the_size_of_a_jpeg_is_found_after_fill_bytes_and_comments():
    file = encoded(".jpg").tobytes()
    more = b"\xff\xd8" + b"\xff\xff\xff\xfe" + struct.pack(">H", 2 + 300) + bytes(300) + file[2:]
    assert encoded_image.announced_size(more) == (21, 13)


@pytest.mark.parametrize("kind", KINDS)
def test_a_truncated_file_is_refused_or_decoded_in_part(kind):
    file = encoded(kind)
    for length in range(0, file.size, 7):
        try:
            image = encoded_image.decode(file[:length])
        except RemoteProtocolError:
            continue
        assert image.shape == IMAGE.shape


BEGINNINGS = (b"", b"\xff\xd8", b"\xff\xd8\xff\xc0", b"\x89PNG\r\n\x1a\n", b"BM")


@given(st.sampled_from(BEGINNINGS), st.binary(max_size=60))
def test_any_bytes_have_a_size_or_none(begin, rest):
    size = encoded_image.announced_size(begin + rest)
    assert size is None or min(size) >= 0


def test_a_header_is_enough_and_less_is_not():
    for kind, size in ((".png", 24), (".bmp", 26)):
        file = encoded(kind).tobytes()
        assert encoded_image.announced_size(file[:size]) == (21, 13)
        assert encoded_image.announced_size(file[: size - 1]) is None
    assert encoded_image.announced_size(bmp_of(21, -13)) == (21, 13)


def tiff_of(width, height, order, big):
    """The head and the first page of a TIFF or BigTIFF, which has more before the two sides."""
    head = struct.pack(f"{order}HHHQ", 43, 8, 0, 16) if big else struct.pack(f"{order}HI", 42, 8)
    entries = b""
    for tag, value in ((254, 0), (256, width), (257, height)):
        entries += struct.pack(f"{order}HHQQ" if big else f"{order}HHII", tag, 4, 1, 0)[: 12 if big else 8]
        entries += struct.pack(f"{order}I", value) + bytes(4 if big else 0)
    count = struct.pack(f"{order}Q" if big else f"{order}H", 3)
    return {"<": b"II", ">": b"MM"}[order] + head + count + entries


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("big", [False, True])
def test_the_size_of_a_tiff_is_found_in_its_first_page(order, big):
    file = tiff_of(300, 200, order, big)
    assert encoded_image.announced_size(file) == (300, 200)
    assert encoded_image.announced_size(file[:-9]) is None


@pytest.mark.parametrize(
    ("components", "depth", "name"),
    [(1, 8, "Mono8"), (1, 12, "Mono12"), (1, 9, "Mono16"), (3, 8, "BGR8"), (3, 9, "BGR16")],
)
def test_a_jpeg_2000_image_has_the_format_of_its_samples(components, depth, name):
    size = struct.pack(">HHH8IHBBB", 0xFF51, 41, 0, 110, 60, 10, 10, 8, 8, 0, 0, components, depth - 1, 1, 1)
    file = b"box" + b"\xff\x4f" + size + b"\xff\x4f\xff\x51" + bytes(50)
    header = encoded_image.jpeg2000_header(file)
    assert (header.width, header.height, header.pixel_format.name) == (100, 50, name)
