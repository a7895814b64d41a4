"""Self-description of a USB3 Vision camera: USB descriptors and bootstrap registers, little-endian.

The ABRM begins at address 0 and leads to the other maps (SBRM, SIRM, EIRM) and to the manifest of
descriptions. Addresses of SBRM, SIRM and EIRM registers are offsets within their map.
"""

from __future__ import annotations

import hashlib
import logging
import struct
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

from grabbergui.core.device_text import text_field
from grabbergui.core.errors import DeviceStatusError, RemoteProtocolError
from grabbergui.driver.description import MAX_STORED_BYTES, parses, unpack

log = logging.getLogger(__name__)

MISCELLANEOUS_CLASS = 0xEF
U3V_SUBCLASS = 0x05
CONTROL_PROTOCOL = 0x00
EVENT_PROTOCOL = 0x01
STREAM_PROTOCOL = 0x02

CLASS_SPECIFIC_INTERFACE = 0x24
DEVICE_INFO_SUBTYPE = 0x01

SPEED_NAMES = {1: "low speed", 2: "full speed", 3: "High-Speed", 4: "SuperSpeed", 5: "SuperSpeed+"}
"Names by libusb's speed code."
STRING_SIZE = 64
"Bytes of a string register; NUL-terminated unless full."
LARGEST_ALIGNMENT_EXPONENT = 20
"Limit of the exponent in SIRM info; real cameras have 0 to 10."
MOST_ENTRIES = 64


@dataclass(frozen=True)
class DeviceInfoDescriptor:
    """The class-specific descriptor after that of the control interface; 20 bytes, little-endian.

    Fields that end in `_index` are indices of string descriptors; 0: none.
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
        """Read a descriptor; ignore further bytes of a longer one. Raises RemoteProtocolError."""
        if len(data) < cls.FORMAT.size:
            raise RemoteProtocolError(f"device-info descriptor of {len(data)} bytes, need {cls.FORMAT.size}")
        _, kind, subtype, *fields = cls.FORMAT.unpack_from(data)
        if (kind, subtype) != (CLASS_SPECIFIC_INTERFACE, DEVICE_INFO_SUBTYPE):
            raise RemoteProtocolError(f"descriptor 0x{kind:02X}/0x{subtype:02X} is no device-info descriptor")
        return cls(*fields)

    @classmethod
    def find(cls, extra: bytes) -> DeviceInfoDescriptor | None:
        """Return the first whole one among the descriptors after an interface's; None if there is none."""
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


class Abrm:
    """Addresses in the technology-agnostic bootstrap register map."""

    GENCP_VERSION = 0x000
    MANUFACTURER_NAME = 0x004
    MODEL_NAME = 0x044
    FAMILY_NAME = 0x084
    DEVICE_VERSION = 0x0C4
    MANUFACTURER_INFO = 0x104
    SERIAL_NUMBER = 0x144
    USER_DEFINED_NAME = 0x184
    DEVICE_CAPABILITY = 0x1C4
    MAXIMUM_RESPONSE_TIME = 0x1CC
    "u32, milliseconds."
    MANIFEST_TABLE_ADDRESS = 0x1D0
    SBRM_ADDRESS = 0x1D8
    DEVICE_CONFIGURATION = 0x1E0
    TIMESTAMP = 0x1F0
    "u64, nanoseconds; valid after a latch."
    TIMESTAMP_LATCH = 0x1F8
    TIMESTAMP_INCREMENT = 0x1FC
    "u64, nanoseconds of one step: the clock's resolution, not a factor."
    ACCESS_PRIVILEGE = 0x204
    PROTOCOL_ENDIANNESS = 0x208
    IMPLEMENTATION_ENDIANNESS = 0x20C
    SIZE = 0x210

    CAPABILITY_USER_DEFINED_NAME = 1 << 0
    CAPABILITY_TIMESTAMP = 1 << 3
    CAPABILITY_FAMILY_NAME = 1 << 8
    CAPABILITY_SBRM = 1 << 9
    CAPABILITY_ENDIANNESS = 1 << 10
    CAPABILITY_WRITTEN_LENGTH = 1 << 11


