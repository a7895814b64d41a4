"""MCAP files with ROS 2 images, from this program's recorder, `ros2 bag` and others.

The file is read record by record (MCAP specification 1.0: a byte of opcode, eight of length), so that one
whose end is missing plays up to there. Uncompressed chunks, as the recorder writes them, are entered without
reading them; compressed ones are decompressed once for the index and again for their frames.
"""

from __future__ import annotations

import logging
import struct
from dataclasses import dataclass, replace
from io import BufferedReader
from pathlib import Path
from typing import Any

import numpy as np
import zstandard
from lz4.frame import LZ4FrameDecompressor
from numpy.typing import NDArray
from typing_extensions import override

from grabbergui.core import ros_image
from grabbergui.core.calibration import Scan3d
from grabbergui.core.component import Component, ComponentKind, PayloadType
from grabbergui.core.errors import RemoteProtocolError, UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import PixelFormat
from grabbergui.core.regular_files import open_regular
from grabbergui.core.ros_image import (
    IMAGE_NAME,
    STRING_NAME,
    TIME_NAME,
    RosImage,
    decode_string,
    decode_time_reference,
)
from grabbergui.recording import (
    MAX_LINE,
    FrameNote,
    Recording,
    RecordingError,
    format_named,
    in_order_of_receipt,
    parse_note,
    rebuilt,
    rising,
)

log = logging.getLogger(__name__)

MAGIC = b"\x89MCAP0\r\n"
DEVICE_TIME = "/device_time"
"Suffix of the topic with the camera's clock, after the images' topic."
NOTE = "/note"
"Suffix of the topic with the notes of frames, as in `frames.jsonl`."
PIXEL_FORMAT_KEY = "pixel_format"
"Key in a channel's metadata: the PFNC name, which ROS's encoding does not contain (Mono12 is mono16)."
BESIDE_KEY = "beside"
"Key in the metadata of a channel with further components: the topic of their frames."
SCAN_METADATA = "grabbergui/scan3d"
"Name of the record with the meaning of 3D data."
MAX_CHUNK = 1 << 30
"Bytes of the largest chunk, before and after decompression."
MOST_MESSAGES = 10_000_000
"Most messages of all topics; a small compressed file could contain any number."
MAX_SMALL = 1 << 24
"Bytes of the largest record without frames."
_NOTHING, _SCHEMA, _CHANNEL, _MESSAGE, _CHUNK, _METADATA = 0, 3, 4, 5, 6, 12
"Opcodes. Zero is not one, but after a power cut the end of a file may be zeros."


@dataclass(frozen=True)
class _Channel:
    topic: str
    schema: int
    metadata: dict[str, str]


@dataclass(frozen=True, slots=True)
class _Place:
    """The position of a message, in the file itself (chunk < 0) or in the chunk at an offset."""

    chunk: int
    offset: int
    length: int
    channel: int
    sequence: int
    log_time: int


