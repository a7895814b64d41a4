"""The simulated camera's register memory, and `camera.xml`, which describes its registers.

The memory is addressed in bytes, with access checks and hooks. It knows no transport: it gives a `Refusal` as
the reason of a refused request, and the front that carried the request (GVCP, GenCP, in process) translates
the reason to its own status code.

`camera.xml` is the only list of registers: their addresses, kinds, ranges and choices are read from it here,
and `registers` gives names to those that the camera's model uses.
"""

from __future__ import annotations

import io
import struct
import zipfile
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from functools import cache
from importlib import resources
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from grabbergui.core.errors import GrabberError

RegisterValue = int | float | str


class Refusal(Enum):
    """Reason for which a device refuses a request."""

    INVALID_ADDRESS = "no register at this address"
    WRITE_PROTECT = "the register is read-only"
    BAD_ALIGNMENT = "not a whole register"
    INVALID_PARAMETER = "the value is not allowed"
    ACCESS_DENIED = "the register is locked at the moment"


class RegisterRefusedError(GrabberError):
    """A device refused to read or write; never leaves the simulated camera."""

    def __init__(self, reason: Refusal, message: str) -> None:
        super().__init__(message)
        self.reason = reason


class Kind(Enum):
    """Type of a register; numbers are big-endian. The value is their `struct` code."""

    UINT32 = "I"
    INT64 = "q"
    FLOAT64 = "d"
    STRING = "s"


@dataclass(frozen=True)
class Register:
    """One register: address, type, default and accepted values."""

    name: str
    address: int
    kind: Kind
    length: int
    default: RegisterValue
    writable: bool = True
    minimum: float | None = None
    maximum: float | None = None
    step: int = 1
    "Of integers, counted from `minimum`."
    choices: frozenset[int] | None = None
    "The only values accepted, for enumerations."
    saved: bool = False
    "True if user sets contain it."

    @property
    def end(self) -> int:
        """The address behind its last byte."""
        return self.address + self.length

    def decode(self, data: bytes) -> RegisterValue:
        """Decode the register's bytes to its value."""
        if self.kind is Kind.STRING:
            return data.split(b"\0", 1)[0].decode("utf-8", "replace")
        value: int | float = struct.unpack(f">{self.kind.value}", data)[0]
        return value

    def encode(self, value: RegisterValue) -> bytes:
        """Return a value as the register's bytes."""
        if self.kind is Kind.STRING:
            # Cut between characters: a host could not decode half of one.
            whole = str(value).encode()[: self.length].decode("utf-8", "ignore")
            return whole.encode().ljust(self.length, b"\0")
        number = float(value) if self.kind is Kind.FLOAT64 else int(value)
        return struct.pack(f">{self.kind.value}", number)

    def check(self, value: RegisterValue) -> None:
        """Raise RegisterRefusedError unless the value is in the register's fixed range."""
        if isinstance(value, str):
            return
        allowed = self.choices is None or value in self.choices
        if self.minimum is not None and self.maximum is not None:
            # Written so that NaN is refused as well.
            allowed = allowed and self.minimum <= value <= self.maximum
            if allowed and self.step > 1:
                allowed = (int(value) - int(self.minimum)) % self.step == 0
        if not allowed:
            raise RegisterRefusedError(Refusal.INVALID_PARAMETER, f"{self.name} does not accept {value}")


