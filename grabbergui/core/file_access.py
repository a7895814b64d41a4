"""Lists, reads, writes and deletes files in a camera (SFNC, FileAccessControl).

A file is opened, transferred block by block through the register FileAccessBuffer, and closed. A transfer
holds the grabber for `TURN` seconds at a time; between turns the selectors have their previous values, and
other callers can use the grabber. Only local cameras have the register; of other sources files can only be
listed.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from grabbergui.core.errors import (
    CameraFileError,
    FeatureError,
    GrabberError,
    LocalFileError,
    MissingFileError,
    TransferCancelledError,
    TransportError,
    UsageError,
)
from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.features import format_value
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.regular_files import read_bounded
from grabbergui.core.sfnc import FILE_ACCESS

TURN = 0.05
"Seconds of a transfer during which other callers wait."
LARGEST = 1 << 30
"Bytes. A camera that still sends more does not know where its file ends."
_SELECTOR, _OPERATION, _MODE, _BUFFER = (
    "FileSelector",
    "FileOperationSelector",
    "FileOpenMode",
    "FileAccessBuffer",
)
_RESTORED = (_SELECTOR, _OPERATION, _MODE)
_SUCCESS = "Success"

Progress = Callable[[int, int], None]
"Called on the caller's thread with the bytes done and the total; 0 if the camera does not report that."
MAX_CONTENT_BYTES = 1 << 30
"Bytes of the largest file that is uploaded."


@dataclass(frozen=True)
class CameraFile:
    """A file as the camera lists it."""

    name: str
    "Its entry of FileSelector."
    size: int | None
    "Bytes; None if the camera does not report it."
    modes: tuple[str, ...]
    "Entries of FileOpenMode for it: Read, Write, ReadWrite."
    details: dict[str, str] = field(default_factory=dict)
    "The vendor's own features about a file, with their text, such as FileState of the simulated camera."
    tooltip: str = ""

    def as_dict(self) -> dict[str, Any]:
        """All fields, for JSON."""
        return asdict(self)


@dataclass(frozen=True)
class Written:
    """An upload that the camera accepted."""

    size: int
    verified: bool
    "Whether the file was read back and compared; false if the camera does not allow reading it."


def is_firmware(name: str) -> bool:
    """Return whether a file is firmware, judged by its name."""
    return any(word in name.lower() for word in ("firmware", "bootloader", "fpga", "bitstream"))


def has_files(grabber: FeatureSource) -> bool:
    """Return whether a camera has FileAccessControl."""
    return grabber.has_feature(_SELECTOR) and grabber.has_feature("FileOperationExecute")


def transfers_files(grabber: FrameGrabber) -> bool:
    """Return whether files of this source can be read and written; those of remote ones are only listed."""
    try:
        return grabber.access is Access.CONTROL and grabber.register_length(_BUFFER) > 0
    except GrabberError:
        return False


def list_files(grabber: FeatureSource) -> list[CameraFile]:
    """Return the files of a camera, in the order of FileSelector.

    Raises UsageError for a camera without files, FeatureError, TransportError.
    """
    _require(grabber)
    entries = [entry for entry in grabber.feature(_SELECTOR).entries if entry.available]
    details = [
        name
        for name in grabber.selectors.descriptions
        if grabber.selectors.of(name) == (_SELECTOR,) and name not in FILE_ACCESS
    ]
    files = []
    for entry in entries:
        with grabber.exclusive(_RESTORED):
            _select(grabber, _SELECTOR, entry.name)
            modes = grabber.feature(_MODE).entries if grabber.has_feature(_MODE) else ()
            values = {name: grabber.feature(name).value for name in details}
            files.append(
                CameraFile(
                    entry.name,
                    _number(grabber, "FileSize"),
                    tuple(mode.name for mode in modes if mode.available),
                    {name: format_value(value) for name, value in values.items() if value is not None},
                    entry.tooltip,
                )
            )
    return files


def read_file(
    grabber: FrameGrabber,
    name: str,
    *,
    progress: Progress = lambda done, of: None,
    cancelled: threading.Event | None = None,
) -> bytes:
    """Return the bytes of a file.

    Raises UsageError for a name that the camera does not list, CameraFileError if it refuses an operation,
    TransferCancelledError after `cancelled` was set, TransportError if the camera is lost,
    FeatureAccessError for a remote source.
    """
    transfer = _Transfer(grabber, name, "reading", cancelled)
    with transfer.opened("Read"):
        return transfer.receive(progress)


def content_of(path: Path) -> bytes:
    """Return the content of a file on this computer, to be written.

    Raises MissingFileError, LocalFileError, UsageError if it is no regular file or too large.
    """
    try:
        return read_bounded(path, MAX_CONTENT_BYTES, "file for a camera")
    except FileNotFoundError as error:
        raise MissingFileError(f"there is no file {path}") from error
    except OSError as error:
        raise LocalFileError.of(path, "read", error) from error


def write_file(
    grabber: FrameGrabber,
    name: str,
    content: bytes,
    *,
    replace_firmware: bool = False,
    progress: Progress = lambda done, of: None,
    cancelled: threading.Event | None = None,
) -> Written:
    """Replace a file, and read it back if the camera allows that.

    Progress counts the bytes written and those read back, so its total is twice the size. An upload that ends
    early cannot be resumed; the whole file must be written again. Firmware is only replaced with
    `replace_firmware`, as a wrong file or a power cut may leave the camera useless. Raises what `read_file`
    raises; UsageError for firmware, CameraFileError also if the file reads back differently.
    """
    if is_firmware(name) and not replace_firmware:
        raise UsageError(
            f"{name} is firmware: a wrong file, or a power cut while it is written, may leave the camera"
            " useless. Confirm that you want to replace it (--replace-firmware, or replace_firmware=True)"
        )
    transfer = _Transfer(grabber, name, "writing", cancelled)
    total = 2 * len(content)
    with transfer.opened("Write"):
        transfer.send(content, lambda done: progress(done, total))
    if "Read" not in transfer.modes:
        progress(total, total)
        return Written(len(content), verified=False)
    check = _Transfer(grabber, name, "reading back", cancelled)
    with check.opened("Read"):
        found = check.receive(lambda done, of: progress(len(content) + min(done, len(content)), total))
    if found != content:
        raise CameraFileError(
            f"{name} was written, but reads back differently ({len(found)} bytes instead of {len(content)},"
            f" first difference at byte {_first_difference(found, content)}); write it again"
            + (" before the camera loses its power" if is_firmware(name) else ""),
            name,
            "Read",
        )
    return Written(len(content), verified=True)


def delete_file(grabber: FrameGrabber, name: str) -> None:
    """Delete a file. Raises what `write_file` raises; firmware is never deleted."""
    if is_firmware(name):
        raise UsageError(f"{name} is firmware, which is never deleted")
    transfer = _Transfer(grabber, name, "deleting", None)
    with transfer.turn():
        transfer.operate("Delete")


class _Transfer:
    """A transfer of one file: its operation and progress."""

    def __init__(
        self, grabber: FrameGrabber, name: str, doing: str, cancelled: threading.Event | None
    ) -> None:
        _require(grabber)
        if grabber.access is not Access.CONTROL:
            raise UsageError(
                f"{doing} {name}: files need control, and {grabber.info.title} is open for reading"
            )
        names = [entry.name for entry in grabber.feature(_SELECTOR).entries if entry.available]
        if name not in names:
            raise UsageError(f"{grabber.info.title} has no file {name}; it has {', '.join(names)}")
        # A remote camera has no such register; fail before a file is opened in it.
        grabber.register_length(_BUFFER)
        self._grabber = grabber
        self._name = name
        self._doing = doing
        self._cancelled = cancelled or threading.Event()
        self._done = 0
        self.modes: tuple[str, ...] = ()

    @contextmanager
    def turn(self) -> Iterator[None]:
        """Hold the grabber with the file selected."""
        with self._explained(), self._grabber.exclusive(_RESTORED):
            _select(self._grabber, _SELECTOR, self._name)
            yield

    @contextmanager
    def opened(self, mode: str) -> Iterator[None]:
        """Open the file in the camera, and close it after the block in any case."""
        with self.turn():
            if self._grabber.has_feature(_MODE):
                self.modes = tuple(e.name for e in self._grabber.feature(_MODE).entries if e.available)
                _select(self._grabber, _MODE, mode)
            self._open()
        try:
            yield
        except BaseException:
            # The first error is the one that matters; a lost camera closes its files itself.
            with suppress(GrabberError), self.turn():
                self.operate("Close")
            raise
        with self.turn():
            self.operate("Close")

    def _open(self) -> None:
        try:
            self.operate("Open")
        except CameraFileError as error:
            # A program that ended during a transfer left it open; nobody else has control now.
            try:
                self.operate("Close")
            except GrabberError:
                raise error from None
            self.operate("Open")

    def receive(self, progress: Progress) -> bytes:
        """Read to the file's end."""
        content = bytearray()
        with self.turn():
            size = _number(self._grabber, "FileSize")

        def read_block() -> bool:
            wanted = self._block if size is None else min(self._block, size - len(content))
            if wanted <= 0:
                return False
            moved = self._move("Read", wanted)
            content.extend(self._grabber.read_register(_BUFFER, moved))
            self._done = len(content)
            progress(self._done, size or 0)
            if self._done > LARGEST:
                raise CameraFileError(f"{self._name} does not end after {LARGEST} bytes", self._name, "Read")
            # A camera that does not report the size ends its file with a short or an empty block.
            return moved > 0 and (size is not None or moved == wanted)

        self._in_turns(read_block)
        if size is not None and len(content) != size:
            raise CameraFileError(
                f"reading {self._name}: the camera reports {size} bytes and delivered {len(content)}",
                self._name,
                "Read",
            )
        return bytes(content)

    def send(self, content: bytes, progress: Callable[[int], None]) -> None:
        """Write all bytes from the file's beginning."""

        def write_block() -> bool:
            block = content[self._done : self._done + self._block]
            if not block:
                return False
            _select(self._grabber, _OPERATION, "Write")  # FileAccessBuffer may depend on it
            self._grabber.write_register(_BUFFER, block)
            moved = self._move("Write", len(block))
            if moved == 0:
                raise CameraFileError(f"{self._where()}: the camera accepted no byte", self._name, "Write")
            self._done += moved
            progress(self._done)
            return True

        self._in_turns(write_block)

    def operate(self, operation: str) -> None:
        """Run an operation on the selected file. Raises CameraFileError unless it succeeds."""
        _select(self._grabber, _OPERATION, operation)
        self._grabber.execute("FileOperationExecute")
        if not self._grabber.has_feature("FileOperationStatus"):
            return
        status = str(self._grabber.feature("FileOperationStatus").value)
        if status != _SUCCESS:
            raise CameraFileError(
                f"{self._where()}: {operation} ended with FileOperationStatus {status}",
                self._name,
                operation,
                status,
            )

    @property
    def _block(self) -> int:
        """Largest number of bytes in one operation."""
        length = self._grabber.register_length(_BUFFER)
        limit = self._grabber.feature("FileAccessLength").maximum
        return max(1, length if limit is None else min(length, int(limit)))

    def _in_turns(self, move_block: Callable[[], bool]) -> None:
        """Transfer block after block until there is none; other callers get their turn in between."""
        more = True
        while more:
            with self.turn():
                end = time.monotonic() + TURN
                while more and time.monotonic() < end:
                    if self._cancelled.is_set():
                        raise TransferCancelledError(f"{self._where()}: cancelled", self._name)
                    more = move_block()
            time.sleep(0)

    def _move(self, operation: str, length: int) -> int:
        """Run Read or Write at the current position; return the number of bytes moved."""
        _select(self._grabber, _OPERATION, operation)
        _select(self._grabber, "FileAccessOffset", self._done)
        _select(self._grabber, "FileAccessLength", length)
        self.operate(operation)
        moved = _number(self._grabber, "FileOperationResult")
        if moved is None:
            return length
        if not 0 <= moved <= length:
            raise CameraFileError(
                f"{self._where()}: the camera reports {moved} bytes, {length} were requested",
                self._name,
                operation,
            )
        return moved

    @contextmanager
    def _explained(self) -> Iterator[None]:
        """Add the file and the progress of the transfer to each error."""
        try:
            yield
        except FeatureError as error:
            raise CameraFileError(f"{self._where()}: {error}", self._name) from error
        except TransportError as error:
            again = "; it cannot be resumed, write the whole file again" if self._doing == "writing" else ""
            raise type(error)(f"{self._where()}: {error}{again}") from error

    def _where(self) -> str:
        return f"{self._doing} {self._name}" + (f" after {self._done} bytes" if self._done else "")


def _require(grabber: FeatureSource) -> None:
    if not has_files(grabber):
        raise UsageError(f"{grabber.info.title} has no files (no FileAccessControl in its description)")


def _select(grabber: FeatureSource, name: str, value: str | int) -> None:
    if grabber.feature(name).value != value:
        grabber.write_feature(name, value)


def _number(grabber: FeatureSource, name: str) -> int | None:
    """Return an integer feature's value; None if the camera has none."""
    value = grabber.feature(name).value if grabber.has_feature(name) else None
    return int(value) if isinstance(value, int | float) else None


def _first_difference(first: bytes, second: bytes) -> int:
    pairs = zip(first, second, strict=False)
    return next((i for i, (one, other) in enumerate(pairs) if one != other), min(len(first), len(second)))
