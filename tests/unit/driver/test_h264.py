"""H.264 streams: any order of asking, lost images, sizes of every profile, damage."""

from __future__ import annotations

from fractions import Fraction

import av
import numpy as np
import pytest
from numpy.typing import NDArray

from grabbergui.core.errors import PixelFormatError
from grabbergui.driver.h264 import H264Stream, scan_h264

PROFILES = [
    (256, 128, "baseline", "yuv420p"),
    (258, 130, "high", "yuv420p"),
    (100, 60, "high444", "yuv444p"),
    (640, 482, "main", "yuv420p"),
]


def encoded(width: int, height: int, profile: str, pixel_format: str, count: int = 14) -> list[bytes]:
    """Access units of random images, a key frame every five."""
    encoder = av.CodecContext.create("libx264", "w")
    encoder.width, encoder.height, encoder.pix_fmt = width, height, pixel_format
    encoder.time_base = Fraction(1, 30)
    encoder.options = {"tune": "zerolatency", "preset": "ultrafast", "g": "5", "profile": profile}
    units = []
    for index in range(count):
        image = np.random.default_rng(index // 4).integers(0, 255, (height, width, 3)).astype(np.uint8)
        image[:, : index * 3] = index
        frame = av.VideoFrame.from_ndarray(image, format="rgb24").reformat(format=pixel_format)
        frame.pts = index
        units += [bytes(packet) for packet in encoder.encode(frame)]
    return units


def decoded(units: list[bytes]) -> list[NDArray[np.uint8]]:
    decoder = av.CodecContext.create("h264", "r")
    images = [image for unit in units for image in decoder.decode(av.Packet(unit))] + decoder.decode(None)
    return [image.to_ndarray(format="rgb24") for image in images]


@pytest.mark.parametrize(("width", "height", "profile", "pixel_format"), PROFILES)
def test_images_in_any_order_are_those_of_pyav(width, height, profile, pixel_format) -> None:
    units = encoded(width, height, profile, pixel_format)
    expected, stream = decoded(units), H264Stream()
    images = [stream.add(index, np.frombuffer(unit, np.uint8)) for index, unit in enumerate(units, 1)]
    for index in (7, 9, 13, 12, 6, 8, 5):
        image = images[index]
        assert image is not None and (image.width, image.height) == (width, height)
        assert np.array_equal(image.raw(), expected[index])
    with pytest.raises(PixelFormatError, match="no longer kept"):
        images[0].raw()


def test_after_a_lost_image_the_next_key_frame_is_waited_for() -> None:
    units = encoded(*PROFILES[0])
    expected, stream = decoded(units), H264Stream()
    images = {
        index: stream.add(index, np.frombuffer(unit, np.uint8), complete=index != 11)
        for index, unit in enumerate(units)
        if index not in (0, 7)  # the first key frame and one image
    }
    shown = [index for index, image in images.items() if image is not None]
    assert shown == [5, 6, 10]
    for index in shown:
        assert np.array_equal(images[index].raw(), expected[index])


def test_damage_is_refused_and_nothing_else() -> None:
    units, random = encoded(*PROFILES[1]), np.random.default_rng(5)
    for length in range(0, 200):
        scan_h264(units[0][:length])
    stream = H264Stream()
    for index, unit in enumerate(units * 8):
        data = np.frombuffer(unit, np.uint8).copy()
        data[random.integers(0, len(data), 12)] = random.integers(0, 256, 12)
        image = stream.add(index, data)
        if image is not None:
            try:
                image.payload  # noqa: B018
            except PixelFormatError as error:
                assert "H.264" in str(error)