class Sbrm:
    """Offsets in the technology-specific map."""

    U3V_VERSION = 0x00
    CAPABILITY = 0x04
    CONFIGURATION = 0x0C
    MAXIMUM_COMMAND_TRANSFER = 0x14
    MAXIMUM_ACKNOWLEDGE_TRANSFER = 0x18
    STREAM_CHANNELS = 0x1C
    SIRM_ADDRESS = 0x20
    SIRM_LENGTH = 0x28
    EIRM_ADDRESS = 0x2C
    EIRM_LENGTH = 0x34
    IIDC2_ADDRESS = 0x38
    CURRENT_SPEED = 0x40
    SIZE = 0x44

    CAPABILITY_SIRM = 1 << 0
    CAPABILITY_EIRM = 1 << 1


class Sirm:
    """Offsets in a stream interface's map."""

    INFO = 0x00
    CONTROL = 0x04
    REQUIRED_PAYLOAD_SIZE = 0x08
    REQUIRED_LEADER_SIZE = 0x10
    REQUIRED_TRAILER_SIZE = 0x14
    MAXIMUM_LEADER_SIZE = 0x18
    PAYLOAD_TRANSFER_SIZE = 0x1C
    PAYLOAD_TRANSFER_COUNT = 0x20
    PAYLOAD_FINAL_TRANSFER_1_SIZE = 0x24
    PAYLOAD_FINAL_TRANSFER_2_SIZE = 0x28
    MAXIMUM_TRAILER_SIZE = 0x2C
    SIZE = 0x30

    STREAM_ENABLE = 1
    "Bit of CONTROL."


class Eirm:
    """Offsets in the event interface's map."""

    CONTROL = 0x00
    MAXIMUM_EVENT_TRANSFER = 0x04
    TEST_CONTROL = 0x08
    SIZE = 0x0C

    EVENT_ENABLE = 1
    "Bit of CONTROL."
    TEST_EVENT_ID = 0x4FFF


def known_registers(sbrm: int, sirm: int, eirm: int) -> list[tuple[str, int, int]]:
    """Return name, address and length of every register of the maps at these addresses; 0: there is none."""
    found = []
    for base, layout in ((0, Abrm), (sbrm, Sbrm), (sirm, Sirm), (eirm, Eirm)):
        offsets = [(name, offset) for name, offset in vars(layout).items() if isinstance(offset, int)]
        end = next(index for index, (name, _) in enumerate(offsets) if name == "SIZE")
        for (name, offset), (_, after) in pairwise(offsets[: end + 1] if base or layout is Abrm else ()):
            longest = STRING_SIZE if after <= Abrm.DEVICE_CAPABILITY and layout is Abrm else 8
            found.append((f"{layout.__name__.upper()}.{name}", base + offset, min(after - offset, longest)))
    return found


_TEXTS = {
    "vendor": Abrm.MANUFACTURER_NAME,
    "model": Abrm.MODEL_NAME,
    "version": Abrm.DEVICE_VERSION,
    "serial": Abrm.SERIAL_NUMBER,
    "user_name": Abrm.USER_DEFINED_NAME,
}


def identity_texts(read: Callable[[int, int], bytes]) -> dict[str, str]:
    """Return the identity registers of an open camera as fields of `DeviceInfo`.

    `read` takes an address and a length in bytes; its errors pass through, except for refused registers.
    """
    texts = {}
    for name, address in _TEXTS.items():
        with suppress(DeviceStatusError):  # the user's name is optional, others are forgotten by some
            texts[name] = text_field(read(address, STRING_SIZE))
    return texts


@dataclass(frozen=True)
class StreamRequirements:
    """The device's requirements for stream transfers (SIRM 0x00 to 0x17)."""

    FORMAT: ClassVar[struct.Struct] = struct.Struct("<IIQII")

    alignment: int
    "Every payload transfer size must be a multiple of this; a power of two."
    enabled: bool
    "True while the stream is on; a host that crashed may have left it on."
    payload_size: int
    leader_size: int
    trailer_size: int

    @classmethod
    def decode(cls, data: bytes) -> StreamRequirements:
        """Read the first 24 bytes of a SIRM. Raises RemoteProtocolError for an absurd alignment."""
        if len(data) < cls.FORMAT.size:
            raise RemoteProtocolError(f"SIRM of {len(data)} bytes, need {cls.FORMAT.size}")
        info, control, payload_size, leader_size, trailer_size = cls.FORMAT.unpack_from(data)
        exponent = info >> 24
        if exponent > LARGEST_ALIGNMENT_EXPONENT:
            raise RemoteProtocolError(
                f"SIRM asks for transfers aligned to 2^{exponent} bytes; "
                f"at most 2^{LARGEST_ALIGNMENT_EXPONENT} makes sense"
            )
        enabled = bool(control & Sirm.STREAM_ENABLE)
        return cls(1 << exponent, enabled, payload_size, leader_size, trailer_size)

    def encode(self) -> bytes:
        """Return the device's side of `decode`."""
        info = (self.alignment.bit_length() - 1) << 24
        return self.FORMAT.pack(
            info, int(self.enabled), self.payload_size, self.leader_size, self.trailer_size
        )


