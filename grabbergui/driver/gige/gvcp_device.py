"""GVCP messages about a device itself: DISCOVERY and FORCEIP."""

from __future__ import annotations

import re
import socket
import struct
from dataclasses import dataclass
from typing import ClassVar

from grabbergui.core.errors import LocalProtocolError, RemoteProtocolError
from grabbergui.driver.gige.bootstrap import IDENTITY_BYTES
from grabbergui.driver.gige.gvcp import FLAG_ACK_REQUIRED, FLAG_BROADCAST_ACK, CommandCode, encode_command

DISCOVERY_REQ_ID = 0xFFFF


def encode_discovery(req_id: int = DISCOVERY_REQ_ID, *, allow_broadcast_ack: bool = False) -> bytes:
    """The datagram of DISCOVERY_CMD.

    With `allow_broadcast_ack` a device in another subnet can be heard too.
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
    "Of GigE Vision: major, minor."
    device_mode: int = 0x80000001
    supported_ip_configuration: int = 7
    current_ip_configuration: int = 6

    def encode(self) -> bytes:
        """The 248 bytes."""
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
        vendor, model, version, info, serial, user_name = (text_of(raw) for raw in rest[3:])
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


def text_of(raw: bytes) -> str:
    """A string register: up to the first zero, whatever the bytes; unprintable characters are dropped."""
    text = raw.split(b"\0", 1)[0].decode("utf-8", "replace")
    return "".join(character for character in text if character.isprintable()).strip()


@dataclass(frozen=True)
class ForceIp:
    """FORCEIP_CMD: give the device with this MAC an address until it is switched off."""

    FORMAT: ClassVar[struct.Struct] = struct.Struct(">2x6s12x4s12x4s12x4s")

    mac: str
    ip: str
    "`0.0.0.0` restarts the device's own search for an address."
    subnet_mask: str = "255.255.255.0"
    gateway: str = "0.0.0.0"

    def encode(self, req_id: int, *, allow_broadcast_ack: bool = True) -> bytes:
        """The datagram, for broadcast. Raises LocalProtocolError for malformed addresses."""
        flags = FLAG_ACK_REQUIRED | (FLAG_BROADCAST_ACK if allow_broadcast_ack else 0)
        try:
            payload = self.FORMAT.pack(
                parse_mac(self.mac),
                *(socket.inet_aton(address) for address in (self.ip, self.subnet_mask, self.gateway)),
            )
        except (OSError, ValueError) as error:
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
    """Six bytes from `00:30:53:0a:0b:0c`, `00-30-53-0A-0B-0C` or `0030530a0b0c`. Raises ValueError."""
    digits = text.replace(":", "").replace("-", "")
    if not re.fullmatch(r"[0-9A-Fa-f]{12}", digits):
        raise ValueError(f"'{text}' is no MAC address")
    return bytes.fromhex(digits)
