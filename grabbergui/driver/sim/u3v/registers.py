"""The simulated camera's USB3 Vision bootstrap registers in front of its own.

Everything up to 0xFFFF is bootstrap; the zipped description lies high above the camera's registers.
"""

from __future__ import annotations

import hashlib
import io
import struct
import zipfile
from collections.abc import Callable

from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.description import camera_xml
from grabbergui.driver.sim.memory import Refusal, RegisterRefusedError
from grabbergui.driver.sim.model import CameraModel
from grabbergui.driver.sim.u3v.descriptors import UsbIdentity
from grabbergui.driver.u3v.bootstrap import (
    STRING_SIZE,
    Abrm,
    Eirm,
    ManifestEntry,
    Sbrm,
    Sirm,
    StreamRequirements,
)
from grabbergui.driver.u3v.stream_protocol import (
    EXTENDED_CHUNK_TRAILER_SIZE,
    IMAGE_LEADER_SIZE,
    TransferPlan,
)

SBRM, SIRM, EIRM, MANIFEST, XML = 0x1000, 0x2000, 0x3000, 0x4000, 0x40_0000
"Addresses of the register maps."
BOOTSTRAP_END = 0x10000

LONGEST_TRANSFER = 1024
"Bytes of a command or acknowledge."
LONGEST_EVENT = 1024
RESPONSE_TIME_MS = 300

_LITTLE_ENDIAN = 0xFFFFFFFF
_SUPER_SPEED = 8


def zipped_description() -> bytes:
    """Return the camera's XML in an archive, the same bytes every time."""
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as opened:
        member = zipfile.ZipInfo("camera.xml", (2020, 1, 1, 0, 0, 0))
        opened.writestr(member, camera_xml(), zipfile.ZIP_DEFLATED)
    return archive.getvalue()


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
        self._xml = zipped_description()

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
