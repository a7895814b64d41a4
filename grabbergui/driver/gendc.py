"""GenDC containers: one descriptor, then the data of its components (EMVA GenDC 1.0 and 1.1). Little-endian.

A descriptor is a container header with the offsets of component headers, each with the offsets of its part
headers, each with the offset of its data. All offsets count from the start of the container.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum, IntFlag
from typing import ClassVar

from grabbergui.core.errors import RemoteProtocolError

SIGNATURE = b"GNDC"
KNOWN_VERSIONS = ((1, 0), (1, 1))
MOST_HEADERS = 64
"Limit of components in a container and of parts in a component; more means damaged data."

Bytes = bytes | bytearray | memoryview


class HeaderType(IntEnum):
    """The kinds of header. The high byte of a part's kind is its number of dimensions."""

    CONTAINER = 0x1000
    COMPONENT = 0x2000
    METADATA = 0x4000
    CHUNK = 0x4001
    IMAGE_1D = 0x4100
    IMAGE_2D = 0x4200
    JPEG = 0x4201
    JPEG2000 = 0x4202


class ComponentFlag(IntFlag):
    """Flags of a component header."""

    INVALID = 0x1
    "This container has no data of the component."


@dataclass(frozen=True)
class PartHeader:
    """A part header: one piece of a component's data."""

    FORMAT: ClassVar[struct.Struct] = struct.Struct("<HHIIHHQQQ")
    SHAPE: ClassVar[struct.Struct] = struct.Struct("<IIHHI")
    SIZE: ClassVar[int] = FORMAT.size + SHAPE.size

    header_type: int
    pixel_format: int
    "PFNC code."
    data_size: int
    data_offset: int
    width: int = 0
    height: int = 0
    padding_x: int = 0
    padding_y: int = 0
    flow: int = 0
    flow_offset: int = 0

    @property
    def is_image(self) -> bool:
        """Whether it has lines of pixels, compressed or not."""
        return self.header_type & 0xFF00 in (HeaderType.IMAGE_1D, HeaderType.IMAGE_2D)

    def encode(self) -> bytes:
        """Return the header of a two-dimensional part."""
        return self.FORMAT.pack(
            self.header_type,
            0,
            self.SIZE,
            self.pixel_format,
            0,
            self.flow,
            self.flow_offset,
            self.data_size,
            self.data_offset,
        ) + self.SHAPE.pack(self.width, self.height, self.padding_x, self.padding_y, 0)

    @classmethod
    def decode(cls, container: Bytes, at: int, length: int | None = None) -> PartHeader:
        """Read a header at an offset; `length` as in `Container.decode`. Raises RemoteProtocolError."""
        kind, _, size, code, _, flow, flow_offset, data_size, data_offset = _fields(
            cls.FORMAT, container, at, "part header"
        )
        length = len(container) if length is None else length
        if data_offset + data_size > length:
            raise RemoteProtocolError(
                f"a GenDC part ends at byte {data_offset + data_size} of a container of {length}"
            )
        shape = (0, 0, 0, 0)
        if kind & 0xFF00 == HeaderType.IMAGE_1D and size >= cls.FORMAT.size + 8:
            (length,) = _fields(struct.Struct("<Q"), container, at + cls.FORMAT.size, "part header")
            shape = (min(length, 0xFFFFFFFF), 1, 0, 0)
        elif kind & 0xFF00 == HeaderType.IMAGE_2D and size >= cls.SIZE:
            *fields, _ = _fields(cls.SHAPE, container, at + cls.FORMAT.size, "part header")
            shape = (fields[0], fields[1], fields[2], fields[3])
        return cls(kind, code, data_size, data_offset, *shape, flow, flow_offset)


@dataclass(frozen=True)
class ComponentHeader:
    """A component header: the result of one sensor or computation."""

    FORMAT: ClassVar[struct.Struct] = struct.Struct("<HHI2xHHHIIQQI2xH")

    type_id: int
    "SFNC's ComponentIDValue."
    pixel_format: int
    parts: tuple[PartHeader, ...]
    group: int = 0
    source: int = 0
    region: int = 0
    offset_x: int = 0
    offset_y: int = 0
    timestamp: int = 0
    flags: int = 0

    @property
    def valid(self) -> bool:
        """Whether it has data in this container."""
        return not self.flags & ComponentFlag.INVALID

    def encode(self, part_offsets: Sequence[int]) -> bytes:
        """Return the header with the offsets of its parts."""
        size = self.FORMAT.size + 8 * len(part_offsets)
        return self.FORMAT.pack(
            HeaderType.COMPONENT,
            self.flags,
            size,
            self.group,
            self.source,
            self.region,
            self.offset_x,
            self.offset_y,
            self.timestamp,
            self.type_id,
            self.pixel_format,
            len(part_offsets),
        ) + struct.pack(f"<{len(part_offsets)}Q", *part_offsets)

    @classmethod
    def decode(cls, container: Bytes, at: int, length: int | None = None) -> ComponentHeader:
        """Read a header and those of its parts, as `PartHeader.decode`. Raises RemoteProtocolError."""
        kind, flags, _, group, source, region, x, y, timestamp, type_id, code, count = _fields(
            cls.FORMAT, container, at, "component header"
        )
        if kind != HeaderType.COMPONENT:
            raise RemoteProtocolError(f"a GenDC component header of type 0x{kind:04X}")
        offsets = _offsets(container, at + cls.FORMAT.size, count)
        parts = (
            tuple(PartHeader.decode(container, offset, length) for offset in offsets) if not flags & 1 else ()
        )
        return cls(type_id, code, parts, group, source, region, x, y, timestamp, flags)


