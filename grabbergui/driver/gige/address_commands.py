"""FORCEIP and ACTION, which need no open camera, and the persistent address of an open one.

At power-on a camera tries its persistent address, DHCP and a link-local address, as far as each is enabled,
and keeps the first that works (GigE Vision 2.x, 16.1).
"""

from __future__ import annotations

import contextlib
import ipaddress
import logging
import socket
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from grabbergui.core.errors import (
    AckTimeoutError,
    DeviceStatusError,
    LocalProtocolError,
    RemoteProtocolError,
    SourceNotFoundError,
    TransportError,
    UsageError,
)
from grabbergui.core.uri import is_ip_address
from grabbergui.driver.gige.bootstrap import (
    GVCP_PORT,
    BootstrapRegister,
    IpConfigurationBit,
    ip_number,
    ip_text,
)
from grabbergui.driver.gige.device import GigeDevice
from grabbergui.driver.gige.discovery import LIMITED_BROADCAST
from grabbergui.driver.gige.gvcp import Ack, CommandCode, status_text
from grabbergui.driver.gige.gvcp_messages import Action
from grabbergui.driver.gige.identity import ForceIp
from grabbergui.driver.gige.interfaces import interfaces
from grabbergui.driver.gige.stream.waits import readable

log = logging.getLogger(__name__)

NONE = "0.0.0.0"
"No address, in an address register or in FORCEIP."
TRIES = 3
"How often FORCEIP is sent within its timeout, because a datagram may be lost."
_WAYS = {
    IpConfigurationBit.PERSISTENT: "its persistent address",
    IpConfigurationBit.DHCP: "DHCP",
    IpConfigurationBit.LINK_LOCAL: "a link-local address",
}


def force_ip(command: ForceIp, timeout: float = 1.0) -> str:
    """Give the camera with a MAC address an IP address until power-off; return the address that answered.

    The command goes to every network by broadcast, so the camera's present address does not matter. Raises
    UsageError for addresses that a camera cannot have, SourceNotFoundError if no camera acknowledges within
    `timeout` seconds, DeviceStatusError if the camera refuses.
    """
    if command.ip != NONE:
        check_addresses(command.ip, command.subnet_mask, command.gateway)
    try:
        datagram = command.encode(1)
    except LocalProtocolError as error:
        raise UsageError(f"force IP: {error.__cause__}; write e.g. 00:30:53:0a:0b:0c 192.168.0.10") from error
    with _broadcasters() as senders:
        for _ in range(TRIES):
            for sender, broadcast in senders:
                for target in {LIMITED_BROADCAST, broadcast}:
                    with contextlib.suppress(OSError):
                        sender.sendto(datagram, (target, GVCP_PORT))
            answer = _first_ack([sender for sender, _ in senders], CommandCode.FORCEIP, timeout / TRIES)
            if answer is not None:
                return answer
    raise SourceNotFoundError(
        f"no camera with the MAC address {command.mac} acknowledged {command.ip}; it may be switched off,"
        " in use by another application, or behind a router"
    )


def send_action(action: Action, addresses: Iterable[str], timeout: float = 0.5) -> None:
    """Send an action to cameras by address and wait until all have acknowledged.

    Raises AckTimeoutError naming those that did not, DeviceStatusError if a scheduled time has passed,
    TransportError for an address without a route.
    """
    waiting = set(addresses)
    datagram = action.encode(1)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for ip in sorted(waiting):
            try:
                sender.sendto(datagram, (ip, GVCP_PORT))
            except OSError as error:
                raise TransportError(f"no way to {ip}: {error.strerror or error}") from error
        deadline = time.monotonic() + timeout
        while waiting and (left := deadline - time.monotonic()) > 0:
            if not readable([sender], left):
                break
            answer = _ack(sender, CommandCode.ACTION)
            if answer is not None:
                waiting.discard(answer)
    if waiting:
        unheard = AckTimeoutError(
            f"the action was not acknowledged by {', '.join(sorted(waiting))}; check its device key, group"
            " key and group mask there"
        )
        unheard.addresses = frozenset(waiting)
        raise unheard


@contextlib.contextmanager
def _broadcasters() -> Iterator[list[tuple[socket.socket, str]]]:
    """Yield a socket on each interface that can broadcast, with its broadcast address."""
    with contextlib.ExitStack() as stack:
        senders = []
        for interface in interfaces():
            sender = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
            try:
                sender.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
                sender.bind((interface.ip, 0))
            except OSError as error:
                log.debug("cannot broadcast on %s: %s", interface.name, error)
                continue
            senders.append((sender, interface.broadcast))
        yield senders


def _first_ack(senders: list[socket.socket], command: CommandCode, timeout: float) -> str | None:
    deadline = time.monotonic() + timeout
    while (left := deadline - time.monotonic()) > 0:
        for sender in readable(senders, left):
            answer = _ack(sender, command)
            if answer is not None:
                return answer
    return None


