"""GVCP messages of discovery: the identity of a device, and FORCEIP, which gives it an address."""

from __future__ import annotations

import re
import socket
import struct
from collections.abc import Callable
from dataclasses import dataclass
from ipaddress import IPv4Address
from typing import ClassVar

from grabbergui.core.device_text import text_field
from grabbergui.core.errors import LocalProtocolError, RemoteProtocolError
from grabbergui.driver.gige.bootstrap import IDENTITY_BYTES, VENDOR
from grabbergui.driver.gige.gvcp import FLAG_ACK_REQUIRED, FLAG_BROADCAST_ACK, CommandCode, encode_command

NO_MAC = "00:00:00:00:00:00"

DISCOVERY_REQ_ID = 0xFFFF
_NUMBERS = VENDOR.address // 4
"Words before the strings, which have no byte order."


def encode_discovery(req_id: int = DISCOVERY_REQ_ID, *, allow_broadcast_ack: bool = False) -> bytes:
    """Return the datagram of DISCOVERY_CMD.

    With `allow_broadcast_ack` a device in another subnet can answer too.
    """
    flags = FLAG_ACK_REQUIRED | (FLAG_BROADCAST_ACK if allow_broadcast_ack else 0)
    return encode_command(CommandCode.DISCOVERY, b"", req_id, flags)


@dataclass(frozen=True)
class Identity:
    """Payload of DISCOVERY_ACK, and the content of registers 0x0000 to 0x00F7."""

    FORMAT: ClassVar[struct.Struct] = struct.Struct(">HHI2x6sII12x4s12x4s12x4s32s32s32s48s16s16s")

    mac: str = "00:00:00:00:00:00"
    "Lower case, with colons."
    ip: str = "0.0.0.0"
    subnet_mask: str = "0.0.0.0"
    gateway: str = "0.0.0.0"
    vendor: str = ""
    model: str = ""
    version: str = ""
    manufacturer_info: str = ""
    serial: str = ""
    user_name: str = ""
    spec_version: tuple[int, int] = (2, 0)
    "Version of GigE Vision: major, minor."
    device_mode: int = 0x80000001
    supported_ip_configuration: int = 7
    current_ip_configuration: int = 6

    def encode(self) -> bytes:
        """Return the 248 bytes."""
        return self.FORMAT.pack(
            *self.spec_version,
            self.device_mode,
            bytes.fromhex(self.mac.replace(":", "")),
            self.supported_ip_configuration,
            self.current_ip_configuration,
            *(socket.inet_aton(address) for address in (self.ip, self.subnet_mask, self.gateway)),
            *(
                text.encode()
                for text in (
                    self.vendor,
                    self.model,
                    self.version,
                    self.manufacturer_info,
                    self.serial,
                    self.user_name,
                )
            ),
        )

    @classmethod
    def decode(cls, payload: bytes) -> Identity:
        """Read at least 248 bytes. Raises RemoteProtocolError."""
        if len(payload) < IDENTITY_BYTES:
            raise RemoteProtocolError(f"DISCOVERY_ACK of {len(payload)} bytes, need {IDENTITY_BYTES}")
        major, minor, mode, mac, supported, current, *rest = cls.FORMAT.unpack_from(payload)
        ip, mask, gateway = (socket.inet_ntoa(raw) for raw in rest[:3])
        vendor, model, version, info, serial, user_name = (text_field(raw) for raw in rest[3:])
        return cls(
            mac=mac.hex(":"),
            ip=ip,
            subnet_mask=mask,
            gateway=gateway,
            vendor=vendor,
            model=model,
            version=version,
            manufacturer_info=info,
            serial=serial,
            user_name=user_name,
            spec_version=(major, minor),
            device_mode=mode,
            supported_ip_configuration=supported,
            current_ip_configuration=current,
        )


def identity_of(read: Callable[[int, int], bytes]) -> Identity:
    """Return the identity in a device's first registers, also from one whose memory is little-endian.

    `read` takes an address and a length in bytes, as READMEM does; its errors pass through. Raises
    RemoteProtocolError.
    """
    data = read(0, IDENTITY_BYTES)
    # The upper half of the first word is GigE Vision's major version.
    major, swapped_major = int.from_bytes(data[0:2], "big"), int.from_bytes(data[2:4], "little")
    if not 0 < major < 256 and 0 < swapped_major < 256:
        numbers = struct.unpack_from(f"<{_NUMBERS}I", data)
        data = struct.pack(f">{_NUMBERS}I", *numbers) + data[4 * _NUMBERS :]
    return Identity.decode(data)


def identity_texts(read: Callable[[int, int], bytes]) -> dict[str, str]:
    """Return the identity registers of an open camera as fields of `DeviceInfo`.

    `read` takes an address and a length in bytes; its errors pass through. Raises RemoteProtocolError.
    """
    identity = identity_of(read)
    return {
        "vendor": identity.vendor,
        "model": identity.model,
        "version": identity.version,
        "serial": identity.serial,
        "user_name": identity.user_name,
        "hardware_id": identity.mac if identity.mac != NO_MAC else "",
    }


@dataclass(frozen=True)
class ForceIp:
    """FORCEIP_CMD: gives the device with this MAC address an IP address until power-off."""

    FORMAT: ClassVar[struct.Struct] = struct.Struct(">2x6s12x4s12x4s12x4s")

    mac: str
    ip: str
    "`0.0.0.0` restarts the device's own search for an address."
    subnet_mask: str = "255.255.255.0"
    gateway: str = "0.0.0.0"

    def encode(self, req_id: int, *, allow_broadcast_ack: bool = True) -> bytes:
        """Return the datagram, for broadcast. Raises LocalProtocolError for malformed addresses."""
        flags = FLAG_ACK_REQUIRED | (FLAG_BROADCAST_ACK if allow_broadcast_ack else 0)
        try:
            payload = self.FORMAT.pack(
                parse_mac(self.mac),
                # Not inet_aton: it reads "192.168.1" as 192.168.0.1 and ignores text after an address.
                *(IPv4Address(address).packed for address in (self.ip, self.subnet_mask, self.gateway)),
            )
        except ValueError as error:
            raise LocalProtocolError(f"{self}: {error}") from error
        return encode_command(CommandCode.FORCEIP, payload, req_id, flags)

    @classmethod
    def decode(cls, payload: bytes) -> ForceIp:
        """Read the command's payload. Raises RemoteProtocolError."""
        if len(payload) != cls.FORMAT.size:
            raise RemoteProtocolError(f"FORCEIP of {len(payload)} bytes, need {cls.FORMAT.size}")
        mac, *addresses = cls.FORMAT.unpack(payload)
        return cls(mac.hex(":"), *(socket.inet_ntoa(raw) for raw in addresses))


def parse_mac(text: str) -> bytes:
    """Return six bytes from `00:30:53:0a:0b:0c`, `00-30-53-0A-0B-0C` or `0030530a0b0c`. Raises ValueError."""
    digits = text.replace(":", "").replace("-", "")
    if not re.fullmatch(r"[0-9A-Fa-f]{12}", digits):
        raise ValueError(f"'{text}' is no MAC address")
    return bytes.fromhex(digits)
