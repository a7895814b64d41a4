"""The simulated camera's register memory.

The memory is addressed in bytes, with access checks and hooks. It knows no transport: it gives a `Refusal` as
the reason of a refused request, and the front that carried the request (GVCP, GenCP, in process) translates
the reason to its own status code.
"""

from __future__ import annotations

import struct
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import Enum

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


class RegisterKind(Enum):
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
    kind: RegisterKind
    length: int
    default: RegisterValue
    writable: bool = True
    minimum: float | None = None
    maximum: float | None = None
    step: int = 1
    "Step of integers, counted from `minimum`."
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
        if self.kind is RegisterKind.STRING:
            return data.split(b"\0", 1)[0].decode("utf-8", "replace")
        value: int | float = struct.unpack(f">{self.kind.value}", data)[0]
        return value

    def encode(self, value: RegisterValue) -> bytes:
        """Return a value as the register's bytes."""
        if self.kind is RegisterKind.STRING:
            # Cut between characters: a host could not decode half of one.
            whole = str(value).encode()[: self.length].decode("utf-8", "ignore")
            return whole.encode().ljust(self.length, b"\0")
        number = float(value) if self.kind is RegisterKind.FLOAT64 else int(value)
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
            if register.kind is RegisterKind.STRING and register.address < position:
                # A word of a text, from a host that writes it word by word.
                before = register.encode(self.get(register))[: position - register.address]
                data, address, position = before + data, register.address, register.address
            if register.address != position:
                raise RegisterRefusedError(Refusal.BAD_ALIGNMENT, f"0x{position:x} is inside {register.name}")
            content = data[position - address : register.end - address]
            if register.kind is not RegisterKind.STRING and len(content) < register.length:
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
