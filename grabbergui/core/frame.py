"""A frame: a payload in a pooled buffer, its metadata, and the image that it contains (raw, RGB, grey)."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass, field, fields, replace
from enum import Enum
from sys import getrefcount
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray
from typing_extensions import override

from grabbergui.core import pixels
from grabbergui.core.component import Component, ComponentKind, Conversions, PayloadType, own_component
from grabbergui.core.errors import PixelFormatError
from grabbergui.core.pfnc import PixelFormat

POOL_MEMORY = 512 << 20
"""Default limit of the memory for one stream's buffers, in bytes."""
FEWEST_BUFFERS, MOST_BUFFERS = 8, 1024
"""Limits of the default number of buffers, whatever their size."""
MOST_AGE = 60.0
"Seconds that a frame may have been in transit."


class BufferPool:
    """Buffers of one size for one stream. Thread-safe.

    Buffers are reused, as the page faults of a fresh 8 MB buffer cost more than filling it. Memory is
    bounded: `take` returns None once `limit` buffers are in use. For buffers of 4 MB or more numpy requests
    huge pages, into which the kernel copies faster.

    A buffer is in use as long as any array, memoryview or other object that looks into it refers to it.
    Python's reference count shows that, and nothing runs when the last of them is gone.
    """

    _UNUSED = 2
    "References to a buffer that nobody uses, as `getrefcount` counts: the list's and its own argument."

    def __init__(self, size: int, limit: int | None = None) -> None:
        """By default, `limit` is as many buffers as fit into `POOL_MEMORY`."""
        self.size = size
        "Bytes of each buffer."
        self.limit = limit or min(max(POOL_MEMORY // max(size, 1), FEWEST_BUFFERS), MOST_BUFFERS)
        "Largest number of buffers in use."
        self._buffers: list[NDArray[np.uint8]] = []
        "In the order in which they were last taken."
        # Reentrant: a garbage collection inside `take` may run a finaliser that takes a buffer.
        self._lock = threading.RLock()

    @property
    def in_use(self) -> int:
        """Buffers that are still referenced."""
        with self._lock:
            return sum(not self._is_unused(index) for index in range(len(self._buffers)))

    def take(self) -> NDArray[np.uint8] | None:
        """Return a writable array of `size` undefined bytes; None if no buffer or no memory is left."""
        with self._lock:
            buffers = self._buffers
            # The one used last first: its memory is still in the processor's cache.
            for index in range(len(buffers) - 1, -1, -1):
                if self._is_unused(index):
                    buffer = buffers.pop(index)
                    break
            else:
                if len(buffers) >= self.limit:
                    return None
                try:
                    buffer = np.empty(self.size, np.uint8)
                except MemoryError:
                    return None  # costs a frame, but the receiving thread must not end
            buffers.append(buffer)
            return buffer[:]

    def _is_unused(self, index: int) -> bool:
        return getrefcount(self._buffers[index]) == self._UNUSED


def time_of_day(monotonic_ns: int) -> int:
    """Return the time of day (`time.time_ns`) at a time of the monotonic clock (`time.monotonic_ns`)."""
    return time.time_ns() - (time.monotonic_ns() - monotonic_ns)


class FrameStatus(Enum):
    """Whether all of the payload arrived."""

    COMPLETE = "complete"
    INCOMPLETE = "incomplete"


@dataclass(eq=False)
class Frame:
    """An image as the sensor sent it, with its metadata. Treat as immutable; may be read from any thread."""

    payload: NDArray[np.uint8]
    "1-D, the bytes on the wire; may be longer than the image (padding, chunks)."
    width: int
    height: int
    pixel_format: PixelFormat
    frame_id: int = 0
    "The device's block id, or a counter; restarts with each acquisition, and 16-bit ids after 65535."
    timestamp_ns: int = 0
    "Device clock in nanoseconds; 0 if the device has none, or the packet that contains it was lost."
    received_ns: int = 0
    """This computer's time of day (`time.time_ns`) when the frame was exposed, if the device's clock could be
    mapped to it, else when it arrived. For stamps and file names. The time of day may jump, so durations must
    be computed from `captured`."""
    captured: float = 0.0
    "The same time on the monotonic clock (`time.monotonic`, seconds); derived from `received_ns` by default."
    status: FrameStatus = FrameStatus.COMPLETE
    missing_bytes: int = 0
    offset_x: int = 0
    offset_y: int = 0
    padding_x: int = 0
    "Bytes at the end of each line that are not pixels."
    big_endian: bool = False
    "Byte order of unpacked pixels deeper than 8 bits, which GigE Vision leaves to the device."
    chunks: dict[str, Any] = field(default_factory=dict)
    "Chunk values by feature name, e.g. `ChunkExposureTime`."
    payload_type: PayloadType = PayloadType.IMAGE
    parts: tuple[Component, ...] = ()
    "The components of a payload with several; empty if the frame has one image of its own, or none."
    stream_channel: int = 0
    "Number of the device's stream channel; each channel counts its own frame ids."
    file_name: str = ""
    "Name of the file if the payload is one."
    chunk_payload: NDArray[np.uint8] | None = field(default=None, repr=False)
    "The bytes that `chunks` were read from; None if that is `payload`."
    _conversions: Conversions = field(default_factory=Conversions, repr=False)

    def __post_init__(self) -> None:
        if not self.captured:
            now = time.monotonic()
            age = (time.time_ns() - self.received_ns) / 1e9
            # A time in the future, or more than a minute ago, was taken from another clock.
            self.captured = now - age if 0 <= age < MOST_AGE else now

    @override
    def __repr__(self) -> str:
        content = f"{self.width}×{self.height} {self.pixel_format.name}"
        if not self.has_image:
            content = self.payload_type.value
        if len(self.parts) > 1:
            content += f" of {len(self.parts)} components"
        missing = "" if self.complete else f", {self.missing_bytes} of them missing"
        return f"<Frame {self.frame_id}: {content}, {self.nbytes} bytes{missing}>"

    def _repr_jpeg_(self) -> bytes | None:
        """Show the frame's own image in a notebook."""
        own = own_component(self.components)
        return own._repr_jpeg_() if own is not None else None

    @property
    def complete(self) -> bool:
        """Whether every byte arrived."""
        return self.status is FrameStatus.COMPLETE

    @property
    def components(self) -> tuple[Component, ...]:
        """The images of the frame, in the camera's order; empty if it has none (raw data, a file, chunks).

        The frame's own `payload`, `raw()` and `rgb()` are those of the first intensity image.
        """
        if self.parts or not self.has_image:
            return self.parts
        return (self._own_component(),)

    @property
    def has_image(self) -> bool:
        """Whether the frame has an image of its own, even if it cannot be shown."""
        return bool(self.width and self.height)

    @property
    def nbytes(self) -> int:
        """Size of the frame's own image as it arrived, in bytes. Decodes nothing."""
        return self.payload.nbytes

    def members(self) -> dict[str, Frame]:
        """Return the frames that it is made of, by camera; empty for a frame of one camera."""
        return {}

    def set_description(self) -> str:
        """Return JSON about the frames that it is made of; empty for a frame of one camera."""
        return ""

    def of_component(self, component: Component) -> Frame:
        """Return a component as a frame of its own, for code that shows, saves or sends frames."""
        return Frame(
            payload=component.payload,
            width=component.width,
            height=component.height,
            pixel_format=component.pixel_format,
            frame_id=self.frame_id,
            timestamp_ns=self.timestamp_ns,
            received_ns=self.received_ns,
            captured=self.captured,
            status=self.status,
            missing_bytes=self.missing_bytes,
            offset_x=component.offset_x,
            offset_y=component.offset_y,
            padding_x=component.padding_x,
            big_endian=component.big_endian,
            chunks=self.chunks,
            stream_channel=self.stream_channel,
        )

    def detached(self) -> Frame:
        """Return a copy of the frame that does not occupy a buffer of the stream."""
        parts = tuple(part.detached() for part in self.parts)
        payload = self.payload.copy()
        for original, copy in zip(self.parts, parts, strict=True):
            if original.data is self.payload:
                payload = copy.data
        return replace(self, payload=payload, parts=parts, chunk_payload=None, _conversions=Conversions())

    def raw(self) -> NDArray[Any]:
        """Return the sensor's data, read-only.

        Shape (height, width) uint8 or uint16 (native byte order, value in the low bits) for mono and
        Bayer, (height, width, n) uint8 for interleaved colour. A view of the payload unless the format is
        packed. Raises PixelFormatError for a format of unknown layout, or without an image.
        """
        return self._conversions.get("raw", lambda: pixels.to_raw(self._image()))

    def rgb(self) -> NDArray[np.uint8]:
        """Return the image for display: (height, width, 3) uint8, R G B, read-only; computed once.

        Deeper formats keep their eight highest bits. A view of the payload for RGB8. Raises PixelFormatError
        for a format that cannot be converted.
        """
        return self._conversions.get("rgb", lambda: pixels.to_rgb(self._image()))

    def bgr(self) -> NDArray[np.uint8]:
        """Return the image as OpenCV has it: as `rgb`, with the channels in the order B G R."""
        return self._conversions.get("bgr", lambda: pixels.to_bgr(self.rgb()))

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:
        """Let `numpy.asarray(frame)`, and what uses it, take the sensor's data: see `raw`."""
        return np.array(self.raw(), dtype, copy=copy)

    def mono(self) -> NDArray[np.uint8]:
        """Return the image in grey: (height, width) uint8, read-only; a view of the payload for Mono8."""
        return self._conversions.get("mono", lambda: pixels.to_mono(self._image()))

    def _image(self) -> Frame:
        if not self.has_image:
            raise PixelFormatError(no_image(self.payload_type, self.nbytes))
        return self

    def _own_component(self) -> Component:
        return Component(
            self.payload,
            self.width,
            self.height,
            self.pixel_format,
            ComponentKind.RANGE if self.pixel_format.is_distance else ComponentKind.INTENSITY,
            offset_x=self.offset_x,
            offset_y=self.offset_y,
            padding_x=self.padding_x,
            big_endian=self.big_endian,
            _conversions=self._conversions,
        )


class EncodedFrame(Frame):
    """A frame whose image is compressed; the first access to `payload` decodes it."""

    _image_part: Component

    @classmethod
    def of(cls, frame: Frame, part: Component) -> EncodedFrame:
        """Return a frame whose image is `part`, with the metadata and parts of another frame."""
        values = {item.name: getattr(frame, item.name) for item in fields(Frame)}
        encoded = cls(**values)
        encoded._image_part = part
        return encoded

    @property
    def payload(self) -> NDArray[np.uint8]:
        """1-D, the bytes of the decoded image. Raises PixelFormatError."""
        return self._image_part.payload

    @payload.setter
    def payload(self, arrived: NDArray[np.uint8]) -> None:
        """Do nothing: the component already has the received bytes."""

    @property
    @override
    def nbytes(self) -> int:
        return self._image_part.data.nbytes

    @override
    def detached(self) -> Frame:
        parts = tuple(part.detached() for part in self.parts)
        index = self.parts.index(self._image_part)
        copy = replace(
            self,
            payload=parts[index].data,
            parts=parts,
            chunk_payload=None,
            _conversions=Conversions(),
        )
        copy._image_part = parts[index]
        return copy


def no_image(payload_type: PayloadType, size: int) -> str:
    """Return the error text for a payload that has no image to show."""
    return (
        f"there is no image: the camera sends {payload_type.as_object} ({size} bytes); the bytes can be"
        " saved, or set PayloadType, ImageCompressionMode or ComponentEnable so that it sends images"
    )
