"""GenDC: one component header, anywhere in a container."""

from __future__ import annotations

from fuzz._gendc import check_component, placed
from fuzz._input import Input, refusing
from grabbergui.driver.gendc import ComponentHeader


def seeds() -> list[bytes]:
    """Return containers, each after two bytes of offset."""
    return placed(ComponentHeader)


def one_input(data: bytes) -> None:
    """Check that a component is refused, or that its parts lie in the container."""
    source = Input(data)
    at, container = source.number(2), source.rest()
    component = refusing(ComponentHeader.decode, container, at)
    if component is not None:
        check_component(component, container)
