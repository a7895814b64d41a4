"""Finds the components in a payload, for all transports.

Components are views of the payload. A payload that cannot be decoded becomes a frame without an image; the
reason is logged once per stream.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grabbergui.core import pfnc
from grabbergui.core.component import Component, ComponentKind, PayloadType, own_component
from grabbergui.core.encoded_image import StillImage, StillImageHeader, jpeg2000_header, jpeg_header
from grabbergui.core.errors import GrabberError
from grabbergui.core.frame import EncodedFrame, Frame
from grabbergui.core.pfnc import PixelFormat
from grabbergui.driver import gendc

log = logging.getLogger(__name__)

HEADER_BYTES = 64 << 10
"Leading bytes of a compressed image that must contain its header; cameras' metadata is smaller."

_HEADER_READERS: dict[PayloadType, Callable[[bytes], StillImageHeader]] = {
    PayloadType.JPEG: jpeg_header,
    PayloadType.JPEG2000: jpeg2000_header,
}
_GENDC_ENCODINGS = {
    int(gendc.HeaderType.JPEG): PayloadType.JPEG,
    int(gendc.HeaderType.JPEG2000): PayloadType.JPEG2000,
}


@dataclass(frozen=True)
class Contents:
    """The components of a payload, and its type."""

    payload_type: PayloadType
    payload: NDArray[np.uint8]
    "1-D, the whole payload."
    parts: tuple[Component, ...] = ()
    chunk_payload: NDArray[np.uint8] | None = None
    file_name: str = ""

    def frame(self, image: Frame) -> Frame:
        """Add these contents to `image`, which has the block's metadata, and return the frame."""
        first = own_component(self.parts)  # for consumers of a single image
        image.payload_type = self.payload_type
        image.file_name, image.chunk_payload = self.file_name, self.chunk_payload
        image.payload = self.payload
        if first is None:
            image.width = image.height = 0
            image.pixel_format = PixelFormat(self.payload_type.value, 0)
            return image
        image.width, image.height, image.pixel_format = first.width, first.height, first.pixel_format
        image.offset_x, image.offset_y = first.offset_x, first.offset_y
        image.padding_x = first.padding_x
        image.parts = self.parts
        if first.encoding is not None:
            return EncodedFrame.of(image, first)
        image.payload = first.data
        return image


def kind_of(pixel_format: PixelFormat, stated: int = 0) -> ComponentKind:
    """Return the kind of an image: the `stated` one (an id of SFNC), else the one of its pixel format."""
    if stated and (kind := ComponentKind.of(stated)) is not ComponentKind.UNDEFINED:
        return kind
    if pixel_format.name.startswith("Coord3D"):
        return ComponentKind.RANGE
    if pixel_format.name.startswith("Confidence"):
        return ComponentKind.CONFIDENCE
    return ComponentKind.INTENSITY


class PayloadReader:
    """Reads the payloads of one stream. One thread."""

    def __init__(self, *, big_endian: bool = False) -> None:
        """`big_endian`: byte order of pixels with more than 8 bits."""
        self._big_endian = big_endian
        self._reported: set[str] = set()

    def plain(self, payload_type: PayloadType, payload: NDArray[np.uint8], file_name: str = "") -> Contents:
        """Read a payload without an image: chunks alone, raw data or a file."""
        chunks = payload if payload_type is PayloadType.CHUNK else None
        return Contents(payload_type, payload, (), chunks, file_name)

    def compressed(self, payload_type: PayloadType, payload: NDArray[np.uint8]) -> Contents:
        """Read a JPEG or JPEG 2000 image."""
        part = self.compressed_part(payload_type, payload)
        return Contents(payload_type, payload, () if part is None else (part,), payload)

    def compressed_part(
        self,
        payload_type: PayloadType,
        data: NDArray[np.uint8],
        kind: ComponentKind = ComponentKind.INTENSITY,
    ) -> Component | None:
        """Read the header of a compressed image; return None and log a warning if it is damaged."""
        try:
            header = _HEADER_READERS[payload_type](data[:HEADER_BYTES].tobytes())
        except GrabberError as error:
            self.warn_once(str(error))
            return None
        encoding = StillImage(payload_type.value, header)
        return Component(data, header.width, header.height, header.pixel_format, kind, encoding=encoding)

    def container(self, payload: NDArray[np.uint8]) -> Contents:
        """Read a GenDC container."""
        try:
            container = gendc.Container.decode(payload.data)
        except GrabberError as error:
            self.warn_once(str(error))
            return Contents(PayloadType.GENDC, payload)
        parts: list[Component] = []
        chunks = None
        for component in container.components:
            for part in component.parts if component.valid else ():
                data = payload[part.data_offset : part.data_offset + part.data_size]
                if part.header_type == gendc.HeaderType.CHUNK:
                    chunks = data
                elif part.is_image and (image := self._gendc_image(component, part, data)) is not None:
                    parts.append(image)
        return Contents(PayloadType.GENDC, payload, tuple(parts), chunks)

    def _gendc_image(
        self, component: gendc.ComponentHeader, part: gendc.PartHeader, data: NDArray[np.uint8]
    ) -> Component | None:
        pixel_format = pfnc.by_code(part.pixel_format or component.pixel_format)
        kind = kind_of(pixel_format, component.type_id)
        image: Component | None = Component(data, part.width, part.height, pixel_format, kind)
        if encoded := _GENDC_ENCODINGS.get(part.header_type):
            image = self.compressed_part(encoded, data, kind)
        if image is None:
            return None
        return replace(
            image,
            region=component.region,
            source=component.source,
            purpose=component.group,
            offset_x=component.offset_x,
            offset_y=component.offset_y,
            padding_x=part.padding_x,
            big_endian=self._big_endian,
        )

    def warn_once(self, fault: str) -> None:
        """Log a fault that may recur with every frame."""
        if fault not in self._reported and len(self._reported) < 16:
            self._reported.add(fault)
            log.warning("%s", fault)
