"""The file of a camera's report: a ZIP archive of JSON, the description, and the log.

`grabbergui.report` writes it; `twin:` sources read it. The members have fixed names, described in
docs/camera-report.md. A report that is read comes from a stranger: only members of these names are unpacked,
each up to a limit, and every value is checked.
"""

from __future__ import annotations

import io
import json
import math
import zipfile
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from grabbergui.core.errors import UsageError
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.json_text import to_json
from grabbergui.core.regular_files import read_bounded
from grabbergui.driver.description import MAX_XML_BYTES
from grabbergui.driver.device import DataLayout

FORMAT = "grabbergui camera report"
VERSION = 1

MAX_FILE_BYTES = 128 << 20
"Size limit of a report that is read."
MAX_MEMBER_BYTES = 16 << 20
"Size limit of an unpacked member that is read, but description and pixels."
MAX_PIXEL_BYTES = 64 << 20
"Size limit of all frames whose pixels a report keeps."
MOST_ACCESSES = 100_000
"Registers, and accesses during the stream."
MOST_FRAMES = 1000
LONGEST_READ = 16 << 20
"Bytes of one register."

README, CAMERA, REGISTERS, STREAM, COMPUTER = (
    "README.txt",
    "camera.json",
    "registers.json",
    "stream.json",
    "computer.json",
)
DESCRIPTION, LOG = "description.xml", "log.txt"
PIXELS = "pixels/{:03}.bin"
MOST_PIXELS = 16
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
Row = TypeVar("Row")
_LARGEST_SIDE = 1 << 20
"Pixels of a frame's width or height."


@dataclass(frozen=True)
class RecordedAccess:
    """One read or write of registers, with its outcome."""

    address: int
    length: int
    data: bytes | None = None
    "As on the device; None for a read that failed."
    milliseconds: float = 0.0
    "From the request to the answer."
    failure: str = ""
    "Name of the error's class; empty if it succeeded."
    status: int = 0
    "The device's status code, if it answered with one."
    message: str = ""
    "The error's text."
    name: str = ""
    "The register's name in the description, or in the standard."
    written: bool = False
    "Whether it was a write."

    @property
    def end(self) -> int:
        """The address behind the last byte."""
        return self.address + self.length


@dataclass(frozen=True)
class FrameRecord:
    """A frame's headers and times."""

    frame_id: int
    timestamp_ns: int
    received_ns: int
    width: int
    height: int
    pixel_format: int
    "PFNC code."
    payload_bytes: int
    payload_type: str = ""
    complete: bool = True
    missing_bytes: int = 0
    offset_x: int = 0
    offset_y: int = 0
    padding_x: int = 0
    big_endian: bool = False
    stream_channel: int = 0
    components: int = 0
    chunks: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class PacketTest:
    """Whether a test packet of this size arrived."""

    size: int
    "Bytes of the IP datagram."
    arrived: bool


@dataclass(frozen=True)
class StreamRecord:
    """A short stream: its frames without pixels, and its counters."""

    frames: tuple[FrameRecord, ...] = ()
    statistics: Mapping[str, Any] = field(default_factory=dict)
    packet_tests: tuple[PacketTest, ...] = ()
    accesses: tuple[RecordedAccess, ...] = ()
    "Reads and writes from the packet tests to the end of the stream, in their order."
    started: bool = False


@dataclass(frozen=True)
class CameraReport:
    """Everything in a report."""

    info: DeviceInfo
    chunk_layout: DataLayout | None = None
    event_layout: DataLayout | None = None
    little_endian: bool = False
    "Whether a GigE Vision camera says that its memory is little-endian."
    numbers: bool = False
    "Whether aligned words were read as numbers, by READREG, and are big-endian here whatever the memory is."
    description: bytes = b""
    "As the device's, unzipped; empty if it could not be read."
    registers: tuple[RecordedAccess, ...] = ()
    bootstrap: tuple[RecordedAccess, ...] = ()
    "Registers with addresses in the transport's standard."
    stream: StreamRecord = field(default_factory=StreamRecord)
    features: tuple[Mapping[str, Any], ...] = ()
    problems: tuple[str, ...] = ()
    "Steps of the report that failed, and why."
    made: Mapping[str, Any] = field(default_factory=dict)
    "Time, versions, and whether names are kept."
    computer: Mapping[str, Any] = field(default_factory=dict)
    "Findings of `doctor`, interfaces, answers to discovery."
    log: str = ""
    readme: str = ""
    pixels: tuple[bytes, ...] = ()
    "Payloads of the first frames; only on request."

    @property
    def scheme(self) -> str:
        """The kind of source that it was made from."""
        return self.info.uri.partition(":")[0]


