"""Aravis 0.8 by ctypes: the cameras it sees, and the few functions that registers and streams need.

The library alone is enough: neither GObject introspection nor PyGObject, which a virtual environment would
have to build. It comes with the system (Debian: libaravis-0.8-0) or in the package aravis-python.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import functools
import importlib.util
import threading
from collections.abc import Iterator
from ctypes import POINTER, byref, c_char_p, c_int, c_size_t, c_uint, c_uint32, c_uint64, c_void_p
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import Any
from urllib.parse import quote

from grabbergui.core.errors import (
    AckTimeoutError,
    DeviceLostError,
    DeviceStatusError,
    GrabberError,
    SourceUnavailableError,
)
from grabbergui.core.identity import DeviceInfo

NAME = "aravis-0.8"
PACKAGE = "aravis"
"The importable name of aravis-python."
SOCKET_NAME = "libaravis-0.8.so.0"

PACKET_SOCKET_DISABLED = 1
"Stream option: a plain UDP socket. Raw packet sockets hear nothing on the loopback."
CONTROL_LOST = b"control-lost"
GENERIC_STATUS = 0x8FFF
"Aravis keeps the device's status code to itself."


class _GError(ctypes.Structure):
    _fields_ = (("domain", c_uint32), ("code", c_int), ("message", c_char_p))


class ErrorCode(IntEnum):
    """Those of ArvDeviceError that are the same in all releases of 0.8."""

    NOT_CONNECTED = 2
    TIMEOUT = 5
    NOT_FOUND = 6


_ERROR = POINTER(POINTER(_GError))
CONTROL_LOST_CALLBACK = ctypes.CFUNCTYPE(None, c_void_p, c_void_p)
"Device, user data; called on a thread of Aravis."

_SIGNATURES: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "arv_update_device_list": (None, ()),
    "arv_get_n_devices": (c_uint, ()),
    **{
        f"arv_get_device_{field}": (c_char_p, (c_uint,))
        for field in ("id", "physical_id", "address", "vendor", "model", "serial_nbr", "protocol")
    },
    "arv_open_device": (c_void_p, (c_char_p, _ERROR)),
    "arv_device_read_memory": (c_int, (c_void_p, c_uint64, c_uint32, c_void_p, _ERROR)),
    "arv_device_write_memory": (c_int, (c_void_p, c_uint64, c_uint32, c_void_p, _ERROR)),
    "arv_device_get_genicam_xml": (c_void_p, (c_void_p, POINTER(c_size_t))),
    "arv_device_create_stream": (c_void_p, (c_void_p, c_void_p, c_void_p, _ERROR)),
    "arv_gv_device_get_type": (c_size_t, ()),
    "arv_uv_device_get_type": (c_size_t, ()),
    "arv_gv_device_is_controller": (c_int, (c_void_p,)),
    "arv_gv_device_leave_control": (c_int, (c_void_p, _ERROR)),
    "arv_gv_device_set_stream_options": (None, (c_void_p, c_int)),
    "arv_stream_push_buffer": (None, (c_void_p, c_void_p)),
    "arv_stream_timeout_pop_buffer": (c_void_p, (c_void_p, c_uint64)),
    "arv_stream_get_statistics": (None, (c_void_p, *(POINTER(c_uint64),) * 3)),
    "arv_stream_get_n_infos": (c_uint, (c_void_p,)),
    "arv_stream_get_info_name": (c_char_p, (c_void_p, c_uint)),
    "arv_stream_get_info_uint64": (c_uint64, (c_void_p, c_uint)),
    "arv_buffer_new": (c_void_p, (c_size_t, c_void_p)),
    "arv_buffer_get_status": (c_int, (c_void_p,)),
    "arv_buffer_get_n_parts": (c_uint, (c_void_p,)),
    "arv_buffer_get_payload_type": (c_int, (c_void_p,)),
    "arv_buffer_get_part_data_type": (c_int, (c_void_p, c_uint)),
    "arv_buffer_get_data": (c_void_p, (c_void_p, POINTER(c_size_t))),
    "arv_buffer_get_frame_id": (c_uint64, (c_void_p,)),
    "arv_buffer_get_timestamp": (c_uint64, (c_void_p,)),
    "arv_buffer_get_system_timestamp": (c_uint64, (c_void_p,)),
    "arv_buffer_get_image_pixel_format": (c_uint32, (c_void_p,)),
    "arv_buffer_get_image_region": (None, (c_void_p, *(POINTER(c_int),) * 4)),
    "arv_buffer_get_image_padding": (None, (c_void_p, *(POINTER(c_int),) * 2)),
    "g_object_unref": (None, (c_void_p,)),
    "g_error_free": (None, (c_void_p,)),
    "g_type_check_instance_is_a": (c_int, (c_void_p, c_size_t)),
    "g_signal_connect_data": (
        c_size_t,
        (c_void_p, c_char_p, CONTROL_LOST_CALLBACK, c_void_p, c_void_p, c_int),
    ),
    "g_signal_handler_disconnect": (None, (c_void_p, c_size_t)),
}
"""Functions by name: types of result and arguments. GLib's are found through the library too."""


