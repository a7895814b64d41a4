"""A camera behind Aravis as a `Device`; `aravis:` sources.

The URI is `aravis:` (the first found), `aravis:192.168.0.10`, `aravis:SERIAL` or `aravis:AravisID`.
"""

from __future__ import annotations

import ctypes
import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from typing import Any
from urllib.parse import quote

from typing_extensions import override

from grabbergui.core.device_text import text_field
from grabbergui.core.errors import (
    AccessDeniedError,
    AckTimeoutError,
    DeviceLostError,
    DeviceStatusError,
    RemoteProtocolError,
    SourceNotFoundError,
    TransportError,
)
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.identity import DeviceInfo, choose, describe, differs, distinct_names, require_same
from grabbergui.core.uri import NoOptions, SourceUri, check_address, is_ip_address, read_options
from grabbergui.driver.aravis.library import (
    CONTROL_LOST,
    CONTROL_LOST_CALLBACK,
    PACKET_SOCKET_DISABLED,
    Failure,
    load,
)
from grabbergui.driver.aravis.stream import AravisStream
from grabbergui.driver.device import DataLayout, Device, StreamRequest, with_texts
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.genapi.cleaning import port_name
from grabbergui.driver.gige.bootstrap import (
    BIG_ENDIAN_MODE,
    GVCP_PORT,
    BootstrapRegister,
    ControlPrivilege,
    known_registers,
)
from grabbergui.driver.gige.identity import identity_texts as gige_texts
from grabbergui.driver.gige.quirks import DescriptionTraits
from grabbergui.driver.u3v.bootstrap import identity_texts as u3v_texts

_list_lock = threading.Lock()
"Aravis keeps one list for the whole process."
_BUS = {"GigEVision": "GigE Vision", "USB3Vision": "USB3 Vision"}
SEARCH = "GRABBERGUI_ARAVIS"
"""Environment variable: set to 1 to list the cameras that Aravis finds, in addition to our own."""


@dataclass(frozen=True)
class FoundCamera:
    """One entry of Aravis's list."""

    id: str
    "Vendor, model and serial number joined by hyphens, by which Aravis opens it."
    physical_id: str
    "MAC address or GUID."
    address: str
    vendor: str
    model: str
    serial: str
    protocol: str

    @property
    def address_or_id(self) -> str:
        """A unique id: the address on a network, where several cameras may share an Aravis id."""
        return self.address if self.protocol == "GigEVision" and self.address else self.id

    @property
    def names(self) -> tuple[str, ...]:
        """Its id, address, MAC address or GUID, and serial number; some may be empty."""
        return (self.id, self.address, self.physical_id, self.serial)

    def answers_to(self, name: str) -> bool:
        """Whether `name` is one of its names."""
        return name.lower() in [text.lower() for text in self.names if text]

    def info(self, name: str = "") -> DeviceInfo:
        """Return the entry for the list of sources; its URI has `name` (by default the id)."""
        return DeviceInfo(
            uri=f"aravis:{quote(name or self.id, safe=' :-_.')}",
            vendor=self.vendor,
            model=self.model,
            serial=self.serial,
            bus=f"{_BUS.get(self.protocol, self.protocol)} by Aravis",
            address=self.address,
            hardware_id=self.physical_id.lower() if self.protocol == "GigEVision" else "",
        )


def find_cameras() -> list[FoundCamera]:
    """Return the cameras on all interfaces; takes about a second. Raises SourceUnavailableError."""
    library = load()
    fields = ("id", "physical_id", "address", "vendor", "model", "serial_nbr", "protocol")
    with _list_lock:
        library.arv_update_device_list()
        getters = [getattr(library, f"arv_get_device_{field}") for field in fields]
        return [
            FoundCamera(*(text_field(getter(index) or b"") for getter in getters))
            for index in range(library.arv_get_n_devices())
        ]


