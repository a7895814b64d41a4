"""Receives GenApi's calls when nodes change, inside the lock of their map (`map_lock`).

`genicam` 1.6 leaks one reference to the value that it passes to a callback: some 150 bytes for each change of
each node, or hundreds of megabytes in a day of streaming with an automatic mode on. `binding_leaks` tests
once whether the installed version does.
"""

from __future__ import annotations

import ctypes
import functools
import weakref
from collections.abc import Callable
from typing import Any

from genicam import genapi

from grabbergui.driver.genapi.loading import load

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
    """Call `note` with the node's name whenever it may have changed; return a handle to deregister.

    The call is made inside the map's lock, on the thread that caused the change.
    """
    name, leaks = node.name, binding_leaks()

    def changed(value: Any) -> None:
        note(name)
        if leaks:
            _release(value)

    return register(node, changed)


@functools.cache
def binding_leaks() -> bool:
    """Whether the binding leaks the value that it passes to a callback."""
    given: list[weakref.ref[Any]] = []
    nodes = load(_PROBE)
    node = nodes.get_node("Probe").node
    handle = register(node, lambda value: given.append(weakref.ref(value)))
    node.invalidate_node()
    node.deregister_callback(handle)
    return bool(given) and all(value() is not None for value in given)


def register(node: Any, callback: Callable[[Any], None]) -> int:
    """Have the binding call `callback` after each change of a node; return a handle to end it."""
    handle: int = genapi.register(node, callback, genapi.ECallbackType.cbPostInsideLock)
    return handle
