"""What is written to a camera before and after it streams, and what must be known of it."""

from __future__ import annotations

import logging
from collections.abc import Container

from grabbergui.core import pfnc
from grabbergui.core.errors import FeatureAccessError, GrabberError
from grabbergui.core.features import Feature
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.selection import SettingKey, instances
from grabbergui.driver.genapi.node_map import CameraNodeMap

log = logging.getLogger(__name__)

TRANSPORT_LOCK = "TLParamsLocked"
"Of the transport layer (SFNC); nobody else writes it."
MODE, TRIGGER = "AcquisitionMode", "TriggerMode"
"What keeps a camera from sending frames without end."
MOST_BYTES_PER_PIXEL = 8
"More than any format takes."
_SET_BY_TRANSPORT = ("GevSCPSPacketSize", "GevSCPD", "GevSCDA", "GevSCPHostPort")
"Features whose registers a transport writes by itself when it opens a stream."
NOT_SETTINGS = frozenset({TRANSPORT_LOCK, *_SET_BY_TRANSPORT})
"Features that are written for each stream."


def run_free(grabber: FrameGrabber, kept: Container[str] = ()) -> None:
    """Write AcquisitionMode Continuous and every TriggerMode Off, but neither that is `kept`."""
    modes = [SettingKey(MODE)] if grabber.has_feature(MODE) else []
    for wanted, keys in (("Continuous", modes), ("Off", _instances(grabber, TRIGGER))):
        for key in keys:
            if key.name in kept:
                continue
            feature = grabber.read_setting(key)
            if feature.value != wanted and feature.access.writable and has_entry(feature, wanted):
                grabber.write_setting(key, wanted)


def payload_size(nodes: CameraNodeMap) -> int:
    """Bytes of the largest frame. Raises FeatureAccessError where nothing tells."""
    if nodes.has_node("PayloadSize"):
        nodes.invalidate(frozenset({"PayloadSize"}))
        size = nodes.feature("PayloadSize").value
        if isinstance(size, int) and size > 0:
            return size
    width, height = nodes.feature("Width").value, nodes.feature("Height").value
    pixel_format = nodes.feature("PixelFormat").value
    if not isinstance(width, int) or not isinstance(height, int):
        raise FeatureAccessError("the camera tells neither PayloadSize nor Width and Height", "PayloadSize")
    try:
        return pfnc.by_name(str(pixel_format)).image_bytes(width, height)
    except KeyError:
        return width * height * MOST_BYTES_PER_PIXEL


def forget_what_transport_set(nodes: CameraNodeMap) -> None:
    """Read anew, when somebody looks, what opening the stream changed beneath GenApi."""
    nodes.invalidate(frozenset(name for name in _SET_BY_TRANSPORT if nodes.has(name)))


def lock_transport(nodes: CameraNodeMap, *, locked: bool) -> None:
    """Keep others from changing what a frame looks like while it streams, or let them again."""
    if not nodes.has_node(TRANSPORT_LOCK):
        return
    try:
        if nodes.feature(TRANSPORT_LOCK).access.writable:
            nodes.write(TRANSPORT_LOCK, int(locked))
    except GrabberError as error:
        log.info("%s=%d: %s", TRANSPORT_LOCK, locked, error)


def has_entry(feature: Feature, name: str) -> bool:
    """Whether an enumeration has an entry that can be chosen just now."""
    return any(entry.name == name and entry.available for entry in feature.entries)


def _instances(grabber: FrameGrabber, name: str) -> list[SettingKey]:
    """Return a feature's settings under all its selectors; none where the camera does not have it."""
    if not grabber.has_feature(name):
        return []
    found, _ = instances(grabber, grabber.selectors.of(name))
    return [SettingKey(name, selected) for selected in found]
