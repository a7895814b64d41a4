"""Aravis 0.8 through ctypes: its functions and its errors.

This needs only the library, from the system (Debian: libaravis-0.8-0) or the package aravis-python; neither
GObject introspection nor PyGObject, which a virtual environment would have to build.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import functools
import importlib.util
import logging
from collections.abc import Iterator
from ctypes import POINTER, byref, c_char_p, c_int, c_size_t, c_uint, c_uint32, c_uint64, c_void_p
from enum import IntEnum
from pathlib import Path
from typing import Any

from grabbergui.core.errors import (
    AckTimeoutError,
    DeviceLostError,
    DeviceStatusError,
    GrabberError,
    SourceUnavailableError,
)

log = logging.getLogger(__name__)

NAME = "aravis-0.8"
PACKAGE = "aravis"
"The importable name of aravis-python."
SOCKET_NAME = "libaravis-0.8.so.0"

PACKET_SOCKET_DISABLED = 1
"Stream option: a plain UDP socket. Raw packet sockets receive nothing on the loopback interface."
CONTROL_LOST = b"control-lost"
GENERIC_STATUS = 0x8FFF
"Stands for the device's status code, which Aravis does not report."
CONTROL_LOST_CALLBACK = ctypes.CFUNCTYPE(None, c_void_p, c_void_p)
"Device, user data; called on a thread of Aravis."


class _GError(ctypes.Structure):
    _fields_ = (("domain", c_uint32), ("code", c_int), ("message", c_char_p))


class ErrorCode(IntEnum):
    """The codes of ArvDeviceError that all releases of 0.8 share."""

    NOT_CONNECTED = 2
    TIMEOUT = 5


_ERROR = POINTER(POINTER(_GError))

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
    "arv_device_read_register": (c_int, (c_void_p, c_uint64, POINTER(c_uint32), _ERROR)),
    "arv_device_write_register": (c_int, (c_void_p, c_uint64, c_uint32, _ERROR)),
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
"""Result and argument types of functions, GLib's included, which the library also leads to."""


@functools.cache
def load() -> Any:
    """Return the library with its functions declared. Raises SourceUnavailableError with the remedy."""
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
    # Not imported, because the package imports PyGObject.
    package = importlib.util.find_spec(PACKAGE)
    for folder in (package.submodule_search_locations or ()) if package else ():
        yield str(Path(folder) / "lib" / SOCKET_NAME)
    if not found:
        yield SOCKET_NAME


class Failure:
    """Receives a function's GError: pass `place` to it, then read the `error`."""

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
        """Raise the error, if there is one."""
        error = self.error()
        if error is not None:
            raise error
