"""The bootstrap registers, which every GigE Vision device has at fixed addresses.

Addresses are in bytes; a register is 32 bits, big-endian, unless a length is given. Masks apply to the
value after decoding (bit 0 = 0x00000001).
"""

from __future__ import annotations

import socket
from dataclasses import dataclass
from enum import IntEnum, IntFlag

GVCP_PORT = 3956
"UDP port on which a device listens for commands."

IDENTITY_BYTES = 248
"Registers 0x0000 to 0x00F7 are what a DISCOVERY_ACK carries."
BIG_ENDIAN_MODE = 0x80000000
"In `BootstrapRegister.DEVICE_MODE`: the device's memory is big-endian."
PACKET_SIZE_MASK = 0xFFFF
PORT_MASK = 0xFFFF
STREAM_CHANNELS_MASK = 0x1FF
"The number of channels in `BootstrapRegister.STREAM_CHANNELS`."
_CHANNEL = {"SCP": 0x00, "SCPS": 0x04, "SCPD": 0x08, "SCDA": 0x18, "SCSP": 0x1C, "SCC": 0x20, "SCCFG": 0x24}
"Registers of a stream channel, from its first."


class BootstrapRegister(IntEnum):
    """Addresses of 32-bit registers."""

    VERSION = 0x0000
    DEVICE_MODE = 0x0004
    MAC_HIGH = 0x0008
    MAC_LOW = 0x000C
    SUPPORTED_IP_CONFIGURATION = 0x0010
    CURRENT_IP_CONFIGURATION = 0x0014
    CURRENT_IP = 0x0024
    CURRENT_SUBNET_MASK = 0x0034
    CURRENT_GATEWAY = 0x0044
    PERSISTENT_IP = 0x064C
    PERSISTENT_SUBNET_MASK = 0x065C
    PERSISTENT_GATEWAY = 0x066C
    LINK_SPEED = 0x0670
    MESSAGE_CHANNELS = 0x0900
    STREAM_CHANNELS = 0x0904
    ACTION_SIGNALS = 0x0908
    ACTION_DEVICE_KEY = 0x090C
    STREAM_CAPABILITY = 0x092C
    MESSAGE_CAPABILITY = 0x0930
    GVCP_CAPABILITY = 0x0934
    HEARTBEAT_TIMEOUT_MS = 0x0938
    TICK_FREQUENCY_HIGH = 0x093C
    TICK_FREQUENCY_LOW = 0x0940
    TIMESTAMP_CONTROL = 0x0944
    TIMESTAMP_HIGH = 0x0948
    TIMESTAMP_LOW = 0x094C
    GVCP_CONFIGURATION = 0x0954
    PENDING_TIMEOUT_MS = 0x0958
    CONTROL_SWITCHOVER_KEY = 0x095C
    GVSP_CONFIGURATION = 0x0960
    SCHEDULED_ACTIONS = 0x0970
    CCP = 0x0A00
    PRIMARY_APPLICATION_PORT = 0x0A04
    PRIMARY_APPLICATION_IP = 0x0A14
    MCP = 0x0B00
    MCDA = 0x0B10
    MCTT_MS = 0x0B14
    MCRC = 0x0B18
    MCSP = 0x0B1C


@dataclass(frozen=True)
class Field:
    """A run of bytes with a fixed length: a string, padded with zeros."""

    address: int
    length: int


VENDOR = Field(0x0048, 32)
MODEL = Field(0x0068, 32)
DEVICE_VERSION = Field(0x0088, 32)
MANUFACTURER_INFO = Field(0x00A8, 48)
SERIAL_NUMBER = Field(0x00D8, 16)
USER_NAME = Field(0x00E8, 16)
FIRST_URL = Field(0x0200, 512)
SECOND_URL = Field(0x0400, 512)