@dataclass(frozen=True)
class ManifestEntry:
    """One file that the device stores."""

    FORMAT: ClassVar[struct.Struct] = struct.Struct("<HBBIQQ20s20x")

    DEVICE_XML: ClassVar[int] = 0
    RAW: ClassVar[int] = 0
    ZIP: ClassVar[int] = 1

    version: tuple[int, int, int]
    "Version of the file: major, minor, subminor."
    file_type: int
    "0: the device's description; 1: a buffer's."
    file_format: int
    "0: plain XML; 1: a zip archive."
    schema: tuple[int, int]
    "GenApi schema: major, minor."
    address: int
    size: int
    sha1: bytes = bytes(20)
    "SHA-1 of the stored file; zeros if not given."

    def encode(self) -> bytes:
        """Return the entry's 64 bytes."""
        major, minor, subminor = self.version
        kind = self.schema[0] << 24 | self.schema[1] << 16 | self.file_format << 10 | self.file_type
        return self.FORMAT.pack(subminor, minor, major, kind, self.address, self.size, self.sha1)

    @classmethod
    def decode(cls, data: bytes) -> ManifestEntry:
        """Read one entry. Raises RemoteProtocolError for fewer than 64 bytes."""
        if len(data) < cls.FORMAT.size:
            raise RemoteProtocolError(f"manifest entry of {len(data)} bytes, need {cls.FORMAT.size}")
        subminor, minor, major, kind, address, size, sha1 = cls.FORMAT.unpack_from(data)
        return cls(
            version=(major, minor, subminor),
            file_type=kind & 0x7,
            file_format=kind >> 10 & 0x3F,
            schema=(kind >> 24, kind >> 16 & 0xFF),
            address=address,
            size=size,
            sha1=sha1,
        )


def descriptions(entries: list[ManifestEntry]) -> list[ManifestEntry]:
    """Return the device's description files, the newest first. Raises RemoteProtocolError without one."""
    candidates = [entry for entry in entries if entry.file_type == ManifestEntry.DEVICE_XML]
    if not candidates:
        raise RemoteProtocolError(f"none of the manifest's {len(entries)} files is a GenICam description")
    return sorted(candidates, key=lambda entry: entry.version, reverse=True)


def read_description(read: Callable[[int, int], bytes], manifest_address: int) -> bytes:
    """Return the XML of a device; `read(address, length)` reads its memory.

    Raises RemoteProtocolError for an invalid manifest or file; errors of `read` pass through.
    """
    if not manifest_address:
        raise RemoteProtocolError("the camera names no manifest of its files")
    count = int.from_bytes(read(manifest_address, 8), "little")
    if not 0 < count <= MOST_ENTRIES:
        raise RemoteProtocolError(f"the manifest announces {count} files; 1 to {MOST_ENTRIES} make sense")
    size = ManifestEntry.FORMAT.size
    first = manifest_address + 8
    entries = [ManifestEntry.decode(read(first + index * size, size)) for index in range(count)]
    problems = []
    unparsed = b""
    for entry in descriptions(entries):
        try:
            xml = _stored_in(entry, read)
        except (RemoteProtocolError, DeviceStatusError) as error:
            problems.append(f"version {'.'.join(map(str, entry.version))}: {error}")
            log.warning("a description in the manifest cannot be read: %s", problems[-1])
            continue
        if parses(xml):
            return xml
        # Such a one may be usable all the same, but an older one may be whole.
        unparsed = unparsed or xml
    if not unparsed:
        raise RemoteProtocolError(f"no description in the manifest can be read: {'; '.join(problems)}")
    return unparsed


def _stored_in(entry: ManifestEntry, read: Callable[[int, int], bytes]) -> bytes:
    if not 0 < entry.size <= MAX_STORED_BYTES:
        raise RemoteProtocolError(f"the manifest announces a description of {entry.size} bytes")
    stored = read(entry.address, entry.size)
    if any(entry.sha1) and hashlib.sha1(stored, usedforsecurity=False).digest() != entry.sha1:
        log.warning("the description's SHA-1 differs from the one in the manifest; it is used nevertheless")
    return unpack(stored)
