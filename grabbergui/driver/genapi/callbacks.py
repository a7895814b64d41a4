"""Callbacks of nodes, without what the binding loses at each call.

`genicam` 1.6 takes one reference too many to the value that it hands to a callback: some 150 bytes for each
change of each node, which make hundreds of megabytes of a day of streaming with an automatic mode on. Whether
the one that is installed does so is tried once, on a node map of its own.
"""

from __future__ import annotations

import ctypes
import functools
import weakref
from collections.abc import Callable
from typing import Any

from genicam import genapi

from grabbergui.driver.genapi import loading

_PROBE = """<?xml version="1.0" encoding="utf-8"?>
<RegisterDescription xmlns="http://www.genicam.org/GenApi/Version_1_1" ModelName="Probe" VendorName="Probe"
 ToolTip="" StandardNameSpace="None" SchemaMajorVersion="1" SchemaMinorVersion="1" SchemaSubMinorVersion="0"
 MajorVersion="1" MinorVersion="0" SubMinorVersion="0" ProductGuid="1" VersionGuid="1">
<Category Name="Root"><pFeature>Probe</pFeature></Category>
<Integer Name="Probe"><Value>0</Value></Integer><Port Name="Device"/>
</RegisterDescription>"""

_let_go = ctypes.pythonapi.Py_DecRef
_let_go.argtypes, _let_go.restype = (ctypes.py_object,), None


def register(node: Any, note: Callable[[str], None]) -> int:
    """Let `note` be called with the node's name when it may have changed; a handle to deregister it with.

    It is called within the map's lock, on the thread that caused the change.
    """
    name, leaks = node.name, binding_leaks()

    def changed(value: Any) -> None:
        note(name)
        if leaks:
            _let_go(value)

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
