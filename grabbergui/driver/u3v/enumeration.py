"""Finds USB3 Vision cameras, and chooses the libusb to find them with."""

from __future__ import annotations

import contextlib
import errno
import logging
import sys
import threading
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import usb.backend.libusb1
import usb.core
import usb.util

from grabbergui.core.device_text import text_field
from grabbergui.core.errors import GrabberError, SourceNotFoundError, SourceUnavailableError
from grabbergui.core.identity import DeviceInfo, choose, describe, distinct_names
from grabbergui.core.uri import SourceUri
from grabbergui.driver.u3v import bootstrap, users
from grabbergui.driver.u3v.bootstrap import DeviceInfoDescriptor
from grabbergui.driver.u3v.usb import BulkInterface, translated

log = logging.getLogger(__name__)

_SYSTEM_DEVICES = Path("/sys/bus/usb/devices")
_UDEV_CONTROL = Path("/run/udev/control")

_lock = threading.Lock()
_kept: list[Any] = []
"""Backends in use, newest last; never dropped, because devices of an older one may still be open."""
_looked_at: set[tuple[int, int]] = set()
"Bus and address of the devices for which the newest backend was made."
ENGLISH = 0x0409
STRING_TIMEOUT_MS = 300
"For each string, so that one dead device does not delay the search."
_DIRECTION_IN = 0x80
_BULK = 0x02


def default_backend() -> Any | None:
    """Return pyusb's backend for the system's libusb or that of `libusb-package`; None without either."""
    with _lock:
        if not _kept:
            backend = usb.backend.libusb1.get_backend()
            if backend is None:
                try:
                    import libusb_package
                except ImportError:
                    return None
                backend = libusb_package.get_libusb1_backend()
            if backend is None:
                return None
            _kept.append(backend)
        with contextlib.suppress(usb.core.USBError):
            _look_again()
        return _kept[-1]


def _look_again() -> None:
    """Create a new context after devices were plugged in or out, if libusb cannot detect that itself.

    libusb relies on udev for it, which containers and small systems lack.
    """
    global _looked_at
    if not sys.platform.startswith("linux") or _UDEV_CONTROL.exists():
        return
    present = set()
    for folder in _SYSTEM_DEVICES.glob("*"):
        with contextlib.suppress(OSError, ValueError):
            present.add((int((folder / "busnum").read_text()), int((folder / "devnum").read_text())))
    newest = _kept[-1]
    descriptors = map(newest.get_device_descriptor, newest.enumerate_devices())
    known = {(descriptor.bus, descriptor.address) for descriptor in descriptors}
    # Once for each change: libusb may not be allowed to see a device that a new context misses, too.
    if present not in (known, _looked_at):
        _looked_at = present
        _kept.append(type(newest)(newest.lib))


@dataclass(frozen=True)
class UsbCamera:
    """A camera found on a bus."""

    info: DeviceInfo
    guid: str
    backend: Any
    device_id: Any
    "The backend's own."
    bus: int
    address: int
    control: BulkInterface
    event: BulkInterface | None
    stream: BulkInterface | None

    @property
    def names(self) -> tuple[str, ...]:
        """Serial number, GUID, bus address and user name; some may be empty."""
        return (self.info.serial, self.guid, self.info.address, self.info.user_name)

    def user(self) -> str:
        """Return the other program that uses it, as far as this computer knows; empty if none does."""
        return users.user_of(self.info.address, self.bus, self.address)

    def answers_to(self, name: str) -> bool:
        """Return whether `name` is one of its names."""
        return name.lower() in (known.lower() for known in self.names if known)


def find_cameras(backend: Any | None = None) -> list[UsbCamera]:
    """Return all cameras on `backend` (libusb by default), in the order of the buses.

    Each has a URI of its own, even if several have one serial number. The list includes devices that cannot
    be opened, with a note about the reason. Raises SourceUnavailableError if libusb is missing.
    """
    backend = backend if backend is not None else default_backend()
    if backend is None:
        raise SourceUnavailableError("u3v: sources need libusb: pip install libusb-package")
    try:
        device_ids = list(backend.enumerate_devices())
    except usb.core.USBError as error:
        log.info("no USB bus can be searched: %s", error)
        return []
    found = []
    for device_id in device_ids:
        # Skip devices with broken descriptors, or that libusb cannot open here: others must be found.
        with contextlib.suppress(GrabberError, IndexError, ValueError), translated("a USB device"):
            camera = _examine(backend, device_id)
            if camera is not None:
                found.append(camera)
    found.sort(key=lambda camera: (camera.bus, camera.address))
    uris = [str(SourceUri("u3v", name)) for name in distinct_names(camera.names for camera in found)]
    return [
        replace(camera, info=replace(camera.info, uri=uri)) for camera, uri in zip(found, uris, strict=True)
    ]


