"""USB descriptors of a USB3 Vision camera: interface classes and the device-info descriptor."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from grabbergui.core.errors import RemoteProtocolError

MISCELLANEOUS_CLASS = 0xEF
U3V_SUBCLASS = 0x05
CONTROL_PROTOCOL = 0x00
EVENT_PROTOCOL = 0x01
STREAM_PROTOCOL = 0x02

CLASS_SPECIFIC_INTERFACE = 0x24
DEVICE_INFO_SUBTYPE = 0x01

SPEED_NAMES = {1: "low speed", 2: "full speed", 3: "High-Speed", 4: "SuperSpeed", 5: "SuperSpeed+"}
"By libusb's speed code."


@dataclass(frozen=True)
class DeviceInfoDescriptor:
    """The class-specific descriptor behind the control interface's own; 20 bytes, little-endian.

    The fields that end in `_index` are string descriptors' indices; 0: there is none.
    """

    FORMAT: ClassVar[struct.Struct] = struct.Struct("<BBBII9B")

    gencp_version: int
    "Major in the high 16 bits, minor in the low."
    u3v_version: int
    guid_index: int
    "12 characters: 4 of the vendor's id, 8 of the unit."
    vendor_index: int = 0
    model_index: int = 0
    family_index: int = 0
    version_index: int = 0
    manufacturer_info_index: int = 0
    serial_index: int = 0
    user_name_index: int = 0
    speeds: int = 0x08
    "Bits: 0 low, 1 full, 2 high, 3 super, 4 super-plus."

    def encode(self) -> bytes:
        """Return the descriptor's 20 bytes."""
        return self.FORMAT.pack(
            self.FORMAT.size,
            CLASS_SPECIFIC_INTERFACE,
            DEVICE_INFO_SUBTYPE,
            self.gencp_version,
            self.u3v_version,
            self.guid_index,
            self.vendor_index,
            self.model_index,
            self.family_index,
            self.version_index,
            self.manufacturer_info_index,
            self.serial_index,
            self.user_name_index,
            self.speeds,
        )

    @classmethod
    def decode(cls, data: bytes) -> DeviceInfoDescriptor:
        """Read one; longer ones are read as far as they are known. Raises RemoteProtocolError."""
        if len(data) < cls.FORMAT.size:
            raise RemoteProtocolError(f"device-info descriptor of {len(data)} bytes, need {cls.FORMAT.size}")
        _, kind, subtype, *fields = cls.FORMAT.unpack_from(data)
        if (kind, subtype) != (CLASS_SPECIFIC_INTERFACE, DEVICE_INFO_SUBTYPE):
            raise RemoteProtocolError(f"descriptor 0x{kind:02X}/0x{subtype:02X} is no device-info descriptor")
        return cls(*fields)

    @classmethod
    def find(cls, extra: bytes) -> DeviceInfoDescriptor | None:
        """Return the first one among the descriptors that follow an interface's, if any is whole."""
        head = bytes((CLASS_SPECIFIC_INTERFACE, DEVICE_INFO_SUBTYPE))
        whole = (
            descriptor
            for descriptor in split(extra)
            if descriptor[1:3] == head and len(descriptor) >= cls.FORMAT.size
        )
        first = next(whole, None)
        return None if first is None else cls.decode(first)


def split(descriptors: bytes) -> Iterator[bytes]:
    """Yield each descriptor of a chain; stop at an invalid length."""
    position = 0
    while position + 2 <= len(descriptors):
        length = descriptors[position]
        if length < 2 or position + length > len(descriptors):
            return
        yield descriptors[position : position + length]
        position += length
