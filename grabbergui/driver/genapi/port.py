"""Loads GenApi's node maps, and receives their calls: registers, changed nodes, chunk data, events.

GenApi's binding holds the GIL while it parses: 100 ms for a camera of 3,500 nodes, during which the window is
frozen. Four fifths of that time go into the XML, so a separate process parses a large description and this
process reads the result (`parse_cache`), which is also kept for the next time.

GenApi calls us for registers (`RegisterPort`) and when nodes change (`register_callback`), inside one lock
(`MapLock`), which defers Ctrl-C until GenApi has returned.

`genicam` 1.6 leaks one reference to the value that it passes to a callback: some 150 bytes for each change of
each node, or hundreds of megabytes in a day of streaming with an automatic mode on. `binding_leaks` tests
once whether the installed version does.
"""

from __future__ import annotations

import ctypes
import functools
import logging
import signal
import struct
import sys
import threading
import weakref
from collections.abc import Callable, Iterator, Mapping
from types import FrameType, TracebackType
from typing import Any, Protocol

import numpy as np
from genicam import genapi
from numpy.typing import NDArray

from grabbergui.core.errors import GrabberError, RemoteProtocolError, TransportError
from grabbergui.core.features import Category, Feature, FeatureKind, FeatureValue
from grabbergui.core.grabber import DeviceEvent
from grabbergui.driver.device import DataLayout
from grabbergui.driver.genapi import node_features
from grabbergui.driver.genapi.register_length import require_length
from grabbergui.driver.genapi.vetting import clean_xml, vetted

if sys.platform == "linux":
    from grabbergui.driver.genapi import parse_cache

log = logging.getLogger(__name__)

# -- loading -------------------------------------------------------------------------------------
LARGE_XML = 300_000
"Characters of a description from which a separate process (0.15 s) pays off."

_loading = threading.Lock()
"Needed for small descriptions too: while the cache is on, GenApi uses it for all of them."


def load(xml: str) -> genapi.NodeMap:
    """Return the node map of a description, without a port. Any thread; calls are serialised.

    Raises RemoteProtocolError for a description that `vetting` refuses or that crashes the parsing process,
    and GenApi's exceptions for one that it cannot use.
    """
    nodes = genapi.NodeMap()
    with _loading:
        if sys.platform == "linux" and len(xml) >= LARGE_XML:
            with parse_cache.parsed(xml) as text:
                nodes.load_xml_from_string(text)
        else:
            nodes.load_xml_from_string(vetted(xml))
    return nodes


# -- registers -----------------------------------------------------------------------------------
class Registers(Protocol):
    """The part of a `Device` that GenApi needs; other modules than cameras have one, too."""

    def read(self, address: int, length: int) -> bytes:
        """Return exactly `length` bytes."""

    def write(self, address: int, data: bytes) -> None:
        """Write all of `data`."""


class RegisterPort(genapi.AbstractPort):  # type: ignore[misc]  # the library has no types
    """Reads and writes registers of a `Device` for GenApi.

    An exception of the device does not pass through C++, so it is stored in `failure` for the caller. An
    unexpected one becomes a TransportError, since GenApi would end the process.
    """

    def __init__(self, device: Registers) -> None:
        super().__init__()
        self._device = device
        self.failure: GrabberError | None = None
        "The last error, until `take_failure` clears it."

    def read(self, address: int, length: int) -> bytes:
        """Called by GenApi."""
        try:
            require_length(length, f"the register at 0x{address:X}")
            return self._device.read(address, length)
        except Exception as error:
            raise self._kept(error) from error

    def write(self, address: int, value: bytes) -> None:
        """Called by GenApi."""
        try:
            require_length(len(value), f"the register at 0x{address:X}")
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
        """Return and clear the error behind GenApi's last exception."""
        failure, self.failure = self.failure, None
        return failure


# -- changes of nodes ----------------------------------------------------------------------------
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

    return _register(node, changed)


@functools.cache
def binding_leaks() -> bool:
    """Whether the binding leaks the value that it passes to a callback."""
    given: list[weakref.ref[Any]] = []
    nodes = load(_PROBE)
    node = nodes.get_node("Probe").node
    handle = _register(node, lambda value: given.append(weakref.ref(value)))
    node.invalidate_node()
    node.deregister_callback(handle)
    return bool(given) and all(value() is not None for value in given)


