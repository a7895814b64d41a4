"""GenDC: one part header, anywhere in a container."""

from __future__ import annotations

from fuzz._gendc import check_part, placed
from fuzz._input import Input, refusing
from grabbergui.driver.gendc import PartHeader


def seeds() -> list[bytes]:
    """Return containers, each after two bytes of offset."""
    return placed(PartHeader)


def one_input(data: bytes) -> None:
    """Check that a part is refused, or lies in the container and its header is encoded the same."""
    source = Input(data)
    at, container = source.number(2), source.rest()
    part = refusing(PartHeader.decode, container, at)
    if part is not None:
        check_part(part, container)
