"""GenApi's calls into Python: registers that it reads and writes, and nodes that changed.

`genicam` 1.6 takes one reference too many to the value that it passes to a callback: some 150 bytes for each
change of each node, which make hundreds of megabytes of a day of streaming with an automatic mode on. Whether
the installed one does so is tried once, on a node map of its own.
"""

from __future__ import annotations

import ctypes
import functools
import weakref
from collections.abc import Callable
from typing import Any

from genicam import genapi

from grabbergui.core.errors import GrabberError, RemoteProtocolError, TransportError
from grabbergui.driver.device import Device
from grabbergui.driver.genapi import loading

LONGEST = 16 << 20
"""Bytes of one register: many times the largest look-up table, and what takes a camera seconds."""


class RegisterPort(genapi.AbstractPort):  # type: ignore[misc]  # the library has no types
    """Reads and writes registers of a `Device` for GenApi.

    An exception of the device does not survive its way through C++, so it is kept in `failure` for whoever
    made the call; what nobody foresaw becomes a TransportError, since GenApi would end the process.
    """

    def __init__(self, device: Device) -> None:
        super().__init__()
        self._device = device
        self.failure: GrabberError | None = None
        "The last error, until taken by `take_failure`."

    def read(self, address: int, length: int) -> bytes:
        """Called by GenApi."""
        try:
            _require_bearable(address, length)
            return self._device.read(address, length)
        except Exception as error:
            raise self._kept(error) from error

    def write(self, address: int, value: bytes) -> None:
        """Called by GenApi."""
        try:
            _require_bearable(address, len(value))
            self._device.write(address, bytes(value))
        except Exception as error:
            raise self._kept(error) from error

    def get_access_mode(self) -> int:
        """Called by GenApi."""
        return int(genapi.EAccessMode.RW)

    def is_open(self) -> bool:
        """Called by GenApi."""
        return True

    def get_principal_interface_type(self) -> int:
        """Called by GenApi."""
        return int(genapi.EInterfaceType.intfIPort)

    def _kept(self, error: Exception) -> RuntimeError:
        """Return the exception that GenApi accepts; `take_failure` returns the reason."""
        if not isinstance(error, GrabberError):
            error = TransportError(f"{type(error).__name__}: {error}")
        self.failure = error
        return RuntimeError(str(error))

    def take_failure(self) -> GrabberError | None:
        """The error behind GenApi's last exception, forgotten by this call."""
        failure, self.failure = self.failure, None
        return failure


def _require_bearable(address: int, length: int) -> None:
    if length > LONGEST:
        raise RemoteProtocolError(
            f"the description has a register of {length} bytes at 0x{address:X}; at most {LONGEST} make sense"
        )


_PROBE = """<?xml version="1.0" encoding="utf-8"?>
<RegisterDescription xmlns="http://www.genicam.org/GenApi/Version_1_1" ModelName="Probe" VendorName="Probe"
 ToolTip="" StandardNameSpace="None" SchemaMajorVersion="1" SchemaMinorVersion="1" SchemaSubMinorVersion="0"
 MajorVersion="1" MinorVersion="0" SubMinorVersion="0" ProductGuid="1" VersionGuid="1">
<Category Name="Root"><pFeature>Probe</pFeature></Category>
<Integer Name="Probe"><Value>0</Value></Integer><Port Name="Device"/>
</RegisterDescription>"""

_release = ctypes.pythonapi.Py_DecRef
_release.argtypes, _release.restype = (ctypes.py_object,), None


def register_callback(node: Any, note: Callable[[str], None]) -> int:
    """Let `note` be called with the node's name when it may have changed; a handle to deregister it with.

    It is called within the map's lock, on the thread that caused the change.
    """
    name, leaks = node.name, binding_leaks()

    def changed(value: Any) -> None:
        note(name)
        if leaks:
            _release(value)

    return _register(node, changed)


@functools.cache
def binding_leaks() -> bool:
    """Whether a value outlives the callback it was given to."""
    given: list[weakref.ref[Any]] = []
    nodes = loading.load(_PROBE)
    node = nodes.get_node("Probe").node
    handle = _register(node, lambda value: given.append(weakref.ref(value)))
    node.invalidate_node()
    node.deregister_callback(handle)
    return bool(given) and all(value() is not None for value in given)


def _register(node: Any, callback: Callable[[Any], None]) -> int:
    handle: int = genapi.register(node, callback, genapi.ECallbackType.cbPostInsideLock)
    return handle
