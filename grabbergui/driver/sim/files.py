"""Files of the simulated camera: SFNC's FileAccessControl with a store that survives power cuts.

Most files are written in place, so a power cut leaves them incomplete. Firmware is collected in RAM and
replaces the old one only when it is closed and its checksum is correct: a power cut loses the upload, never
the firmware. FileState reports the result, and the file DeviceLog gets a line about it. The look-up table is
the file LUTLuminance and, at the same time, LUTValueAll, LUTIndex and LUTValue. The user sets are files, too.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.memory import (
    Kind,
    Refusal,
    Register,
    RegisterMemory,
    RegisterRefusedError,
    RegisterValue,
)
from grabbergui.driver.sim.packing import LUT_INPUT_BITS
from grabbergui.driver.sim.registers import File, FileOpenMode, FileOperation, FileOperationStatus, FileState

LUT_ENTRIES = 1 << LUT_INPUT_BITS
"Of LUTLuminance: 16-bit output values, little-endian, one for each input value of `LUT_INPUT_BITS`."

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


_FILE_KINDS = {
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
            kept = _FILE_KINDS[file].wear is Wear.ON_CLOSE
            self.states[file] = FileState.DISCARDED if kept else FileState.INCOMPLETE
            self.note(
                f"power was lost while {_FILE_KINDS[file].name} was written, after {received} bytes: "
                + ("the upload is discarded, the file before it kept" if kept else "the file is incomplete")
            )
        self.uploading.clear()
        self.note("power on")


# -- access to files -----------------------------------------------------------------------------
_Outcome = tuple[FileOperationStatus, int]
"FileOperationStatus and FileOperationResult."
_SUCCEEDED: _Outcome = FileOperationStatus.SUCCESS, 0
_FAILED: _Outcome = FileOperationStatus.FAILURE, 0


class FileControl:
    """The registers of FileAccessControl. The caller holds the camera's lock."""

    def __init__(self, memory: RegisterMemory, store: FileStore, table: LookUpTable) -> None:
        self._memory = memory
        self.store = store
        self._table = table
        self._open: dict[File, FileOpenMode] = {}
        self._staged: dict[File, bytearray] = {}
        "Data to be stored when the file is closed."
        self._buffer = memory.add_buffer(*reg.FILE_ACCESS_BUFFER)
        memory.on_read(reg.FILE_SIZE, lambda: len(store.content(self._selected())))
        memory.on_read(reg.FILE_STATE, lambda: store.state(self._selected()))
        store.power_on()

    def execute(self) -> None:
        """Run the selected operation on the selected file; its outcome is in FileOperationStatus."""
        operation = FileOperation(self._memory.integer(reg.FILE_OPERATION_SELECTOR))
        action = {
            FileOperation.OPEN: self._open_file,
            FileOperation.CLOSE: self._close,
            FileOperation.READ: self._read,
            FileOperation.WRITE: self._write,
            FileOperation.DELETE: self._delete,
        }[operation]
        status, result = action(self._selected())
        self._memory.set(reg.FILE_OPERATION_STATUS, status)
        self._memory.set(reg.FILE_OPERATION_RESULT, result)

    def close_all(self) -> None:
        """Abandon open files as a reset does: their uploads stay unfinished."""
        self._open.clear()
        self._staged.clear()
        self.store.power_on()

    def _selected(self) -> File:
        return File(self._memory.integer(reg.FILE_SELECTOR))

    def _open_file(self, file: File) -> _Outcome:
        if file in self._open:
            return _FAILED
        mode = FileOpenMode(self._memory.integer(reg.FILE_OPEN_MODE))
        if file is File.LUT_LUMINANCE:
            self._table.save()
        wear = _FILE_KINDS[file].wear
        if mode is not FileOpenMode.READ:
            if wear is Wear.READ_ONLY:
                return _FAILED
            fresh = b"" if mode is FileOpenMode.WRITE else self.store.content(file)
            self.store.uploading[file] = 0
            if wear is Wear.ON_CLOSE:
                self._staged[file] = bytearray(fresh)
            else:
                self.store.contents[file] = bytearray(fresh)
                self.store.states[file] = FileState.INCOMPLETE
        self._open[file] = mode
        return _SUCCEEDED

    def _close(self, file: File) -> _Outcome:
        mode = self._open.pop(file, None)
        if mode is None:
            return _FAILED
        if mode is FileOpenMode.READ:
            return _SUCCEEDED
        received = self.store.uploading.pop(file, 0)
        staged = self._staged.pop(file, None)
        if staged is not None and firmware_version(bytes(staged)) is None:
            self.store.states[file] = FileState.DISCARDED
            self.store.note(
                f"{_FILE_KINDS[file].name}: {received} bytes are not valid firmware and were discarded"
            )
            return _FAILED
        self.store.replace(file, self.store.content(file) if staged is None else bytes(staged))
        self._note_stored(file, f"was written: {len(self.store.content(file))} bytes")
        return _SUCCEEDED

    def _read(self, file: File) -> _Outcome:
        offset, length = self._range()
        content = self.store.content(file)
        if self._open.get(file) not in (FileOpenMode.READ, FileOpenMode.READ_WRITE) or offset > len(content):
            return _FAILED
        part = content[offset : offset + length]
        self._buffer[: len(part)] = part
        return FileOperationStatus.SUCCESS, len(part)

    def _write(self, file: File) -> _Outcome:
        offset, length = self._range()
        if self._open.get(file) not in (FileOpenMode.WRITE, FileOpenMode.READ_WRITE):
            return _FAILED
        content = self._staged.get(file, self.store.contents.setdefault(file, bytearray()))
        if offset > len(content):
            return _FAILED
        if offset + length > _FILE_KINDS[file].capacity:
            return FileOperationStatus.OVERFLOW, 0
        content[offset : offset + length] = self._buffer[:length]
        self.store.uploading[file] += length
        return FileOperationStatus.SUCCESS, length

    def _delete(self, file: File) -> _Outcome:
        if _FILE_KINDS[file].wear is not Wear.IN_PLACE or file in self._open:
            return _FAILED
        self.store.replace(file, b"")
        self._note_stored(file, "was deleted")
        return _SUCCEEDED

    def _note_stored(self, file: File, what: str) -> None:
        self.store.note(f"{_FILE_KINDS[file].name} {what}")
        if file is File.LUT_LUMINANCE:
            self._table.load()

    def _range(self) -> tuple[int, int]:
        """Return FileAccessOffset and FileAccessLength."""
        length = min(self._memory.integer(reg.FILE_ACCESS_LENGTH), len(self._buffer))
        return self._memory.integer(reg.FILE_ACCESS_OFFSET), length


