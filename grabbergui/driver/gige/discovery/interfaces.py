"""The host's IPv4 interfaces as psutil reports them on every system, and waiting for sockets.

`select.select` raises for descriptors from 1024 on, and Windows has no `poll`; `selectors` knows what a
system has.
"""

from __future__ import annotations

import ipaddress
import os
import select
import selectors
import socket
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import psutil

DEFAULT_MTU = 1500
"Of an interface whose MTU the system does not report."


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
        """The subnet this address is in."""
        return ipaddress.IPv4Network((self.ip, self.netmask), strict=False)

    @property
    def broadcast(self) -> str:
        """Directed broadcast, from the mask: what systems report is wrong on link-local links."""
        return str(self.network.broadcast_address)

    def reaches(self, ip: str) -> bool:
        """Whether an address lies in the same subnet."""
        return ipaddress.IPv4Address(ip) in self.network


ONLY = "GRABBERGUI_INTERFACES"
"""Environment variable: names of the only interfaces to use, separated by commas; all without it."""


def interfaces() -> list[Interface]:
    """Return every IPv4 address of every interface that is up, or of those that the user allows (`ONLY`)."""
    allowed = {name.strip() for name in os.environ.get(ONLY, "").split(",")} - {""}
    return [interface for interface in _all_interfaces() if not allowed or interface.name in allowed]


def interface_of(ip: str) -> Interface:
    """Return the interface that has a local address, or one with usual values if none is reported."""
    for interface in interfaces():
        if interface.ip == ip or (interface.loopback and interface.reaches(ip)):
            return interface
    return Interface("", ip, loopback=ip.startswith("127."))


def _all_interfaces() -> list[Interface]:
    found = []
    links = psutil.net_if_stats()
    for name, addresses in psutil.net_if_addrs().items():
        link = links.get(name.partition(":")[0])  # an alias (`eth0:1`) is on the link of the first name
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


def readable(sockets: Iterable[socket.socket], timeout: float) -> list[socket.socket]:
    """Return those sockets that have something to read, after at most `timeout` seconds."""
    with selectors.DefaultSelector() as selector:
        for each in sockets:
            selector.register(each, selectors.EVENT_READ, each)
        return [key.data for key, _ in selector.select(timeout)]


def waiter(sockets: Iterable[socket.socket]) -> Callable[[float], list[int]]:
    """Return a function that waits up to so many seconds and returns the descriptors that can be read.

    For a loop: the sockets are registered once, and nothing must be closed afterwards. Not on Windows.
    """
    if sys.platform == "win32":
        raise OSError("Windows has no poll")
    poll = select.poll()
    for each in sockets:
        poll.register(each, select.POLLIN)
    return lambda timeout: [descriptor for descriptor, _ in poll.poll(1000 * timeout)]
