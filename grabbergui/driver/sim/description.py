"""The camera's GenICam XML, as its transport's front gives it away."""

from __future__ import annotations

from functools import cache
from importlib import resources

_FEATURES_HERE = b"    <!-- features of the transport -->\n"
_END = b"</RegisterDescription>"


@cache
def camera_xml() -> bytes:
    """The description that all transports share."""
    return resources.files(__package__).joinpath("camera.xml").read_bytes()


def with_transport(features: tuple[str, ...], nodes: bytes) -> bytes:
    """The description with features of a transport, listed in TransportLayerControl, and their nodes."""
    listed = b"".join(b"    <pFeature>%s</pFeature>\n" % name.encode() for name in features)
    return camera_xml().replace(_FEATURES_HERE, listed).replace(_END, nodes + _END)
