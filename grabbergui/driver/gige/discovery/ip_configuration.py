"""How a camera gets its address at power-on, and writing a persistent one.

GigE Vision 2.x, 16.1: a persistent address, DHCP and a link-local address, each switched on or off; the first
of them that works is taken.
"""

from __future__ import annotations

import ipaddress
import struct
from dataclasses import dataclass

from grabbergui.core.errors import TransportError, UsageError
from grabbergui.driver.device import Device
from grabbergui.driver.gige.bootstrap import IpConfigurationBit, Register

NONE = "0.0.0.0"


@dataclass(frozen=True)
class IpConfiguration:
    """Content of a camera's address registers."""

    current_ip: str
    ways: IpConfigurationBit
    "Ways tried at power-on."
    supported: IpConfigurationBit
    persistent_ip: str = NONE
    persistent_mask: str = NONE
    persistent_gateway: str = NONE

    def __str__(self) -> str:
        tried = [name for bit, name in _WAYS.items() if bit in self.ways]
        text = f"{self.current_ip} now; at power-on: {', then '.join(tried) or 'nothing is tried'}"
        if IpConfigurationBit.PERSISTENT in self.ways:
            text += f" ({self.persistent_ip}, mask {self.persistent_mask}"
            text += f", gateway {self.persistent_gateway})" if self.persistent_gateway != NONE else ")"
        return text


_WAYS = {
    IpConfigurationBit.PERSISTENT: "its persistent address",
    IpConfigurationBit.DHCP: "DHCP",
    IpConfigurationBit.LINK_LOCAL: "a link-local address",
}


def read_configuration(device: Device) -> IpConfiguration:
    """From the bootstrap registers of an open GigE Vision device. Raises as `Device.read`."""
    return IpConfiguration(
        current_ip=_address(device, Register.CURRENT_IP),
        ways=_bits(device, Register.CURRENT_IP_CONFIGURATION),
        supported=_bits(device, Register.SUPPORTED_IP_CONFIGURATION),
        persistent_ip=_address(device, Register.PERSISTENT_IP),
        persistent_mask=_address(device, Register.PERSISTENT_SUBNET_MASK),
        persistent_gateway=_address(device, Register.PERSISTENT_GATEWAY),
    )


def keep_address(device: Device, ip: str, mask: str, gateway: str = NONE) -> IpConfiguration:
    """Write the address that the camera uses from its next power-on; return what it then reports.

    Raises UsageError for addresses that make no sense together, TransportError for a camera that cannot or
    does not keep them, and as `Device.write`.
    """
    check_addresses(ip, mask, gateway)
    _require(device, IpConfigurationBit.PERSISTENT)
    wanted = {
        Register.PERSISTENT_IP: ip,
        Register.PERSISTENT_SUBNET_MASK: mask,
        Register.PERSISTENT_GATEWAY: gateway,
    }
    for register, address in wanted.items():
        device.write(register, ipaddress.IPv4Address(address).packed)
    ways = _bits(device, Register.CURRENT_IP_CONFIGURATION) | IpConfigurationBit.PERSISTENT
    device.write(Register.CURRENT_IP_CONFIGURATION, struct.pack(">I", ways))
    kept = read_configuration(device)
    held = (kept.persistent_ip, kept.persistent_mask, kept.persistent_gateway)
    if held != tuple(wanted.values()) or IpConfigurationBit.PERSISTENT not in kept.ways:
        raise TransportError(f"{device.info.title} did not keep {ip}: {kept}")
    return kept


def forget_address(device: Device) -> IpConfiguration:
    """Let the camera ask DHCP, or take a link-local address, from its next power-on; what it then reports.

    Raises as `keep_address`.
    """
    ways = _bits(device, Register.CURRENT_IP_CONFIGURATION) & ~IpConfigurationBit.PERSISTENT
    others = IpConfigurationBit.DHCP | IpConfigurationBit.LINK_LOCAL
    ways |= _bits(device, Register.SUPPORTED_IP_CONFIGURATION) & others
    device.write(Register.CURRENT_IP_CONFIGURATION, struct.pack(">I", ways))
    return read_configuration(device)


def check_addresses(ip: str, mask: str, gateway: str = NONE) -> None:
    """Raise UsageError unless a camera could live with these."""
    try:
        interface = ipaddress.IPv4Interface(f"{ip}/{mask}")
        router = ipaddress.IPv4Address(gateway)
    except ValueError as error:
        raise UsageError(f"{error}; write e.g. 192.168.0.10 255.255.255.0") from error
    network = interface.network
    if network.prefixlen < 31 and interface.ip in (network.network_address, network.broadcast_address):
        raise UsageError(f"{ip} with mask {mask} names the network itself, not a camera in it")
    if interface.ip.is_multicast or interface.ip.is_unspecified:
        raise UsageError(f"{ip} cannot be a camera's address")
    if gateway != NONE and router not in network:
        raise UsageError(f"the gateway {gateway} is not in the camera's network {network}")


def _require(device: Device, way: IpConfigurationBit) -> None:
    supported = _bits(device, Register.SUPPORTED_IP_CONFIGURATION)
    if way not in supported:
        raise TransportError(
            f"{device.info.title} cannot keep an address of its own; let DHCP give it one, by its MAC address"
        )


def _bits(device: Device, register: Register) -> IpConfigurationBit:
    (value,) = struct.unpack(">I", device.read(register, 4))
    return IpConfigurationBit(value & 0x7)


def _address(device: Device, register: Register) -> str:
    return str(ipaddress.IPv4Address(device.read(register, 4)))
