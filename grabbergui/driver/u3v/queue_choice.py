"""Which queue of stream transfers a camera gets."""

from __future__ import annotations

import logging
from typing import Any

import usb.backend.libusb1

from grabbergui.core.errors import AccessDeniedError, DeviceLostError, TransportError
from grabbergui.driver.u3v.enumeration import UsbCamera
from grabbergui.driver.u3v.synchronous_queue import SynchronousQueue
from grabbergui.driver.u3v.transfer_queue import TransferQueue
from grabbergui.driver.u3v.usb import UsbHandle

log = logging.getLogger(__name__)


def open_queue(camera: UsbCamera, handle: UsbHandle, depth: int) -> TransferQueue:
    """The best queue there is: asynchronous over libusb, synchronous where that cannot be had.

    Raises AccessDeniedError, DeviceLostError, TransportError.
    """
    stream = camera.stream
    if stream is None:
        raise TransportError(f"{handle.name} has no stream interface")
    library = _libusb_of(camera.backend)
    if library is not None and depth > 1:
        try:
            from grabbergui.driver.u3v.libusb_queue import LibusbQueue

            return LibusbQueue(library, camera, stream, depth)
        except ImportError:
            log.info("python-libusb1 is missing; streaming takes one transfer at a time")
        except (AccessDeniedError, DeviceLostError):
            raise
        except TransportError as error:
            log.info("no second handle (%s); streaming takes one transfer at a time", error)
    return SynchronousQueue(handle, stream)


def _libusb_of(backend: Any) -> str | None:
    """The path of the libusb that a pyusb backend runs on; None for a simulated bus."""
    if not isinstance(backend, usb.backend.libusb1._LibUSB):
        return None
    name: str = backend.lib._name
    return name
