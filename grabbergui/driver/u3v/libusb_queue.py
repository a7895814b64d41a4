"""Keeps several transfers of the stream endpoint in flight by python-libusb1, into the frames' buffers.

`open_queue` falls back to one transfer at a time where this is not possible.
"""

from __future__ import annotations

import contextlib
import ctypes
import logging
import time
from collections import deque
from typing import Any

import numpy as np
import usb.backend.libusb1
from numpy.typing import NDArray

from grabbergui.core.errors import AccessDeniedError, DeviceLostError, TransportError
from grabbergui.driver.u3v.block_assembler import TransferRequest
from grabbergui.driver.u3v.enumeration import UsbCamera
from grabbergui.driver.u3v.transfer_queue import Completion, SynchronousQueue, TransferOutcome, TransferQueue
from grabbergui.driver.u3v.usb import BulkInterface, UsbHandle, permission_denied

log = logging.getLogger(__name__)


try:
    import usb1
except ImportError:
    usb1 = None


CANCEL_TIME = 2.0
"Seconds until all cancelled transfers must have returned."

MOST_PREPARED = 1024
"""Idle transfers kept for reuse with the same memory: enough for a stream's buffers, leaders and trailers."""


class LibusbQueue(TransferQueue):
    """Asynchronous transfers on its own device handle, which claims the stream interface."""

    def __init__(self, library: str, camera: UsbCamera, stream: BulkInterface, depth: int) -> None:
        """Open the camera a second time, with the libusb that pyusb uses, and claim its stream interface.

        Raises AccessDeniedError, DeviceLostError, TransportError.
        """
        super().__init__()
        self.depth = depth
        self._name = camera.info.title
        self._stream = stream
        self._prepared: dict[tuple[int, int], Any] = {}
        "Idle transfers by the address and length of their memory."
        self._in_flight: deque[tuple[Any, TransferRequest, tuple[int, int]]] = deque()
        "Transfers in order, with the address and length of their memory."
        self._finished: set[Any] = set()
        usb1.loadLibrary(ctypes.CDLL(library))
        self._context: Any = usb1.USBContext().open()
        try:
            self._handle: Any = self._open(camera)
            self._handle.setAutoDetachKernelDriver(True)
            self._handle.claimInterface(stream.number)
        except usb1.USBError as error:
            self._context.close()
            raise self._ours(error) from error
        except DeviceLostError:
            self._context.close()
            raise

    def submit(self, request: TransferRequest) -> bool:
        """Queue a request; False where the kernel's memory for USB is used up."""
        place = _place(request.view)
        transfer = self._transfer(request, place)
        try:
            transfer.submit()
        except (usb1.USBErrorNoMem, usb1.USBErrorIO) as error:
            self._keep(transfer, place)
            if self._in_flight:
                return False
            raise TransportError(
                f"{self._name}: the system has no memory for a USB transfer of {len(request.view)} bytes; "
                "raise /sys/module/usbcore/parameters/usbfs_memory_mb, to 1000 say"
            ) from error
        except usb1.USBError as error:
            self._keep(transfer, place)
            raise self._ours(error) from error
        self._in_flight.append((transfer, request, place))
        self._count(request, 1)
        return True

    def wait(self, timeout: float) -> Completion | None:
        """Return the oldest request, completed."""
        if not self._in_flight:
            return None
        transfer, request, _ = self._in_flight[0]
        if transfer not in self._finished:
            self._handle_events(timeout)
            if transfer not in self._finished:
                return None
        status, length = self._collect()
        if status == usb1.TRANSFER_NO_DEVICE:
            raise DeviceLostError(f"{self._name} was unplugged")
        if status == usb1.TRANSFER_COMPLETED:
            return Completion(request, length)
        return Completion(
            request,
            length,
            TransferOutcome.HALTED if status == usb1.TRANSFER_STALL else TransferOutcome.FAILED,
        )

    def cancel(self) -> None:
        """Cancel all transfers and wait for them."""
        # Newest first: otherwise the kernel would start the next one while the oldest is cancelled.
        for transfer, *_ in reversed(self._in_flight):
            with contextlib.suppress(usb1.USBError):
                transfer.cancel()
        deadline = time.monotonic() + CANCEL_TIME
        while self._in_flight and time.monotonic() < deadline:
            if self._in_flight[0][0] in self._finished:
                self._collect()
            else:
                with contextlib.suppress(TransportError):
                    self._handle_events(0.1)
        if self._in_flight:
            log.error("%s: %d cancelled USB transfers did not return", self._name, len(self._in_flight))

    def reset_endpoint(self) -> None:
        """Halt and clear."""
        try:
            with contextlib.suppress(usb1.USBErrorPipe):  # a device may refuse to be halted
                self._handle.controlWrite(
                    0x02, usb1.REQUEST_SET_FEATURE, 0, self._stream.endpoint_in, b"", 500
                )
            self._handle.clearHalt(self._stream.endpoint_in)
        except usb1.USBError as error:
            raise self._ours(error) from error

    def wake(self) -> None:
        """Interrupt libusb's wait."""
        with contextlib.suppress(usb1.USBError, AttributeError):
            self._context.interruptEventHandler()

    def close(self) -> None:
        """Cancel, release, close the handle and its context."""
        if self._context is None:
            return
        self.cancel()
        for transfer in self._prepared.values():
            transfer.close()
        self._prepared.clear()
        with contextlib.suppress(usb1.USBError):
            self._handle.releaseInterface(self._stream.number)
        self._handle.close()
        self._context.close()
        self._context = None

    def _transfer(self, request: TransferRequest, place: tuple[int, int]) -> Any:
        """Return a transfer into the request's memory, an idle one if that memory was used before.

        Setting up a transfer takes half of the time that python-libusb1 spends on it.
        """
        transfer = self._prepared.pop(place, None)
        if transfer is None:
            transfer = self._handle.getTransfer()
            transfer.setBulk(self._stream.endpoint_in, _window(request.view), self._finished.add)
        return transfer

    def _keep(self, transfer: Any, place: tuple[int, int]) -> None:
        """Keep an idle transfer for the next request into its memory; drop the oldest of too many."""
        if place in self._prepared:  # two requests used the scratch buffer of dropped frames
            transfer.close()
            return
        self._prepared[place] = transfer
        if len(self._prepared) > MOST_PREPARED:
            self._prepared.pop(next(iter(self._prepared))).close()

    def _open(self, camera: UsbCamera) -> Any:
        for device in self._context.getDeviceIterator(skip_on_error=True):
            if (device.getBusNumber(), device.getDeviceAddress()) == (camera.bus, camera.address):
                return device.open()
        raise DeviceLostError(f"{self._name} was unplugged")

    def _handle_events(self, timeout: float) -> None:
        try:
            self._context.handleEventsTimeout(timeout)
        except usb1.USBErrorInterrupted:
            pass
        except usb1.USBError as error:
            raise self._ours(error) from error

    def _collect(self) -> tuple[int, int]:
        """Remove the oldest transfer, which has finished; return its libusb status and length."""
        transfer, request, place = self._in_flight.popleft()
        self._finished.discard(transfer)
        self._count(request, -1)
        result = transfer.getStatus(), transfer.getActualLength()
        self._keep(transfer, place)
        return result

    def _ours(self, error: usb1.USBError) -> AccessDeniedError | TransportError:
        if isinstance(error, usb1.USBErrorNoDevice):
            return DeviceLostError(f"{self._name} was unplugged")
        if isinstance(error, usb1.USBErrorAccess):
            return permission_denied(self._name)
        if isinstance(error, usb1.USBErrorBusy):
            return AccessDeniedError(f"{self._name}: another application holds its stream; close it there")
        return TransportError(f"{self._name}: USB error: {error}")