@dataclass(frozen=True)
class StreamChannel:
    """Addresses of one stream channel's registers."""

    index: int = 0

    def _at(self, address: int) -> int:
        return address + 0x40 * self.index

    @property
    def port(self) -> int:
        """SCP: the host's UDP port in 0xFFFF; 0 closes the channel."""
        return self._at(0x0D00)

    @property
    def packet_size(self) -> int:
        """SCPS: bytes of a packet, IP and UDP headers included, and `PacketSizeFlag`."""
        return self._at(0x0D04)

    @property
    def packet_delay(self) -> int:
        """SCPD: pause between packets, in timestamp ticks."""
        return self._at(0x0D08)

    @property
    def destination(self) -> int:
        """SCDA: the IP address that packets go to; may be multicast."""
        return self._at(0x0D18)

    @property
    def source_port(self) -> int:
        """SCSP: the device's UDP port, 0 if it does not report one."""
        return self._at(0x0D1C)


class GvcpCapability(IntFlag):
    """GVCP capability, register 0x0934."""

    CONCATENATION = 0x1
    WRITEMEM = 0x2
    PACKETRESEND = 0x4
    EVENT = 0x8
    EVENTDATA = 0x10
    PENDING_ACK = 0x20
    ACTION = 0x40
    SCHEDULED_ACTION = 0x20000
    IEEE1588 = 0x80000
    SWITCHOVER = 0x200000
    TEST_DATA = 0x2000000
    "Test packets hold a known pattern; every device can send one, of whatever content."
    PRIMARY_APPLICATION = 0x8000000
    LINK_SPEED = 0x10000000
    HEARTBEAT_DISABLE = 0x20000000
    SERIAL_NUMBER = 0x40000000
    USER_NAME = 0x80000000


class MessageCapability(IntFlag):
    """Message channel capability, register 0x0930."""

    SOURCE_PORT = 0x80000000
    "MCSP holds the port that messages are sent from."


class ControlPrivilege(IntFlag):
    """Control channel privilege, register CCP."""

    EXCLUSIVE = 0x1
    CONTROL = 0x2
    SWITCHOVER = 0x4


class GvcpConfiguration(IntFlag):
    """GVCP configuration, register 0x0954."""

    HEARTBEAT_DISABLE = 0x1
    PENDING_ACK = 0x2
    UNCONDITIONAL_ACTION = 0x8
    IEEE1588 = 0x80000


class GvspConfiguration(IntFlag):
    """Bits of `BootstrapRegister.GVSP_CONFIGURATION`."""

    EXTENDED_IDS = 0x40000000
    "64-bit block ids, in packet headers of 20 bytes."


class IpConfigurationBit(IntFlag):
    """Ways to an address, registers 0x0010 (supported) and 0x0014 (switched on)."""

    PERSISTENT = 0x1
    DHCP = 0x2
    LINK_LOCAL = 0x4


class PacketSizeFlag(IntFlag):
    """Flags next to the size in SCPS."""

    BIG_ENDIAN_PIXELS = 0x20000000
    DO_NOT_FRAGMENT = 0x40000000
    FIRE_TEST_PACKET = 0x80000000


_FIELDS = {
    "VENDOR": VENDOR,
    "MODEL": MODEL,
    "DEVICE_VERSION": DEVICE_VERSION,
    "MANUFACTURER_INFO": MANUFACTURER_INFO,
    "SERIAL_NUMBER": SERIAL_NUMBER,
    "USER_NAME": USER_NAME,
    "FIRST_URL": FIRST_URL,
    "SECOND_URL": SECOND_URL,
}


def known_registers(channels: int) -> list[tuple[str, int, int]]:
    """Return name, address and length of every register here, with those of so many stream channels."""
    found = [(register.name, int(register), 4) for register in BootstrapRegister]
    found += [(name, field.address, field.length) for name, field in _FIELDS.items()]
    for index in range(channels):
        first = StreamChannel(index).port
        found += [(f"{name}{index}", first + offset, 4) for name, offset in _CHANNEL.items()]
    return sorted(found, key=lambda register: register[1])


def ip_number(address: str) -> int:
    """Return an IPv4 address as registers hold it."""
    return int.from_bytes(socket.inet_aton(address), "big")


def ip_text(number: int) -> str:
    """Return the IPv4 address in a register."""
    return socket.inet_ntoa(number.to_bytes(4, "big"))
