"""The simulated camera behind pyusb's backend interface: a USB bus within the process, on any system."""

from __future__ import annotations

import ctypes
import errno
import struct
from array import array
from collections.abc import Iterable
from types import SimpleNamespace
from typing import Any

import usb.backend
import usb.core

from grabbergui.driver.sim.u3v.device import SimulatedU3vDevice
from grabbergui.driver.sim.u3v.pipe import (
    PipeError,
    PipeGoneError,
    PipeHaltedError,
    PipeOverflowError,
    PipeTimeoutError,
)
from grabbergui.driver.sim.u3v.registers import CONTROL_OUT, DEVICE
from grabbergui.driver.u3v.bootstrap import split

_INTERFACE, _ENDPOINT = 4, 5
_SUPER_SPEED = 4

# The descriptors' fields by the names of the USB specification, which pyusb reads as attributes.
_DEVICE_FIELDS = (
    "bLength", "bDescriptorType", "bcdUSB", "bDeviceClass", "bDeviceSubClass", "bDeviceProtocol",
    "bMaxPacketSize0", "idVendor", "idProduct", "bcdDevice", "iManufacturer", "iProduct", "iSerialNumber",
    "bNumConfigurations",
)  # fmt: skip
_CONFIGURATION_FIELDS = (
    "bLength", "bDescriptorType", "wTotalLength", "bNumInterfaces", "bConfigurationValue", "iConfiguration",
    "bmAttributes", "bMaxPower",
)  # fmt: skip
_INTERFACE_FIELDS = (
    "bLength", "bDescriptorType", "bInterfaceNumber", "bAlternateSetting", "bNumEndpoints", "bInterfaceClass",
    "bInterfaceSubClass", "bInterfaceProtocol", "iInterface",
)  # fmt: skip
_ENDPOINT_FIELDS = (
    "bLength", "bDescriptorType", "bEndpointAddress", "bmAttributes", "wMaxPacketSize", "bInterval",
)  # fmt: skip
_ERRNO = {
    PipeGoneError: errno.ENODEV,
    PipeHaltedError: errno.EPIPE,
    PipeOverflowError: errno.EOVERFLOW,
}