# -- look-up table -------------------------------------------------------------------------------
class LookUpTable:
    """The table's registers over a buffer, big-endian; the file has the same values, little-endian.

    The caller holds the camera's lock.
    """

    def __init__(self, memory: RegisterMemory, store: FileStore) -> None:
        self._memory = memory
        self._store = store
        self._buffer = memory.add_buffer(*reg.LUT_VALUE_ALL)
        memory.on_read(reg.LUT_VALUE, self._value)
        memory.on_check(reg.LUT_VALUE, self._set_value)
        self.load()

    def load(self) -> None:
        """Take over the file; one that has no whole table means that values pass unchanged."""
        content = self._store.content(File.LUT_LUMINANCE)
        table = np.arange(LUT_ENTRIES, dtype="<u2") * 16
        if len(content) == table.nbytes:
            table = np.frombuffer(content, "<u2")
        self._loaded = table.astype(">u2").tobytes()
        self._buffer[:] = self._loaded

    def save(self) -> None:
        """Bring the file up to date if the registers were written."""
        present = bytes(self._buffer)
        if present != self._loaded:
            self._store.replace(File.LUT_LUMINANCE, np.frombuffer(present, ">u2").astype("<u2").tobytes())
            self._loaded = present

    def _place(self) -> slice:
        index = self._memory.integer(reg.LUT_INDEX)
        return slice(2 * index, 2 * index + 2)

    def _value(self) -> RegisterValue:
        return int.from_bytes(self._buffer[self._place()], "big")

    def _set_value(self, value: RegisterValue) -> RegisterValue:
        self._buffer[self._place()] = int(value).to_bytes(2, "big")
        return value


