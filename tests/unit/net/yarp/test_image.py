from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from every_case import every_case
from grabbergui.core import pfnc
from grabbergui.core.errors import LocalProtocolError, RemoteProtocolError
from grabbergui.core.frame import Frame
from grabbergui.net.yarp import image
from grabbergui.net.yarp.grabber_image import Capability
from grabbergui.net.yarp.mjpeg import JpegStreamReader, decode_jpeg, encode_part, find_comment
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os.bottle import BLOB, INT32, LIST, VOCAB, Bottle
from grabbergui.net.yarp.os.stamp import Stamp
from grabbergui.net.yarp.os.values import Vocab
from yarp_transcripts import read


@every_case("code", image.CODES)
def test_every_code_round_trips_with_padding(code):
    pixel = image.CODES[code]
    for width, height in product(range(41), range(10)):
        shape = (height, width, pixel.channels) if pixel.channels > 1 else (height, width)
        pixels = np.arange(int(np.prod(shape)) or 1, dtype=pixel.dtype)[: int(np.prod(shape))].reshape(shape)
        header, body = image.encode(pixels, code)
        found, again = image.decode(header + bytes(body))
        assert found.code == code and again.dtype == pixels.dtype
        assert np.array_equal(again, pixels), (width, height)
        assert found.row_bytes % 8 == 0 and len(body) == found.row_bytes * height


def test_pixels_are_not_copied_where_rows_fit():
    pixels = np.zeros((4, 16, 3), np.uint8)
    _, body = image.encode(pixels, "rgb")
    assert np.shares_memory(np.frombuffer(body, np.uint8), pixels)
    message = bytearray(image.encode_header("rgb", 16, 4, 48) + bytes(192))
    assert np.shares_memory(image.decode(message)[1], np.frombuffer(message, np.uint8))


def test_an_image_is_a_bottle():
    header, body = image.encode(np.ones((2, 5, 3), np.uint8), "rgb")
    assert Bottle.decode(header + bytes(body))[1] == Vocab("rgb")
    assert image.to_bottle(header, body).encode() == header + bytes(body)


def test_the_quantum_word_has_no_high_half():
    header, _ = image.encode(np.zeros((2, 5), np.uint8), "mono")
    assert header[40:44] == bytes((8, 0, 0, 0))


@pytest.mark.parametrize(
    ("code", "order", "expected"),
    [
        ("mono", "bggr", "bggr"),
        ("mono", "grbg", "grbg"),
        ("mo16", "rggb", "rg16"),
        ("mo16", "gbrg", "gb16"),
        ("rgb", "bggr", "rgb"),
        ("bggr", "rggb", "bggr"),
    ],
)
@pytest.mark.parametrize("kind", [bytes, bytearray], ids=["read-only", "writable"])
def test_a_mono_image_becomes_a_bayer_pattern_and_no_other(code, order, expected, kind):
    pixel = image.CODES[code]
    shape = (4, 6) if pixel.channels == 1 else (4, 6, pixel.channels)
    pixels = np.arange(np.prod(shape), dtype=pixel.dtype).reshape(shape)
    header, body = image.encode(pixels, code)
    found, again = image.decode(image.as_bayer(memoryview(kind(header + bytes(body))), order))
    assert found.code == expected
    assert np.array_equal(again, pixels)


def test_a_bottle_is_no_bayer_pattern():
    message = memoryview(Bottle([1, "two"]).encode())
    assert image.as_bayer(message, "grbg") == message


@every_case("field", range(8, 15))
@every_case("value", [-1_000_000_000, -1, 2**31 - 1])
def test_absurd_sizes_are_refused(field, value):
    header, body = image.encode(np.zeros((4, 16, 3), np.uint8), "rgb")
    values = list(image.HEADER.unpack(header))
    values[field] = value
    broken = image.HEADER.pack(*values) + bytes(body)
    if field == 10 and value == -1:
        return  # a quantum of 65535 with the flag of 3.x; the sizes then decide what a row is
    with pytest.raises(RemoteProtocolError):
        image.decode(broken)


def test_pixels_of_no_bytes_are_refused_and_not_made_up():
    side = image.SIDE_LIMIT
    numbers = (*(0, 0, 8), *(side, side))
    start = (LIST, 4, VOCAB, Vocab("mat"), VOCAB, 12345, LIST + INT32, 5)
    with pytest.raises(RemoteProtocolError, match="pixels of no bytes"):
        image.decode(image.HEADER.pack(*start, *numbers, BLOB, 0))


@given(st.binary(max_size=80))
def test_random_bytes_are_refused(data):
    with pytest.raises(RemoteProtocolError):
        image.decode(data)


def test_arrays_that_fit_no_code_are_refused():
    with pytest.raises(LocalProtocolError, match="rgb"):
        image.encode(np.zeros((4, 4), np.uint8), "rgb")
    with pytest.raises(LocalProtocolError, match="no pixel code xyz"):
        image.encode(np.zeros((4, 4), np.uint8), "xyz")


@pytest.mark.parametrize(
    ("name", "code", "dtype"),
    [
        ("Mono8", "mono", np.uint8),
        ("Mono12p", "mo16", np.uint16),
        ("Mono8s", "mono", np.uint8),
        ("Coord3D_C32f", "mono", np.uint8),
        ("RGB16", "rgb", np.uint8),
        ("RGB8", "rgb", np.uint8),
    ],
)
def test_values_that_yarp_has_no_code_for_are_sent_as_they_are_shown(name, code, dtype):
    pixel_format = pfnc.by_name(name)
    payload = np.random.default_rng(1).integers(0, 120, pixel_format.image_bytes(8, 4), np.uint8)
    pixels, sent = Capability.RAW.pixels(Frame(payload, 8, 4, pixel_format))
    assert (sent, pixels.dtype) == (code, dtype)


def test_real_mjpeg_stream_in_pieces():
    conversation = next(c for c in read("stream_mjpeg_312") if c.client.startswith(b"GET /?ac"))
    assert conversation.client == wire.STREAM_REQUEST % b"127.0.0.1"
    assert conversation.server.startswith(wire.STREAM_RESPONSE)
    whole = JpegStreamReader().feed(conversation.server)
    reader = JpegStreamReader()
    assert [
        p for n in range(len(conversation.server)) for p in reader.feed(conversation.server[n : n + 1])
    ] == whole
    assert len(whole) >= 3
    for jpeg in whole:
        header, pixels, envelope = decode_jpeg(jpeg)
        assert image.ImageHeader.decode(header).width == 16 and len(pixels) == 576
        assert Stamp.decode(envelope)
        ours = b"".join(encode_part(header + bytes(pixels), envelope))
        (again,) = JpegStreamReader().feed(ours)
        assert find_comment(again) == envelope
        theirs = conversation.server
        assert ours[: ours.index(b"Length")] in theirs and ours.endswith(b"\r\n--boundarydonotcross\r\n")


def test_a_source_that_refuses_is_quoted():
    with pytest.raises(RemoteProtocolError, match="404 Not Found"):
        JpegStreamReader().feed(b"HTTP/1.0 404 Not Found\r\nContent-Length: 9\r\n\r\n")
