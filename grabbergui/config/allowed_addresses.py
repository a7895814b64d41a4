"""The addresses and networks whose requests are answered."""

from __future__ import annotations

import ipaddress
from collections.abc import Iterable

from grabbergui.core.errors import UsageError

_Network = ipaddress.IPv4Network | ipaddress.IPv6Network
_MAPPED_PREFIX = 96
"""Bits before the IPv4 address in an IPv6 one such as `::ffff:10.0.0.1`."""


class AllowedAddresses:
    """A set of networks. Without any, every address is allowed; this computer is always allowed."""

    def __init__(self, networks: Iterable[_Network] = ()) -> None:
        self._networks = tuple(networks)

    @classmethod
    def parse(cls, texts: Iterable[str]) -> AllowedAddresses:
        """Read `10.0.0.0/24` and `192.168.1.7`. Raises UsageError."""
        return cls(_network(text) for text in texts)

    @property
    def everybody(self) -> bool:
        """Whether every address is allowed."""
        return not self._networks

    def allows(self, address: str, own: str = "") -> bool:
        """Return whether a peer at `address` is allowed; `own` is the local address of the connection."""
        if not self._networks or address == own:
            return True
        try:
            peer = ipaddress.ip_address(address.partition("%")[0])
        except ValueError:
            return False
        if isinstance(peer, ipaddress.IPv6Address) and peer.ipv4_mapped:
            peer = peer.ipv4_mapped
        return peer.is_loopback or any(peer in network for network in self._networks)

    @property
    def hosts(self) -> list[str] | None:
        """The single addresses; None if a network is allowed, which has too many to list."""
        if any(network.num_addresses > 1 for network in self._networks):
            return None
        return [str(network.network_address) for network in self._networks]

    def __str__(self) -> str:
        return ", ".join(map(str, self._networks)) or "everybody"


EVERYBODY = AllowedAddresses()


def _network(text: str) -> _Network:
    try:
        network = ipaddress.ip_network(text.strip(), strict=False)
    except ValueError as error:
        raise UsageError(f"--allow {text}: write an address or a network, as 10.0.0.0/24") from error
    mapped = network.network_address.ipv4_mapped if isinstance(network, ipaddress.IPv6Network) else None
    if mapped and network.prefixlen >= _MAPPED_PREFIX:
        return ipaddress.IPv4Network((mapped, network.prefixlen - _MAPPED_PREFIX))
    return network
