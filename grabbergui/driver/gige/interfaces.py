"""The host's IPv4 interfaces, without packages: Linux by ioctl, elsewhere by host name."""

from __future__ import annotations

import ipaddress
import os
import socket
import struct
import sys
from dataclasses import dataclass

SIOCGIFCONF = 0x8912
SIOCGIFFLAGS = 0x8913
SIOCGIFNETMASK = 0x891B
SIOCGIFMTU = 0x8921
IFF_UP = 0x1
IFF_LOOPBACK = 0x8
IFREQ = struct.Struct("16s24s")
"A name and a union, on 64-bit Linux."

DEFAULT_MTU = 1500
"Where the system does not tell."


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
    """Every IPv4 address of every interface that is up, or of those that the user allows (`ONLY`)."""
    linux = sys.platform == "linux" and struct.calcsize("P") == 8
    found = _linux_interfaces() if linux else _portable_interfaces()
    allowed = {name.strip() for name in os.environ.get(ONLY, "").split(",")} - {""}
    return [interface for interface in found if not allowed or interface.name in allowed]


def interface_of(ip: str) -> Interface:
    """The interface that has a local address; a guess with usual figures where the system does not tell."""
    for interface in interfaces():
        if interface.ip == ip or (interface.loopback and interface.reaches(ip)):
            return interface
    return Interface("", ip, loopback=ip.startswith("127."))


def _linux_interfaces() -> list[Interface]:
    import array
    import fcntl

    found = []
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        room = array.array("B", bytes(256 * IFREQ.size))
        address, _ = room.buffer_info()
        answer = fcntl.ioctl(probe, SIOCGIFCONF, struct.pack("iP", len(room), address))
        used = struct.unpack("iP", answer)[0]
        for name, sockaddr in IFREQ.iter_unpack(room.tobytes()[: used - used % IFREQ.size]):

            def ask(code: int, name: bytes = name, sockaddr: bytes = sockaddr) -> bytes:
                return fcntl.ioctl(probe, code, IFREQ.pack(name, sockaddr))[16:]

            try:
                (flags,) = struct.unpack_from("h", ask(SIOCGIFFLAGS))
                netmask = socket.inet_ntoa(ask(SIOCGIFNETMASK)[4:8])
                (mtu,) = struct.unpack_from("i", ask(SIOCGIFMTU))
            except OSError:
                continue  # the interface went away while we asked
            if flags & IFF_UP:
                label = name.split(b"\0", 1)[0].decode("utf-8", "replace")
                ip = socket.inet_ntoa(sockaddr[4:8])
                found.append(Interface(label, ip, netmask, mtu, bool(flags & IFF_LOOPBACK)))
    return found


def _portable_interfaces() -> list[Interface]:
    try:
        rows = socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET, socket.SOCK_DGRAM)
    except OSError:
        rows = []
    addresses = dict.fromkeys(str(row[4][0]) for row in rows)
    addresses.pop("127.0.0.1", None)
    return [Interface("lo", "127.0.0.1", "255.0.0.0", 65535, True)] + [Interface(ip, ip) for ip in addresses]
