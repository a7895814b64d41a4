"""The host's IPv4 interfaces, and sending by a certain one."""

from __future__ import annotations

import ipaddress
import logging
import os
import socket
import sys
from dataclasses import dataclass

import psutil

log = logging.getLogger(__name__)

DEFAULT_MTU = 1500
"MTU of an interface if the system does not report one."
ONLY = "GRABBERGUI_INTERFACES"
"""Environment variable: comma-separated names of the interfaces to use; all if it is not set."""
_UNICAST_INTERFACE = {"linux": (socket.IPPROTO_IP, 50), "win32": (socket.IPPROTO_IP, 31)}
"""Levels and numbers of IP_UNICAST_IF, which takes an interface's index in network byte order."""
_BOUND_INTERFACE = (socket.IPPROTO_IP, 25)
"""macOS's IP_BOUND_IF, which takes it as it is."""


@dataclass(frozen=True)
class Interface:
    """One IPv4 address of one network interface."""

    name: str
    ip: str
    netmask: str = "255.255.255.0"
    mtu: int = DEFAULT_MTU
    "Bytes of the largest IP datagram."
    loopback: bool = False

    @property
    def network(self) -> ipaddress.IPv4Network:
        """The subnet of this address."""
        return ipaddress.IPv4Network((self.ip, self.netmask), strict=False)

    @property
    def broadcast(self) -> str:
        """Directed broadcast address from the mask: systems report a wrong one on link-local links."""
        return str(self.network.broadcast_address)

    def reaches(self, ip: str) -> bool:
        """Whether an address lies in the same subnet."""
        return ipaddress.IPv4Address(ip) in self.network


def interfaces() -> list[Interface]:
    """Return every IPv4 address of the interfaces that are up and that the user allows (`ONLY`)."""
    allowed = {name.strip() for name in os.environ.get(ONLY, "").split(",")} - {""}
    return [interface for interface in _all_interfaces() if not allowed or interface.name in allowed]


def interface_of(ip: str) -> Interface:
    """Return the interface with a local address, or one with default values if none is reported."""
    for interface in interfaces():
        if interface.ip == ip or (interface.loopback and interface.reaches(ip)):
            return interface
    return Interface("", ip, loopback=ip.startswith("127."))


def _all_interfaces() -> list[Interface]:
    found = []
    links = psutil.net_if_stats()
    for name, addresses in psutil.net_if_addrs().items():
        link = links.get(name.partition(":")[0])  # an alias (`eth0:1`) shares the link of `eth0`
        if link is None:
            continue  # it was removed between the two calls
        flags = link.flags.split(",") if link.flags else []  # Windows reports none
        if not ("up" in flags if flags else link.isup):
            continue
        for each in addresses:
            if each.family == socket.AF_INET:
                loopback = "loopback" in flags or each.address.startswith("127.")
                netmask = each.netmask or "255.255.255.255"
                found.append(Interface(name, each.address, netmask, link.mtu or DEFAULT_MTU, loopback))
    return found


def leave_through(opened: socket.socket, interface: Interface) -> None:
    """Let a socket's datagrams leave through an interface, whatever the routing table prefers.

    With two cards in one network it prefers the first for cameras on either. Nothing happens on the loopback,
    for an interface without a name, and where the system cannot.
    """
    if interface.loopback or not interface.name:
        return
    try:
        index = socket.if_nametoindex(interface.name.partition(":")[0])
        if sys.platform in _UNICAST_INTERFACE:
            opened.setsockopt(*_UNICAST_INTERFACE[sys.platform], index.to_bytes(4, "big"))
        elif sys.platform == "darwin":
            opened.setsockopt(*_BOUND_INTERFACE, index)
    except OSError as error:
        log.debug("%s cannot be chosen for a socket: %s", interface.name, error)
