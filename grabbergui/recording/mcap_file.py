"""MCAP files with ROS 2 messages, from this program's recorder, `ros2 bag` and others.

The file is read record by record (MCAP specification 1.0: a byte of opcode, eight of length), so that one
whose end is missing plays up to there. Uncompressed chunks, as the recorder writes them, are entered without
reading them; compressed ones are decompressed once for the index and again for their frames. Their announced
sizes are bounded before that, as 30 kB of zstd can hold gigabytes.
"""

from __future__ import annotations

import logging
import struct
from io import BufferedReader
from pathlib import Path

import zstandard
from lz4.frame import LZ4FrameDecompressor
from typing_extensions import override

from grabbergui.core.coord3d import Scan3d
from grabbergui.core.errors import UsageError
from grabbergui.core.regular_files import open_regular
from grabbergui.recording.errors import RecordingError
from grabbergui.recording.message_store import MessageStore, Place, TopicChannel

log = logging.getLogger(__name__)

MAGIC = b"\x89MCAP0\r\n"
SCAN_METADATA = "grabbergui/scan3d"
"Name of the record with the meaning of 3D data."
MAX_CHUNK = 1 << 28
"Bytes of the largest chunk, before and after decompression: one image of 100 MP with 16 bits."
MOST_EXPANDED = 1 << 27
MOST_EXPANSION = 1000
"All chunks may grow to `MOST_EXPANDED` bytes and `MOST_EXPANSION` times the size of the file."
MAX_SMALL = 1 << 24
"Bytes of the largest record without frames."
_NOTHING, _SCHEMA, _CHANNEL, _MESSAGE, _CHUNK, _METADATA = 0, 3, 4, 5, 6, 12
"Opcodes. Zero is not one, but after a power cut the end of a file may be zeros."


class McapFile(MessageStore):
    """An MCAP file and the index of its messages."""

    def __init__(self, path: Path, number: int = 0) -> None:
        """Open and index a file. Raises UsageError, RecordingError."""
        self.path, self.number = path, number
        try:
            self._file: BufferedReader = open_regular(path)
        except OSError as error:
            raise self._unreadable(error) from error
        self._schemas: dict[int, str] = {}
        self.channels = {}
        self.messages = []
        self._expanded = 0
        self._chunk: tuple[int, bytes] = (-1, b"")
        self._damaged = False
        "Whether there is a chunk that cannot be read."
        try:
            if self._file.read(len(MAGIC)) != MAGIC:
                raise UsageError(f"{path} is no MCAP file")
            self._index()
        except BaseException:
            self._file.close()
            raise

    @override
    def close(self) -> None:
        self._file.close()

    def _index(self) -> None:
        self._size = size = self._file.seek(0, 2)
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
        self._check_expansion(at)
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

    def _check_expansion(self, at: int) -> None:
        """Raise UsageError if a chunk announces to grow beyond the limits."""
        self._file.seek(at + 9 + 16)
        size = int.from_bytes(self._file.read(8), "little")
        if size > MAX_CHUNK:
            raise UsageError(
                f"{self.path}: a chunk announces {size} bytes; at most {MAX_CHUNK} are read: "
                "`mcap decompress` makes smaller ones"
            )
        self._expanded += size
        if self._expanded > MOST_EXPANDED + MOST_EXPANSION * self._size:
            raise UsageError(
                f"{self.path} of {self._size} bytes announces to grow beyond {MOST_EXPANSION} times that: "
                "if you trust it, `mcap decompress` it"
            )

    def _add_message(self, head: bytes, chunk: int, offset: int, length: int) -> None:
        channel, sequence, log_time, _ = struct.unpack("<HIQQ", head)
        self.add(Place(self.number, chunk, offset + 22, length - 22, channel, sequence, log_time))

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
            encoding = str(body[at + 4 : at + 4 + size], "utf-8", "replace")
            metadata, kind = _pairs(body, at + 4 + size), self._schemas.get(schema, "")
            self.channels[number] = TopicChannel(topic, kind, encoding, metadata)
        except struct.error:
            raise UsageError(f"{self.path}: a schema or channel was cut short") from None

    def _read_coordinates(self, body: bytes) -> None:
        try:
            (size,) = struct.unpack_from("<I", body)
            if str(body[4 : 4 + size], "utf-8", "replace") == SCAN_METADATA:
                self.scan = Scan3d.from_json(_pairs(body, 4 + size).get("json", ""))
        except (UsageError, struct.error) as error:
            log.warning("%s: %s; distances have no unit", self.path, error)

    @override
    def content(self, place: Place) -> bytes | memoryview:
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
                raise RecordingError(f"{self.path}: a chunk announces {size} bytes, which cannot be")
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


def _pairs(body: bytes, at: int) -> dict[str, str]:
    """Read a map of strings to strings, which follows its size in bytes."""
    (size,) = struct.unpack_from("<I", body, at)
    at, end, texts = at + 4, at + 4 + size, []
    while at < min(end, len(body)):
        (length,) = struct.unpack_from("<I", body, at)
        texts.append(str(body[at + 4 : at + 4 + length], "utf-8", "replace"))
        at += 4 + length
    return dict(zip(texts[::2], texts[1::2], strict=False))
