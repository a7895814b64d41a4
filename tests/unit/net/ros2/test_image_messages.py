"""Images as they come over ROS, and how one differs from the next; without ROS."""

import re
import time
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from every_case import every_case
from grabbergui.core import pfnc
from grabbergui.core.errors import PixelFormatError
from grabbergui.core.frame import Frame
from grabbergui.core.ros_encodings import FORMATS
from grabbergui.net.ros2 import compressed_images
from grabbergui.net.ros2.client_stream import ImageStream
from grabbergui.net.ros2.image_messages import (
    Continuity,
    encoding_of,
    frame_of,
    pixels_of,
)
from pixel_formats import CONVERTIBLE

NOW = "now"


def image(width=4, height=2, encoding="mono8", step=8, data=bytes(16), stamp=NOW, big_endian=0):
    seconds = time.time() if stamp is NOW else stamp
    header = SimpleNamespace(stamp=SimpleNamespace(sec=int(seconds), nanosec=int(seconds % 1 * 1e9)))
    return SimpleNamespace(
        header=header,
        width=width,
        height=height,
        encoding=encoding,
        step=step,
        data=data,
        is_bigendian=big_endian,
    )


def test_a_frame_looks_into_the_message():
    frame = frame_of(image(data=bytes(range(16))), 7)

    assert frame.raw().tolist() == [[0, 1, 2, 3], [8, 9, 10, 11]]
    assert (frame.frame_id, frame.padding_x) == (7, 4)


def test_big_endian_pixels_are_swapped():
    frame = frame_of(image(1, 2, "mono16", 2, b"\x01\x02\x03\x04", big_endian=1), 1)

    assert frame.raw().tolist() == [[0x0102], [0x0304]]


def test_a_stamp_of_our_clock_is_the_time_of_exposure():
    frame = frame_of(image(stamp=time.time() - 0.5), 1)

    assert frame.received_ns == frame.timestamp_ns < time.time_ns() - 4e8


@pytest.mark.parametrize("stamp", [0, 5, 4e9])
def test_a_stamp_of_another_clock_is_not(stamp):
    before = time.time_ns()
    frame = frame_of(image(stamp=stamp), 1)

    assert frame.timestamp_ns == stamp * 1e9 and before <= frame.received_ns <= time.time_ns()


@pytest.mark.parametrize(
    "wrong", [{"width": 9}, {"height": 3}, {"width": 0}, {"height": 0}, {"step": 3}, {"data": b""}]
)
def test_contradictory_messages_are_refused(wrong):
    with pytest.raises(PixelFormatError, match="contradicts itself"):
        frame_of(image(**wrong), 1)


@given(
    st.integers(0, 2**32 - 1),
    st.integers(0, 2**32 - 1),
    st.one_of(st.sampled_from(sorted(FORMATS)), st.text(max_size=8)),
    st.integers(0, 2**32 - 1),
    st.binary(max_size=64),
)
def test_no_message_does_more_harm_than_being_refused(width, height, encoding, step, data):
    try:
        frame = frame_of(image(width, height, encoding, step, data), 1)
    except PixelFormatError:
        return
    assert frame.raw().shape[:2] == (height, width)


@pytest.mark.parametrize(
    ("encoding", "size", "name"),
    [("nv12", 12, "YUV422_8"), ("nv21", 12, "YUV422_8"), ("nv24", 24, "YUV8_UYV"), ("i420", 12, "YUV422_8")],
)
def test_subsampled_colour_is_shown(encoding, size, name):
    """As v4l2_camera and Jetson's cameras publish it: V is high, so it is red."""
    luma, u, v = [128] * 8, 128, 200
    pairs = {"nv12": [u, v] * 2, "nv21": [v, u] * 2, "nv24": [u, v] * 8, "i420": [u, u, v, v]}[encoding]
    frame = frame_of(image(4, 2, encoding, 4, bytes(luma + pairs)), 1)
    assert len(luma + pairs) == size and frame.pixel_format.name == name
    red, green, blue = frame.rgb()[0, 0].astype(int)
    assert red > blue + 50 > green


def compressed_message():
    header = SimpleNamespace(stamp=SimpleNamespace(sec=0, nanosec=0))
    return SimpleNamespace(header=header, format="", data=b"")


@pytest.mark.parametrize(
    "name", ["Mono8", "Mono12", "Mono16", "BayerRG8", "BayerGB16", "RGB8", "BGRa8", "RGB16"]
)
def test_png_keeps_every_bit(name):
    pixel_format = pfnc.by_name(name)
    payload = np.random.default_rng(1).integers(0, 16, pixel_format.image_bytes(8, 6), np.uint8)
    frame, message = Frame(payload, 8, 6, pixel_format), compressed_message()
    compressed_images.fill_png(message, frame, 3)

    again = compressed_images.frame_of_compressed(message, 1)
    if pixel_format.family.name == "RGB":
        assert np.array_equal(again.rgb(), frame.rgb())
    else:
        assert np.array_equal(again.raw(), frame.raw())
    described, _, how = message.format.partition("; ")
    assert how == f"png compressed {described}"