def _place(view: NDArray[np.uint8]) -> tuple[int, int]:
    """Return the address and length of an array's memory."""
    return view.__array_interface__["data"][0], len(view)


def _window(view: NDArray[np.uint8]) -> ctypes.Array[ctypes.c_char]:
    """Return the array's memory without a reference to the array; the request in flight holds that.

    python-libusb1 leaves a reference cycle at each transfer. With the array in it, a frame's buffer would
    return to its pool only with the next cyclic garbage collection.
    """
    return (ctypes.c_char * len(view)).from_address(view.ctypes.data)


def open_queue(camera: UsbCamera, handle: UsbHandle, depth: int) -> TransferQueue:
    """Return the best available queue: asynchronous over libusb, otherwise synchronous.

    Raises AccessDeniedError, DeviceLostError, TransportError.
    """
    stream = camera.stream
    if stream is None:
        raise TransportError(f"{handle.name} has no stream interface")
    library = _libusb_of(camera.backend)
    if library is not None and depth > 1 and usb1 is None:
        log.info("python-libusb1 is missing; streaming takes one transfer at a time")
    elif library is not None and depth > 1:
        try:
            return LibusbQueue(library, camera, stream, depth)
        except (AccessDeniedError, DeviceLostError):
            raise
        except TransportError as error:
            log.info("no second handle (%s); streaming takes one transfer at a time", error)
    return SynchronousQueue(handle, stream)


def _libusb_of(backend: Any) -> str | None:
    """Return the path of the libusb that a pyusb backend runs on; None for a simulated bus."""
    if not isinstance(backend, usb.backend.libusb1._LibUSB):
        return None
    name: str = backend.lib._name
    return name
