"""The budget of a rig's link: read from its open cameras, written into its file, and taken out again."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from grabbergui.core.errors import GrabberError
from grabbergui.core.features import FeatureValue
from grabbergui.core.frame_period import frame_rate
from grabbergui.core.grabber import FrameGrabber
from grabbergui.rig.link_budget import CameraLoad, LinkBudget, Pacing, SharedLink, plan
from grabbergui.rig.rig_file import RigEntry

WRITTEN = ("GevSCPD", "GevSCFTD", "DeviceLinkThroughputLimitMode", "DeviceLinkThroughputLimit")
"Settings that a budget writes."
USB3_RATE = 400e6
"Bytes per second of a USB 3 bus that arrive as payload."
_LINK_SPEEDS = (("DeviceLinkSpeed", 1.0), ("GevLinkSpeed", 125_000.0))
"Features with the speed of the camera's cable, and the factor to bytes per second."


def loads_of(entry: RigEntry, cameras: Mapping[str, FrameGrabber]) -> list[CameraLoad]:
    """Return what each camera needs as it is set now. Raises GrabberError if a camera cannot be read."""
    return [_load(name, grabber, entry) for name, grabber in cameras.items()]


def budgets_of(entry: RigEntry, cameras: Mapping[str, FrameGrabber]) -> list[LinkBudget]:
    """Return a budget for each link: that of the rig's network, and the USB. Raises GrabberError.

    Cameras on neither, such as simulated ones within this program, are in no budget.
    """
    network = SharedLink(entry.link.rate, entry.link.share, entry.link.buffer)
    # USB has no switch that drops what arrives together: each camera waits for its turn on the bus.
    usb = SharedLink(USB3_RATE, entry.link.share, math.inf)
    on_usb = {name: each for name, each in cameras.items() if each.info.bus.startswith("USB")}
    others = {name: each for name, each in cameras.items() if name not in on_usb}
    on_network = [load for load in loads_of(entry, others) if load.packet_size]
    shared = ((on_network, network), (loads_of(entry, on_usb), usb))
    return [plan(loads, link) for loads, link in shared if loads]


def with_budget(entry: RigEntry, budgets: list[LinkBudget]) -> RigEntry:
    """Return the rig with the settings of its budgets."""
    settings: dict[str, dict[str, FeatureValue]] = {}
    for budget in budgets:
        for each in budget.allotments:
            chosen: dict[str, FeatureValue] = dict(each.settings)
            if each.pacing is Pacing.THROUGHPUT_LIMIT:
                chosen = {"DeviceLinkThroughputLimitMode": "On", **chosen}
            settings[each.load.name] = chosen
    cameras = {
        name: replace(camera, settings={**_without(camera.settings), **settings.get(name, {})})
        for name, camera in entry.cameras.items()
    }
    return replace(entry, cameras=cameras)


def without_budget(entry: RigEntry) -> RigEntry:
    """Return the rig without the settings of a budget."""
    cameras = {
        name: replace(camera, settings=_without(camera.settings)) for name, camera in entry.cameras.items()
    }
    return replace(entry, cameras=cameras)


def _without(settings: dict[str, FeatureValue]) -> dict[str, FeatureValue]:
    return {name: value for name, value in settings.items() if name not in WRITTEN}


def _load(name: str, grabber: FrameGrabber, entry: RigEntry) -> CameraLoad:
    rate = entry.trigger.rate if entry.trigger.by != "free" and entry.trigger.rate else frame_rate(grabber)
    packet_size = _number(grabber, "GevSCPSPacketSize")
    link = next((speed * factor for each, factor in _LINK_SPEEDS if (speed := _number(grabber, each))), 0.0)
    means = [
        pacing
        for pacing in (Pacing.PACKET_DELAY, Pacing.THROUGHPUT_LIMIT, Pacing.FRAME_DELAY)
        if grabber.has_feature(pacing.value) and grabber.feature(pacing.value).access.readable
    ]
    return CameraLoad(
        name,
        payload=int(_number(grabber, "PayloadSize")),
        frame_rate=rate,
        packet_size=int(packet_size),
        link=link or (entry.link.rate if packet_size else USB3_RATE),
        tick_frequency=int(_number(grabber, "GevTimestampTickFrequency")) or 1_000_000_000,
        means=tuple(means),
    )


def _number(grabber: FrameGrabber, name: str) -> float:
    """Return a feature's value; 0 if the camera does not report it."""
    try:
        value = grabber.feature(name).value if grabber.has_feature(name) else 0
    except GrabberError:
        return 0
    return value if isinstance(value, int | float) and not isinstance(value, bool) else 0