@pytest.mark.parametrize(("name", "mode"), [("Mono16", "mono8"), ("BayerRG8", "bgr8"), ("RGB8", "bgr8")])
def test_jpeg_has_eight_bits(name, mode):
    pixel_format = pfnc.by_name(name)
    payload = np.full(pixel_format.image_bytes(16, 16), 100, np.uint8)
    message = compressed_message()
    compressed_images.fill_jpeg(message, Frame(payload, 16, 16, pixel_format), 90)
    assert message.format == f"{mode}; jpeg compressed {mode}"
    again = compressed_images.frame_of_compressed(message, 1)
    assert np.abs(again.rgb().astype(int) - 100).max() < 5


def test_distances_are_finest_nearby():
    """The plug-in's own formula: a quantum of inverse depth is a / z² per metre."""
    metres = np.array([[0.5, 1, 2, 5], [9.9, 10.5, 0, np.nan]], "<f4")
    frame = Frame(metres.reshape(-1).view(np.uint8), 4, 2, pfnc.by_name("Coord3D_C32f"))
    message = compressed_message()
    assert compressed_images.is_depth(frame)
    compressed_images.fill_depth(message, frame, 3)
    assert message.format == "32FC1; compressedDepth png"

    again = compressed_images.frame_of_compressed(message, 1).raw()
    assert np.isnan(again[1, 1:]).all(), "beyond 10 m, or not measured"
    seen = again.ravel()[:5]
    assert np.all(np.abs(seen - metres.ravel()[:5]) <= metres.ravel()[:5] ** 2 / 10_100 + 1e-6)
    assert bytes(message.data[:4]) == bytes(4) and bytes(message.data[12:16]) == b"\x89PNG"


def test_continuous_images_cause_no_report():
    continuity = Continuity()

    assert [continuity.remarks(frame_of(image(), number)) for number in range(3)] == [{}, {}, {}]


def test_a_change_of_size_or_format():
    continuity = Continuity()
    continuity.remarks(frame_of(image(), 1))

    assert continuity.remarks(frame_of(image(2), 2)) == {
        "layout": "images are 2×2 Mono8 now, they were 4×2 Mono8"
    }
    assert "BayerRG8" in continuity.remarks(frame_of(image(2, encoding="bayer_rggb8"), 3))["layout"]


def test_a_clock_that_jumps():
    continuity = Continuity()
    continuity.remarks(frame_of(image(stamp=1000.0), 1))

    assert "back by 400 s" in continuity.remarks(frame_of(image(stamp=600.0), 2))["jump"]
    assert continuity.remarks(frame_of(image(stamp=601.0), 3)) == {}


def test_a_foreign_clock_is_reported_once():
    continuity = Continuity()
    ahead = time.time() + 3600

    assert "60 min ahead" in continuity.remarks(frame_of(image(stamp=ahead), 1))["clock"]
    assert continuity.remarks(frame_of(image(stamp=ahead + 1), 2)) == {}


def test_no_stamps_at_all_are_no_remark():
    continuity = Continuity()

    assert [continuity.remarks(frame_of(image(stamp=0), number)) for number in range(2)] == [{}, {}]


WITHOUT = {"Mono32", "Data32", "Data64", "Data64s"}
"Formats that no encoding of ROS holds."
CHANNELS = {"mono": 1, "bayer": 1, "rgb": 3, "bgr": 3, "rgba": 4, "bgra": 4, "yuv": 2}


@every_case("pixel_format", [f for f in CONVERTIBLE if f.name not in WITHOUT], ids=str)
def test_pixels_are_what_their_encoding_says(pixel_format):
    payload = np.zeros(pixel_format.image_bytes(8, 4), np.uint8)
    pixels, encoding = pixels_of(Frame(payload, 8, 4, pixel_format)), encoding_of(pixel_format)
    if generic := re.fullmatch(r"(\d+)([USF])C(\d)", encoding):
        bits, kind, channels = int(generic[1]), {"U": "u", "S": "i", "F": "f"}[generic[2]], int(generic[3])
    else:
        bits, kind = 16 if encoding.endswith("16") else 8, "u"
        channels = CHANNELS[re.match("[a-z]+", encoding)[0]]
    assert pixels.dtype == np.dtype(f"<{kind}{bits // 8}")
    assert pixels.shape == ((4, 8) if channels == 1 else (4, 8, channels))


def test_pixels_travel_without_a_copy_unless_packed():
    payload = np.arange(24, dtype=np.uint8)
    frame = Frame(payload, 4, 3, pfnc.by_name("Mono12"))

    assert np.shares_memory(pixels_of(frame), payload) and pixels_of(frame).dtype == "<u2"
    packed = Frame(payload[:18], 4, 3, pfnc.by_name("Mono12p"))
    assert pixels_of(packed).shape == (3, 4)


def test_a_format_without_encoding_is_named():
    for name in WITHOUT:
        with pytest.raises(PixelFormatError, match=name):
            encoding_of(pfnc.by_name(name))
    with pytest.raises(PixelFormatError, match="'64FC4' cannot be shown"):
        frame_of(image(encoding="64FC4"), 1)


def test_a_publisher_that_changes_its_odd_encoding_all_the_time_is_reported_once():
    notices = []
    stream = ImageStream(None, "/camera/image_raw", lambda frame: None, notices.append)
    for number in range(50):
        stream._on_image(image(encoding=f"odd{number}" + "x" * 1000), {})
    assert len(notices) == 1 and len(notices[0]) < 2000
    assert stream.statistics().incomplete == 50
