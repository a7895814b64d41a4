"""An open USB device: transfers through pyusb's backends (libusb, or a simulated bus).

Calls are synchronous, from any thread; close a handle only when no other thread uses it. pyusb's errors
become ours here.
"""

from __future__ import annotations

import contextlib
import errno
import logging
import time
from array import array
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import usb.core
from numpy.typing import NDArray

from grabbergui.core.environment import sudo_command
from grabbergui.core.errors import AccessDeniedError, DeviceLostError, GrabberError, TransportError

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
