"""A camera behind Aravis as a `Device`."""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from grabbergui.core.errors import AccessDeniedError, DeviceLostError, SourceNotFoundError, TransportError
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import Access, DeviceInfo, StreamStatistics
from grabbergui.core.uri import is_ip_address
from grabbergui.driver.aravis.cameras import FoundCamera, find_cameras
from grabbergui.driver.aravis.library import (
    CONTROL_LOST,
    CONTROL_LOST_CALLBACK,
    PACKET_SOCKET_DISABLED,
    Failure,
    load,
)
from grabbergui.driver.aravis.stream import AravisStream
from grabbergui.driver.device import DataLayout, Device, StreamRequest
from grabbergui.driver.stream_slot import StreamSlot


class AravisDevice(Device):
    """One camera, by IP address, Aravis's id, serial number or MAC address; empty: the first found."""

    def __init__(self, name: str, info: DeviceInfo) -> None:
        self.info = info
        self._name = name
        self._library: Any = None
        self._device: int | None = None
        self._slot = StreamSlot()
        self._writable = False
        # The signal's handler must live as long as the device.
        self._on_control_lost = CONTROL_LOST_CALLBACK(self._on_signal)
        self._handler = 0

    # -- connection ------------------------------------------------------------------------------
    def open(self, access: Access) -> Access:
        """See Device. Aravis takes control by itself; for reading only it is given back at once."""
        self.close()
        self._library = load()
        found = None if is_ip_address(self._name) else self._find()
        name = found.id if found else self._name
        failure = Failure(f"opening {name}")
        device = self._library.arv_open_device(name.encode(), failure.place)
        error = failure.error()
        if not device:
            raise SourceNotFoundError(f"Aravis cannot open '{name}': {error}") from error
        self._device = device
        if found is not None:
            self.info = replace(found.info(), uri=self.info.uri if self._name else found.info().uri)
        try:
            self._settle_access(device, access)
        except BaseException:
            self.close()
            raise
        if found is not None:
            # The same one again after a loss, also where the first was asked for.
            self._name = self._name or found.id
        self._handler = self._library.g_signal_connect_data(
            device, CONTROL_LOST, self._on_control_lost, None, None, 0
        )
        return access

    def close(self) -> None:
        """See Device."""
        self.close_stream()
        device, self._device = self._device, None
        self._writable = False
        if device is not None:
            if self._handler:
                self._library.g_signal_handler_disconnect(device, self._handler)
                self._handler = 0
            # The last reference: Aravis gives control back and closes its sockets.
            self._library.g_object_unref(device)

    def _find(self) -> FoundCamera:
        cameras = find_cameras()
        for camera in cameras:
            if not self._name or camera.answers_to(self._name):
                return camera
        known = ", ".join(camera.info().uri for camera in cameras) or "none"
        raise SourceNotFoundError(
            f"Aravis sees no camera {self._name or 'at all'}; found: {known}. Check cable, power and address;"
            " a camera in another network can be named by its IP address, as in aravis:192.168.0.10"
        )

    def _settle_access(self, device: int, access: Access) -> None:
        library = self._library
        gige = self._is_a(device, library.arv_gv_device_get_type())
        self.chunk_layout = DataLayout.GIGE_VISION if gige else DataLayout.USB3_VISION
        self._writable = access is Access.CONTROL
        if not gige:
            return
        if self.info.address.startswith("127."):
            library.arv_gv_device_set_stream_options(device, PACKET_SOCKET_DISABLED)
        if library.arv_gv_device_is_controller(device):
            if access is Access.MONITOR:
                failure = Failure("giving control back")
                library.arv_gv_device_leave_control(device, failure.place)
                failure.check()
        elif access is Access.CONTROL:
            raise AccessDeniedError(f"another application controls {self.info.title}; close it there")

    def _is_a(self, instance: int, kind: int) -> bool:
        return bool(self._library.g_type_check_instance_is_a(instance, kind))

    def _on_signal(self, device: int, user_data: int) -> None:
        # On a thread of Aravis, which must not wait for us and for which Python would keep a record for ever.
        threading.Thread(target=self._tell_lost, name="aravis-lost", daemon=True).start()

    def _tell_lost(self) -> None:
        if self.on_lost is not None:
            self.on_lost("Aravis lost control: the camera does not answer, or another application has it")

    # -- registers -------------------------------------------------------------------------------
    def read(self, address: int, length: int) -> bytes:
        """See Device."""
        data = ctypes.create_string_buffer(length)
        failure = Failure(f"reading {length} bytes at 0x{address:X}")
        self._library_of_open().arv_device_read_memory(self._device, address, length, data, failure.place)
        failure.check()
        return data.raw

    def write(self, address: int, data: bytes) -> None:
        """See Device."""
        library = self._library_of_open()
        if not self._writable:
            raise AccessDeniedError("the camera is open for reading only; another application may control it")
        failure = Failure(f"writing {len(data)} bytes at 0x{address:X}")
        library.arv_device_write_memory(self._device, address, len(data), data, failure.place)
        failure.check()

    def description(self) -> bytes:
        """See Device."""
        size = ctypes.c_size_t()
        place = self._library_of_open().arv_device_get_genicam_xml(self._device, ctypes.byref(size))
        if not place:
            raise TransportError("Aravis has no description of this camera")
        return ctypes.string_at(place, size.value)

    # -- stream ----------------------------------------------------------------------------------
    def open_stream(self, request: StreamRequest, deliver: Callable[[Frame], None]) -> None:
        """See Device. Only a controller gets pictures."""
        library = self._library_of_open()
        if not self._writable:
            raise AccessDeniedError("Aravis receives pictures only for whoever controls the camera")
        self.close_stream()
        assert self._device is not None
        self._slot.put(AravisStream(library, self._device, request, deliver))

    def close_stream(self) -> None:
        """See Device."""
        self._slot.close()

    def stream_statistics(self) -> StreamStatistics:
        """See Device."""
        return self._slot.statistics()

    def _library_of_open(self) -> Any:
        if self._device is None:
            raise DeviceLostError(f"{self.info.title} is not open")
        return self._library
