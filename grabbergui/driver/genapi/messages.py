"""Chunk data behind an image, and events, as GenApi reads them: both by its adapters.

Chunks are read by a node map of their own, so that the receiving thread never waits for a control, and a
control never for a frame. It has no way to the camera: a feature that also needs registers is left out.
Events go into the camera's node map, whose nodes then hold what the message contains.
"""

from __future__ import annotations

import logging
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np
from genicam import genapi
from numpy.typing import NDArray

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.core.features import AccessMode, Category, Feature, FeatureKind, FeatureValue
from grabbergui.core.grabber import DeviceEvent
from grabbergui.driver.device import DataLayout
from grabbergui.driver.genapi import loading, node_features
from grabbergui.driver.genapi.loading import clean_xml

log = logging.getLogger(__name__)

SWITCHES = frozenset({"ChunkModeActive", "ChunkSelector", "ChunkEnable"})
"""Features that switch chunks on and off; other features of the category are values that chunks carry."""
MOST_CHUNKS = 256
LARGEST_CHUNK = 65536
"""Bytes; a longer one is the picture itself, which nobody reads as a feature."""

_TAG = {DataLayout.GIGE_VISION: struct.Struct(">II"), DataLayout.USB3_VISION: struct.Struct("<II")}
"""Id and length behind each chunk's data (GigE Vision 2.x, 25.8; USB3 Vision 1.x, 5.4.3)."""
_CHUNK_ADAPTER = {
    DataLayout.GIGE_VISION: genapi.ChunkAdapterGEV,
    DataLayout.USB3_VISION: genapi.ChunkAdapterU3V,
}


class ChunkReader:
    """Reads the chunks of one stream's payloads. One thread."""

    def __init__(self, xml: bytes, features: Category, layout: DataLayout) -> None:
        """`features`: the camera's tree, which names what chunks may carry."""
        self._layout = layout
        self._map = loading.load(clean_xml(xml))
        self._adapter = _CHUNK_ADAPTER[layout](self._map)
        self._nodes: list[tuple[str, FeatureKind, Any]] = [
            (description.name, description.kind, self._map.get_node(description.name))
            for description in features.descriptions()
            if description.name.startswith("Chunk")
            and description.name not in SWITCHES
            and description.kind is not FeatureKind.COMMAND
        ]
        self._reported = False

    def read(self, payload: NDArray[np.uint8]) -> dict[str, FeatureValue]:
        """The values behind a picture; empty where there are none or they are malformed. Never raises."""
        chunks = without_pictures(payload, self._layout)
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

    def _values(self) -> list[tuple[str, FeatureValue]]:
        values = []
        for name, kind, node in self._nodes:
            try:
                if node_features.access_of(node) in (AccessMode.READ_ONLY, AccessMode.READ_WRITE):
                    values.append((name, node_features.read_value(node, kind)))
            except (genapi.GenericException, RuntimeError):
                continue  # one that leans on the camera's registers
        return values


def without_pictures(payload: NDArray[np.uint8], layout: DataLayout) -> bytes:
    """The chunks of a payload with pictures cut down to their tags; empty where the tags are malformed."""
    tag = _TAG[layout]
    pieces: list[bytes] = []
    end = len(payload)
    while end and len(pieces) < MOST_CHUNKS:
        if end < tag.size:
            return b""
        chunk_id, length = tag.unpack(payload[end - tag.size : end].tobytes())
        begin = end - tag.size - length
        if begin < 0:
            return b""
        kept = payload[begin : begin + length].tobytes() if length <= LARGEST_CHUNK else b""
        pieces.append(kept + tag.pack(chunk_id, len(kept)))
        end = begin
    return b"" if end else b"".join(reversed(pieces))


SELECTOR = "EventSelector"

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
        """Let the event's nodes hold what the message says. Raises RemoteProtocolError."""
        try:
            self._adapter.deliver_message(message)
        except (genapi.GenericException, RuntimeError) as error:
            raise RemoteProtocolError(f"event message: {node_features.reason_of(error)}") from error

    def event(self, event_id: int, changed: Mapping[str, Feature]) -> DeviceEvent:
        """The event behind the nodes that a message changed."""
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
    if not node_map.has_node(SELECTOR):
        return []
    selector = node_map.get_node(SELECTOR)
    return [entry.symbolic for entry in selector.entries] if hasattr(selector, "entries") else []
