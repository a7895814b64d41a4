"""An open USB device: transfers through pyusb's backends (libusb, or a simulated bus), and registers.

Calls are synchronous, from any thread; close a handle only when no other thread uses it. pyusb's errors
become ours here. Registers are accessed by GenCP over the two endpoints of the control interface.
"""

from __future__ import annotations

import contextlib
import errno
import logging
import threading
import time
from array import array
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import usb.core
from numpy.typing import NDArray

from grabbergui.core.environment import sudo_command
from grabbergui.core.errors import (
    AccessDeniedError,
    AckTimeoutError,
    DeviceLostError,
    DeviceStatusError,
    GrabberError,
    LocalProtocolError,
    RemoteProtocolError,
    TransportError,
)
from grabbergui.driver.u3v.gencp import (
    HEADER_SIZE,
    SMALLEST_ACKNOWLEDGE,
    WRITE_OVERHEAD,
    CommandId,
    ControlChannel,
    Packet,
    parse_reserved_and_value,
    read_memory,
    write_memory,
)
from grabbergui.driver.u3v.stream_protocol import round_up

log = logging.getLogger(__name__)

_ENDPOINT_RECIPIENT = 0x02
_DEVICE_TO_HOST = 0x80
_GET_STATUS = 0
_SET_FEATURE = 3
_ENDPOINT_HALT = 0

_GONE = (errno.ENODEV, errno.ESHUTDOWN, errno.ENXIO)


class EndpointHaltedError(TransportError):
    """The device stalls the endpoint; clearing the halt may help."""


class UsbTimeoutError(TransportError):
    """A transfer timed out."""


def permission_denied(name: str) -> AccessDeniedError:
    """Return the error for a device that we have no permission to open, with advice."""
    return AccessDeniedError(
        f"no permission to open {name}: run `{sudo_command('setup', 'udev')}`, then plug the camera in again"
    )


@contextlib.contextmanager
def translated(name: str) -> Iterator[None]:
    """Raise pyusb's errors about the device `name` as ours."""
    try:
        yield
    except usb.core.USBTimeoutError as error:
        raise UsbTimeoutError(f"{name}: USB transfer timed out") from error
    except usb.core.USBError as error:
        if error.errno in _GONE:
            raise DeviceLostError(f"{name} was unplugged") from error
        if error.errno == errno.EACCES:
            raise permission_denied(name) from error
        if error.errno == errno.EBUSY:
            raise AccessDeniedError(f"{name} is in use by another application; close it there") from error
        if error.errno == errno.EPIPE:
            raise EndpointHaltedError(f"{name} halted a USB endpoint") from error
        raise TransportError(f"{name}: USB error: {error.strerror or error}") from error
    except NotImplementedError as error:
        # LIBUSB_ERROR_NOT_SUPPORTED: the system's driver cannot do it.
        raise TransportError(
            f"{name}: the driver that the system uses for it lacks this call; on Windows libusb needs WinUSB"
        ) from error


@dataclass(frozen=True)
class BulkInterface:
    """An interface with its endpoints, which are found by direction: numbers differ between makers."""

    number: int
    endpoint_in: int
    endpoint_out: int
    "0: none."
    packet_size: int
    "Bytes of the largest packet: 1024 at SuperSpeed, 512 at High-Speed."


class _Window:
    """A numpy view with the interface of `array.array` that pyusb's backends use."""

    itemsize = 1

    def __init__(self, view: NDArray[np.uint8]) -> None:
        self._view = view

    def buffer_info(self) -> tuple[int, int]:
        return self._view.ctypes.data, len(self._view)

    def __len__(self) -> int:
        return len(self._view)


