"""`gige:` sources: `gige:` the first found, `gige:192.168.0.10`, `gige:SERIAL`, `gige:MAC`, `gige:user name`.

Options: `packet_size=auto|keep|BYTES`, `incomplete=1` (deliver frames with missing packets), `resend=0`
(never ask for lost packets), `packet_delay=10us` or `bandwidth=60MB` (pauses between packets),
`multicast=239.192.0.1` (send to a group, so that others can listen in), `plain=1` (a system call for each
datagram), `packet_ring=1` (no system calls, which needs CAP_NET_RAW).
"""

from __future__ import annotations

import ipaddress
from dataclasses import replace

from grabbergui.core.errors import UsageError
from grabbergui.core.grabber import DeviceInfo, FrameGrabber
from grabbergui.core.uri import SourceUri
from grabbergui.driver.camera import Camera
from grabbergui.driver.gige.device import GigeDevice, GigeOptions
from grabbergui.driver.gige.discovery import search
from grabbergui.driver.gige.stream.packet_settings import PacketDelayPolicy, PacketSizePolicy
from grabbergui.driver.gige.stream.resend import ResendPolicy

_OPTIONS = (
    "packet_size",
    "incomplete",
    "resend",
    "packet_delay",
    "bandwidth",
    "multicast",
    "plain",
    "packet_ring",
)


def create(uri: SourceUri) -> FrameGrabber:
    """The camera that a URI names, not yet opened or looked for. Raises UsageError."""
    unknown = [name for name in uri.options if name not in _OPTIONS]
    if unknown:
        raise UsageError(f"{uri}: unknown option {unknown[0]}; there are {', '.join(_OPTIONS)}")
    options = GigeOptions(
        packet_size=PacketSizePolicy.parse(uri.option("packet_size")),
        resend=ResendPolicy(enabled=_switch(uri, "resend", default=True)),
        packet_delay=PacketDelayPolicy.parse(uri.option("packet_delay"), uri.option("bandwidth")),
        multicast=_group(uri),
        packet_ring=_switch(uri, "packet_ring", default=False),
        batched=not _switch(uri, "plain", default=False),
    )
    device = GigeDevice(uri.name, options)
    device.info = replace(device.info, uri=str(uri))
    return Camera(device, deliver_incomplete=_switch(uri, "incomplete", default=False))


def discover(timeout: float) -> list[DeviceInfo]:
    """Every camera that answers within `timeout` seconds, each under a URI that no other answers to."""
    infos = [device.info() for device in search.discover(timeout)]
    uris = [info.uri for info in infos]
    return [
        info if uris.count(info.uri) == 1 else replace(info, uri=f"gige:{info.address}") for info in infos
    ]


def _group(uri: SourceUri) -> str:
    group = uri.option("multicast")
    try:
        if group and not ipaddress.IPv4Address(group).is_multicast:
            raise ValueError(group)
    except ValueError as error:
        raise UsageError(f"{uri}: multicast={group}: write a group's address, e.g. 239.192.0.1") from error
    return group


def _switch(uri: SourceUri, name: str, *, default: bool) -> bool:
    text = uri.option(name, "1" if default else "0").lower()
    if text in ("1", "true", "on", "yes", ""):
        return True
    if text in ("0", "false", "off", "no"):
        return False
    raise UsageError(f"{uri}: {name}={text}: write 0 or 1")
