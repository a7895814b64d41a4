"""USB descriptors (SuperSpeed) and bootstrap registers of the simulated USB3 Vision camera.

The bootstrap registers lie in front of the registers of the camera itself.
"""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Callable
from dataclasses import dataclass

from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.camera_xml import camera_xml, zipped
from grabbergui.driver.sim.memory import Refusal, RegisterRefusedError
from grabbergui.driver.sim.model import CameraModel
from grabbergui.driver.u3v.bootstrap import (
    CONTROL_PROTOCOL,
    EVENT_PROTOCOL,
    MISCELLANEOUS_CLASS,
    STREAM_PROTOCOL,
    STRING_SIZE,
    U3V_SUBCLASS,
    Abrm,
    DeviceInfoDescriptor,
    Eirm,
    ManifestEntry,
    Sbrm,
    Sirm,
    StreamRequirements,
)
from grabbergui.driver.u3v.stream_protocol import EXTENDED_CHUNK_TRAILER_SIZE, IMAGE_LEADER_SIZE, TransferPlan

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
SBRM, SIRM, EIRM, MANIFEST, XML = 0x1000, 0x2000, 0x3000, 0x4000, 0x40_0000
"Addresses of the register maps."
BOOTSTRAP_END = 0x10000
LONGEST_TRANSFER = 1024
"Bytes of a command or acknowledge."
LONGEST_EVENT = 1024
RESPONSE_TIME_MS = 300
_LITTLE_ENDIAN = 0xFFFFFFFF
_SUPER_SPEED = 8


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


