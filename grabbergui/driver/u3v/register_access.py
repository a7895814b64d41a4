"""Reads and writes a USB3 Vision camera's registers, by GenCP over the control interface."""

from __future__ import annotations

import logging
import threading
import time

import numpy as np

from grabbergui.core.errors import (
    AckTimeoutError,
    DeviceStatusError,
    LocalProtocolError,
    RemoteProtocolError,
    TransportError,
)
from grabbergui.driver.u3v.control_channel import ControlChannel
from grabbergui.driver.u3v.gencp import (
    HEADER_SIZE,
    SMALLEST_ACKNOWLEDGE,
    WRITE_OVERHEAD,
    CommandId,
    Packet,
    parse_reserved_and_value,
    read_memory,
    write_memory,
)
from grabbergui.driver.u3v.stream_protocol import round_up
from grabbergui.driver.u3v.usb import BulkInterface, EndpointHaltedError, UsbHandle, UsbTimeoutError

log = logging.getLogger(__name__)

FIRST_TRANSFER = 128
"Bytes of a transfer until the device has reported their limit."
LONGEST_TRANSFER = 65536
"Limit against a faulty register; no device supports more."


class RegisterAccess:
    """Access to a device's memory by address. Thread-safe; calls are serialised."""

    def __init__(self, handle: UsbHandle, control: BulkInterface) -> None:
        self.channel = ControlChannel()
        self._handle = handle
        self._control = control
        self._longest_command = FIRST_TRANSFER
        self._longest_acknowledge = FIRST_TRANSFER
        self._inbox = np.zeros(LONGEST_TRANSFER + control.packet_size, np.uint8)
        self._lock = threading.Lock()

    def set_longest_transfers(self, command: int, acknowledge: int) -> None:
        """Use the device's limits for whole transfers (SBRM), in bytes. Raises RemoteProtocolError."""
        if command <= WRITE_OVERHEAD or acknowledge <= SMALLEST_ACKNOWLEDGE:
            raise RemoteProtocolError(
                f"the device takes commands of {command} bytes and gives acknowledges of {acknowledge} at "
                "most; that is too short for any"
            )
        self._longest_command = min(command, LONGEST_TRANSFER)
        self._longest_acknowledge = min(acknowledge, LONGEST_TRANSFER)

    def read(self, address: int, length: int) -> bytes:
        """Read exactly `length` bytes. Raises DeviceStatusError, AckTimeoutError, DeviceLostError."""
        step = self._longest_acknowledge - HEADER_SIZE
        data = bytearray()
        with self._lock:
            while len(data) < length:
                data += self._read_piece(address + len(data), min(step, length - len(data)))
        return bytes(data)

    def write(self, address: int, data: bytes) -> None:
        """Write all of `data`. Raises as `read`."""
        step = self._longest_command - WRITE_OVERHEAD
        with self._lock:
            for start in range(0, len(data), step):
                self._write_piece(address + start, data[start : start + step])

    def read_u64(self, address: int) -> int:
        """Return a little-endian register of eight bytes."""
        return int.from_bytes(self.read(address, 8), "little")

    def read_optional(self, address: int, length: int, otherwise: int = 0) -> int:
        """Return a little-endian register that a device need not have; `otherwise` if it refuses to."""
        try:
            return int.from_bytes(self.read(address, length), "little")
        except DeviceStatusError as error:
            log.info("the camera has no register 0x%X: %s", address, error)
            return otherwise

    def write_u32(self, address: int, value: int) -> None:
        """Write a little-endian register of four bytes."""
        self.write(address, value.to_bytes(4, "little"))

    def _read_piece(self, address: int, length: int) -> bytes:
        answer = self._exchange(CommandId.READMEM, read_memory(address, length), HEADER_SIZE + length)
        if len(answer.data) != length:
            raise RemoteProtocolError(f"asked for {length} bytes at 0x{address:X}, got {len(answer.data)}")
        return answer.data

    def _write_piece(self, address: int, data: bytes) -> None:
        answer = self._exchange(CommandId.WRITEMEM, write_memory(address, data), SMALLEST_ACKNOWLEDGE)
        # Devices without the capability "written length" may omit it or send zero.
        written = parse_reserved_and_value(answer.data) if answer.data else 0
        if written not in (0, len(data)):
            raise TransportError(f"the device wrote {written} of {len(data)} bytes at 0x{address:X}")

    def _exchange(self, command: CommandId, data: bytes, expected: int) -> Packet:
        channel = self.channel
        try:
            self._send(channel.begin(command, data, time.monotonic()))
            while True:
                left = channel.deadline - time.monotonic()
                transfer = self._receive(expected, left) if left > 0 else None
                if transfer is not None:
                    answer = channel.receive(transfer, time.monotonic())
                    if answer is not None:
                        return answer
                elif time.monotonic() >= channel.deadline:
                    self._send(channel.expire(time.monotonic()))
        finally:
            channel.abandon()

    def _send(self, transfer: bytes) -> None:
        timeout = max(self.channel.response_time, 1.0)
        try:
            self._handle.write(self._control.endpoint_out, self._control.number, transfer, timeout)
        except EndpointHaltedError:
            self.clear_halts()
            self._handle.write(self._control.endpoint_out, self._control.number, transfer, timeout)
        except UsbTimeoutError as error:
            raise AckTimeoutError("the device takes no commands; unplug it and plug it in again") from error

    def _receive(self, expected: int, timeout: float) -> bytes | None:
        # No longer than the answer may be: after an answer of whole packets no empty packet follows.
        if expected > len(self._inbox):
            raise LocalProtocolError(f"an acknowledge of {expected} bytes is too long")
        room = round_up(max(expected, SMALLEST_ACKNOWLEDGE), self._control.packet_size)
        try:
            length = self._handle.read_into(
                self._control.endpoint_in, self._control.number, self._inbox[:room], timeout
            )
        except UsbTimeoutError:
            return None
        except EndpointHaltedError:
            self.clear_halts()
            return None
        return self._inbox[:length].tobytes()

    def clear_halts(self) -> None:
        """Clear a stall of either endpoint, which a previous host may have left."""
        self._handle.clear_halt(self._control.endpoint_in)
        self._handle.clear_halt(self._control.endpoint_out)