def _ack(sender: socket.socket, command: CommandCode) -> str | None:
    """Return the address that acknowledged; None for other datagrams. Raises DeviceStatusError if refused."""
    try:
        datagram, (source, _) = sender.recvfrom(2048)
        ack = Ack.decode(datagram)
    except (OSError, RemoteProtocolError) as error:
        log.debug("an answer to %s: %s", command.name, error)
        return None
    if ack.acknowledge != command + 1:
        return None
    if ack.failed:
        raise DeviceStatusError(f"{source} refuses {command.name}: {status_text(ack.status)}", ack.status)
    return str(source)


@dataclass(frozen=True)
class IpConfiguration:
    """Content of a camera's address registers."""

    current_ip: str
    ways: IpConfigurationBit
    "Ways tried at power-on."
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


def read_configuration(device: GigeDevice) -> IpConfiguration:
    """Read the bootstrap registers of an open GigE Vision device. Raises as `GigeDevice.read`."""
    return IpConfiguration(
        current_ip=_address(device, BootstrapRegister.CURRENT_IP),
        ways=_bits(device, BootstrapRegister.CURRENT_IP_CONFIGURATION),
        persistent_ip=_address(device, BootstrapRegister.PERSISTENT_IP),
        persistent_mask=_address(device, BootstrapRegister.PERSISTENT_SUBNET_MASK),
        persistent_gateway=_address(device, BootstrapRegister.PERSISTENT_GATEWAY),
    )


def keep_address(device: GigeDevice, ip: str, mask: str, gateway: str = NONE) -> IpConfiguration:
    """Write the address that the camera uses from its next power-on; return its registers afterwards.

    Raises UsageError for addresses that do not fit together, TransportError if the camera cannot or does not
    keep them, and as `GigeDevice.write`.
    """
    check_addresses(ip, mask, gateway)
    _require(device, IpConfigurationBit.PERSISTENT)
    wanted = {
        BootstrapRegister.PERSISTENT_IP: ip,
        BootstrapRegister.PERSISTENT_SUBNET_MASK: mask,
        BootstrapRegister.PERSISTENT_GATEWAY: gateway,
    }
    for register, address in wanted.items():
        device.write_number(register, ip_number(address))
    ways = _bits(device, BootstrapRegister.CURRENT_IP_CONFIGURATION) | IpConfigurationBit.PERSISTENT
    device.write_number(BootstrapRegister.CURRENT_IP_CONFIGURATION, ways)
    kept = read_configuration(device)
    held = (kept.persistent_ip, kept.persistent_mask, kept.persistent_gateway)
    if held != tuple(wanted.values()) or IpConfigurationBit.PERSISTENT not in kept.ways:
        raise TransportError(f"{device.info.title} did not keep {ip}: {kept}")
    return kept


def forget_address(device: GigeDevice) -> IpConfiguration:
    """Let the camera use DHCP or a link-local address from its next power-on; return its registers.

    Raises as `keep_address`.
    """
    ways = _bits(device, BootstrapRegister.CURRENT_IP_CONFIGURATION) & ~IpConfigurationBit.PERSISTENT
    others = IpConfigurationBit.DHCP | IpConfigurationBit.LINK_LOCAL
    ways |= _bits(device, BootstrapRegister.SUPPORTED_IP_CONFIGURATION) & others
    device.write_number(BootstrapRegister.CURRENT_IP_CONFIGURATION, ways)
    return read_configuration(device)


def check_addresses(ip: str, mask: str, gateway: str = NONE) -> None:
    """Raise UsageError unless a camera can have this address, mask and gateway."""
    for what, text in (("address", ip), ("gateway", gateway)):
        if not is_ip_address(text):
            raise UsageError(f"'{text}' is no {what}; write four numbers, as in 192.168.0.10")
    router = ipaddress.IPv4Address(gateway)
    try:
        interface = ipaddress.IPv4Interface(f"{ip}/{mask}")
    except ValueError as error:
        raise UsageError(f"{mask} is no subnet mask; write e.g. 255.255.255.0") from error
    if mask != str(interface.netmask):  # a prefix length, or a mask with all bits inverted
        raise UsageError(f"{mask} is no subnet mask; write e.g. 255.255.255.0")
    network = interface.network
    if network.prefixlen < 31 and interface.ip in (network.network_address, network.broadcast_address):
        raise UsageError(f"{ip} with mask {mask} names the network itself, not a camera in it")
    if interface.ip.is_multicast or interface.ip.is_unspecified:
        raise UsageError(f"{ip} cannot be a camera's address")
    if gateway != NONE and router not in network:
        raise UsageError(f"the gateway {gateway} is not in the camera's network {network}")


def _require(device: GigeDevice, way: IpConfigurationBit) -> None:
    supported = _bits(device, BootstrapRegister.SUPPORTED_IP_CONFIGURATION)
    if way not in supported:
        raise TransportError(
            f"{device.info.title} cannot keep an address of its own; let DHCP give it one, by its MAC address"
        )


def _bits(device: GigeDevice, register: BootstrapRegister) -> IpConfigurationBit:
    return IpConfigurationBit(device.read_number(register) & 0x7)


def _address(device: GigeDevice, register: BootstrapRegister) -> str:
    return ip_text(device.read_number(register))