class U3vRegisters:
    """Memory by address, as the control channel sees it. Little-endian. Callers take turns."""

    def __init__(
        self, model: CameraModel, identity: UsbIdentity, alignment: int = 1, leader_space: int = 0
    ) -> None:
        self.model = model
        self.plan = TransferPlan(0, 0, 0, 0, 0, 0)
        "The transfer sizes that the host wrote into the stream's registers."
        self.stream_enabled = False
        self.events_enabled = False
        self.on_stream_control: Callable[[bool], None] = lambda enable: None
        "Called before the stream is switched; raises RegisterRefusedError or U3vRefusedError to refuse."
        self.on_test_event: Callable[[], None] = lambda: None
        self._identity = identity
        self._alignment = alignment
        self._leader_size = max(IMAGE_LEADER_SIZE, leader_space)
        self._trailer_size = max(EXTENDED_CHUNK_TRAILER_SIZE, leader_space)
        self._latched = 0
        self._xml = zipped("camera.xml", camera_xml())

    def requirements(self) -> StreamRequirements:
        """Return the sizes that the stream needs with the camera's present settings."""
        payload = self.model.memory.integer(reg.PAYLOAD_SIZE)
        return StreamRequirements(
            self._alignment, self.stream_enabled, payload, self._leader_size, self._trailer_size
        )

    def read(self, address: int, length: int) -> bytes:
        """Read a range within one map. Raises RegisterRefusedError."""
        maps = (
            (0, self._abrm),
            (SBRM, self._sbrm),
            (SIRM, self._sirm),
            (EIRM, self._eirm),
            (MANIFEST, self._manifest),
            (XML, lambda: self._xml),
        )
        for base, content in maps:
            size = len(content()) if base <= address else 0
            if base <= address and address + length <= base + size:
                return content()[address - base : address - base + length]
        if address < BOOTSTRAP_END:
            raise RegisterRefusedError(Refusal.INVALID_ADDRESS, f"no bootstrap register at 0x{address:x}")
        return self.model.read(address, length)

    def write(self, address: int, data: bytes) -> None:
        """Write one whole register, or the beginning of a string. Raises RegisterRefusedError."""
        if address >= BOOTSTRAP_END:
            self.model.write(address, data)
        elif Abrm.USER_DEFINED_NAME <= address < Abrm.USER_DEFINED_NAME + STRING_SIZE:
            self.model.write(reg.DEVICE_USER_ID.address, data[: reg.DEVICE_USER_ID.length])
        elif address == Abrm.TIMESTAMP_LATCH:
            self._latched = self.model.timestamp()
        elif address == SIRM + Sirm.CONTROL:
            self._switch_stream(bool(_number(data) & Sirm.STREAM_ENABLE))
        elif SIRM + TransferPlan.ADDRESS <= address < SIRM + Sirm.SIZE:
            self._write_plan(address - SIRM - TransferPlan.ADDRESS, data)
        elif address == EIRM + Eirm.CONTROL:
            self.events_enabled = bool(_number(data) & Eirm.EVENT_ENABLE)
        elif address == EIRM + Eirm.TEST_CONTROL:
            self.on_test_event()
        elif address not in (Abrm.DEVICE_CONFIGURATION, SBRM + Sbrm.CONFIGURATION):
            self.read(address, len(data))  # refuses an unmapped address
            raise RegisterRefusedError(Refusal.WRITE_PROTECT, f"0x{address:x} is read-only")

    def _switch_stream(self, enable: bool) -> None:
        self.on_stream_control(enable)
        self.stream_enabled = enable

    def _write_plan(self, offset: int, data: bytes) -> None:
        if self.stream_enabled:
            raise RegisterRefusedError(Refusal.ACCESS_DENIED, "the stream's sizes are frozen while it is on")
        content = bytearray(self.plan.encode())
        if offset % 4 or len(data) % 4 or offset + len(data) > len(content):
            raise RegisterRefusedError(Refusal.BAD_ALIGNMENT, "not a whole register")
        content[offset : offset + len(data)] = data
        self.plan = TransferPlan.decode(bytes(content))

    def _abrm(self) -> bytes:
        image = bytearray(Abrm.SIZE)
        identity = self._identity
        user_name = str(self.model.memory.get(reg.DEVICE_USER_ID))
        for address, text in (
            (Abrm.MANUFACTURER_NAME, identity.vendor),
            (Abrm.MODEL_NAME, identity.model),
            (Abrm.FAMILY_NAME, "Simulated"),
            (Abrm.DEVICE_VERSION, identity.version),
            (Abrm.MANUFACTURER_INFO, str(self.model.memory.get(reg.DEVICE_MANUFACTURER_INFO))),
            (Abrm.SERIAL_NUMBER, identity.serial),
            (Abrm.USER_DEFINED_NAME, user_name),
        ):
            image[address : address + STRING_SIZE] = text.encode()[:STRING_SIZE].ljust(STRING_SIZE, b"\0")
        capability = (
            Abrm.CAPABILITY_USER_DEFINED_NAME
            | Abrm.CAPABILITY_TIMESTAMP
            | Abrm.CAPABILITY_FAMILY_NAME
            | Abrm.CAPABILITY_SBRM
            | Abrm.CAPABILITY_ENDIANNESS
            | Abrm.CAPABILITY_WRITTEN_LENGTH
        )
        struct.pack_into("<I", image, Abrm.GENCP_VERSION, 0x0001_0001)
        struct.pack_into("<Q", image, Abrm.DEVICE_CAPABILITY, capability)
        struct.pack_into("<I", image, Abrm.MAXIMUM_RESPONSE_TIME, RESPONSE_TIME_MS)
        struct.pack_into("<QQ", image, Abrm.MANIFEST_TABLE_ADDRESS, MANIFEST, SBRM)
        struct.pack_into("<Q", image, Abrm.TIMESTAMP, self._latched)
        struct.pack_into("<Q", image, Abrm.TIMESTAMP_INCREMENT, 1)
        struct.pack_into("<II", image, Abrm.PROTOCOL_ENDIANNESS, _LITTLE_ENDIAN, _LITTLE_ENDIAN)
        return bytes(image)

    def _sbrm(self) -> bytes:
        capability = Sbrm.CAPABILITY_SIRM | Sbrm.CAPABILITY_EIRM
        return struct.pack(
            "<IQQIIIQIQIQI",
            0x0001_0000,
            capability,
            0,
            LONGEST_TRANSFER,
            LONGEST_TRANSFER,
            1,
            SIRM,
            Sirm.SIZE,
            EIRM,
            Eirm.SIZE,
            0,
            _SUPER_SPEED,
        )

    def _sirm(self) -> bytes:
        return self.requirements().encode() + self.plan.encode()

    def _eirm(self) -> bytes:
        return struct.pack("<III", int(self.events_enabled), LONGEST_EVENT, 0)

    def _manifest(self) -> bytes:
        entry = ManifestEntry(
            version=(1, 0, 0),
            file_type=ManifestEntry.DEVICE_XML,
            file_format=ManifestEntry.ZIP,
            schema=(1, 1),
            address=XML,
            size=len(self._xml),
            sha1=hashlib.sha1(self._xml, usedforsecurity=False).digest(),
        )
        return (1).to_bytes(8, "little") + entry.encode()


def _number(data: bytes) -> int:
    return int.from_bytes(data, "little")