class RegisterMemory:
    """Registers and read-only blocks of bytes. Not thread-safe; the device holds a lock around it."""

    def __init__(self, registers: Iterable[Register]) -> None:
        self._registers = sorted(registers, key=lambda register: register.address)
        self._starts = [register.address for register in self._registers]
        self._values: dict[int, RegisterValue] = {}
        "By address, as a host reads them."
        self._blocks: list[tuple[int, bytes | bytearray]] = []
        self._before_read: dict[int, Callable[[], RegisterValue]] = {}
        self._before_write: dict[int, Callable[[RegisterValue], RegisterValue | None]] = {}
        self._after_write: dict[int, Callable[[], None]] = {}
        for register in self._registers:
            self.set(register, register.default)

    def add_block(self, address: int, content: bytes) -> None:
        """Add read-only bytes, such as the zipped XML, padded with zeros to a multiple of 4."""
        self._blocks.append((address, content + bytes(-len(content) % 4)))

    def add_buffer(self, address: int, length: int) -> bytearray:
        """Make bytes that a host reads and writes in any pieces, and the device uses as they are."""
        content = bytearray(length)
        self._blocks.append((address, content))
        return content

    def on_read(self, register: Register, supply: Callable[[], RegisterValue]) -> None:
        """Let `supply` give the value whenever the register is read."""
        self._before_read[register.address] = supply

    def on_check(self, register: Register, check: Callable[[RegisterValue], RegisterValue | None]) -> None:
        """Let `check` refuse a write (by raising) or give the value to store instead."""
        self._before_write[register.address] = check

    def on_written(self, register: Register, act: Callable[[], None]) -> None:
        """Call `act` once a write from outside is stored."""
        self._after_write[register.address] = act

    def get(self, register: Register) -> RegisterValue:
        """Return a register's value."""
        supply = self._before_read.get(register.address)
        return supply() if supply else self._values[register.address]

    def integer(self, register: Register) -> int:
        """Return a register's value as an integer."""
        return int(self.get(register))

    def number(self, register: Register) -> float:
        """Return a register's value as a float."""
        return float(self.get(register))

    def stored(self, register: Register) -> RegisterValue:
        """Return the stored content, without calling `on_read`."""
        return self._values[register.address]

    def set(self, register: Register, value: RegisterValue) -> None:
        """Store a value from inside the device, unchecked."""
        # A frame asks for dozens of registers, which seldom change.
        self._values[register.address] = register.decode(register.encode(value))

    def read(self, address: int, length: int) -> bytes:
        """Read a range that begins in a register or block; gaps between registers read as zeros."""
        for start, content in self._blocks:
            if start <= address < start + len(content):
                return bytes(content[address - start : address - start + length]).ljust(length, b"\0")
        data = bytearray(length)
        found = False
        for register in self.registers_in(address, length):
            found = True
            content = register.encode(self.get(register))
            begin, end = max(address, register.address), min(address + length, register.end)
            data[begin - address : end - address] = content[begin - register.address : end - register.address]
        if not found:
            raise RegisterRefusedError(Refusal.INVALID_ADDRESS, f"no register at 0x{address:x}")
        return bytes(data)

    def write(self, address: int, data: bytes) -> None:
        """Write one or several whole registers, or part of a buffer; a string may be shorter."""
        for start, content in self._blocks:
            if isinstance(content, bytearray) and start <= address <= start + len(content) - len(data):
                content[address - start : address - start + len(data)] = data
                return
        registers = list(self.registers_in(address, len(data)))
        if not registers:
            raise RegisterRefusedError(Refusal.INVALID_ADDRESS, f"no register at 0x{address:x}")
        position = address
        for register in registers:
            if register.kind is Kind.STRING and register.address < position:
                # A word of a text, from a host that writes it word by word.
                before = register.encode(self.get(register))[: position - register.address]
                data, address, position = before + data, register.address, register.address
            if register.address != position:
                raise RegisterRefusedError(Refusal.BAD_ALIGNMENT, f"0x{position:x} is inside {register.name}")
            content = data[position - address : register.end - address]
            if register.kind is not Kind.STRING and len(content) < register.length:
                raise RegisterRefusedError(
                    Refusal.BAD_ALIGNMENT, f"{register.name} is {register.length} bytes"
                )
            self._write_register(register, register.decode(content))
            position = register.end
        if position < address + len(data):
            raise RegisterRefusedError(Refusal.INVALID_ADDRESS, f"no register at 0x{position:x}")

    def _write_register(self, register: Register, value: RegisterValue) -> None:
        if not register.writable:
            raise RegisterRefusedError(Refusal.WRITE_PROTECT, f"{register.name} is read-only")
        register.check(value)
        if check := self._before_write.get(register.address):
            replacement = check(value)
            value = value if replacement is None else replacement
        self.set(register, value)
        if act := self._after_write.get(register.address):
            act()

    def registers_in(self, address: int, length: int) -> list[Register]:
        """Return the registers of which a range has at least one byte, in the order of their addresses."""
        # No register is longer than the step back to the one before it, so one step back is enough.
        first = max(bisect_right(self._starts, address) - 1, 0)
        last = bisect_left(self._starts, address + length)
        return [register for register in self._registers[first:last] if register.end > address]


# -- camera.xml ----------------------------------------------------------------------------------
_FEATURES_HERE = b"    <!-- features of the transport -->\n"
_END = b"</RegisterDescription>"

_SCHEMA = "{http://www.genicam.org/GenApi/Version_1_1}"
_PORT = "Device"
"The port that leads to registers; chunks and events have ports of their own."
_FEATURE_KINDS = ("Integer", "Float", "Boolean", "Enumeration", "Command")
_REGISTER_KINDS = {
    ("IntReg", 4): Kind.UINT32,
    ("IntReg", 8): Kind.INT64,
    ("FloatReg", 8): Kind.FLOAT64,
}
_BUFFER = "Register"
"A node of plain bytes."
_SUFFIX = "Reg"
"Ends the name of a feature's register; a string is its register itself."

PowerOn = RegisterValue | tuple[RegisterValue, ...]
"A register's value after power-on, or one for each entry of its selector."


@cache
def camera_xml() -> bytes:
    """Return the description that all transports share."""
    return resources.files(__package__).joinpath("camera.xml").read_bytes()


