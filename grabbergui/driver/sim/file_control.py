"""SFNC's FileAccessControl: opens, reads, writes and closes the simulated camera's files."""

from __future__ import annotations

from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.enumerations import (
    File,
    FileOpenMode,
    FileOperation,
    FileOperationStatus,
    FileState,
)
from grabbergui.driver.sim.file_store import FILE_KINDS, FileStore, Wear, firmware_version
from grabbergui.driver.sim.lookup_table import LookUpTable
from grabbergui.driver.sim.memory import RegisterMemory

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
        wear = FILE_KINDS[file].wear
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
                f"{FILE_KINDS[file].name}: {received} bytes are not valid firmware and were discarded"
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
        if offset + length > FILE_KINDS[file].capacity:
            return FileOperationStatus.OVERFLOW, 0
        content[offset : offset + length] = self._buffer[:length]
        self.store.uploading[file] += length
        return FileOperationStatus.SUCCESS, length

    def _delete(self, file: File) -> _Outcome:
        if FILE_KINDS[file].wear is not Wear.IN_PLACE or file in self._open:
            return _FAILED
        self.store.replace(file, b"")
        self._note_stored(file, "was deleted")
        return _SUCCEEDED

    def _note_stored(self, file: File, what: str) -> None:
        self.store.note(f"{FILE_KINDS[file].name} {what}")
        if file is File.LUT_LUMINANCE:
            self._table.load()

    def _range(self) -> tuple[int, int]:
        """Return FileAccessOffset and FileAccessLength."""
        length = min(self._memory.integer(reg.FILE_ACCESS_LENGTH), len(self._buffer))
        return self._memory.integer(reg.FILE_ACCESS_OFFSET), length
