"""Containers of the simulated camera, and checks of what is read from a container."""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

from fuzz._input import erring
from grabbergui.driver import gendc
from grabbergui.driver.gendc import ComponentHeader, Container, PartHeader
from grabbergui.driver.payload_contents import Contents
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.contents import complete, payload_bytes
from grabbergui.driver.sim.enumerations import Chunk
from grabbergui.driver.sim.h264_encoder import H264Encoder
from grabbergui.driver.sim.model import CameraModel
from grabbergui.driver.sim.settings import settings_of


def containers() -> list[bytes]:
    """Return whole containers, without and with chunk data."""
    return [_container(chunks) for chunks in ({}, {Chunk.GAIN: 7.0})]


def placed(kind: type[ComponentHeader | PartHeader]) -> list[bytes]:
    """Return containers after two bytes of offset, for each header of that kind in turn."""
    found = []
    for container in containers():
        for place in _headers(container):
            is_component = kind is ComponentHeader
            places = (
                [place] if is_component else _offsets(container, place + ComponentHeader.FORMAT.size, "<H")
            )
            found += [struct.pack(">H", here) + container for here in places]
    return found


def check_part(part: PartHeader, container: bytes) -> None:
    """Check that an accepted part lies in its container and has a size that a frame may have."""
    if not 0 <= part.data_offset <= part.data_offset + part.data_size <= len(container):
        raise AssertionError(part)
    if min(part.width, part.height, part.padding_x, part.padding_y) < 0 or part.width > 0xFFFFFFFF:
        raise AssertionError(part)
    if part.header_type & 0xFF00 == gendc.HeaderType.IMAGE_2D and part.width and len(container) < 1 << 16:
        again = PartHeader.decode(part.encode() + bytes(part.data_offset + part.data_size), 0)
        if again != part:
            raise AssertionError((part, again))


def check_component(component: ComponentHeader, container: bytes) -> None:
    """Check that an accepted component has few parts, and none if it is invalid."""
    if len(component.parts) > gendc.MOST_HEADERS or (component.parts and not component.valid):
        raise AssertionError(component)
    for part in component.parts:
        check_part(part, container)


def check_contents(contents: Contents, payload: NDArray[np.uint8]) -> None:
    """Check that every image is a view of the payload, and that its pixels are converted or refused."""
    for part in contents.parts:
        if (part.data.size and not np.shares_memory(part.data, payload)) or part.width < 0:
            raise AssertionError(part)
        if part.encoding is None and part.data.size < 1 << 20:
            erring(part.raw)


def _container(chunks: dict[Chunk, float]) -> bytes:
    power_on = {reg.WIDTH: 16, reg.HEIGHT: 8, reg.GENDC_STREAMING_MODE: 1}
    power_on |= dict.fromkeys(reg.COMPONENT_ENABLE, 1)
    settings = settings_of(CameraModel(power_on=power_on).memory)
    out = np.zeros(payload_bytes(settings, tuple(chunks)), np.uint8)
    values = np.zeros((settings.height, settings.width), np.uint8)
    length = complete(settings, 1, values, chunks, out, H264Encoder(), little_endian=True)
    return out[:length].tobytes()


def _headers(container: bytes) -> list[int]:
    return _offsets(container, Container.FORMAT.size, "<I")


def _offsets(container: bytes, end: int, count_format: str) -> list[int]:
    """Return the offsets after a header that ends with their number."""
    (count,) = struct.unpack_from(count_format, container, end - struct.calcsize(count_format))
    return list(struct.unpack_from(f"<{count}Q", container, end))
