"""The bytes of ROS's messages in recordings: images, compressed images, times and texts.

The messages `sensor_msgs/msg/Image`, `TimeReference` and `std_msgs/msg/String` are in OMG CDR (XCDR1): after
an encapsulation header of four bytes, primitives are aligned to their size relative to its end. Strings and
sequences follow a 32-bit count, and strings end with a zero. Messages are encoded little-endian.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

from grabbergui.core.errors import RemoteProtocolError

CDR_LITTLE_ENDIAN = b"\x00\x01\x00\x00"
_HEADER = "std_msgs/Header header\n"
_SEPARATOR = "=" * 80 + "\n"
_HEADER_DEFINITION = (
    f"{_SEPARATOR}MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
    f"{_SEPARATOR}MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
)
IMAGE_NAME = "sensor_msgs/msg/Image"
IMAGE_DEFINITION = (
    f"{_HEADER}uint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\nuint8[] data\n"
    + _HEADER_DEFINITION
)
COMPRESSED_NAME = "sensor_msgs/msg/CompressedImage"
CAMERA_INFO_DEFINITION = (
    f"{_HEADER}uint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\nfloat64[9] k\n"
    "float64[9] r\nfloat64[12] p\nuint32 binning_x\nuint32 binning_y\nRegionOfInterest roi\n"
    f"{_SEPARATOR}MSG: sensor_msgs/RegionOfInterest\nuint32 x_offset\nuint32 y_offset\nuint32 height\n"
    "uint32 width\nbool do_rectify\n" + _HEADER_DEFINITION
)
TIME_NAME = "sensor_msgs/msg/TimeReference"
TIME_DEFINITION = f"{_HEADER}builtin_interfaces/Time time_ref\nstring source\n" + _HEADER_DEFINITION
STRING_NAME = "std_msgs/msg/String"
STRING_DEFINITION = "string data\n"


COMPRESSED_ENDS = ("/compressedDepth", "/compressed")
"""Ends of the names of compressed topics, below that of the plain images (image_transport)."""


def plain_topic(topic: str) -> str:
    """Return the topic of the plain images beside which `camera_info` lies; of a plain one itself."""
    for end in COMPRESSED_ENDS:
        topic = topic.removesuffix(end)
    return topic


@dataclass(frozen=True)
class RosImage:
    """The fields of a `sensor_msgs/msg/Image`."""

    stamp_ns: int
    frame_id: str
    height: int
    width: int
    encoding: str
    is_bigendian: int
    step: int
    "Bytes of a line."
    data: bytes | memoryview

    def encode(self) -> bytes:
        """Return the message, including its encapsulation header."""
        writer = CdrWriter()
        writer.header(self.stamp_ns, self.frame_id)
        writer.numbers("II", self.height, self.width)
        writer.text(self.encoding)
        writer.numbers("B", self.is_bigendian)
        writer.numbers("II", self.step, len(self.data))
        return b"".join((CDR_LITTLE_ENDIAN, writer.content, self.data))

    @classmethod
    def decode(cls, message: bytes | memoryview) -> RosImage:
        """Read a message; `data` is a view of it. Raises RemoteProtocolError."""
        reader = CdrReader(message)
        stamp, frame_id = reader.header()
        height, width = reader.number("I"), reader.number("I")
        encoding = reader.text()
        big = reader.number("B")
        step = reader.number("I")
        data = reader.bytes(reader.number("I"))
        if step * height > len(data):
            raise RemoteProtocolError(
                f"an image of {height} lines of {step} bytes has only {len(data)} bytes"
            )
        return cls(stamp, frame_id, height, width, encoding, big, step, data)


@dataclass(frozen=True)
class RosCompressedImage:
    """The fields of a `sensor_msgs/msg/CompressedImage`."""

    stamp_ns: int
    format: str
    "Such as `jpeg`, or `bgr8; jpeg compressed bgr8` of image_transport."
    data: memoryview

    @classmethod
    def decode(cls, message: bytes | memoryview) -> RosCompressedImage:
        """Read a message; `data` is a view of it. Raises RemoteProtocolError."""
        reader = CdrReader(message)
        stamp, _ = reader.header()
        return cls(stamp, reader.text(), reader.bytes(reader.number("I")))


def decode_stamp(message: bytes | memoryview) -> int:
    """Return the nanoseconds of the header that a message begins with. Raises RemoteProtocolError."""
    return CdrReader(message).time()


def encode_string(text: str) -> bytes:
    """Encode a `std_msgs/msg/String`."""
    writer = CdrWriter()
    writer.text(text)
    return CDR_LITTLE_ENDIAN + bytes(writer.content)


def decode_string(message: bytes | memoryview) -> str:
    """Return the text of a `std_msgs/msg/String`. Raises RemoteProtocolError."""
    return CdrReader(message).text()


def encode_time_reference(stamp_ns: int, frame_id: str, time_ns: int, source: str) -> bytes:
    """Encode a `TimeReference`: the time of the camera's clock when the host's was `stamp_ns`."""
    writer = CdrWriter()
    writer.header(stamp_ns, frame_id)
    writer.time(time_ns)
    writer.text(source)
    return CDR_LITTLE_ENDIAN + bytes(writer.content)


def decode_time_reference(message: bytes | memoryview) -> int:
    """Return the camera's time in nanoseconds. Raises RemoteProtocolError."""
    reader = CdrReader(message)
    reader.header()
    return reader.time()


