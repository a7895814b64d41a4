"""GenDC: the container header, and everything that it refers to."""

from __future__ import annotations

from fuzz._gendc import check_component, containers
from fuzz._input import refusing
from grabbergui.driver.gendc import KNOWN_VERSIONS, MOST_HEADERS, Container


def seeds() -> list[bytes]:
    """Return whole containers, and their first bytes."""
    return [piece for whole in containers() for piece in (whole, whole[: Container.FORMAT.size], whole[:8])]


def one_input(data: bytes) -> None:
    """Check that a container is refused, or has a known version and bounded, consistent headers."""
    container = refusing(Container.decode, data)
    if container is None:
        return
    if container.version[:2] not in KNOWN_VERSIONS or len(container.components) > MOST_HEADERS:
        raise AssertionError(container)
    if container.descriptor_size > len(data):
        raise AssertionError(container)
    for component in container.components:
        check_component(component, data)
