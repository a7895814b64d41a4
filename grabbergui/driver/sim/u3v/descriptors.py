"""The simulated USB3 Vision camera's USB descriptors, SuperSpeed."""

from __future__ import annotations

import struct
from dataclasses import dataclass

from grabbergui.driver.u3v.descriptors import (
    CONTROL_PROTOCOL,
    EVENT_PROTOCOL,
    MISCELLANEOUS_CLASS,
    STREAM_PROTOCOL,
    U3V_SUBCLASS,
    DeviceInfoDescriptor,
)

VENDOR_ID, PRODUCT_ID = 0x1209, 0x0001
"pid.codes' number for private experiments."

CONTROL_IN, CONTROL_OUT, EVENT_IN, STREAM_IN = 0x81, 0x01, 0x82, 0x83
CONTROL_INTERFACE, EVENT_INTERFACE, STREAM_INTERFACE = 0, 1, 2
PACKET_SIZE = 1024
"Bytes of a bulk packet at SuperSpeed."

DEVICE, CONFIGURATION, STRING, BOS = 1, 2, 3, 15
"Descriptor types that a host asks for."

_BURST = 15
"Packets of a burst, minus one."


@dataclass(frozen=True)
class UsbIdentity:
    """The names in the string descriptors."""

    vendor: str
    model: str
    serial: str
    version: str
    user_name: str

    @property
    def guid(self) -> str:
        """Twelve characters: the vendor's four, the unit's eight."""
        return ("GRUI" + self.serial.rjust(8, "0")[-8:]).upper()


class Descriptors:
    """Answers GET_DESCRIPTOR."""

    def __init__(self, identity: UsbIdentity) -> None:
        self._strings = (
            identity.vendor,
            identity.model,
            identity.serial,
            identity.guid,
            identity.version,
            identity.user_name,
        )
        self.info = DeviceInfoDescriptor(
            gencp_version=0x0001_0001,
            u3v_version=0x0001_0000,
            guid_index=4,
            vendor_index=1,
            model_index=2,
            version_index=5,
            serial_index=3,
            user_name_index=6 if identity.user_name else 0,
        )

    def get(self, kind: int, index: int) -> bytes | None:
        """Return a descriptor; None if it does not exist, which a device answers with a stall."""
        if kind == DEVICE:
            return self.device()
        if kind == CONFIGURATION and index == 0:
            return self.configuration()
        if kind == BOS:
            return self.bos()
        if kind == STRING:
            return self.string(index)
        return None

    def device(self) -> bytes:
        """Return the device descriptor; strings 1 to 3 are vendor, model and serial number."""
        ids = (VENDOR_ID, PRODUCT_ID, 0x0100)
        return struct.pack(
            "<BBHBBBBHHHBBBB", 18, DEVICE, 0x0300, MISCELLANEOUS_CLASS, 2, 1, 9, *ids, 1, 2, 3, 1
        )

    def configuration(self) -> bytes:
        """Return the one configuration with its three interfaces."""
        association = struct.pack("<8B", 8, 0x0B, 0, 3, MISCELLANEOUS_CLASS, U3V_SUBCLASS, 0, 0)
        body = (
            association
            + _interface(CONTROL_INTERFACE, 2, CONTROL_PROTOCOL)
            + self.info.encode()
            + _endpoint(CONTROL_IN)
            + _endpoint(CONTROL_OUT)
            + _interface(EVENT_INTERFACE, 1, EVENT_PROTOCOL)
            + _endpoint(EVENT_IN)
            + _interface(STREAM_INTERFACE, 1, STREAM_PROTOCOL)
            + _endpoint(STREAM_IN)
        )
        # Self-powered, and 8 mA × 112 = 896 mA at most.
        return struct.pack("<BBHBBBBB", 9, CONFIGURATION, 9 + len(body), 3, 1, 0, 0xC0, 112) + body

    def bos(self) -> bytes:
        """Return the binary object store, which a SuperSpeed device must have."""
        extension = struct.pack("<BBBI", 7, 16, 2, 0)
        super_speed = struct.pack("<BBBBHBBH", 10, 16, 3, 0, 0x0008, 3, 10, 0x07FF)
        body = extension + super_speed
        return struct.pack("<BBHB", 5, BOS, 5 + len(body), 2) + body

    def string(self, index: int) -> bytes | None:
        """Return a string descriptor; 0 lists the languages."""
        if index == 0:
            return struct.pack("<BBH", 4, STRING, 0x0409)
        if index > len(self._strings):
            return None
        text = self._strings[index - 1].encode("utf-16-le")[:252]
        return bytes((2 + len(text), STRING)) + text


def _interface(number: int, endpoints: int, protocol: int) -> bytes:
    return struct.pack("<9B", 9, 4, number, 0, endpoints, MISCELLANEOUS_CLASS, U3V_SUBCLASS, protocol, 0)


def _endpoint(address: int) -> bytes:
    companion = struct.pack("<BBBBH", 6, 0x30, _BURST, 0, 0)
    return struct.pack("<BBBBHB", 7, 5, address, 2, PACKET_SIZE, 0) + companion