class UsbHandle:
    """One opened USB device."""

    def __init__(self, backend: Any, device_id: Any, name: str) -> None:
        """Open it. Raises AccessDeniedError, DeviceLostError, TransportError."""
        self.name = name
        "The device's name in messages."
        self._backend = backend
        self._claimed: dict[int, bool] = {}
        "Claimed interfaces, and whether a kernel driver gets them back."
        with translated(name):
            self._handle = backend.open_device(device_id)

    def claim(self, interface: int) -> None:
        """Claim an interface, detaching a kernel driver. Raises AccessDeniedError if it is in use."""
        detached = self._detach(interface)
        try:
            with translated(self.name):
                self._backend.claim_interface(self._handle, interface)
        except (TransportError, AccessDeniedError):
            self._attach(interface, detached)
            raise
        self._claimed[interface] = detached

    def release(self, interface: int) -> None:
        """Release an interface and reattach its kernel driver. Never raises."""
        if interface not in self._claimed:
            return
        detached = self._claimed.pop(interface)
        with contextlib.suppress(GrabberError), translated(self.name):
            self._backend.release_interface(self._handle, interface)
        self._attach(interface, detached)

    def close(self) -> None:
        """Release all interfaces and close the device. May be called twice; never raises."""
        for interface in tuple(self._claimed):
            self.release(interface)
        handle, self._handle = self._handle, None
        if handle is not None:
            with contextlib.suppress(GrabberError), translated(self.name):
                self._backend.close_device(handle)

    def write(self, endpoint: int, interface: int, data: bytes, timeout: float) -> None:
        """Write one bulk transfer. Raises UsbTimeoutError, EndpointHaltedError, DeviceLostError."""
        with translated(self.name):
            sent = self._backend.bulk_write(
                self._handle, endpoint, interface, array("B", data), _milliseconds(timeout)
            )
        if sent != len(data):
            raise TransportError(f"{self.name} took {sent} of {len(data)} bytes")

    def read_into(self, endpoint: int, interface: int, view: NDArray[np.uint8], timeout: float) -> int:
        """Read one bulk transfer of at most `len(view)` bytes; return its length. Raises as `write`."""
        with translated(self.name):
            length: int = self._backend.bulk_read(
                self._handle, endpoint, interface, _Window(view), _milliseconds(timeout)
            )
        return length

    def read_whole(self, endpoint: int, interface: int, view: NDArray[np.uint8], timeout: float) -> int:
        """Like `read_into`, but read a started transfer to its end, beyond the timeout if necessary.

        Otherwise a timeout in the middle of a long transfer would look like its end.
        """
        length = 0
        while True:
            begun = time.monotonic()
            part = self.read_into(endpoint, interface, view[length:], timeout)
            length += part
            timed_out = time.monotonic() - begun >= timeout
            if not timed_out or part == 0 or part % 512 or length == len(view):
                return length

    def clear_halt(self, endpoint: int) -> None:
        """End a stall and restart the endpoint's sequence on both sides."""
        with translated(self.name):
            self._backend.clear_halt(self._handle, endpoint)

    def set_halt(self, endpoint: int) -> None:
        """Make the device stall the endpoint and discard the data queued on it."""
        with translated(self.name):
            self._backend.ctrl_transfer(
                self._handle, _ENDPOINT_RECIPIENT, _SET_FEATURE, _ENDPOINT_HALT, endpoint, array("B"), 500
            )

    def is_present(self) -> bool:
        """Return whether the device still answers on endpoint 0."""
        try:
            with translated(self.name):
                self._backend.ctrl_transfer(
                    self._handle, _DEVICE_TO_HOST, _GET_STATUS, 0, 0, array("B", bytes(2)), 500
                )
        except DeviceLostError:
            return False
        except TransportError:
            return True
        return True

    def _detach(self, interface: int) -> bool:
        try:
            with translated(self.name):
                if self._backend.is_kernel_driver_active(self._handle, interface):
                    self._backend.detach_kernel_driver(self._handle, interface)
                    return True
        except GrabberError as error:
            log.debug("kernel driver of interface %d: %s", interface, error)
        return False

    def _attach(self, interface: int, detached: bool) -> None:
        if detached:
            with contextlib.suppress(GrabberError), translated(self.name):
                self._backend.attach_kernel_driver(self._handle, interface)


def _milliseconds(timeout: float) -> int:
    return max(int(timeout * 1000), 1)  # 0 means no limit to libusb


# -- registers by address ------------------------------------------------------------------------
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

    def read_u32(self, address: int) -> int:
        """Return a little-endian register of four bytes."""
        return int.from_bytes(self.read(address, 4), "little")

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