def find_camera(name: str, backend: Any | None = None, wanted: DeviceInfo | None = None) -> UsbCamera:
    """Return the camera with this name, or the first if `name` is empty; only the `wanted` unit if given.

    Raises SourceNotFoundError; OtherCameraError if another camera answers to the name, or several do.
    """
    cameras = find_cameras(backend)
    answering = [camera for camera in cameras if not name or camera.answers_to(name)]
    if (chosen := choose(name, answering, wanted, lambda camera: camera.info)) is not None:
        return chosen
    if not cameras:
        raise SourceNotFoundError("no USB3 Vision camera is plugged in")
    known = ", ".join(camera.info.uri for camera in cameras)
    if wanted is not None and not name:
        raise SourceNotFoundError(f"{describe(wanted)} is not plugged in; there is {known}")
    raise SourceNotFoundError(f"no USB3 Vision camera answers to '{name}'; there is {known}")


def _examine(backend: Any, device_id: Any) -> UsbCamera | None:
    device = usb.core.Device(device_id, backend)
    for configuration in device:
        by_protocol: dict[int, Any] = {}
        for interface in configuration:
            if (interface.bInterfaceClass, interface.bInterfaceSubClass) == (
                bootstrap.MISCELLANEOUS_CLASS,
                bootstrap.U3V_SUBCLASS,
            ):
                by_protocol.setdefault(interface.bInterfaceProtocol, interface)
        control = _bulk_interface(by_protocol.get(bootstrap.CONTROL_PROTOCOL))
        if control is None or not control.endpoint_out:
            continue
        described = DeviceInfoDescriptor.find(_extra(by_protocol[bootstrap.CONTROL_PROTOCOL]))
        info, guid = _identify(device, described)
        return UsbCamera(
            info=info,
            guid=guid,
            backend=backend,
            device_id=device_id,
            bus=device.bus or 0,
            address=device.address or 0,
            control=control,
            event=_bulk_interface(by_protocol.get(bootstrap.EVENT_PROTOCOL)),
            stream=_bulk_interface(by_protocol.get(bootstrap.STREAM_PROTOCOL)),
        )
    return None


def _bulk_interface(interface: Any) -> BulkInterface | None:
    if interface is None:
        return None
    ends = [endpoint for endpoint in interface if endpoint.bmAttributes & 3 == _BULK]
    inward = [endpoint for endpoint in ends if endpoint.bEndpointAddress & _DIRECTION_IN]
    outward = [endpoint for endpoint in ends if not endpoint.bEndpointAddress & _DIRECTION_IN]
    if not inward:
        return None
    packet_size = inward[0].wMaxPacketSize & 0x7FF
    return BulkInterface(
        interface.bInterfaceNumber,
        inward[0].bEndpointAddress,
        outward[0].bEndpointAddress if outward else 0,
        packet_size or 512,
    )


def _extra(interface: Any) -> bytes:
    ends = b"".join(bytes(endpoint.extra_descriptors or b"") for endpoint in interface)
    return bytes(interface.extra_descriptors or b"") + ends


def _identify(device: Any, described: DeviceInfoDescriptor | None) -> tuple[DeviceInfo, str]:
    """Return names and GUID from the device's strings or, without access to them, from the system."""
    place = f"{device.bus}-{'.'.join(map(str, device.port_numbers or (device.address,)))}"
    d = described or DeviceInfoDescriptor(0, 0, 0)
    note = ""
    texts = dict.fromkeys(("vendor", "model", "serial", "version", "user_name", "guid"), "")
    indices = {
        "vendor": d.vendor_index or device.iManufacturer,
        "model": d.model_index or device.iProduct,
        "serial": d.serial_index or device.iSerialNumber,
        "version": d.version_index,
        "user_name": d.user_name_index,
        "guid": d.guid_index,
    }
    try:
        with translated(f"USB device {place}"):
            texts.update(_strings(device, indices))
    except GrabberError as error:
        texts.update(_system_strings(place))
        note = str(error)
    finally:
        usb.util.dispose_resources(device)
    guid = texts.pop("guid")
    speed = bootstrap.SPEED_NAMES.get(device.speed or 0, "")
    info = DeviceInfo(
        uri=f"u3v:{place}",  # until `find_cameras` knows the others' names
        bus="USB3 Vision",
        address=place,
        interface=f"USB bus {device.bus}" + (f", {speed}" if speed else ""),
        note=note,
        hardware_id=guid.lower(),
        **texts,
    )
    return info, guid


def _strings(device: Any, indices: dict[str, int]) -> Iterator[tuple[str, str]]:
    device.default_timeout = STRING_TIMEOUT_MS
    for name, index in indices.items():
        if index:
            try:
                yield name, (usb.util.get_string(device, index, ENGLISH) or "").strip("\0 ")
            except (UnicodeDecodeError, IndexError):
                continue
            except usb.core.USBError as error:
                if error.errno != errno.EPIPE:  # a stall means that there is no such string
                    raise


def _system_strings(place: str) -> Iterator[tuple[str, str]]:
    """Yield the names and serial number that Linux read when the device was plugged in."""
    folder = Path("/sys/bus/usb/devices") / place
    for name, file in (("vendor", "manufacturer"), ("model", "product"), ("serial", "serial")):
        with contextlib.suppress(OSError):
            yield name, text_field((folder / file).read_bytes())