class AravisDevice(Device):
    """One camera, by IP address, Aravis's id, serial number or MAC address; empty: the first found.

    The name selects a camera only the first time; reopening finds the same unit or fails.
    """

    def __init__(self, name: str, info: DeviceInfo) -> None:
        super().__init__(info)
        self._name = name
        self._library: Any = None
        self._device: int | None = None
        self._writable = False
        self._numbers = False
        "Whether registers of four bytes are read and written as numbers, see `driver.gige.quirks`."
        self._identified = False
        "Whether `info` comes from the camera itself."
        # The signal's handler must live as long as the device.
        self._on_control_lost = CONTROL_LOST_CALLBACK(self._on_signal)
        self._handler = 0

    @override
    def open(self, access: Access) -> Access:
        """Open the camera. Aravis always takes control; for MONITOR access it is released again."""
        self.close()
        self._library, self.lost = load(), ""
        found = None if is_ip_address(self._name) else self._find()
        # Aravis opens any of several cameras with the same id; an address is unique.
        name = found.address_or_id if found else self._name
        failure = Failure(f"opening {name}")
        device = self._library.arv_open_device(name.encode(), failure.place)
        error = failure.error()
        if not device:
            raise SourceNotFoundError(f"Aravis cannot open '{name}': {error}") from error
        self._device = device
        try:
            info = self._identify(device, found)
            self._settle_access(device, access, info)
        except BaseException:
            self.close()
            raise
        self.info, self._identified = info, True
        self._handler = self._library.g_signal_connect_data(
            device, CONTROL_LOST, self._on_control_lost, None, None, 0
        )
        return access

    @override
    def close(self) -> None:
        self.close_stream()
        device, self._device = self._device, None
        self._writable = False
        if device is not None:
            if self._handler:
                self._library.g_signal_handler_disconnect(device, self._handler)
                self._handler = 0
            # The last reference: Aravis releases control and closes its sockets.
            self._library.g_object_unref(device)

    def _identify(self, device: int, found: FoundCamera | None) -> DeviceInfo:
        """Return the open camera's own identity. Raises OtherCameraError if it is another camera."""
        library = self._library
        gige = bool(library.g_type_check_instance_is_a(device, library.arv_gv_device_get_type()))
        self.chunk_layout = DataLayout.GIGE_VISION if gige else DataLayout.USB3_VISION
        info = found.info() if found else replace(self.info, address=self._name)
        opened = info
        with suppress(DeviceStatusError, RemoteProtocolError):
            opened = with_texts(info, (gige_texts if gige else u3v_texts)(self.read))
        if found is not None and differs(info, opened):
            require_same(info, opened)
        opened = replace(opened, uri=self.info.uri if self._name else opened.uri)
        if self._identified:
            require_same(self.info, opened)
        return opened

    def _find(self) -> FoundCamera:
        cameras = find_cameras()
        answering = [camera for camera in cameras if not self._name or camera.answers_to(self._name)]
        opened = self.info if self._identified else None
        chosen = choose(self._name, answering, opened, lambda camera: camera.info(camera.address_or_id))
        if chosen is not None:
            return chosen
        known = ", ".join(camera.info().uri for camera in cameras) or "none"
        wanted = self._name or (describe(self.info) if self._identified else "")
        raise SourceNotFoundError(
            f"Aravis does not see {wanted or 'any camera'}; found: {known}. Check cable, power and address;"
            " a camera in another network can be named by its IP address, as in aravis:192.168.0.10"
        )

    def _settle_access(self, device: int, access: Access, info: DeviceInfo) -> None:
        library = self._library
        self._writable = access is Access.CONTROL
        if self.chunk_layout is not DataLayout.GIGE_VISION:
            return
        if info.address.startswith("127."):
            library.arv_gv_device_set_stream_options(device, PACKET_SOCKET_DISABLED)
        if library.arv_gv_device_is_controller(device):
            if access is Access.MONITOR:
                failure = Failure("releasing control")
                library.arv_gv_device_leave_control(device, failure.place)
                failure.check()
        elif access is Access.CONTROL:
            raise AccessDeniedError(f"another application controls {info.title}; close it there")

    def _on_signal(self, device: int, user_data: int) -> None:
        # A thread of Aravis must not wait for us, and Python would keep a thread object for it forever.
        threading.Thread(target=self._report_loss_of, args=(device,), name="aravis-lost", daemon=True).start()

    def _report_loss_of(self, device: int) -> None:
        if device == self._device:
            self.report_lost("Aravis lost control: the camera does not answer, or another application has it")

    @override
    def read(self, address: int, length: int) -> bytes:
        with self._detecting_loss():
            if self._numbers and length == 4 and not address % 4:
                return self._read_register(address).to_bytes(4, "big")
            return self._read(address, length)

    @override
    def write(self, address: int, data: bytes) -> None:
        library = self._library_of_open()
        if not self._writable:
            raise AccessDeniedError("the camera is open for reading only; another application may control it")
        failure = Failure(f"writing {len(data)} bytes at 0x{address:X}")
        with self._detecting_loss(writing=True):
            if self._numbers and len(data) == 4 and not address % 4:
                number = int.from_bytes(data, "big")
                library.arv_device_write_register(self._device, address, number, failure.place)
            else:
                library.arv_device_write_memory(self._device, address, len(data), data, failure.place)
            failure.check()

    @override
    def bootstrap_registers(self) -> list[tuple[str, int, int]]:
        return known_registers(1) if self.chunk_layout is DataLayout.GIGE_VISION else []

    @override
    def use_description(self, xml: str) -> None:
        self._numbers = False
        if self.chunk_layout is DataLayout.GIGE_VISION:
            little_endian = not self._read_register(BootstrapRegister.DEVICE_MODE) & BIG_ENDIAN_MODE
            traits = DescriptionTraits.of(xml, port_name(xml))
            self._numbers = traits.numbers(little_endian=little_endian)

    def _read_register(self, address: int) -> int:
        number = ctypes.c_uint32()
        failure = Failure(f"reading the register 0x{address:X}")
        place = ctypes.byref(number)
        self._library_of_open().arv_device_read_register(self._device, address, place, failure.place)
        failure.check()
        return number.value

    def _read(self, address: int, length: int) -> bytes:
        data = ctypes.create_string_buffer(length)
        failure = Failure(f"reading {length} bytes at 0x{address:X}")
        self._library_of_open().arv_device_read_memory(self._device, address, length, data, failure.place)
        failure.check()
        return data.raw

    @contextmanager
    def _detecting_loss(self, *, writing: bool = False) -> Iterator[None]:
        """Check after a failed access whether the camera is lost.

        Aravis reports a loss itself, but late: its heartbeat waits while accesses are retried.
        """
        self._library_of_open()
        try:
            yield
        except DeviceLostError as error:
            self.report_lost(str(error))
            raise
        except (AckTimeoutError, DeviceStatusError) as error:
            if writing or isinstance(error, AckTimeoutError):
                self._require_answer(error)
            raise

    def _require_answer(self, cause: Exception) -> None:
        """Raise DeviceLostError, and report it, if the camera is silent or no longer under our control."""
        gige = self.chunk_layout is DataLayout.GIGE_VISION
        try:
            control = int.from_bytes(self._read(BootstrapRegister.CCP if gige else 0, 4), "big")
        except AckTimeoutError:
            reason = "the camera does not answer"
        except DeviceStatusError:
            return
        else:
            if (
                not gige
                or not self._writable
                or control & (ControlPrivilege.CONTROL | ControlPrivilege.EXCLUSIVE)
            ):
                return
            reason = "the camera took our control back; its heartbeat may have expired, or it has restarted"
        self.report_lost(reason)
        raise DeviceLostError(f"the camera is lost: {reason}") from cause

    @override
    def description(self) -> bytes:
        size = ctypes.c_size_t()
        place = self._library_of_open().arv_device_get_genicam_xml(self._device, ctypes.byref(size))
        if not place:
            raise TransportError("Aravis has no description of this camera")
        return ctypes.string_at(place, size.value)

    @override
    def open_stream(self, request: StreamRequest, deliver: Callable[[Frame], None]) -> None:
        """Open the stream, which needs control."""
        library = self._library_of_open()
        if not self._writable:
            raise AccessDeniedError("Aravis receives images only with control of the camera")
        self.close_stream()
        assert self._device is not None
        self._receiving = AravisStream(library, self._device, request, deliver)

    def _library_of_open(self) -> Any:
        if self._device is None:
            raise DeviceLostError(f"{self.info.title} is not open")
        if self.lost:
            raise DeviceLostError(f"the camera is lost: {self.lost}")
        return self._library


def create(uri: SourceUri) -> FrameGrabber:
    """Return the camera of a URI, without opening it. Raises UsageError, SourceUnavailableError."""
    read_options(NoOptions, uri)
    check_address(uri, GVCP_PORT)
    load()
    info = DeviceInfo(str(uri), bus="Aravis", address=uri.name)
    return DeviceGrabber(AravisDevice(uri.name, info))


def discover(timeout: float) -> list[DeviceInfo]:
    """Return the cameras that Aravis finds, if `SEARCH` is set. Takes a second, whatever the `timeout`."""
    if os.environ.get(SEARCH, "") in ("", "0"):
        return []
    found = find_cameras()
    names = distinct_names(camera.names for camera in found)
    return [camera.info(name) for camera, name in zip(found, names, strict=True)]