@dataclass(frozen=True)
class Container:
    """A whole descriptor."""

    FORMAT: ClassVar[struct.Struct] = struct.Struct("<4sBBBxHHIQH6xQQII")

    components: tuple[ComponentHeader, ...]
    container_id: int = 0
    data_size: int = 0
    data_offset: int = 0
    descriptor_size: int = 0
    version: tuple[int, int, int] = (1, 1, 0)
    flags: int = 0

    def encode(self) -> bytes:
        """Return the descriptor, with the parts' own sizes and offsets of data."""
        at = self.FORMAT.size + 8 * len(self.components)
        component_offsets, headers = [], b""
        for component in self.components:
            component_offsets.append(at)
            first = at + ComponentHeader.FORMAT.size + 8 * len(component.parts)
            part_offsets = [first + index * PartHeader.SIZE for index in range(len(component.parts))]
            headers += component.encode(part_offsets) + b"".join(part.encode() for part in component.parts)
            at = first + PartHeader.SIZE * len(component.parts)
        return (
            self.FORMAT.pack(
                SIGNATURE,
                *self.version,
                HeaderType.CONTAINER,
                self.flags,
                self.FORMAT.size + 8 * len(self.components),
                self.container_id,
                0,
                self.data_size,
                self.data_offset,
                at,
                len(self.components),
            )
            + struct.pack(f"<{len(self.components)}Q", *component_offsets)
            + headers
        )

    @classmethod
    def decode(cls, container: Bytes, length: int | None = None) -> Container:
        """Read the descriptor at the start of a container; of a whole one unless its `length` is given.

        Raises RemoteProtocolError.
        """
        check_version(container)
        _, *version, kind, flags, _, container_id, _, size, offset, descriptor, count = _fields(
            cls.FORMAT, container, 0, "container header"
        )
        if kind != HeaderType.CONTAINER:
            raise RemoteProtocolError(f"a GenDC container header of type 0x{kind:04X}")
        if descriptor > len(container):
            raise RemoteProtocolError(
                f"a GenDC descriptor of {descriptor} bytes in a container of {len(container)}"
            )
        components = tuple(
            ComponentHeader.decode(container, at, length)
            for at in _offsets(container, cls.FORMAT.size, count)
        )
        major, minor, patch = version
        return cls(components, container_id, size, offset, descriptor, (major, minor, patch), flags)


def check_version(start: Bytes) -> None:
    """Raise RemoteProtocolError unless `start` begins a container of a known version."""
    if bytes(start[:4]) != SIGNATURE or len(start) < 8:
        raise RemoteProtocolError(
            "the camera announces a GenDC container and sends something else; set GenDCStreamingMode=Off"
        )
    if (start[4], start[5]) not in KNOWN_VERSIONS:
        known = " and ".join(f"{major}.{minor}" for major, minor in KNOWN_VERSIONS)
        raise RemoteProtocolError(
            f"the camera sends GenDC version {start[4]}.{start[5]}, known are {known};"
            " set GenDCStreamingMode=Off"
        )


def descriptor_size(components: Sequence[int]) -> int:
    """Return the bytes of a descriptor whose components have these numbers of parts."""
    return Container.FORMAT.size + sum(
        8 + ComponentHeader.FORMAT.size + (8 + PartHeader.SIZE) * n for n in components
    )


def _fields(layout: struct.Struct, container: Bytes, at: int, where: str) -> tuple[int, ...]:
    if at + layout.size > len(container):
        raise RemoteProtocolError(
            f"a GenDC {where} ends at byte {at + layout.size} of a container of {len(container)}"
        )
    return layout.unpack_from(container, at)


def _offsets(container: Bytes, at: int, count: int) -> tuple[int, ...]:
    if count > MOST_HEADERS:
        raise RemoteProtocolError(f"a GenDC header with {count} entries; at most {MOST_HEADERS} make sense")
    return _fields(struct.Struct(f"<{count}Q"), container, at, "list of offsets")
