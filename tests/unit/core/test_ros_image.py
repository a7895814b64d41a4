"""Messages of ROS as bytes (OMG CDR, XCDR1): both ways, in both byte orders, cut at every length."""

from __future__ import annotations

import struct
from dataclasses import replace

import pytest

from grabbergui.core.camera_info_message import CameraInfoFields, RegionFields
from grabbergui.core.errors import RemoteProtocolError
from grabbergui.core.ros_image import (
    CdrReader,
    RosCompressedImage,
    RosImage,
    decode_stamp,
    decode_string,
    decode_time_reference,
    encode_string,
    encode_time_reference,
    plain_topic,
)


def little(digits: str) -> bytes:
    return bytes.fromhex(f"00010000 {digits}")


# Seconds, nanoseconds, then "cam" with its count of four, the zero included.
HEAD = "00f15365 05000010 04000000 63616d00"
HEAD_BIG = "6553f100 10000005 00000004 63616d00"
NS = 1_700_000_000 * 10**9 + 0x10000005
IMAGE = RosImage(NS, "cam", 2, 3, "mono8", 0, 4, b"abc_def_")
IMAGE_BYTES = little(
    f"{HEAD} 02000000 03000000 06000000 6d6f6e6f3800 00 00 04000000 08000000 6162635f6465665f"
)


def test_the_bytes_of_an_image() -> None:
    assert IMAGE.encode() == IMAGE_BYTES
    read = RosImage.decode(IMAGE_BYTES)
    assert replace(read, data=bytes(read.data)) == IMAGE
    assert decode_stamp(IMAGE_BYTES) == NS
    marked = replace(IMAGE, is_bigendian=1, encoding="mono16", step=8, height=1)
    assert replace(RosImage.decode(marked.encode()), data=b"") == replace(marked, data=b"")


def test_an_image_of_a_big_endian_computer_is_read() -> None:
    digits = f"{HEAD_BIG} 00000002 00000003 00000006 6d6f6e6f3800 01 00 00000004 00000008 6162635f6465665f"
    read = RosImage.decode(bytes.fromhex(f"00000000 {digits}"))
    assert replace(read, data=bytes(read.data)) == replace(IMAGE, is_bigendian=1)


def test_a_message_that_is_cut_off_is_refused() -> None:
    for length in range(len(IMAGE_BYTES)):
        with pytest.raises(RemoteProtocolError, match=r"^a ROS message (ends|has only|without a CDR header)"):
            RosImage.decode(IMAGE_BYTES[:length])
    with pytest.raises(RemoteProtocolError, match="ends after 2 bytes, in a number"):
        CdrReader(little("0100")).number("I")
    with pytest.raises(RemoteProtocolError, match="has only 2 of 3 bytes left"):
        CdrReader(little("0102")).bytes(3)
    for header in ("01010000", "00020000", "0001 00"):
        with pytest.raises(RemoteProtocolError, match=r"^a ROS message without a CDR header$"):
            CdrReader(bytes.fromhex(header))


def test_an_image_has_all_its_lines() -> None:
    for height, step in ((3, 4), (2, 5)):
        with pytest.raises(RemoteProtocolError, match=f"{height} lines of {step} bytes has only 8 bytes"):
            RosImage.decode(replace(IMAGE, height=height, step=step).encode())
    assert RosImage.decode(replace(IMAGE, height=1).encode()).height == 1, "more bytes do no harm"


def test_numbers_are_aligned_to_their_size_from_the_end_of_the_encapsulation() -> None:
    reader = CdrReader(little("01 ffffff 02000000 03 ff 0400 ffffffff 0500000000000000 000000000000e03f"))
    read = [reader.number("B"), reader.number("I"), reader.number("B"), reader.number("H")]
    assert [*read, reader.number("q"), reader.real()] == [1, 2, 3, 4, 5, 0.5]


def test_a_compressed_image() -> None:
    message = little(f"{HEAD} 05000000 6a70656700 000000 03000000 ffd8ff")
    image = RosCompressedImage.decode(message)
    assert (image.stamp_ns, image.format, bytes(image.data)) == (NS, "jpeg", b"\xff\xd8\xff")


def test_texts_end_with_a_zero() -> None:
    message = little("0400 0000 c3a97800")
    assert encode_string("\u00e9x") == message and decode_string(message) == "\u00e9x"
    assert decode_string(little("02000000 ff78")) == "\ufffdx", "no UTF-8, and no zero"


def test_a_cameras_time_is_kept_beside_the_hosts() -> None:
    message = encode_time_reference(NS, "cam", 7 * 10**9 + 9, "PTP")
    assert message == little(f"{HEAD} 07000000 09000000 04000000 50545000")
    assert decode_time_reference(message) == 7 * 10**9 + 9
    late = encode_time_reference(NS, "cam", 2**31 * 10**9 + 5, "")
    assert decode_time_reference(late) == (2**31 - 1) * 10**9 + 5, "seconds have 31 bits"


@pytest.mark.parametrize(
    ("topic", "plain"),
    [
        ("/left/image_raw/compressed", "/left/image_raw"),
        ("/depth/image_raw/compressedDepth", "/depth/image_raw"),
        ("/left/image_raw", "/left/image_raw"),
        ("/compressed_images", "/compressed_images"),
    ],
)
def test_the_topic_of_plain_images(topic: str, plain: str) -> None:
    assert plain_topic(topic) == plain


def test_the_bytes_of_a_camera_info() -> None:
    numbers = [float(number) for number in range(1, 33)]
    info = CameraInfoFields(
        NS, "cam", 480, 640, "plumb_bob", numbers[:2], numbers[2:11], numbers[11:20], numbers[20:32], 2, 4,
        RegionFields(8, 16, 100, 200),
    )  # fmt: skip
    doubles = struct.pack("<32d", *numbers).hex()
    message = little(
        f"{HEAD} e0010000 80020000 0a000000 706c756d625f626f6200 0000 02000000 00000000 {doubles}"
        " 02000000 04000000 08000000 10000000 64000000 c8000000 00"
    )
    assert info.encode() == message
    assert CameraInfoFields.decode(message) == info
    for length in range(len(message) - 1):
        with pytest.raises(RemoteProtocolError):
            CameraInfoFields.decode(message[:length])