def _register(node: Any, callback: Callable[[Any], None]) -> int:
    handle: int = genapi.register(node, callback, genapi.ECallbackType.cbPostInsideLock)
    return handle


# -- the lock ------------------------------------------------------------------------------------
class HeldInterrupts:
    """Defers the KeyboardInterrupt of Python's default handler during a block on the main thread.

    GenApi is C++ that calls our ports. An unexpected exception there crashes it, or leaves its lock taken.
    Another handler is left in place: the program that installed it decides when to raise. Blocks may be
    nested. On other threads, where Python handles no signals, nothing happens.
    """

    def __init__(self) -> None:
        self._depth = 0
        self._installed = False
        self._interrupted = False

    def hold(self) -> None:
        """Begin a block, which `release` must end."""
        if threading.current_thread() is not threading.main_thread():
            return
        if not self._depth and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            signal.signal(signal.SIGINT, self._note)
            self._installed = True
        self._depth += 1

    def release(self) -> None:
        """End a block. The outermost raises KeyboardInterrupt if Ctrl-C was pressed in it."""
        if threading.current_thread() is not threading.main_thread():
            return
        self._depth -= 1
        if self._depth or not self._installed:
            return
        interrupted, self._interrupted, self._installed = self._interrupted, False, False
        if signal.getsignal(signal.SIGINT) == self._note:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        if interrupted:
            raise KeyboardInterrupt

    def _note(self, number: int, frame: FrameType | None) -> None:
        self._interrupted = True


class MapLock:
    """A reentrant lock that collects the names of changed features and reports them after its release.

    The report is made outside the lock, on the thread that held it, also after an exception. Ctrl-C raises
    KeyboardInterrupt after the report, never inside GenApi.
    """

    def __init__(self, on_change: Callable[[frozenset[str]], None]) -> None:
        self.on_change = on_change
        self.changed: set[str] = set()
        "Features that changed since the lock was taken. Only for the thread that holds it."
        self._lock = threading.Lock()
        self._owner: int | None = None
        self._depth = 0
        self._interrupts = HeldInterrupts()

    def __enter__(self) -> None:
        thread = threading.get_ident()
        if self._owner != thread:
            self._interrupts.hold()
            self._lock.acquire()
            self._owner = thread
        self._depth += 1

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._depth -= 1
        if self._depth:
            return
        changed = frozenset(self.changed)
        self.changed.clear()
        self._owner = None
        self._lock.release()
        try:
            if changed:
                self.on_change(changed)
        finally:
            self._interrupts.release()


# -- chunk data ----------------------------------------------------------------------------------
CHUNK_SWITCHES = frozenset({"ChunkModeActive", "ChunkSelector", "ChunkEnable"})
"""Features that switch chunks on and off; other features of the category are values that chunks carry."""
MOST_CHUNKS = 256
LARGEST_CHUNK = 65536
"""Bytes; a longer one is the image itself, which is not a feature."""

_CHUNK_TAG = {DataLayout.GIGE_VISION: struct.Struct(">II"), DataLayout.USB3_VISION: struct.Struct("<II")}
"""Id and length behind each chunk's data (GigE Vision 2.x, 25.8; USB3 Vision 1.x, 5.4.3)."""
_CHUNK_ADAPTER = {
    DataLayout.GIGE_VISION: genapi.ChunkAdapterGEV,
    DataLayout.USB3_VISION: genapi.ChunkAdapterU3V,
}


