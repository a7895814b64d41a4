"""Containers of the simulated camera, and what holds for whatever is read from a container."""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

from fuzz import payloads
from grabbergui.driver import gendc
from grabbergui.driver.gendc import Component, Container, Part


def containers() -> list[bytes]:
    """Whole containers, with and without chunk data."""
    return [seed[1:] for seed in payloads.seeds() if seed[:1] == b"\0"]


def placed(kind: type[Component | Part]) -> list[bytes]:
    """Containers behind the two bytes that `at` reads: each header of that kind in turn."""
    found = []
    for container in containers():
        for place in _headers(container):
            parts = _offsets(container, place + Component.FORMAT.size, "<H")
            places = [place] if kind is Component else parts
            found += [struct.pack(">H", here) + container for here in places]
    return found


def check_part(part: Part, container: bytes) -> None:
    """A part that was accepted lies in its container, and its size is one that a frame may have."""
    if not 0 <= part.data_offset <= part.data_offset + part.data_size <= len(container):
        raise AssertionError(part)
    if min(part.width, part.height, part.padding_x, part.padding_y) < 0 or part.width > 0xFFFFFFFF:
        raise AssertionError(part)
    if part.header_type & 0xFF00 == gendc.HeaderType.IMAGE_2D and part.width and len(container) < 1 << 16:
        again = Part.decode(part.encode() + bytes(part.data_offset + part.data_size), 0)
        if again != part:
            raise AssertionError((part, again))


def check_component(component: Component, container: bytes) -> None:
    """A component that was accepted has few parts, none if it is invalid."""
    if len(component.parts) > gendc.MOST_HEADERS or (component.parts and not component.valid):
        raise AssertionError(component)
    for part in component.parts:
        check_part(part, container)


def _headers(container: bytes) -> list[int]:
    return _offsets(container, Container.FORMAT.size, "<I")


def _offsets(container: bytes, end: int, count_format: str) -> list[int]:
    """The list of offsets behind a header that ends with its length."""
    (count,) = struct.unpack_from(count_format, container, end - struct.calcsize(count_format))
    return list(struct.unpack_from(f"<{count}Q", container, end))


def as_payload(container: bytes) -> NDArray[np.uint8]:
    """A container as a stream delivers it."""
    return np.frombuffer(container, np.uint8)
