"""ROS's encodings become pixels of PFNC's formats."""

from __future__ import annotations

import struct
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from every_case import every_case
from grabbergui.core.errors import PixelFormatError
from grabbergui.core.ros_image import RosCompressedImage, RosImage
from grabbergui.core.ros_pictures import KNOWN, of_compressed, of_file, of_image


def image(
    encoding: str, width: int, height: int, data: bytes, *, step: int = 0, big_endian: bool = False
) -> RosImage:
    step = step or len(data) // height
    return RosImage(0, "cam", height, width, encoding, int(big_endian), step, data)


def test_lines_lose_their_padding() -> None:
    pixels, name, width, height = of_image(image("mono8", 3, 2, b"abc-def-"))
    assert (name, width, height) == ("Mono8", 3, 2)
    assert pixels.shape == (2, 3) and pixels.tobytes() == b"abcdef"


def test_samples_of_16_bits_become_little_endian() -> None:
    data = bytes.fromhex("0102 0304 ff 0506 0708 ff")
    for big_endian, expected in ((True, [0x0102, 0x0304]), (False, [0x0201, 0x0403])):
        pixels, name, *_ = of_image(image("mono16", 2, 2, data, step=5, big_endian=big_endian))
        assert name == "Mono16" and pixels.view("<u2")[0].tolist() == expected
    pixels, *_ = of_image(image("rgb8", 1, 1, b"abc", big_endian=True))
    assert pixels.tobytes() == b"abc", "the flag means nothing for bytes"


def test_signed_and_floating_samples_keep_their_values() -> None:
    for encoding, name, kind in (("16SC1", "Data16s", "i2"), ("32FC1", "Coord3D_C32f", "f4")):
        values = np.array([[-2.0, 3.0]], f">{kind}")
        pixels, found, *_ = of_image(image(encoding, 2, 1, values.tobytes(), big_endian=True))
        assert found == name and pixels.view(f"<{kind}").ravel().tolist() == [-2, 3]


def test_a_recorded_format_counts_more_than_the_encoding() -> None:
    packed = bytes(range(1, 7))  # four pixels of twelve bits
    pixels, name, width, height = of_image(image("8UC1", 4, 1, packed, big_endian=True), "Mono12p")
    assert (name, width, height, pixels.tobytes()) == ("Mono12p", 4, 1, packed)


@pytest.mark.parametrize(
    ("encoding", "chroma"),
    [("nv12", b"uvUV"), ("nv21", b"vuVU"), ("i420", b"uUvV"), ("iyuv", b"uUvV"), ("yuv420p", b"uUvV")],
)
def test_chroma_of_every_second_line_is_that_of_the_line_above(encoding: str, chroma: bytes) -> None:
    """A 4×2 image: two pairs of chroma for two lines of four."""
    pixels, name, width, height = of_image(image(encoding, 4, 2, b"abcdefgh" + chroma, step=4))
    assert (name, width, height) == ("YUV422_8", 4, 2)
    assert [bytes(line.ravel()) for line in pixels] == [b"aubvcUdV", b"eufvgUhV"]


@pytest.mark.parametrize(("encoding", "second"), [("nv12", b"wxWX"), ("i420", b"wWxX")])
def test_each_two_lines_have_chroma_of_their_own(encoding: str, second: bytes) -> None:
    planes = b"uUwWvVxX" if encoding == "i420" else b"uvUV" + second
    pixels, *_ = of_image(image(encoding, 4, 4, b"abcdefghijklmnop" + planes, step=4))
    lines = [b"aubvcUdV", b"eufvgUhV", b"iwjxkWlX", b"mwnxoWpX"]
    assert [bytes(line.ravel()) for line in pixels] == lines


def test_padding_of_subsampled_lines_is_skipped() -> None:
    data = b"ab--cd--uv--"
    pixels, *_ = of_image(image("nv12", 2, 2, data, step=4))
    assert pixels.tobytes() == b"aubvcudv"
    pixels, *_ = of_image(image("i420", 2, 2, b"ab--cd--u-v-", step=4))
    assert pixels.tobytes() == b"aubvcudv"


def test_chroma_of_every_pixel() -> None:
    pixels, name, width, height = of_image(image("nv24", 2, 2, b"abcd" + b"uvUVwxWX", step=2))
    assert (name, width, height) == ("YUV8_UYV", 2, 2)
    assert pixels.tobytes() == b"uavUbVwcxWdX"


def test_points_lose_their_fourth_value() -> None:
    values = np.arange(8, dtype=">f4")
    for order in (">", "<"):
        data = values.astype(f"{order}f4").tobytes()
        pixels, name, width, height = of_image(image("32FC4", 2, 1, data, big_endian=order == ">"))
        assert (name, width, height) == ("Coord3D_ABC32f", 2, 1)
        assert pixels.tolist() == [[[0, 1, 2], [4, 5, 6]]] and pixels.dtype == np.dtype("<f4")


