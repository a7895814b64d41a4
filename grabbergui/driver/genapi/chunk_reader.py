"""Chunk data behind a picture, as values by feature name.

A node map of its own reads them, so that the receiving thread never waits for a control, and a control never
for a picture. It has no way to the camera: what a chunk's feature needs from registers is left out.
"""

from __future__ import annotations

import logging
import struct
from typing import Any

import numpy as np
from genicam import genapi
from numpy.typing import NDArray

from grabbergui.core.features import AccessMode, Category, FeatureKind, FeatureValue
from grabbergui.driver.device import DataLayout
from grabbergui.driver.genapi import loading, node_features
from grabbergui.driver.genapi.xml_text import clean_xml

log = logging.getLogger(__name__)

SWITCHES = frozenset({"ChunkModeActive", "ChunkSelector", "ChunkEnable"})
"""What turns chunks on and off, as opposed to what they carry."""
MOST_CHUNKS = 256
LARGEST_CHUNK = 65536
"""Bytes; a longer one is the picture itself, which nobody reads as a feature."""

_TAG = {DataLayout.GIGE_VISION: struct.Struct(">II"), DataLayout.USB3_VISION: struct.Struct("<II")}
"""Id and length behind each chunk's data (GigE Vision 2.x, 25.8; USB3 Vision 1.x, 5.4.3)."""
_ADAPTER = {
    DataLayout.GIGE_VISION: genapi.ChunkAdapterGEV,
    DataLayout.USB3_VISION: genapi.ChunkAdapterU3V,
}


class ChunkReader:
    """Reads the chunks of one stream's payloads. One thread."""

    def __init__(self, xml: bytes, features: Category, layout: DataLayout) -> None:
        """`features`: the camera's tree, which names what chunks may carry."""
        self._layout = layout
        self._map = loading.load(clean_xml(xml))
        self._adapter = _ADAPTER[layout](self._map)
        self._nodes: list[tuple[str, FeatureKind, Any]] = [
            (description.name, description.kind, self._map.get_node(description.name))
            for description in features.descriptions()
            if description.name.startswith("Chunk")
            and description.name not in SWITCHES
            and description.kind is not FeatureKind.COMMAND
        ]
        self._told = False

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
            if not self._told:
                self._told = True
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