def encode(report: CameraReport) -> bytes:
    """Return the file's content."""
    stream = report.stream
    members: dict[str, str | bytes] = {
        README: report.readme,
        CAMERA: _json(
            {
                "format": FORMAT,
                "version": VERSION,
                "made": report.made,
                "info": report.info.as_dict(),
                "chunk_layout": report.chunk_layout and report.chunk_layout.value,
                "event_layout": report.event_layout and report.event_layout.value,
                "little_endian": report.little_endian,
                "numbers": report.numbers,
                "problems": report.problems,
                "features": report.features,
            }
        ),
        REGISTERS: _json(
            {"bootstrap": _rows(report.bootstrap), "registers": _rows(report.registers)},
        ),
        STREAM: _json(
            {
                "started": stream.started,
                "statistics": stream.statistics,
                "packet_tests": [vars(test) for test in stream.packet_tests],
                "frames": [vars(frame) for frame in stream.frames],
                "accesses": _rows(stream.accesses),
            }
        ),
        COMPUTER: _json(report.computer),
        LOG: report.log,
    }
    if report.description:
        members[DESCRIPTION] = report.description
    for index, payload in enumerate(report.pixels[:MOST_PIXELS]):
        members[PIXELS.format(index)] = payload
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as opened:
        for name, content in members.items():
            opened.writestr(name, content)
    return archive.getvalue()


def _json(content: Any) -> str:
    return to_json(_finite(content), indent=1, ascii_only=False)


def _finite(content: Any) -> Any:
    """Return the content as JSON has it: numbers that are none become text."""
    if isinstance(content, float) and not math.isfinite(content):
        return str(content)
    if isinstance(content, Mapping):
        return {str(key): _finite(value) for key, value in content.items()}
    if isinstance(content, list | tuple):
        return [_finite(value) for value in content]
    if content is None or isinstance(content, str | int | float | bool):
        return content
    return str(content)


def _rows(accesses: tuple[RecordedAccess, ...]) -> list[dict[str, Any]]:
    return [_row(access) for access in accesses]


def _row(access: RecordedAccess) -> dict[str, Any]:
    row: dict[str, Any] = {"address": f"0x{access.address:X}", "length": access.length}
    if access.name:
        row["name"] = access.name
    if access.written:
        row["written"] = True
    if access.data is not None:
        row["data"] = access.data.hex()
    if access.failure:
        row |= {"failure": access.failure, "status": access.status, "message": access.message}
    return {**row, "ms": round(access.milliseconds, 3)}


def load(path: Path) -> CameraReport:
    """Read a report. Raises UsageError for a file that is none or beyond the limits, and OSError."""
    return decode(read_bounded(path, MAX_FILE_BYTES, "camera report"), str(path))


def decode(content: bytes, name: str = "the file") -> CameraReport:
    """Parse a report. Raises UsageError."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            return _decode(_Members(archive))
    except UsageError as error:
        raise UsageError(f"{name} cannot be read as a camera report: {error}") from error
    # zipfile raises RuntimeError for encryption, NotImplementedError (one) for unknown methods.
    except (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, ValueError, OverflowError) as error:
        raise UsageError(f"{name} is no camera report, or is damaged: {error}") from error
    except (KeyError, TypeError, AttributeError, IndexError) as error:
        raise UsageError(f"{name} is no complete camera report: {type(error).__name__} {error}") from error


class _Members:
    """Unpacks members of an archive, each within its limit."""

    def __init__(self, archive: zipfile.ZipFile) -> None:
        self._archive = archive
        self._names = frozenset(archive.namelist())

    def content(self, name: str, most: int | None = None) -> bytes | None:
        """Return a member; None without it. Raises UsageError beyond `most` bytes (MAX_MEMBER_BYTES)."""
        most = MAX_MEMBER_BYTES if most is None else most
        if name not in self._names:
            return None
        if self._archive.getinfo(name).compress_type not in _METHODS:
            raise UsageError(f"{name} is compressed by an unusual method")
        with self._archive.open(name) as member:
            # The sizes in the archive may be false, so count the bytes that come out.
            content = member.read(most + 1)
        if len(content) > most:
            raise UsageError(f"{name} has more than {most} bytes")
        return content

    def json(self, name: str) -> dict[str, Any]:
        """Return a member's JSON object; empty without it."""
        content = self.content(name)
        parsed = json.loads(content.decode("utf-8")) if content is not None else {}
        if not isinstance(parsed, dict):
            raise UsageError(f"{name} is no JSON object")
        return parsed


