"""`gige:` sources: `gige:` the first found, `gige:192.168.0.10`, `gige:SERIAL`, `gige:MAC`, `gige:user name`.

Its options are in `GigeUriOptions`.
"""

from __future__ import annotations

import ipaddress
from dataclasses import replace

from grabbergui.core.errors import UsageError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.uri import GigeUriOptions, SourceUri, read_options
from grabbergui.driver.camera import Camera
from grabbergui.driver.gige.device import GigeDevice, GigeOptions
from grabbergui.driver.gige.discovery import search
from grabbergui.driver.gige.stream.channel import ALL_CHANNELS
from grabbergui.driver.gige.stream.packet_ring import RingUse
from grabbergui.driver.gige.stream.packet_settings import PacketDelayPolicy, PacketSizePolicy
from grabbergui.driver.gige.stream.resend import ResendPolicy

MOST_CHANNELS = 512
"Stream channels of a device (GigE Vision, register 0x0904)."


def create(uri: SourceUri) -> FrameGrabber:
    """Return the camera that a URI names, not yet opened or searched for. Raises UsageError."""
    chosen = read_options(GigeUriOptions, uri)
    options = GigeOptions(
        packet_size=PacketSizePolicy.parse(chosen.packet_size),
        resend=ResendPolicy(enabled=chosen.resend),
        packet_delay=PacketDelayPolicy.parse(chosen.packet_delay, chosen.bandwidth),
        stream_channel=_channel(uri, chosen.stream_channel),
        multicast=_checked_group(uri, chosen.multicast),
        packet_ring=RingUse(chosen.packet_ring),
        batched=not chosen.plain,
    )
    device = GigeDevice(uri.name, options)
    device.info = replace(device.info, uri=str(uri))
    return Camera(device, deliver_incomplete=chosen.incomplete)


def _channel(uri: SourceUri, text: str) -> int:
    if text == "all":
        return ALL_CHANNELS
    if text.isdecimal() and int(text) < MOST_CHANNELS:
        return int(text)
    raise UsageError(f"{uri}: stream_channel={text}: write a number from 0 to {MOST_CHANNELS - 1}, or all")


def discover(timeout: float) -> list[DeviceInfo]:
    """Return every camera that answers within `timeout` seconds, each under a URI of its own."""
    infos = [device.info() for device in search.discover(timeout)]
    uris = [info.uri for info in infos]
    return [
        info if uris.count(info.uri) == 1 else replace(info, uri=f"gige:{info.address}") for info in infos
    ]


def _checked_group(uri: SourceUri, group: str) -> str:
    try:
        if group and not ipaddress.IPv4Address(group).is_multicast:
            raise ValueError(group)
    except ValueError as error:
        raise UsageError(f"{uri}: multicast={group}: write a group's address, e.g. 239.192.0.1") from error
    return group