def zipped(name: str, xml: bytes) -> bytes:
    """Return an archive with a description, the same bytes every time."""
    archive = io.BytesIO()
    member = zipfile.ZipInfo(name, (2024, 1, 1, 0, 0, 0))
    with zipfile.ZipFile(archive, "w") as opened:
        opened.writestr(member, xml, zipfile.ZIP_DEFLATED)
    return archive.getvalue()


def with_transport(features: tuple[str, ...], nodes: bytes) -> bytes:
    """Return the description with a transport's features, listed in TransportLayerControl, and nodes."""
    listed = b"".join(b"    <pFeature>%s</pFeature>\n" % name.encode() for name in features)
    return camera_xml().replace(_FEATURES_HERE, listed).replace(_END, nodes + _END)


class DescribedRegisters:
    """The registers in `camera.xml`, by the name of their feature."""

    def __init__(
        self,
        power_on: Mapping[str, PowerOn],
        limits: Mapping[str, tuple[float | None, float]],
        saved: Container[str],
    ) -> None:
        """Read the description.

        `power_on`: what registers hold after power-on, by feature; others hold 0, or no text. `limits`: the
        smallest and largest values if the description computes them or has none. `saved`: features in user
        sets in addition to those marked Streamable.
        """
        self._power_on = power_on
        self._limits = limits
        self._saved = saved
        root = ElementTree.fromstring(camera_xml())
        self._nodes = {node.get("Name", ""): node for node in root}
        self._feature_of = {
            _text(node, "pValue"): node
            for node in root
            if _tag(node) in _FEATURE_KINDS and _text(node, "pValue")
        }
        "By the register that holds its value."
        self._registers = {
            name.removesuffix(_SUFFIX): tuple(self._instances(name.removesuffix(_SUFFIX), node))
            for name, node in self._nodes.items()
            if _text(node, "pPort") == _PORT and _tag(node) != _BUFFER
        }

    def __iter__(self) -> Iterator[Register]:
        """Give every register."""
        for instances in self._registers.values():
            yield from instances

    def one(self, name: str) -> Register:
        """Return the register of a feature without selector."""
        (register,) = self._registers[name]
        return register

    def each(self, name: str) -> tuple[Register, ...]:
        """Return the registers of a feature, one for each entry of its selector, in their order."""
        return self._registers[name]

    def buffer(self, name: str) -> tuple[int, int]:
        """Return address and length of a node of plain bytes."""
        node = self._nodes[name]
        return int(_text(node, "Address"), 0), int(_text(node, "Length"))

    def _instances(self, name: str, node: Element) -> Iterator[Register]:
        index = node.find(f"{_SCHEMA}pIndex")
        offset, count = 0, 1
        if index is not None:
            offset = int(index.get("Offset", "0"))
            count = len(_choices(self._feature_of[index.text or ""]) or ())
        defaults = self._power_on.get(name)
        for which in range(count):
            default = defaults[which] if isinstance(defaults, tuple) else defaults
            yield self._register(name, node, which, offset * which, default)

    def _register(
        self, name: str, node: Element, which: int, offset: int, default: RegisterValue | None
    ) -> Register:
        length = int(_text(node, "Length"))
        kind = _REGISTER_KINDS.get((_tag(node), length), Kind.STRING)
        writable = _text(node, "AccessMode") == "RW"
        # A feature that is converted from its register (Gain from GainRaw) has no bearing on its range.
        feature = self._feature_of.get(name + _SUFFIX, node)
        minimum, maximum = self._limit(feature, "Min"), self._limit(feature, "Max")
        if name in self._limits:
            smallest, maximum = self._limits[name]
            minimum = minimum or smallest or 0.0
        if default is None:
            default = "" if kind is Kind.STRING else 0
        return Register(
            f"{name}[{which}]" if which else name,
            int(_text(node, "Address"), 0) + offset,
            kind,
            length,
            default,
            writable,
            minimum,
            maximum,
            step=int(_text(feature, "Inc") or 1) if kind is not Kind.FLOAT64 else 1,
            choices=_choices(feature),
            saved=writable and (name in self._saved or _text(feature, "Streamable") == "Yes"),
        )

    def _limit(self, feature: Element, end: str) -> float | None:
        """Return one end (`Min`, `Max`) of a feature's range, which another register may hold."""
        if constant := _text(feature, end):
            return float(constant)
        holder = self._feature_of.get(_text(feature, f"p{end}"))
        return None if holder is None else self._limit(holder, end)


def _choices(feature: Element) -> frozenset[int] | None:
    """Return the only values that an enumeration or a switch takes; None for other features."""
    if _tag(feature) == "Boolean":
        return frozenset({int(_text(feature, "OffValue")), int(_text(feature, "OnValue"))})
    entries = feature.findall(f"{_SCHEMA}EnumEntry")
    return frozenset(int(_text(entry, "Value"), 0) for entry in entries) if entries else None


def _tag(node: Element) -> str:
    return node.tag.removeprefix(_SCHEMA)


def _text(node: Element, tag: str) -> str:
    return node.findtext(_SCHEMA + tag, "")