def test_an_unknown_encoding_is_named_with_those_that_are_known() -> None:
    with pytest.raises(PixelFormatError) as failure:
        of_image(image("x" * 50, 1, 1, b"a"))
    known = f"known are {', '.join(KNOWN)}"
    assert str(failure.value) == f"images with the encoding '{'x' * 40}' cannot be shown; {known}"
    assert {"mono8", "bgr8", "bayer_rggb8", "nv21", "i420", "nv24", "32FC4"} <= set(KNOWN)


@pytest.mark.parametrize(
    ("encoding", "width", "height", "data", "step"),
    [
        ("mono8", 4, 1, b"abc", 3),
        ("mono8", 2, 2, b"abc", 2),
        ("mono8", 1, 0, b"abc", 1),
        ("mono8", 0, 1, b"abc", 1),
        ("nv12", 2, 2, b"abcdu", 2),
        ("i420", 2, 2, b"abcdu", 2),
        ("nv24", 2, 1, b"abuvu", 2),
        ("32FC4", 1, 1, bytes(15), 15),
    ],
)
def test_lines_that_are_not_there_are_refused(
    encoding: str, width: int, height: int, data: bytes, step: int
) -> None:
    with pytest.raises(
        PixelFormatError, match=f"^an image of {width}×{height} {encoding} in lines of {step} bytes"
    ):
        of_image(image(encoding, width, height, data, step=step))


@pytest.mark.parametrize("encoding", ["nv12", "nv21", "i420"])
@pytest.mark.parametrize(("width", "height"), [(3, 2), (2, 3)])
def test_subsampled_images_have_even_sides(encoding: str, width: int, height: int) -> None:
    with pytest.raises(PixelFormatError, match=f"{width}×{height} {encoding} needs even sides"):
        of_image(image(encoding, width, height, bytes(100), step=4))


def compressed(ending: str, pixels: NDArray[Any]) -> bytes:
    written, coded = cv2.imencode(ending, pixels)
    assert written
    return coded.tobytes()


GREY = np.arange(12, dtype=np.uint8).reshape(3, 4)
COLOUR = np.arange(36, dtype=np.uint8).reshape(3, 4, 3)


@every_case(
    ("described", "pixels", "name"),
    [
        ("png", GREY, "Mono8"),
        ("png", COLOUR, "BGR8"),
        ("mono8; png compressed mono8", GREY, "Mono8"),
        ("bayer_rggb8; png compressed bayer_rggb8", GREY, "BayerRG8"),
        ("bgr8; png compressed bgr8", COLOUR, "BGR8"),
        ("rgb8; png compressed bgr8", COLOUR, "BGR8"),
        ("rgb8; png compressed mono8", GREY, "Mono8"),
        ("16UC1; png compressed ", GREY.astype(np.uint16) * 300, "Coord3D_C16"),
        ("mono16; png compressed mono8", GREY, "Mono8"),
        ("16UC1; compressedDepth png", GREY.astype(np.uint16) * 300, "Coord3D_C16"),
    ],
)
def test_a_compressed_image_has_the_pixels_that_were_compressed(
    described: str, pixels: NDArray[Any], name: str
) -> None:
    head = bytes(12) if "compressedDepth" in described else b""
    message = RosCompressedImage(0, described, memoryview(head + compressed(".png", pixels)))
    found, found_name, width, height = of_compressed(message)
    assert np.array_equal(found, pixels) and (width, height) == (4, 3)
    assert found_name == name


def test_depth_in_metres_is_stored_inversely() -> None:
    """compressed_depth_image_transport: depth = a / (stored - b), and 0 where nothing was measured."""
    stored = np.array([[0, 110, 210]], np.uint16)
    data = struct.pack("<iff", 0, 100.0, 10.0) + compressed(".png", stored)
    pixels, name, width, height = of_compressed(
        RosCompressedImage(0, "32FC1; compressedDepth", memoryview(data))
    )
    assert (name, width, height, pixels.dtype) == ("Coord3D_C32f", 3, 1, np.float32)
    assert np.isnan(pixels[0, 0]) and pixels[0, 1:].tolist() == [1.0, 0.5]


def test_what_is_no_compressed_image_is_refused() -> None:
    for described, data, reason in (
        ("jpeg", b"no image", "a compressed image .'jpeg'.: "),
        ("32FC1; compressedDepth", bytes(11), "a compressed image .'32FC1; compressedDepth'.: only 11 bytes"),
    ):
        with pytest.raises(PixelFormatError, match=reason):
            of_compressed(RosCompressedImage(0, described, memoryview(data)))


def test_pixels_of_a_file_have_the_format_of_their_layout() -> None:
    for shape, kind, name in (
        ((2, 3), "u1", "Mono8"),
        ((2, 3, 1), "u1", "Mono8"),
        ((2, 3), "u2", "Mono16"),
        ((2, 3, 3), "u1", "BGR8"),
        ((2, 3, 3), "u2", "BGR16"),
        ((2, 3, 4), "u1", "BGRa8"),
        ((2, 3), "i2", "Data16s"),
        ((2, 3), "f4", "Coord3D_C32f"),
        ((2, 3), "f8", "Data64f"),
        ((2, 3, 2), "u1", ""),
        ((2, 3, 3), "f4", ""),
    ):
        assert of_file(np.zeros(shape, kind)) == name
