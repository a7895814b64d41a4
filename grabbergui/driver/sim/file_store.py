"""The simulated camera's files, in a store that survives power cuts.

Most files are written in place, so a power cut leaves them incomplete. Firmware is collected in RAM and
replaces the old one only when it is closed and its checksum is correct: a power cut loses the upload, never
the firmware. FileState reports the result, and the file DeviceLog gets a line about it.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from grabbergui.driver.sim.enumerations import File, FileState

LUT_INPUT_BITS = 12
"Bits of an input value of the look-up table, whose output values have 16."

LUT_ENTRIES = 1 << LUT_INPUT_BITS
"Output values in LUTLuminance, 16 bits each, little-endian: one for each input value."

_FIRMWARE = struct.Struct("<4s12sII")
"Magic, version, length and CRC-32 of the body that follows."
_MAGIC = b"GGFW"
_LOG_LINES = 200


class Wear(Enum):
    """Way in which a file is written."""

    READ_ONLY = "read-only"
    IN_PLACE = "in place"
    ON_CLOSE = "when it is closed and valid"


@dataclass(frozen=True)
class _FileKind:
    name: str
    "As FileSelector has it."
    wear: Wear
    capacity: int
    "Bytes."


FILE_KINDS = {
    File.USER_SET1: _FileKind("UserSet1", Wear.IN_PLACE, 1 << 16),
    File.USER_SET2: _FileKind("UserSet2", Wear.IN_PLACE, 1 << 16),
    File.LUT_LUMINANCE: _FileKind("LUTLuminance", Wear.IN_PLACE, LUT_ENTRIES * 2),
    File.SHADING_CORRECTION: _FileKind("ShadingCorrection", Wear.IN_PLACE, 1 << 15),
    File.DEVICE_LOG: _FileKind("DeviceLog", Wear.READ_ONLY, 1 << 16),
    File.FIRMWARE: _FileKind("Firmware", Wear.ON_CLOSE, 1 << 20),
}


def firmware_image(version: str, body: bytes) -> bytes:
    """Return a firmware file that the camera accepts."""
    return _FIRMWARE.pack(_MAGIC, version.encode(), len(body), zlib.crc32(body)) + body


def firmware_version(image: bytes) -> str | None:
    """Return the version of a firmware file; None if it is damaged or something else."""
    if len(image) < _FIRMWARE.size:
        return None
    magic, version, length, checksum = _FIRMWARE.unpack_from(image)
    body = image[_FIRMWARE.size :]
    if magic != _MAGIC or len(body) != length or zlib.crc32(body) != checksum:
        return None
    return str(version.rstrip(b"\0").decode("ascii", "replace"))


def _factory_contents() -> dict[File, bytes]:
    ramp = np.arange(LUT_ENTRIES, dtype="<u2") * 16
    flat = np.full(64 * 64, 4096, "<u2")
    body = np.random.default_rng(1).integers(0, 256, 24_000, np.uint8)
    return {
        File.LUT_LUMINANCE: ramp.tobytes(),
        File.SHADING_CORRECTION: flat.tobytes(),
        File.FIRMWARE: firmware_image("1.0.0", body.tobytes()),
    }


@dataclass
class FileStore:
    """Non-volatile memory of the camera: contents and states of its files, and its log."""

    contents: dict[File, bytearray] = field(default_factory=dict)
    states: dict[File, FileState] = field(default_factory=dict)
    uploading: dict[File, int] = field(default_factory=dict)
    "Files open for writing, and the bytes received so far."
    log: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        for file, content in _factory_contents().items():
            self.contents.setdefault(file, bytearray(content))

    def state(self, file: File) -> FileState:
        """Return the state of a file."""
        if file in self.states:
            return self.states[file]
        return FileState.INTACT if self.content(file) else FileState.EMPTY

    def content(self, file: File) -> bytes:
        """Return the bytes of a file."""
        if file is File.DEVICE_LOG:
            return "".join(f"{line}\n" for line in self.log).encode()
        return bytes(self.contents.get(file, b""))

    def replace(self, file: File, content: bytes) -> None:
        """Replace a whole file from inside the camera."""
        self.contents[file] = bytearray(content)
        self.states.pop(file, None)

    def note(self, line: str) -> None:
        """Append a line to the log, which keeps the last `_LOG_LINES`."""
        self.log.append(line)
        del self.log[:-_LOG_LINES]

    def power_on(self) -> None:
        """Find the uploads that the last power cut ended, and log them."""
        for file, received in self.uploading.items():
            kept = FILE_KINDS[file].wear is Wear.ON_CLOSE
            self.states[file] = FileState.DISCARDED if kept else FileState.INCOMPLETE
            self.note(
                f"power was lost while {FILE_KINDS[file].name} was written, after {received} bytes: "
                + ("the upload is discarded, the file before it kept" if kept else "the file is incomplete")
            )
        self.uploading.clear()
        self.note("power on")
