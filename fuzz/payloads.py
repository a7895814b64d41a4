"""Payloads to components: GenDC containers, headers of compressed images, H.264 streams."""

from __future__ import annotations

import cv2
import numpy as np

from fuzz._gendc import check_contents, containers
from fuzz._input import Input, erring
from grabbergui.core.component import PayloadType
from grabbergui.core.encoded_image import jpeg2000_header, jpeg_header
from grabbergui.driver.h264 import LARGEST_H264_SIDE, scan_h264
from grabbergui.driver.payload_contents import PayloadReader
from grabbergui.driver.sim.h264_encoder import H264Encoder


def seeds() -> list[bytes]:
    """Return containers, images and video of the simulated camera."""
    image = np.arange(64 * 64, dtype=np.uint32).astype(np.uint8).reshape(64, 64)
    encoded = [np.asarray(cv2.imencode(suffix, image)[1]).tobytes() for suffix in (".jpg", ".jp2")]
    video = H264Encoder()
    return [
        *(b"\0" + whole for whole in containers()),
        *(bytes((1 + index,)) + data for index, data in enumerate(encoded)),
        *(b"\3" + video.encode(number, image).tobytes() for number in (1, 2)),
    ]


def one_input(data: bytes) -> None:
    """Feed the reader that the first byte chooses."""
    source = Input(data)
    (_gendc, _jpeg, _jpeg2000, _h264)[source.number(1) % 4](source.rest())


def _gendc(data: bytes) -> None:
    payload = np.frombuffer(data, np.uint8)
    check_contents(PayloadReader().container(payload), payload)


def _jpeg(data: bytes) -> None:
    _compressed(PayloadType.JPEG, data)
    erring(jpeg_header, data)


def _jpeg2000(data: bytes) -> None:
    _compressed(PayloadType.JPEG2000, data)
    erring(jpeg2000_header, data)


def _compressed(kind: PayloadType, data: bytes) -> None:
    payload = np.frombuffer(data, np.uint8)
    check_contents(PayloadReader().compressed(kind, payload), payload)


def _h264(data: bytes) -> None:
    _, size = scan_h264(data)
    if size is not None and not (0 < min(size) <= max(size) <= LARGEST_H264_SIDE):
        raise AssertionError(size)
