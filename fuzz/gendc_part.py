"""GenDC: one part header, anywhere in a container."""

from __future__ import annotations

from fuzz._gendc import check_part, placed
from fuzz._input import Input, refusing
from grabbergui.driver.gendc import Part


def seeds() -> list[bytes]:
    """Two bytes of offset, and a container."""
    return placed(Part)


def one_input(data: bytes) -> None:
    """A part is refused, or its data lie in the container, and its header reads the same again."""
    source = Input(data)
    at, container = source.number(2), source.rest()
    part = refusing(Part.decode, container, at)
    if part is not None:
        check_part(part, container)