# -- user sets -----------------------------------------------------------------------------------
class UserSets:
    """The user sets stored by UserSetSave: files of the camera, which survive resets and power cuts.

    A file has a line `register = value` for each setting; omitted settings have the factory's values.
    """

    def __init__(self, memory: RegisterMemory, store: FileStore) -> None:
        self._memory = memory
        self._store = store
        self._factory = self._present()
        for file in _FILE_OF_SET.values():
            if store.state(file) is FileState.EMPTY:
                store.replace(file, _encode_settings(self._factory))

    def save(self) -> None:
        """Keep the present settings in the selected set. Raises RegisterRefusedError for the factory's."""
        selected = reg.UserSet(self._memory.integer(reg.USER_SET_SELECTOR))
        if selected is reg.UserSet.DEFAULT:
            raise RegisterRefusedError(Refusal.ACCESS_DENIED, "the factory's user set cannot be overwritten")
        self._store.replace(_FILE_OF_SET[selected], _encode_settings(self._present()))

    def apply(self, which: Register) -> None:
        """Take over the set that a register names.

        Raises RegisterRefusedError, and changes nothing, if its file is incomplete or makes no sense.
        """
        selected = reg.UserSet(self._memory.integer(which))
        settings = dict(self._factory)
        if selected in _FILE_OF_SET:
            file = _FILE_OF_SET[selected]
            if self._store.state(file) is not FileState.INTACT:
                raise RegisterRefusedError(
                    Refusal.ACCESS_DENIED, f"the file of {selected.name} is incomplete"
                )
            settings |= _decode_settings(self._store.content(file))
        for register, value in settings.items():
            self._memory.set(register, value)

    def apply_or_factory(self, which: Register) -> None:
        """Take over the set that a register names; the factory's if that one is damaged."""
        try:
            self.apply(which)
        except RegisterRefusedError as error:
            self._store.note(f"the factory's settings are used: {error}")
            for register, value in self._factory.items():
                self._memory.set(register, value)

    def _present(self) -> dict[Register, RegisterValue]:
        return {register: self._memory.stored(register) for register in reg.ALL if register.saved}


_FILE_OF_SET = {reg.UserSet.USER_SET1: File.USER_SET1, reg.UserSet.USER_SET2: File.USER_SET2}
_SAVED_REGISTERS = {register.name: register for register in reg.ALL if register.saved}


def _encode_settings(settings: dict[Register, RegisterValue]) -> bytes:
    return "".join(f"{register.name} = {value}\n" for register, value in settings.items()).encode()


def _decode_settings(content: bytes) -> dict[Register, RegisterValue]:
    """Return the settings in the file of a user set. Raises RegisterRefusedError."""
    settings: dict[Register, RegisterValue] = {}
    for line in content.decode("utf-8", "replace").splitlines():
        name, _, text = line.partition(" = ")
        register = _SAVED_REGISTERS.get(name)
        if register is None:
            raise RegisterRefusedError(
                Refusal.INVALID_PARAMETER, f"the user set has no setting {name[:40]!r}"
            )
        try:
            value = float(text) if register.kind is Kind.FLOAT64 else int(text)
        except ValueError as error:
            message = f"the user set's {name} is not a number: {text[:40]!r}"
            raise RegisterRefusedError(Refusal.INVALID_PARAMETER, message) from error
        register.check(value)
        settings[register] = value
    return settings
