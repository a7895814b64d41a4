"""The parts of a payload: their kinds, bytes and pixels (SFNC, Component Control)."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum, IntEnum
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray
from typing_extensions import override

from grabbergui.core import pixels
from grabbergui.core.encoded_image import Encoding, jpeg_to_show
from grabbergui.core.errors import PixelFormatError
from grabbergui.core.pfnc import PixelFormat


class PayloadType(Enum):
    """The kind of a frame's payload, in the words of GigE Vision and GenTL."""

    IMAGE = "image"
    CHUNK = "chunk data"
    RAW_DATA = "raw data"
    FILE = "file"
    JPEG = "JPEG"
    JPEG2000 = "JPEG 2000"
    H264 = "H.264"
    MULTI_PART = "multi-part"
    GENDC = "GenDC"

    @property
    def as_object(self) -> str:
        """The kind as the object of a sentence about a frame without an image: `the camera sends …`."""
        return _AS_OBJECT[self]


_AS_OBJECT = {
    PayloadType.IMAGE: "an image without size or pixel format",
    PayloadType.CHUNK: "chunk data alone",
    PayloadType.RAW_DATA: "raw data",
    PayloadType.FILE: "a file",
    PayloadType.JPEG: "a damaged JPEG image",
    PayloadType.JPEG2000: "a damaged JPEG 2000 image",
    PayloadType.H264: "H.264 video",
    PayloadType.MULTI_PART: "multi-part data of other kinds",
    PayloadType.GENDC: "a GenDC container of other data",
}


class ComponentKind(IntEnum):
    """The quantity that a component measures: SFNC's ComponentIDValue, which GenDC calls TypeId."""

    UNDEFINED = 0
    INTENSITY = 1
    INFRARED = 2
    ULTRAVIOLET = 3
    RANGE = 4
    REFLECTANCE = 5
    CONFIDENCE = 6
    SCATTER = 7
    DISPARITY = 8
    MULTISPECTRAL = 9
    METADATA = 0x8001

    @classmethod
    def of(cls, value: int) -> ComponentKind:
        """Return the kind of an id; UNDEFINED for a vendor's own and any other that the standard lacks."""
        return cls(value) if value in cls._value2member_map_ else cls.UNDEFINED


class Conversions:
    """Caches the arrays computed from an image. Any thread."""

    def __init__(self) -> None:
        self._arrays: dict[str, NDArray[Any]] = {}
        self._lock = threading.RLock()  # computing the pixels of an encoded image computes its payload

    def __reduce__(self) -> tuple[type[Conversions], tuple[()]]:
        """Pickle without the arrays; another process computes them again."""
        return Conversions, ()

    def get(self, key: str, convert: Callable[[], NDArray[Any]]) -> NDArray[Any]:
        """Return the array of `key`, read-only; `convert` computes it the first time."""
        with self._lock:
            array = self._arrays.get(key)
            if array is None:
                array = convert().view()
                array.flags.writeable = False
                self._arrays[key] = array
            return array


@dataclass(frozen=True, eq=False)
class Component:
    """One image of a frame, in the bytes that the stream received. Immutable; any thread."""

    data: NDArray[np.uint8]
    "1-D, the bytes on the wire: a view, never a copy; compressed if there is an `encoding`."
    width: int
    height: int
    pixel_format: PixelFormat
    "Format of `payload`, which is decoded."
    kind: ComponentKind = ComponentKind.INTENSITY
    region: int = 0
    "Region id; 0 where the device has only one."
    source: int = 0
    "Id of the sensor, or of one of several devices in one camera."
    purpose: int = 0
    "Purpose id (multi-part) or group id (GenDC); components with the same id belong together."
    offset_x: int = 0
    offset_y: int = 0
    padding_x: int = 0
    "Bytes at the end of each line that are not pixels."
    big_endian: bool = False
    camera: str = ""
    "The name of its camera, in a frame of several cameras."
    encoding: Encoding | None = None
    "How `data` is compressed; None if it is not."
    _conversions: Conversions = field(default_factory=Conversions, repr=False)

    @override
    def __repr__(self) -> str:
        return f"<Component {self.name}: {self.width}×{self.height} {self.pixel_format.name}>"

    def _repr_jpeg_(self) -> bytes | None:
        """Show the image in a notebook, if its format can be shown."""
        try:
            return jpeg_to_show(self.rgb())
        except PixelFormatError:
            return None

    @property
    def name(self) -> str:
        """The kind in lower case, for names of files and topics; of several cameras, the camera's name."""
        kind = self.kind.name.lower()
        if not self.camera:
            return kind
        return self.camera if self.kind is ComponentKind.INTENSITY else f"{self.camera}_{kind}"

    @property
    def payload(self) -> NDArray[np.uint8]:
        """1-D, the image's bytes: `data`, decoded if it is compressed. Raises PixelFormatError."""
        if self.encoding is None:
            return self.data
        encoding = self.encoding
        return self._conversions.get("payload", lambda: encoding.decode(self.data))

    def raw(self) -> NDArray[Any]:
        """Return the component's data, read-only, as `Frame.raw` does. Raises PixelFormatError."""
        return self._conversions.get("raw", lambda: pixels.to_raw(self._decoded()))

    def rgb(self) -> NDArray[np.uint8]:
        """Return the component for display, as `Frame.rgb` does. Raises PixelFormatError."""
        return self._conversions.get("rgb", lambda: pixels.to_rgb(self._decoded()))

    def bgr(self) -> NDArray[np.uint8]:
        """Return the component as OpenCV has it, as `Frame.bgr` does. Raises PixelFormatError."""
        return self._conversions.get("bgr", lambda: pixels.to_bgr(self.rgb()))

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:
        """Let `numpy.asarray(component)` take its data: see `raw`."""
        return np.array(self.raw(), dtype, copy=copy)

    def detached(self) -> Component:
        """Return a copy of the component that does not occupy a buffer of the stream."""
        return replace(self, data=self.data.copy(), _conversions=Conversions())

    def _decoded(self) -> _DecodedImage:
        return _DecodedImage(
            self.payload, self.width, self.height, self.pixel_format, self.padding_x, self.big_endian
        )


def own_component(parts: Sequence[Component]) -> Component | None:
    """Return the component for consumers of a single image: the first intensity, or else the first."""
    intensities = (part for part in parts if part.kind is ComponentKind.INTENSITY)
    return next(intensities, parts[0] if parts else None)


def further_components(parts: Sequence[Component]) -> Iterator[tuple[str, Component]]:
    """Yield the other components with their names for files and topics: `range`, `range_2`."""
    own = own_component(parts)
    seen: Counter[str] = Counter()
    for part in parts:
        seen[part.name] += 1
        if part is not own:
            yield part.name + (f"_{seen[part.name]}" if seen[part.name] > 1 else ""), part


@dataclass(eq=False)
class _DecodedImage:
    """A component's uncompressed pixels, in the form that `core.pixels` takes."""

    payload: NDArray[np.uint8]
    width: int
    height: int
    pixel_format: PixelFormat
    padding_x: int
    big_endian: bool
