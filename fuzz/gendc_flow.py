"""GenDC: the header of a flow's data in a GVSP packet, and containers made of any flows, offsets and sizes.

Random bytes seldom get past the headers; here the headers are made from the input, and what is read must be
views of the data.
"""

from __future__ import annotations

import numpy as np

from fuzz._gendc import check_contents
from fuzz._input import Input, refusing
from grabbergui.driver.gendc import ComponentHeader, Container, PartHeader, descriptor_size
from grabbergui.driver.gige.gvsp import GendcPosition
from grabbergui.driver.payload_contents import PayloadReader

_TYPES = (0x4200, 0x4100, 0x4000, 0x4001, 0x4201, 0x4202, 0x4300)
_FORMATS = (0x01080001, 0x01100003, 0x010C0047, 0x011000B8, 0x02180014, 0x010800C6, 0x026000C0, 0x81080001)
_PART = 16
"Bytes of the input for a part."


def seeds() -> list[bytes]:
    """Return containers of one to three parts in flow 0, in several flows, and with a wrong offset."""
    image = bytes((0, 0, 0, 0, 0, 8, 0, 4)) + bytes((0, 0, 0, 32, 0, 0, 0, 0))
    other = bytes((0, 0, 1, 0, 0, 8, 0, 4)) + bytes((0, 0, 0, 32, 0, 0, 0, 0))
    wrong = bytes((0, 3, 0, 0, 0, 8, 0, 4)) + bytes((255, 255, 0, 32, 0, 0, 0, 0))
    position = GendcPosition(32, 64, GendcPosition.DESCRIPTOR, GendcPosition.FIRST, 0).encode() + bytes(32)
    return [
        *(bytes((0, 0, count, 1)) + image * count for count in (1, 2, 3)),
        bytes((0, 0, 2, 1)) + image + other,
        bytes((0, 0, 1, 1)) + wrong,
        b"\1" + position,
    ]


def one_input(data: bytes) -> None:
    """Feed the header or a container, as the first byte chooses."""
    source = Input(data)
    (_container, _position)[source.number(1) % 2](source)


def _position(source: Input) -> None:
    body = source.rest()
    position = refusing(GendcPosition.decode, body)
    if position is None:
        return
    if position.encode() != body[: GendcPosition.FORMAT.size]:
        raise AssertionError(position)
    if position.size > len(body) - GendcPosition.FORMAT.size:
        raise AssertionError(position)


def _container(source: Input) -> None:
    groups = 1 + source.number(1) % 3
    counts = [source.number(1) % 5 for _ in range(groups)]
    first = descriptor_size(counts)
    components = tuple(
        ComponentHeader(source.number(1), _FORMATS[0], tuple(_part(source, first) for _ in range(count)))
        for count in counts
    )
    container = Container(components, data_size=4096, data_offset=first).encode() + bytes(4096)
    payload = np.frombuffer(container, np.uint8)
    check_contents(PayloadReader().container(payload), payload)


def _part(source: Input, first: int) -> PartHeader:
    kind, pixel_format, flow, padding = (source.number(1) for _ in range(4))
    width, height, offset, size = (source.number(2) for _ in range(4))
    flow_offset = source.number(4)
    return PartHeader(
        _TYPES[kind % len(_TYPES)],
        _FORMATS[pixel_format % len(_FORMATS)],
        size,
        first + offset,
        width,
        height,
        padding % 16,
        padding // 16,
        flow,
        flow_offset,
    )