@functools.cache
def load() -> Any:
    """The library with its functions declared. Raises SourceUnavailableError with the remedy."""
    problems = []
    for path in _places():
        try:
            library = ctypes.CDLL(path)
            for name, (result, arguments) in _SIGNATURES.items():
                function = getattr(library, name)
                function.restype, function.argtypes = result, arguments
            return library
        except (OSError, AttributeError) as error:
            problems.append(str(error))
    raise SourceUnavailableError(
        "aravis: sources need the library Aravis 0.8: sudo apt install libaravis-0.8-0, or pip install"
        f" aravis-python where grabbergui is ({'; '.join(problems)})"
    )


def _places() -> Iterator[str]:
    found = ctypes.util.find_library(NAME)
    if found:
        yield found
    # Found without being imported: that would ask for PyGObject.
    package = importlib.util.find_spec(PACKAGE)
    for folder in (package.submodule_search_locations or ()) if package else ():
        yield str(Path(folder) / "lib" / SOCKET_NAME)
    if not found:
        yield SOCKET_NAME


class Failure:
    """Where a function leaves its GError: pass `place`, then ask for the `error`."""

    def __init__(self, what: str) -> None:
        """`what` names the attempted operation in the message."""
        self._what = what
        self._pointer = POINTER(_GError)()
        self.place = byref(self._pointer)

    def error(self) -> GrabberError | None:
        """Return the error and free it; None if there is none."""
        if not self._pointer:
            return None
        code, text = self._pointer.contents.code, self._pointer.contents.message or b""
        load().g_error_free(self._pointer)
        self._pointer = POINTER(_GError)()
        message = f"{self._what}: Aravis answered: {text.decode('utf-8', 'replace')}"
        if code == ErrorCode.NOT_CONNECTED:
            return DeviceLostError(message)
        if code == ErrorCode.TIMEOUT:
            return AckTimeoutError(message)
        return DeviceStatusError(message, GENERIC_STATUS)

    def check(self) -> None:
        """Raise what went wrong, if anything did."""
        error = self.error()
        if error is not None:
            raise error


# Aravis keeps one list for the whole process.
_list_lock = threading.Lock()


@dataclass(frozen=True)
class FoundCamera:
    """One entry of Aravis's list."""

    id: str
    "Vendor, model and serial number joined by hyphens: what Aravis opens it by."
    physical_id: str
    "MAC address or GUID."
    address: str
    vendor: str
    model: str
    serial: str
    protocol: str

    @property
    def address_or_id(self) -> str:
        """An id that only this camera has: its address on a network, where several may share an id."""
        return self.address if self.protocol == "GigEVision" and self.address else self.id

    def answers_to(self, name: str) -> bool:
        """Whether `name` is its id, address, serial number or MAC address."""
        known = (self.id, self.address, self.serial, self.physical_id)
        return name.lower() in [text.lower() for text in known if text]

    def info(self) -> DeviceInfo:
        """As a list of sources shows it."""
        return DeviceInfo(
            uri=f"aravis:{quote(self.id, safe=' :-_.')}",
            vendor=self.vendor,
            model=self.model,
            serial=self.serial,
            bus=f"{_BUS.get(self.protocol, self.protocol)} by Aravis",
            address=self.address,
            hardware_id=self.physical_id.lower() if self.protocol == "GigEVision" else "",
        )


_BUS = {"GigEVision": "GigE Vision", "USB3Vision": "USB3 Vision"}


def find_cameras() -> list[FoundCamera]:
    """All of them, on every interface; takes about a second. Raises SourceUnavailableError."""
    library = load()
    fields = ("id", "physical_id", "address", "vendor", "model", "serial_nbr", "protocol")
    with _list_lock:
        library.arv_update_device_list()
        return [
            FoundCamera(*(_text(getattr(library, f"arv_get_device_{field}")(index)) for field in fields))
            for index in range(library.arv_get_n_devices())
        ]


def _text(raw: bytes | None) -> str:
    return (raw or b"").decode("utf-8", "replace")
