"""Deviations of the simulated GigE Vision camera, as cameras of other makers have them."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from grabbergui.driver.gige.bootstrap import BIG_ENDIAN_MODE, GvcpCapability
from grabbergui.driver.sim.memory import RegisterKind, RegisterMemory

_WORD = 4
Read = Callable[[int, int], bytes]
"Takes an address and a length in bytes."
_REGISTER = re.compile(r"<((?:Masked)?IntReg|FloatReg) .*?</\1>", re.DOTALL)
_BITS = re.compile(r"<(Bit|LSB|MSB)>(\d+)</\1>")


@dataclass(frozen=True)
class Deviations:
    """Deviations from the simulated camera as it is."""

    little_endian: bool = False
    "Whether its memory is little-endian, as READMEM and WRITEMEM show it."
    schema: int = 1
    """Minor version of GenApi's schema that its description claims. With 0, numbers are declared big-endian,
    and those of eight bytes are so in its memory, too: hosts read longer registers as they are."""
    declared_big_endian: bool = False
    "Whether its description declares numbers big-endian although its memory is not."
    absent: GvcpCapability = field(default_factory=lambda: GvcpCapability(0))
    "Capabilities that it does not have."
    refused: Mapping[int, int] = field(default_factory=dict)
    "GVCP status of the answer to each access, by register address."
    read_only: frozenset[int] = frozenset()
    "Addresses of registers that refuse to be written."
    urls: tuple[str, str] | None = None
    "Texts of the URL registers instead of its own."
    damaged_archive: bool = False
    "Whether the checksum in its zipped description is wrong."
    longest_access: int = 536
    "Bytes that one READMEM or WRITEMEM may have."

    @property
    def device_mode(self) -> int:
        """The register DeviceMode: the order of its memory, and UTF-8."""
        return 0x1 if self.little_endian else BIG_ENDIAN_MODE | 0x1

    def describe(self, xml: bytes) -> bytes:
        """Return the description as this camera has it."""
        text = xml.decode()
        if not self.schema:
            text = text.replace("GenApi/Version_1_1", "GenApi/Version_1_0")
            text = text.replace('SchemaMinorVersion="1"', 'SchemaMinorVersion="0"')
        elif self.little_endian and not self.declared_big_endian:
            text = _REGISTER.sub(lambda node: _declare_little(node[0]), text)
        return text.encode()

    def store(self, archive: bytes) -> bytes:
        """Return the zipped description as it is in this camera's memory."""
        if not self.damaged_archive:
            return archive
        directory = archive.rindex(b"PK\1\2")
        return b"".join(
            (
                archive[: directory + 16],
                bytes(byte ^ 0xFF for byte in archive[directory + 16 : directory + 20]),
                archive[directory + 20 :],
            )
        )

    def read(self, memory: RegisterMemory, read: Read, address: int, length: int) -> bytes:
        """Return the bytes that READMEM reads; `read` reads the registers of `memory`. Raises as it does."""
        data = bytearray(read(address, length))
        for start, size in self._reversed(memory, address, length):
            whole = read(start, size)[::-1]
            first, end = max(start, address), min(start + size, address + length)
            data[first - address : end - address] = whole[first - start : end - start]
        return bytes(data)

    def stored(self, memory: RegisterMemory, address: int, data: bytes) -> bytes:
        """Return what the bytes of a WRITEMEM mean to the registers there."""
        turned = bytearray(data)
        for start, size in self._reversed(memory, address, len(data)):
            if address <= start and start + size <= address + len(data):
                at = start - address
                turned[at : at + size] = turned[at : at + size][::-1]
        return bytes(turned)

    def number(self, word: bytes) -> bytes:
        """Turn a word of the memory into the number that READREG carries, or back."""
        return word[::-1] if self.little_endian else word

    def _reversed(self, memory: RegisterMemory, address: int, length: int) -> list[tuple[int, int]]:
        """Return address and bytes of each number in a range that the memory holds in reverse."""
        if not self.little_endian:
            return []
        return [
            (register.address, register.length)
            for register in memory.registers_in(address, length)
            if register.kind is not RegisterKind.STRING and (self.schema or register.length == _WORD)
        ]


def _declare_little(node: str) -> str:
    """Declare a register of the camera little-endian; its bits are numbered from the other end then."""
    if "<pPort>Device</pPort>" not in node:
        return node
    node = node.replace("<Endianess>BigEndian", "<Endianess>LittleEndian")
    return _BITS.sub(lambda bit: f"<{bit[1]}>{31 - int(bit[2])}</{bit[1]}>", node)