def _decode(members: _Members) -> CameraReport:
    camera = members.json(CAMERA)
    if camera.get("format") != FORMAT:
        raise UsageError(f"it has no {CAMERA} of a camera report; `grabbergui report SOURCE` makes one")
    if camera.get("version") != VERSION:
        raise UsageError(f"its version is {camera.get('version')!r}; this program reads version {VERSION}")
    registers, stream = members.json(REGISTERS), members.json(STREAM)
    return CameraReport(
        info=DeviceInfo(**{name: _text(value) for name, value in dict(camera["info"]).items()}),
        chunk_layout=_layout(camera.get("chunk_layout")),
        event_layout=_layout(camera.get("event_layout")),
        little_endian=bool(camera.get("little_endian")),
        numbers=bool(camera.get("numbers")),
        description=members.content(DESCRIPTION, MAX_XML_BYTES) or b"",
        registers=_list(registers, "registers", MOST_ACCESSES, _access),
        bootstrap=_list(registers, "bootstrap", MOST_ACCESSES, _access),
        stream=StreamRecord(
            frames=_list(stream, "frames", MOST_FRAMES, _frame),
            statistics=dict(stream.get("statistics", {})),
            packet_tests=_list(
                stream,
                "packet_tests",
                MOST_FRAMES,
                lambda row: PacketTest(_whole(row["size"], 0xFFFF), bool(row["arrived"])),
            ),
            accesses=_list(stream, "accesses", MOST_ACCESSES, _access),
            started=bool(stream.get("started")),
        ),
        features=_list(camera, "features", MOST_ACCESSES, dict),
        problems=_list(camera, "problems", MOST_FRAMES, _text),
        made=dict(camera.get("made", {})),
        computer=members.json(COMPUTER),
        log=(members.content(LOG) or b"").decode("utf-8", "replace"),
        pixels=tuple(_pixels(members)),
    )


def _pixels(members: _Members) -> list[bytes]:
    found: list[bytes] = []
    for index in range(MOST_PIXELS):
        left = MAX_PIXEL_BYTES - sum(map(len, found))
        if content := members.content(PIXELS.format(index), left):
            found.append(content)
    return found


def _list(content: Mapping[str, Any], name: str, most: int, read: Callable[[Any], Row]) -> tuple[Row, ...]:
    rows = content.get(name, [])
    if not isinstance(rows, list) or len(rows) > most:
        raise UsageError(f"'{name}' is no list of at most {most} entries")
    return tuple(map(read, rows))


def _access(row: Mapping[str, Any]) -> RecordedAccess:
    data = bytes.fromhex(row["data"]) if "data" in row else None
    length = _whole(row["length"], LONGEST_READ)
    if data is not None and len(data) != length:
        raise UsageError(f"the register at {row['address']!r} has {len(data)} bytes instead of {length}")
    if data is None and not row.get("failure"):
        raise UsageError(f"the register at {row['address']!r} has neither data nor a failure")
    return RecordedAccess(
        address=_whole(int(row["address"], 16), (1 << 64) - 1 - length),
        length=length,
        data=data,
        milliseconds=_number(row.get("ms", 0.0)),
        failure=_text(row.get("failure", "")),
        status=_whole(row.get("status", 0), 0xFFFFFFFF),
        message=_text(row.get("message", "")),
        name=_text(row.get("name", "")),
        written=bool(row.get("written", False)),
    )


def _frame(row: Mapping[str, Any]) -> FrameRecord:
    return FrameRecord(
        frame_id=_whole(row["frame_id"], (1 << 64) - 1),
        timestamp_ns=_whole(row["timestamp_ns"], (1 << 63) - 1),
        received_ns=_whole(row["received_ns"], (1 << 63) - 1),
        width=_whole(row["width"], _LARGEST_SIDE),
        height=_whole(row["height"], _LARGEST_SIDE),
        pixel_format=_whole(row["pixel_format"], 0xFFFFFFFF),
        payload_bytes=_whole(row["payload_bytes"], 1 << 30),
        payload_type=_text(row.get("payload_type", "")),
        complete=bool(row.get("complete", True)),
        chunks=dict(row.get("chunks", {})),
    )


def _whole(value: Any, most: int) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value <= most:
        raise UsageError(f"{value!r} is no whole number from 0 to {most}")
    return value


def _number(value: Any) -> float:
    number = float(value)
    if not 0 <= number < 1e9:
        raise UsageError(f"{value!r} is no number of milliseconds")
    return number


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise UsageError(f"{value!r} is no text")
    return value


def _layout(value: Any) -> DataLayout | None:
    return None if value is None else DataLayout(value)
