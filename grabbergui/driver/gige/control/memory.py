"""A device's memory and registers of any length and alignment, over its control link."""

from __future__ import annotations

import struct

from grabbergui.core.errors import (
    AccessDeniedError,
    AckTimeoutError,
    DeviceStatusError,
    GrabberError,
    TransportError,
)
from grabbergui.driver.gige.bootstrap import (
    PORT_MASK,
    Capability,
    Control,
    Field,
    GvcpConfiguration,
    Register,
)
from grabbergui.driver.gige.control.link import ControlLink
from grabbergui.driver.gige.gvcp import MEMORY_CHUNK, Status, WriteMem, WriteReg
from grabbergui.driver.gige.gvcp_messages import text_of

WORD = 4
SPACE = 1 << 32


class DeviceMemory:
    """Reads and writes of any length and alignment, by the protocol's aligned ones. Any thread may call."""

    def __init__(self, link: ControlLink) -> None:
        self._link = link
        self.capability = Capability(0)
        "The device's capabilities; set while it is opened."
        self.writable = False
        "Whether we have control."
        self._pending_acks_enabled = False

    def read(self, address: int, length: int) -> bytes:
        """Read exactly `length` bytes. Raises DeviceStatusError, TransportError, RemoteProtocolError."""
        first, end = self._aligned(address, length)
        pieces = [
            self._link.read_memory(at, min(MEMORY_CHUNK, end - at)) for at in range(first, end, MEMORY_CHUNK)
        ]
        return b"".join(pieces)[address - first :][:length]

    def write(self, address: int, data: bytes) -> None:
        """Write all of `data`; a word covered in part is read first. Raises as `read`, AccessDeniedError."""
        if not self.writable:
            raise AccessDeniedError("the camera is open for reading only; another application may control it")
        first, end = self._aligned(address, len(data))
        if (first, end) != (address, address + len(data)):
            around = self.read(first, end - first)
            data = around[: address - first] + data + around[address - first + len(data) :]
        self._enable_pending_acks()
        for at in range(0, len(data), MEMORY_CHUNK):
            self._write_aligned(first + at, data[at : at + MEMORY_CHUNK])

    def read_register(self, register: int) -> int:
        """Read a 32-bit register. Raises as `read`."""
        return self._link.read_register(register)

    def write_register(self, register: int, value: int) -> None:
        """Write a 32-bit register. Raises as `write`."""
        self._execute_write(WriteReg(((register, value),)))

    def read_text(self, field: Field) -> str:
        """Read a string register. Raises as `read`."""
        return text_of(self.read(field.address, field.length))

    def _aligned(self, address: int, length: int) -> tuple[int, int]:
        first, end = address - address % WORD, address + length + -(address + length) % WORD
        if address < 0 or length < 0 or end > SPACE:
            raise TransportError(
                f"{length} bytes at 0x{address:X} are outside the camera's 32-bit address space"
            )
        return first, end

    def _write_aligned(self, address: int, data: bytes) -> None:
        if Capability.WRITEMEM in self.capability:
            self._execute_write(WriteMem(address, data))
            return
        for offset in range(0, len(data), WORD):
            (value,) = struct.unpack_from(">I", data, offset)
            self._execute_write(WriteReg(((address + offset, value),)))

    def _execute_write(self, request: WriteReg | WriteMem) -> None:
        try:
            self._link.execute(request)
        except AckTimeoutError as error:
            # Some devices do not answer a refused write; unlike dead ones they answer a read.
            self._link.read_register(Register.CCP)
            raise AccessDeniedError(
                "the camera answers reads but not this write; another application may control it"
            ) from error
        except DeviceStatusError as error:
            if error.status == Status.ACCESS_DENIED and not self._in_control():
                raise AccessDeniedError(f"another application controls the camera: {error}") from error
            raise

    def _in_control(self) -> bool:
        """Return whether control is ours: devices answer ACCESS_DENIED for locked features too."""
        try:
            privilege = self._link.read_register(Register.CCP)
            if not privilege & (Control.CONTROL | Control.EXCLUSIVE):
                return False
            if self.capability & Capability.PRIMARY_APPLICATION:
                port = self._link.read_register(Register.PRIMARY_APPLICATION_PORT) & PORT_MASK
                return port in (0, self._link.local_port)
        except GrabberError:
            return False
        return self.writable

    def _enable_pending_acks(self) -> None:
        """Enable PENDING_ACK before the first write, and not before, so that opening writes nothing."""
        if self._pending_acks_enabled or not self.capability & Capability.PENDING_ACK:
            return
        self._pending_acks_enabled = True
        configuration = self._link.read_register(Register.GVCP_CONFIGURATION)
        if not configuration & GvcpConfiguration.PENDING_ACK:
            self.write_register(Register.GVCP_CONFIGURATION, configuration | GvcpConfiguration.PENDING_ACK)