class SimulatedBus(usb.backend.IBackend):  # type: ignore[misc]  # the library has no types
    """A bus with one camera. Interfaces are claimed exclusively, as in Linux."""

    def __init__(self, camera: SimulatedU3vDevice, *, forbidden: bool = False) -> None:
        """`forbidden`: nobody may open the device, as without a udev rule."""
        self.camera = camera
        self._forbidden = forbidden
        self._claimed: dict[int, object] = {}
        self.opened = 0
        "Handles that are open."

    def enumerate_devices(self) -> list[SimulatedU3vDevice]:
        """Return the camera, while it is plugged in."""
        return [self.camera] if self.camera.plugged else []

    def get_parent(self, dev: SimulatedU3vDevice) -> None:
        """No hub."""

    def get_device_descriptor(self, dev: SimulatedU3vDevice) -> SimpleNamespace:
        """Return the device descriptor with the device's bus address."""
        data = dev.descriptors.get(DEVICE, 0) or b""
        values = struct.unpack("<BBHBBBBHHHBBBB", data)
        place = {"bus": 1, "address": 1, "port_number": 1, "port_numbers": (1,), "speed": _SUPER_SPEED}
        return SimpleNamespace(**_named(_DEVICE_FIELDS, values), **place)

    def get_configuration_descriptor(self, dev: SimulatedU3vDevice, config: int) -> SimpleNamespace:
        """Return the only configuration."""
        if config:
            raise IndexError(f"no configuration {config}")
        values = struct.unpack_from("<BBHBBBBB", dev.descriptors.configuration())
        return SimpleNamespace(**_named(_CONFIGURATION_FIELDS, values), extra_descriptors=[])

    def get_interface_descriptor(
        self, dev: SimulatedU3vDevice, intf: int, alt: int, config: int
    ) -> SimpleNamespace:
        """Return an interface by its index; only alternate setting 0 exists."""
        interfaces = _interfaces(dev)
        if alt or intf >= len(interfaces):
            raise IndexError(f"no interface {intf} with setting {alt}")
        return interfaces[intf][0]

    def get_endpoint_descriptor(
        self, dev: SimulatedU3vDevice, ep: int, intf: int, alt: int, config: int
    ) -> SimpleNamespace:
        """Return an endpoint by its index."""
        return _interfaces(dev)[intf][1][ep]

    def open_device(self, dev: SimulatedU3vDevice) -> object:
        """Return a new handle."""
        if self._forbidden:
            raise _error(errno.EACCES)
        self._require_plugged()
        self.opened += 1
        return object()

    def close_device(self, dev_handle: object) -> None:
        """Close the handle and release the interfaces that it had claimed."""
        self._claimed = {number: owner for number, owner in self._claimed.items() if owner is not dev_handle}
        self.opened -= 1

    def claim_interface(self, dev_handle: object, intf: int) -> None:
        """Exclusively."""
        self._require_plugged()
        if self._claimed.setdefault(intf, dev_handle) is not dev_handle:
            raise _error(errno.EBUSY)

    def release_interface(self, dev_handle: object, intf: int) -> None:
        """Free it."""
        if self._claimed.get(intf) is dev_handle:
            del self._claimed[intf]

    def get_configuration(self, dev_handle: object) -> int:
        """Return the configuration that the system set when the camera was plugged in."""
        return 1

    def is_kernel_driver_active(self, dev_handle: object, intf: int) -> bool:
        """Return False: no kernel has a driver for it."""
        return False

    def ctrl_transfer(
        self,
        dev_handle: object,
        bmRequestType: int,
        bRequest: int,
        wValue: int,
        wIndex: int,
        data: Any,
        timeout: int,
    ) -> int:
        """Execute a standard request on endpoint 0; return the length of its data."""
        self._require_plugged()
        answer = self.camera.control_request(bmRequestType, bRequest, wValue, wIndex)
        if answer is None:
            raise _error(errno.EPIPE)
        address, length = data.buffer_info()
        answer = answer[:length]
        ctypes.memmove(address, answer, len(answer))
        return len(answer)

    def bulk_write(self, dev_handle: object, ep: int, intf: int, data: array[int], timeout: int) -> int:
        """Pass a command to the camera; return its length."""
        self._require_plugged()
        if ep != CONTROL_OUT or self._claimed.get(intf) is not dev_handle:
            raise _error(errno.ENOENT)
        self.camera.command(data.tobytes())
        return len(data)

    def bulk_read(self, dev_handle: object, ep: int, intf: int, buff: Any, timeout: int) -> int:
        """Return the data of the endpoint's pipe within `timeout` milliseconds."""
        self._require_plugged()
        if self._claimed.get(intf) is not dev_handle:
            raise _error(errno.ENOENT)
        address, room = buff.buffer_info()
        try:
            parts = self.camera.pipes[ep].take(room, timeout / 1000)
        except PipeTimeoutError:
            raise usb.core.USBTimeoutError("Operation timed out", -7, errno.ETIMEDOUT) from None
        except PipeError as error:
            raise _error(_ERRNO.get(type(error), errno.EIO)) from None
        length = 0
        for part in parts:
            ctypes.memmove(address + length, _address_of(part), len(part))
            length += len(part)
        return length

    def clear_halt(self, dev_handle: object, ep: int) -> None:
        """Clear the endpoint's halt (CLEAR_FEATURE)."""
        self._require_plugged()
        self.camera.control_request(0x02, 1, 0, ep)

    def _require_plugged(self) -> None:
        if not self.camera.plugged:
            raise _error(errno.ENODEV)


def _named(fields: tuple[str, ...], values: Iterable[int]) -> dict[str, Any]:
    return dict(zip(fields, values, strict=True))


def _error(number: int) -> usb.core.USBError:
    return usb.core.USBError(errno.errorcode[number], None, number)


def _address_of(part: memoryview) -> Any:
    # A view of read-only bytes has no address for ctypes; such transfers are short.
    return (
        bytes(part) if part.readonly else ctypes.addressof(ctypes.c_char.from_buffer(part)) if part else b""
    )


def _interfaces(dev: SimulatedU3vDevice) -> list[tuple[SimpleNamespace, list[SimpleNamespace]]]:
    """Return the interfaces with their endpoints, parsed from the configuration as libusb does."""
    interfaces: list[tuple[SimpleNamespace, list[SimpleNamespace]]] = []
    latest: SimpleNamespace | None = None
    for descriptor in split(dev.descriptors.configuration()):
        if descriptor[1] == _INTERFACE:
            latest = SimpleNamespace(**_named(_INTERFACE_FIELDS, descriptor), extra_descriptors=[])
            interfaces.append((latest, []))
        elif descriptor[1] == _ENDPOINT:
            values = struct.unpack("<BBBBHB", descriptor)
            more: dict[str, Any] = {"bRefresh": 0, "bSynchAddress": 0, "extra_descriptors": []}
            latest = SimpleNamespace(**_named(_ENDPOINT_FIELDS, values), **more)
            interfaces[-1][1].append(latest)
        elif latest is not None:
            latest.extra_descriptors.extend(descriptor)
    return interfaces