class McapRecording(Recording):
    """The images of the topic with the most images."""

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            self._file: BufferedReader = open_regular(path)
        except OSError as error:
            raise self._unreadable(error) from error
        self._schemas: dict[int, str] = {}
        self._channels: dict[int, _Channel] = {}
        self._messages: list[_Place] = []
        self._beside: dict[tuple[int, int], list[_Place]] = {}
        "Further components by sequence number and time of their frame."
        self._chunk: tuple[int, bytes] = (-1, b"")
        self._damaged = False
        "Whether there is a chunk that cannot be read."
        try:
            if self._file.read(len(MAGIC)) != MAGIC:
                raise UsageError(f"{path} is no MCAP file")
            self._index()
            self._choose_topic()
        except BaseException:
            self._file.close()
            raise

    @override
    def frame(self, index: int, received_ns: int) -> Frame:
        place = self._images[index]
        frame = self._image(place, index, received_ns)
        beside = self._beside.get((place.sequence, place.log_time), ())
        if beside:
            images = [(frame, place), *((self._image(one, index, received_ns), one) for one in beside)]
            parts = sorted((self._component(*one) for one in images), key=lambda part: part[0])
            components = tuple(part for _, part in parts)
            frame = replace(frame, parts=components, payload_type=PayloadType.MULTI_PART)
        return frame

    def _image(self, place: _Place, index: int, received_ns: int) -> Frame:
        try:
            image = RosImage.decode(self._content(place))
        except RemoteProtocolError as error:
            raise RecordingError(f"{self.path}: frame {index}: {error}") from error
        pixel_format = self._format(place, image)
        note = replace(
            self._note(place),
            width=image.width,
            height=image.height,
            pixel_format=pixel_format.name,
            timestamp_ns=self._device_time(place),
        )
        return rebuilt(self._lines(image, pixel_format), note, received_ns)

    def _component(self, image: Frame, place: _Place) -> tuple[int, Component]:
        """Return an image as a component, after its index in the frame."""
        metadata = self._channels[place.channel].metadata
        kind = ComponentKind.__members__.get(metadata.get("component", ""), ComponentKind.UNDEFINED)
        numbers = (_number(metadata.get(name, "")) for name in ("index", "region", "source", "purpose"))
        index, region, source, purpose = numbers
        return index, Component(
            image.payload,
            image.width,
            image.height,
            image.pixel_format,
            kind,
            region=region,
            source=source,
            purpose=purpose,
        )

    @override
    def close(self) -> None:
        self._file.close()

    def _format(self, place: _Place, image: RosImage) -> PixelFormat:
        """Return the format of an image, from the recorder's metadata or else from the encoding."""
        name = self._channels[place.channel].metadata.get(PIXEL_FORMAT_KEY)
        pixel_format = format_named(name) if name else ros_image.format_of(image.encoding)
        if pixel_format is None:
            raise RecordingError(f"{self.path}: images of encoding '{image.encoding[:40]}' cannot be played")
        return pixel_format

    def _lines(self, image: RosImage, pixel_format: PixelFormat) -> NDArray[Any]:
        """Return lines without padding: (height, bytes) uint8, or (height, n) little-endian samples."""
        line = pixel_format.line_bytes(image.width)
        if not image.height or not line or line > image.step:
            raise RecordingError(
                f"{self.path}: an image of {image.width}×{image.height} {image.encoding[:40]} in lines of "
                f"{image.step} bytes is impossible"
            )
        padded = np.frombuffer(image.data, np.uint8)[: image.step * image.height]
        lines = np.ascontiguousarray(padded.reshape(image.height, image.step)[:, :line])
        size = pixel_format.sample_bytes
        # The flag is meaningless for 8-bit components, including YUV.
        if not image.is_bigendian or size == 1 or pixel_format.packed:
            return lines
        sample = f"{pixel_format.kind}{size}"
        return lines.view(f">{sample}").astype(f"<{sample}")

    def _device_time(self, place: _Place) -> int:
        time_place = self._times.get((place.sequence, place.log_time))
        if time_place is None:
            return 0
        try:
            return max(0, decode_time_reference(self._content(time_place)))
        except RemoteProtocolError:
            return 0

    def _note(self, place: _Place) -> FrameNote:
        """Return the note that was recorded of an image, or the little that is known without one."""
        note_place = self._notes.get((place.sequence, place.log_time))
        if note_place is not None and note_place.length <= 2 * MAX_LINE:
            try:
                return parse_note(decode_string(self._content(note_place)), "a note")
            except (RemoteProtocolError, UsageError) as error:
                log.debug("%s: %s", self.path, error)  # another program's topic
        return FrameNote(width=0, height=0, pixel_format="", frame_id=place.sequence)

    # -- indexing the file -----------------------------------------------------------------------
    def _index(self) -> None:
        size = self._file.seek(0, 2)
        at = len(MAGIC)
        while at + 9 <= size:
            self._file.seek(at)
            opcode, length = struct.unpack("<BQ", self._file.read(9))
            if opcode == _NOTHING or at + 9 + length > size:
                return  # cut short here
            if opcode == _CHUNK:
                header = self._uncompressed_header(length)
                if header:
                    at += 9 + header
                    continue
                self._index_chunk(at, length)
            elif opcode in (_SCHEMA, _CHANNEL, _METADATA) and length <= MAX_SMALL:
                self._add_definition(opcode, self._file.read(length))
            elif opcode == _MESSAGE and length >= 22:
                self._add_message(self._file.read(22), -1, at + 9, length)
            at += 9 + length

    def _uncompressed_header(self, length: int) -> int:
        """Return the length of an uncompressed chunk's header; 0 for a compressed one."""
        head = self._file.read(32)
        count = struct.unpack_from("<I", head, 28)[0] if len(head) == 32 else 1
        return 32 + 8 if count == 0 and length >= 32 + 8 else 0

    def _index_chunk(self, at: int, length: int) -> None:
        if length > MAX_CHUNK:
            raise RecordingError(f"{self.path}: a chunk of {length} bytes; at most {MAX_CHUNK} are read")
        try:
            content = memoryview(self._chunk_content(at))
        except RecordingError as error:
            if not self._damaged:
                self._damaged = True
                log.warning("%s; its frames are left out, and those of others like it", error)
            return
        offset = 0
        while offset + 9 <= len(content):
            opcode, inner = struct.unpack_from("<BQ", content, offset)
            if opcode == _NOTHING or offset + 9 + inner > len(content):
                return
            body = content[offset + 9 : offset + 9 + inner]
            if opcode in (_SCHEMA, _CHANNEL) and inner <= MAX_SMALL:
                self._add_definition(opcode, bytes(body))
            elif opcode == _MESSAGE and inner >= 22:
                self._add_message(bytes(body[:22]), at, offset + 9, inner)
            offset += 9 + inner

    def _add_message(self, head: bytes, chunk: int, offset: int, length: int) -> None:
        if len(self._messages) == MOST_MESSAGES:
            raise UsageError(
                f"{self.path} holds more than {MOST_MESSAGES} messages; cut a part out (`mcap filter`)"
            )
        channel, sequence, log_time, _ = struct.unpack("<HIQQ", head)
        self._messages.append(_Place(chunk, offset + 22, length - 22, channel, sequence, log_time))

    def _add_definition(self, opcode: int, body: bytes) -> None:
        try:
            if opcode == _SCHEMA:
                number, size = struct.unpack_from("<HI", body)
                self._schemas[number] = str(body[6 : 6 + size], "utf-8", "replace")
                return
            if opcode == _METADATA:
                self._read_coordinates(body)
                return
            number, schema, size = struct.unpack_from("<HHI", body)
            topic, at = str(body[8 : 8 + size], "utf-8", "replace"), 8 + size
            (size,) = struct.unpack_from("<I", body, at)
            self._channels[number] = _Channel(topic, schema, _pairs(body, at + 4 + size))
        except struct.error:
            raise UsageError(f"{self.path}: a schema or channel was cut short") from None

    def _read_coordinates(self, body: bytes) -> None:
        try:
            (size,) = struct.unpack_from("<I", body)
            if str(body[4 : 4 + size], "utf-8", "replace") == SCAN_METADATA:
                self.scan = Scan3d.from_json(_pairs(body, 4 + size).get("json", ""))
        except (UsageError, struct.error) as error:
            log.warning("%s: %s; distances have no unit", self.path, error)

    def _choose_topic(self) -> None:
        by_kind: dict[str, dict[str, list[_Place]]] = {IMAGE_NAME: {}, TIME_NAME: {}, STRING_NAME: {}}
        for place in self._messages:
            channel = self._channels.get(place.channel)
            kind = self._schemas.get(channel.schema) if channel is not None else None
            if channel is not None and kind in by_kind:
                by_kind[kind].setdefault(channel.topic, []).append(place)
        by_topic = by_kind[IMAGE_NAME]
        if not by_topic:
            raise UsageError(f"{self.path} holds no images of the type {IMAGE_NAME}")
        frames = [topic for topic, places in by_topic.items() if self._frame_topic(places[0]) not in by_topic]
        topic = max(frames or by_topic, key=lambda topic: len(by_topic[topic]))
        images = by_topic[topic]
        for places in by_topic.values():
            if self._frame_topic(places[0]) == topic:
                for place in places:
                    self._beside.setdefault((place.sequence, place.log_time), []).append(place)
        self.title = f"{self.path.name} {topic}"
        self._images = in_order_of_receipt(images, lambda place: place.log_time)
        # The sequence number alone is not unique, as a camera that restarts counts from one again.
        self._times, self._notes = (
            {(place.sequence, place.log_time): place for place in places}
            for places in (
                by_kind[TIME_NAME].get(topic + DEVICE_TIME, []),
                by_kind[STRING_NAME].get(topic + NOTE, []),
            )
        )
        self.times_ns = rising([place.log_time for place in self._images])

    def _frame_topic(self, place: _Place) -> str:
        """Return the topic of the frames that a component belongs to; empty for frames themselves."""
        return self._channels[place.channel].metadata.get(BESIDE_KEY, "")

    def _content(self, place: _Place) -> bytes | memoryview:
        if place.chunk >= 0:
            return memoryview(self._chunk_content(place.chunk))[place.offset : place.offset + place.length]
        try:
            self._file.seek(place.offset)
            return self._file.read(place.length)
        except OSError as error:
            raise self._unreadable(error) from error

    def _chunk_content(self, at: int) -> bytes:
        """Return the records of the chunk at an offset of the file. Raises RecordingError."""
        if self._chunk[0] != at:
            try:
                self._file.seek(at + 1)
                (length,) = struct.unpack("<Q", self._file.read(8))
                body = self._file.read(length)
            except OSError as error:
                raise self._unreadable(error) from error
            except struct.error as error:
                raise RecordingError(f"{self.path} was cut short while it was played") from error
            self._chunk = (at, self._uncompressed(body))
        return self._chunk[1]

    def _unreadable(self, error: OSError) -> RecordingError:
        return RecordingError(f"{self.path} could not be read: {error.strerror or error}")

    def _uncompressed(self, body: bytes) -> bytes:
        try:
            size, count = struct.unpack_from("<16xQ4xI", body)
            at = 32 + count + 8
            if size > MAX_CHUNK or at > len(body):
                raise RecordingError(
                    f"{self.path}: a chunk announces {size} bytes; at most {MAX_CHUNK} are read"
                )
            compression = str(body[32 : 32 + count], "ascii", "replace")
            return _decompressed(body[at:], compression, size) if compression else body[at:]
        except (struct.error, zstandard.ZstdError, RuntimeError, ValueError, MemoryError) as error:
            raise RecordingError(f"{self.path}: a chunk cannot be read: {error}") from error


def _decompressed(data: bytes, compression: str, size: int) -> bytes:
    """Return the first `size` bytes of a chunk: a few kilobytes can hold gigabytes more than announced.

    Raises ValueError for an unknown compression, and what the decompressors raise.
    """
    if compression == "zstd":
        return zstandard.ZstdDecompressor().stream_reader(data).read(size)
    if compression == "lz4":
        content: bytes = LZ4FrameDecompressor().decompress(data, size)
        return content
    raise ValueError(f"its compression '{compression[:20]}' is not known")


def _number(text: str) -> int:
    return int(text) if text.isascii() and text.isdigit() and len(text) < 20 else 0


def _pairs(body: bytes, at: int) -> dict[str, str]:
    """Read a map of strings to strings, which follows its size in bytes."""
    (size,) = struct.unpack_from("<I", body, at)
    at, end, texts = at + 4, at + 4 + size, []
    while at < min(end, len(body)):
        (length,) = struct.unpack_from("<I", body, at)
        texts.append(str(body[at + 4 : at + 4 + length], "utf-8", "replace"))
        at += 4 + length
    return dict(zip(texts[::2], texts[1::2], strict=False))
