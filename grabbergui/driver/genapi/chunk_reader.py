"""Reads the features that a frame's chunk data carries, by GenApi's chunk adapters."""

from __future__ import annotations

import logging
import struct
from collections.abc import Iterator
from typing import Any

import numpy as np
from genicam import genapi
from numpy.typing import NDArray

from grabbergui.core.features import Category, FeatureKind, FeatureValue
from grabbergui.driver.device import DataLayout
from grabbergui.driver.genapi import node_features
from grabbergui.driver.genapi.cleaning import clean_xml
from grabbergui.driver.genapi.loading import load

log = logging.getLogger(__name__)

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
