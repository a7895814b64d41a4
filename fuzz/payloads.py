"""Payloads to components: GenDC containers, headers of compressed images, H.264 streams."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from fuzz._input import Input, erring
from grabbergui.core.component import PayloadType
from grabbergui.core.encoded_image import jpeg2000_header, jpeg_header
from grabbergui.driver import gendc
from grabbergui.driver.h264 import LARGEST_SIDE, scan
from grabbergui.driver.payload_contents import Contents, PayloadReader
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.contents import H264Encoder, complete, payload_bytes
from grabbergui.driver.sim.model import CameraModel
from grabbergui.driver.sim.registers import Chunk
from grabbergui.driver.sim.settings import settings_of


def seeds() -> list[bytes]:
    """Containers, images and video of the simulated camera."""
    image = np.arange(64 * 64, dtype=np.uint32).astype(np.uint8).reshape(64, 64)
    encoded = [np.asarray(cv2.imencode(suffix, image)[1]).tobytes() for suffix in (".jpg", ".jp2")]
    video = H264Encoder()
    return [
        *(b"\0" + _container(chunks) for chunks in ({}, dict.fromkeys((Chunk.GAIN,), 7.0))),
        *(bytes((1 + index,)) + data for index, data in enumerate(encoded)),
        *(b"\3" + video.encode(number, image).tobytes() for number in (1, 2)),
    ]


def _container(chunks: dict[Chunk, float]) -> bytes:
    power_on = {reg.WIDTH: 16, reg.HEIGHT: 8, reg.GENDC_STREAMING_MODE: 1}
    power_on |= dict.fromkeys(reg.COMPONENT_ENABLE, 1)
    settings = settings_of(CameraModel(power_on=power_on).memory)
    out = np.zeros(payload_bytes(settings, tuple(chunks)), np.uint8)
    values = np.zeros((settings.height, settings.width), np.uint8)
    length = complete(settings, 1, values, chunks, out, H264Encoder(), little_endian=True)
    return out[:length].tobytes()


def one_input(data: bytes) -> None:
    """One reader's turn, by the first byte."""
    source = Input(data)
    (_gendc, _jpeg, _jpeg2000, _h264)[source.number(1) % 4](source.rest())


def _check(contents: Contents, payload: NDArray[np.uint8]) -> None:
    for part in contents.parts:
        if not (np.shares_memory(part.data, payload) or not part.data.size) or part.width < 0:
            raise AssertionError(part)
        erring(lambda part=part: part.raw() if part.encoding is None and part.data.size < 1 << 20 else None)


def _gendc(data: bytes) -> None:
    payload = np.frombuffer(data, np.uint8)
    _check(PayloadReader().container(payload), payload)
    container = erring(gendc.Container.decode, data)
    if container is not None and container.version[0] != 1:
        raise AssertionError(container)


def _jpeg(data: bytes) -> None:
    _compressed(PayloadType.JPEG, data)
    erring(jpeg_header, data)


def _jpeg2000(data: bytes) -> None:
    _compressed(PayloadType.JPEG2000, data)
    erring(jpeg2000_header, data)


def _compressed(kind: PayloadType, data: bytes) -> None:
    payload = np.frombuffer(data, np.uint8)
    _check(PayloadReader().compressed(kind, payload), payload)


def _h264(data: bytes) -> None:
    _, size = scan(data)
    if size is not None and not (0 < min(size) <= max(size) <= LARGEST_SIDE):
        raise AssertionError(size)