class ChunkReader:
    """Reads the chunks of one stream's payloads. One thread."""

    def __init__(self, xml: bytes, features: Category, layout: DataLayout) -> None:
        """`features`: the camera's feature tree, which names the possible chunks."""
        self._layout = layout
        self._map = load(clean_xml(xml))
        self._adapter = _CHUNK_ADAPTER[layout](self._map)
        self._nodes: list[tuple[str, FeatureKind, Any]] = [
            (description.name, description.kind, self._map.get_node(description.name))
            for description in features.descriptions()
            if description.name.startswith("Chunk")
            and description.name not in CHUNK_SWITCHES
            and description.kind is not FeatureKind.COMMAND
        ]
        self._reported = False

    def read(self, payload: NDArray[np.uint8]) -> dict[str, FeatureValue]:
        """Return the chunk values of a payload; empty without, or with malformed, chunks. Never raises."""
        chunks = without_images(payload, self._layout)
        if not chunks:
            return {}
        try:
            self._adapter.attach_buffer(chunks, len(chunks))
            try:
                return dict(self._values())
            finally:
                self._adapter.detach_buffer()
        except (genapi.GenericException, RuntimeError) as error:
            if not self._reported:
                self._reported = True
                log.warning("chunk data cannot be read: %s", node_features.reason_of(error))
            return {}

    def _values(self) -> Iterator[tuple[str, FeatureValue]]:
        for name, kind, node in self._nodes:
            try:
                if node_features.access_of(node).readable:
                    yield name, node_features.READERS[kind](node)
            except node_features.READ_ERRORS:
                continue  # it depends on the camera's registers, or is not UTF-8


def chunk_spans(payload: NDArray[np.uint8], layout: DataLayout) -> list[tuple[int, int, int]]:
    """Return id, offset and length of each chunk of a payload; empty if the tags are malformed."""
    tag = _CHUNK_TAG[layout]
    spans: list[tuple[int, int, int]] = []
    end = len(payload)
    while end and len(spans) < MOST_CHUNKS:
        if end < tag.size:
            return []
        chunk_id, length = tag.unpack(payload[end - tag.size : end].tobytes())
        begin = end - tag.size - length
        if begin < 0:
            return []
        spans.append((chunk_id, begin, length))
        end = begin
    return [] if end else spans[::-1]


def without_images(payload: NDArray[np.uint8], layout: DataLayout) -> bytes:
    """Return the chunks of a payload, of images only their tags; empty if the tags are malformed."""
    tag = _CHUNK_TAG[layout]
    pieces: list[bytes] = []
    for chunk_id, begin, length in chunk_spans(payload, layout):
        kept = payload[begin : begin + length].tobytes() if length <= LARGEST_CHUNK else b""
        pieces.append(kept + tag.pack(chunk_id, len(kept)))
    return b"".join(pieces)


# -- events --------------------------------------------------------------------------------------
EVENT_SELECTOR = "EventSelector"

_EVENT_ADAPTER = {
    DataLayout.GIGE_VISION: genapi.EventAdapterGEV,
    DataLayout.USB3_VISION: genapi.EventAdapterU3V,
}


class EventReader:
    """The event adapter of one node map. Calls are serialised by the map's owner."""

    def __init__(self, node_map: Any, layout: DataLayout) -> None:
        self._adapter = _EVENT_ADAPTER[layout](node_map.pointer)
        self._names = _event_names(node_map)

    def deliver(self, message: bytes) -> None:
        """Update the event's nodes from a message. Raises RemoteProtocolError."""
        try:
            self._adapter.deliver_message(message)
        except (genapi.GenericException, RuntimeError) as error:
            raise RemoteProtocolError(f"event message: {node_features.reason_of(error)}") from error

    def event(self, event_id: int, changed: Mapping[str, Feature]) -> DeviceEvent:
        """Return the event whose message changed these nodes."""
        values = {name: feature.value for name, feature in changed.items() if feature.value is not None}
        return DeviceEvent(self._name_of(changed) or f"0x{event_id:04X}", event_id, values)

    def close(self) -> None:
        """Release the node map."""
        self._adapter.detach_node_map()

    def _name_of(self, changed: Mapping[str, Feature]) -> str:
        # SFNC: the features of event X are called EventX, EventXTimestamp, EventXFrameID …
        fitting = [name for name in self._names if any(node.startswith(f"Event{name}") for node in changed)]
        return max(fitting, key=len, default="")


def _event_names(node_map: Any) -> list[str]:
    if not node_map.has_node(EVENT_SELECTOR):
        return []
    selector = node_map.get_node(EVENT_SELECTOR)
    return [entry.symbolic for entry in selector.entries] if hasattr(selector, "entries") else []
