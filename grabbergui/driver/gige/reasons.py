"""Why a GigE Vision camera is not found, or sends no frames.

One diagnosis for the window, the command line, the library and `doctor`. No I/O: callers pass what they know.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.driver.gige.bootstrap import GVCP_PORT
from grabbergui.driver.gige.interfaces import Interface

FIREWALL = f"a firewall must let UDP in: sudo ufw allow proto udp from any port {GVCP_PORT}"
"""Remedy where nothing answers: to a stateful firewall, answers to a broadcast are no answers."""


@dataclass(frozen=True)
class StreamFacts:
    """Observations of a stream that yields no frames."""

    statistics: StreamStatistics
    camera: str
    "IP address of the camera."
    port: int
    "UDP port of this host that the camera sends to."
    interface: Interface
    "The one that the stream is expected on."
    fault: str = ""
    "Why the packets that arrive make no frame."
    seen_as: str = ""
    "Address at which the camera sees this host (register 0x0A14); empty if it does not tell."
    packet_size: int = 0
    "Bytes, IP and UDP headers included."


def no_frames(facts: StreamFacts, interfaces: Sequence[Interface]) -> str:
    """Return why no frames arrive and what to do, as display text; empty while some do."""
    if facts.statistics.frames:
        return ""
    if facts.fault:
        return facts.fault
    if facts.statistics.packets:
        return ""
    if facts.seen_as and facts.seen_as not in (facts.interface.ip, "0.0.0.0"):
        return (
            f"the camera sees this computer at {facts.seen_as}, not at {facts.interface.ip}: a router between"
            " them translates addresses (NAT), so frames do not get through; give this computer an address in"
            " the camera's network"
        )
    for one, other in shared_networks(interfaces):
        if facts.interface.name in (one.name, other.name):
            return f"no packet arrives; {shared_text(one, other)}: {shared_remedy(other)}"
    if facts.interface.loopback:
        return ""
    large = ""
    if facts.packet_size > 1500:
        large = f"; packets of {facts.packet_size} bytes need an MTU as large on every device between"
    return (
        "no packet arrives; a firewall may drop them:"
        f" sudo ufw allow proto udp from {facts.camera} to any port {facts.port}{large}"
    )


def shared_networks(interfaces: Sequence[Interface]) -> list[tuple[Interface, Interface]]:
    """Return pairs of interfaces in one subnet."""
    return [
        (one, other)
        for one, other in combinations(interfaces, 2)
        if one.name != other.name and not one.loopback and one.network.overlaps(other.network)
    ]


def shared_text(one: Interface, other: Interface) -> str:
    """Return that two interfaces are in one subnet."""
    return (
        f"{one.name} ({one.ip}) and {other.name} ({other.ip}) are in one subnet, {one.network}; "
        "the system may use the wrong one for a camera"
    )


def shared_remedy(other: Interface) -> str:
    """Return the remedy for it."""
    return f"give {other.name} and its cameras addresses of another subnet"


def not_found(interfaces: Sequence[Interface]) -> str:
    """Return what to check where no camera answers a search."""
    for one, other in shared_networks(interfaces):
        return (
            f"check power, cable and address; {shared_text(one, other)}: {shared_remedy(other)}; {FIREWALL}"
        )
    return f"check power, cable and address; {FIREWALL}"
