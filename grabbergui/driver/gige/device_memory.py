"""A GigE Vision device's memory: reads and writes of any length and alignment."""

from __future__ import annotations

import logging
import struct
from collections.abc import Callable
from contextlib import suppress
from functools import partial

from grabbergui.core.device_text import text_field
from grabbergui.core.errors import (
    AccessDeniedError,
    AckTimeoutError,
    DeviceStatusError,
    GrabberError,
    RemoteProtocolError,
    TransportError,
)
from grabbergui.driver.gige.bootstrap import BootstrapRegister, Field, GvcpCapability, GvcpConfiguration
from grabbergui.driver.gige.control_link import ControlLink
from grabbergui.driver.gige.gvcp import MEMORY_CHUNK, ReadMem, Status, WriteMem, WriteReg

log = logging.getLogger(__name__)

_WORD = 4
SHORTEST_CHUNK = 64
"Bytes that a device is expected to read or write at once."
_ABOUT_THE_PLACE = (Status.INVALID_ADDRESS, Status.WRITE_PROTECT, Status.ACCESS_DENIED, Status.BUSY)
"Statuses that have nothing to do with the length of an access."
_SPACE = 1 << 32
"Bytes that 32-bit addresses reach."


class DeviceMemory:
    """Reads and writes of any length and alignment, by the protocol's aligned ones. Any thread may call."""

    def __init__(self, link: ControlLink) -> None:
        self._link = link
        self.capability = GvcpCapability(0)
        "The device's capabilities; set while it is opened."
        self.writable = False
        "Whether we have control."
        self.little_endian = False
        "Whether words are little-endian in the device's memory, which READMEM and WRITEMEM carry as it is."
        self._ready_to_write = False
        "Whether PENDING_ACK is enabled where the device has it."
        self._writes_memory = False
        "Whether the device knows WRITEMEM."
        self._absent: set[int] = set()
        "Registers that the device refused to read; it is not asked again."
        self._protected: set[int] = set()
        "Registers that it refused to write."
        self._longest = dict.fromkeys((ReadMem, WriteMem), MEMORY_CHUNK)
        "Bytes that one READMEM or WRITEMEM may have; some devices take fewer than the standard allows."

    def read(self, address: int, length: int) -> bytes:
        """Read exactly `length` bytes. Raises DeviceStatusError, TransportError, RemoteProtocolError."""
        first, end = self._aligned(address, length)
        data = bytearray()
        while first + len(data) < end:
            read = partial(self._link.read_memory, first + len(data))
            data += self._shortened(ReadMem, end - first - len(data), read)
        return bytes(data[address - first :][:length])

    def write(self, address: int, data: bytes) -> None:
        """Write all of `data`; a word covered in part is read first. Raises as `read`, AccessDeniedError."""
        self._begin_write()
        first, end = self._aligned(address, len(data))
        if (first, end) != (address, address + len(data)):
            around = self.read(first, end - first)
            data = around[: address - first] + data + around[address - first + len(data) :]
        written = 0
        while written < len(data):
            written += self._write_aligned(first + written, data[written:])

    def read_register(self, register: int) -> int:
        """Read a 32-bit register as a number, whatever the order of its bytes. Raises as `read`."""
        return self._link.read_register(register)

    def write_register(self, register: int, value: int) -> None:
        """Write a number into a 32-bit register of the standard, as `read_register` reads it.

        Raises as `read`, AccessDeniedError.
        """
        self._execute_write(WriteReg(((register, value),)))

    def read_numbers(self, address: int, length: int) -> bytes:
        """Read as `read`, but a single aligned word as a number, its most significant byte first."""
        if length != _WORD or address % _WORD:
            return self.read(address, length)
        self._aligned(address, length)
        return self._link.read_register(address).to_bytes(_WORD, "big")

    def write_numbers(self, address: int, data: bytes) -> None:
        """Write as `write`, but a single aligned word as a number, its most significant byte first."""
        if len(data) != _WORD or address % _WORD:
            self.write(address, data)
            return
        self._begin_write()
        self._aligned(address, len(data))
        self.write_register(address, int.from_bytes(data, "big"))

    def read_optional(self, register: int, otherwise: int = 0) -> int:
        """Read a register that a device need not have; one that refuses is asked once.

        Returns `otherwise` without it. Raises TransportError, DeviceLostError, RemoteProtocolError.
        """
        if register in self._absent:
            return otherwise
        try:
            return self.read_register(register)
        except DeviceStatusError as error:
            refusal: GrabberError = error
        except AckTimeoutError as error:
            self._link.read_register(BootstrapRegister.CCP)  # some devices do not answer what they refuse
            refusal = error
        self._absent.add(register)
        log.info("the camera has no register 0x%04X: %s", register, refusal)
        return otherwise

    def write_optional(self, register: int, value: int) -> bool:
        """Write a register that a device need not have, or may protect; return whether it took the value.

        One that refuses is asked once. Raises TransportError, DeviceLostError.
        """
        if register in self._protected:
            return False
        try:
            self.write_register(register, value)
        except (DeviceStatusError, AccessDeniedError) as error:
            if isinstance(error, DeviceStatusError) and error.status == Status.BUSY:
                raise
            self._protected.add(register)
            log.info("the camera does not take %d in its register 0x%04X: %s", value, register, error)
            return False
        return True

    def read_text(self, field: Field) -> str:
        """Read a string register. Raises as `read`."""
        return text_field(self.read(field.address, field.length))

    def _aligned(self, address: int, length: int) -> tuple[int, int]:
        first, end = address - address % _WORD, address + length + -(address + length) % _WORD
        if address < 0 or length < 0 or end > _SPACE:
            raise TransportError(
                f"{length} bytes at 0x{address:X} are outside the camera's 32-bit address space"
            )
        return first, end

    def _write_aligned(self, address: int, data: bytes) -> int:
        """Write as much as one command takes; return the number of bytes."""
        if self._writes_memory:

            def write(count: int) -> bytes:
                self._execute_write(WriteMem(address, data[:count]))
                return data[:count]

            return len(self._shortened(WriteMem, len(data), write))
        word = struct.Struct("<I" if self.little_endian else ">I")
        for offset in range(0, len(data), _WORD):
            (value,) = word.unpack_from(data, offset)
            self._execute_write(WriteReg(((address + offset, value),)))
        return len(data)

    def _shortened(
        self, command: type[ReadMem | WriteMem], wanted: int, execute: Callable[[int], bytes]
    ) -> bytes:
        """Execute a command for at most `wanted` bytes; learn how many a device takes that refuses many."""
        while True:
            count = min(wanted, self._longest[command])
            try:
                return execute(count)
            except (DeviceStatusError, RemoteProtocolError) as error:
                if count <= SHORTEST_CHUNK or getattr(error, "status", None) in _ABOUT_THE_PLACE:
                    raise
                refusal: GrabberError = error
            # Shorter ones may be refused for the same reason, which is not their length then.
            for shorter in (256, 128, SHORTEST_CHUNK):
                if shorter < count:
                    with suppress(DeviceStatusError, RemoteProtocolError):
                        data = execute(shorter)
                        self._longest[command] = shorter
                        log.info("the camera takes %d bytes at a time: %s", shorter, refusal)
                        return data
            raise refusal

    def _execute_write(self, request: WriteReg | WriteMem) -> None:
        try:
            self._link.execute(request)
        except AckTimeoutError as error:
            # Some devices do not answer a refused write; unlike dead ones they answer a read.
            self._link.require_control()
            if error.postponed:
                raise DeviceStatusError(str(error), Status.BUSY) from error
            raise AccessDeniedError(
                "the camera answers reads but not this write; another application may control it"
            ) from error
        except DeviceStatusError as error:
            # Devices answer ACCESS_DENIED for locked features too.
            if error.status == Status.ACCESS_DENIED:
                self._link.require_control()
            raise

    def _begin_write(self) -> None:
        if not self.writable:
            raise AccessDeniedError("the camera is open for reading only; another application may control it")
        if not self._ready_to_write:
            self._prepare_writing()

    def _prepare_writing(self) -> None:
        """Enable PENDING_ACK before the first write, and not before, so that opening writes nothing."""
        self._writes_memory = GvcpCapability.WRITEMEM in self.capability
        if self.capability & GvcpCapability.PENDING_ACK:
            register, bit = BootstrapRegister.GVCP_CONFIGURATION, GvcpConfiguration.PENDING_ACK
            try:
                configuration = self._link.read_register(register)
                if not configuration & bit:
                    self.write_register(register, configuration | bit)
            except DeviceStatusError as error:
                log.info("late acknowledges cannot be announced: %s", error)
        self._ready_to_write = True