class CdrWriter:
    """Encodes the fields of a message in their order."""

    def __init__(self) -> None:
        self.content = bytearray()

    def numbers(self, codes: str, *values: float) -> None:
        """Append numbers, each aligned to its size, by their `struct` codes."""
        for code, value in zip(codes, values, strict=True):
            size = struct.calcsize(f"<{code}")
            self.content += bytes(-len(self.content) % size) + struct.pack(f"<{code}", value)

    def text(self, text: str) -> None:
        """Append a string."""
        encoded = text.encode() + b"\0"
        self.numbers("I", len(encoded))
        self.content += encoded

    def time(self, ns: int) -> None:
        """Append a `builtin_interfaces/Time`."""
        # Seconds are int32, which the clock of a camera may exceed.
        self.numbers("iI", min(ns // 10**9, 2**31 - 1), ns % 10**9)

    def header(self, stamp_ns: int, frame_id: str) -> None:
        """Append a `std_msgs/Header`."""
        self.time(stamp_ns)
        self.text(frame_id)


class CdrReader:
    """Reads the fields of a message in their order. All methods raise RemoteProtocolError at its end."""

    def __init__(self, message: bytes | memoryview) -> None:
        view = memoryview(message)
        if len(view) < 4 or view[0] != 0 or view[1] not in (0, 1):
            raise RemoteProtocolError("a ROS message without a CDR header")
        self._order = "<" if view[1] else ">"
        self._view = view[4:]
        self._at = 0

    def number(self, code: str) -> int:
        """Return an integer by its `struct` code."""
        return int(self._value(code))

    def real(self) -> float:
        """Return a 64-bit float."""
        return float(self._value("d"))

    def _value(self, code: str) -> float:
        size = struct.calcsize(f"<{code}")
        at = self._at + -self._at % size
        if at + size > len(self._view):
            raise RemoteProtocolError(f"a ROS message ends after {len(self._view)} bytes, in a number")
        self._at = at + size
        value: float = struct.unpack_from(f"{self._order}{code}", self._view, at)[0]
        return value

    def bytes(self, count: int) -> memoryview:
        """Return a view of the next bytes."""
        if self._at + count > len(self._view):
            raise RemoteProtocolError(
                f"a ROS message has only {len(self._view) - self._at} of {count} bytes left"
            )
        self._at += count
        return self._view[self._at - count : self._at]

    def text(self) -> str:
        """Return a string."""
        return str(bytes(self.bytes(self.number("I"))), "utf-8", "replace").rstrip("\0")

    def time(self) -> int:
        """Return the nanoseconds of a `builtin_interfaces/Time`."""
        return self.number("i") * 10**9 + self.number("I")

    def header(self) -> tuple[int, str]:
        """Return the stamp in nanoseconds and the frame of a `std_msgs/Header`."""
        return self.time(), self.text()
