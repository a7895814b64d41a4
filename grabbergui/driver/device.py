"""The interface of a transport (registers, description, stream), and code that transports share.

GigE Vision, USB3 Vision, GenTL and the simulated camera each implement `Device`; `driver.camera.Camera`
combines any of them with a node map into a `FrameGrabber`.

A URL names the description: `Local:name.zip;address;length` in the device's memory (numbers in hexadecimal),
or `File:` on this host. Data from a device is not trusted: sizes are checked before anything is read, and
files are read only below a folder that the user chose.
"""

from __future__ import annotations

import io
import logging
import os
import re
import struct
import threading
import zipfile
import zlib
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from enum import Enum
from pathlib import Path
from typing import Protocol
from urllib.parse import unquote, urlsplit
from xml.parsers import expat

from grabbergui.core.errors import (
    DeviceLostError,
    GrabberError,
    RemoteProtocolError,
    TransportError,
    UsageError,
)
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import RateMeter, StreamStatistics
from grabbergui.core.grabber import Access
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.regular_files import read_bounded

log = logging.getLogger(__name__)


class DataLayout(Enum):
    """Layout of the chunks behind an image in the payload, and of event messages."""

    GIGE_VISION = "GigE Vision"
    USB3_VISION = "USB3 Vision"


@dataclass(frozen=True)
class StreamRequest:
    """Parameters of a stream, fixed before the camera starts to send."""

    payload_size: int
    "Bytes of the largest payload (feature PayloadSize), chunks included."
    deliver_incomplete: bool = False
    "Whether frames with missing packets are delivered (with their status) or only counted."
    big_endian_pixels: bool | None = None
    "Byte order of pixels with more than 8 bits by the camera's own feature; None if it has none."


class Stream(Protocol):
    """Receives from its construction until it is closed."""

    def close(self) -> None:
        """Stop. Nothing is delivered after return."""

    def statistics(self) -> StreamStatistics:
        """Return a snapshot of the counters. Any thread."""


class Device(ABC):
    """One camera on one transport. Registers are addressed in bytes; their content is as on the device.

    The exception are cameras whose description declares another byte order than they have: see
    `use_description`.

    Register calls may come from any thread and are serialised by the caller (`Camera`); stream callbacks
    run on the device's own receiving thread.
    """

    on_lost: Callable[[str], None] | None = None
    """Called once, from any thread, with the reason, when the device is gone or has lost us as controller."""

    on_held: Callable[[bool], None] | None = None
    """Called from any thread during read-only access with whether an application has control: at first, and
    when that changes. Only some transports can."""

    on_event: Callable[[int, bytes], None] | None = None
    """Called on any thread with each event's id and the message that carried it; must not wait."""

    chunk_layout: DataLayout | None = None
    """Chunk layout of the payloads; None if the transport has no chunks or reads them itself."""

    event_layout: DataLayout | None = None
    """Layout of the messages for `on_event`, which hold one event with its header; None without events."""

    description_file = ""
    """A file to read the description from, instead of the camera; see `driver.description_files`."""

    take_over = False
    """Whether `open` may take control from a program that offers it; only some transports can."""

    interrupted = False
    """Set by `interrupt`; cleared before an `open` that is wanted."""

    def __init__(self, info: DeviceInfo) -> None:
        self.info = info
        self.lost = ""
        "Reason for the loss of the camera; empty while it is connected. Each `open` clears it."
        self._reporting = threading.Lock()
        "Protects `lost`: the stream and a register access may detect a loss at the same time."
        self._receiving: Stream | None = None
        self._last_statistics = StreamStatistics()

    def interrupt(self) -> None:
        """Let an `open` in progress on another thread, and the next one, fail soon. Any thread; never waits.

        A transport that waits for answers of an absent camera checks `interrupted` meanwhile.
        """
        self.interrupted = True

    @abstractmethod
    def open(self, access: Access) -> Access:
        """Connect with CONTROL or MONITOR access and return what was granted; see `take_over`.

        A device object represents one camera: when it is reopened and another unit answers
        (`core.identity`), OtherCameraError names that one. Raises SourceNotFoundError, AccessDeniedError
        (another application has control), TransportError.
        """

    @abstractmethod
    def close(self) -> None:
        """Release control and sockets or handles. May be called twice; never raises."""

    @abstractmethod
    def read(self, address: int, length: int) -> bytes:
        """Return exactly `length` bytes. Raises DeviceStatusError, AckTimeoutError, DeviceLostError."""

    @abstractmethod
    def write(self, address: int, data: bytes) -> None:
        """Write all of `data`. Raises as `read`; AccessDeniedError without control."""

    @abstractmethod
    def description(self) -> bytes:
        """Return the GenICam XML, unzipped, as the device stores it (junk before `<?xml` included)."""

    def use_description(self, xml: str) -> None:  # noqa: B027 - most transports have one order of bytes
        """Read and write registers as this description means it; called before the first of its registers is.

        `xml` is the text of the description, of its own or from a file.
        """

    def bootstrap_registers(self) -> list[tuple[str, int, int]]:
        """Return name, address and length of registers with addresses in the transport's standard.

        For reports; of an open device, which may lack some of them.
        """
        return []

    def open_events(self) -> None:  # noqa: B027 - most transports need nothing
        """Prepare to receive events, before the first is enabled. May be called again; raises as `write`."""

    @abstractmethod
    def open_stream(self, request: StreamRequest, deliver: Callable[[Frame], None]) -> None:
        """Prepare to receive; `deliver` is called on the receiving thread and must not wait.

        Called before AcquisitionStart. Resets the counters.
        """

    def close_stream(self) -> None:
        """Stop receiving; called after AcquisitionStop. `deliver` is not called after return."""
        stream = self._receiving
        if stream is not None:
            stream.close()
            self._last_statistics = replace(stream.statistics(), frame_rate=0.0, bandwidth=0.0)
            self._receiving = None

    def stream_statistics(self) -> StreamStatistics:
        """Return a snapshot of the current or last stream's counters. Any thread; never waits."""
        stream = self._receiving
        return stream.statistics() if stream is not None else replace(self._last_statistics)

    def silence(self) -> str:
        """Return why no frames arrive, as display text; empty while they do, and if unknown.

        Any thread; never waits for the camera.
        """
        return ""

    def report_event(self, event_id: int, message: bytes) -> None:
        """Pass an event to `on_event`. Any thread."""
        if self.on_event is not None:
            self.on_event(event_id, message)

    def report_lost(self, reason: str) -> None:
        """Note that an open camera is lost, and call `on_lost` the first time. Any thread."""
        with self._reporting:
            if self.lost:
                return
            self.lost = reason
        if self.on_lost is not None:
            self.on_lost(reason)


MAX_PAYLOAD_BYTES = 1 << 30
"Largest payload of a frame; a camera that announces more is faulty."


def check_payload_size(size: int) -> None:
    """Raise TransportError for a size of payloads that no stream can be opened for."""
    if not 0 < size <= MAX_PAYLOAD_BYTES:
        raise TransportError(f"the camera announces frames of {size} bytes; check PayloadSize")


FARTHEST_BLOCK = 10_000
"Steps between the ids of two blocks; a camera with a larger gap has restarted its ids."


def lost_between(steps: int) -> int:
    """Return how many blocks were lost between two whose ids are `steps` apart."""
    return steps - 1 if 1 < steps <= FARTHEST_BLOCK else 0


class FrameCounter:
    """Counts the frames of a stream. One thread counts."""

    def __init__(self) -> None:
        self.counts = StreamStatistics()
        "The rates in it stay 0; see `statistics`."
        self._rate = RateMeter()
        self._last_id: int | None = None

    def note_id(self, frame_id: int) -> None:
        """Count the frames that were lost before this one."""
        if self._last_id is not None:
            self.counts.lost += lost_between(frame_id - self._last_id)
        self._last_id = frame_id

    def note_complete(self, size: int) -> None:
        """Count a complete frame of `size` bytes."""
        self.counts.frames += 1
        self.counts.bytes += size
        self._rate.add(size)

    def statistics(self) -> StreamStatistics:
        """Return a snapshot with the current rates. Any thread."""
        return self.counts.snapshot(self._rate)


def deliver_or_log(deliver: Callable[[Frame], None], frame: Frame) -> None:
    """Deliver a frame; log the failure of a consumer, which must not end the stream."""
    try:
        deliver(frame)
    except Exception:
        log.exception("a consumer of frames failed")


def with_texts(info: DeviceInfo, texts: Mapping[str, str]) -> DeviceInfo:
    """Return `info` with the texts of a camera's registers, except those that are empty."""
    return replace(info, **{name: text for name, text in texts.items() if text})


# -- the description that a camera names ---------------------------------------------------------
MAX_STORED_BYTES = 16 << 20
"Size limit of a description in a device's memory or in a file."
FOLDER_VARIABLE = "GRABBERGUI_DESCRIPTIONS"
"Environment variable: the folder below which `File:` descriptions may be read."

_LOCAL = re.compile(
    r"local:/*(?P<name>[^;]*);\s*(?:0x)?(?P<address>[0-9a-f]{1,16})\s*;\s*(?:0x)?(?P<length>[0-9a-f]{1,16})\s*(?:\?.*)?$",
    re.IGNORECASE,
)


@dataclass(frozen=True)
class LocalFile:
    """A description in the device's own memory."""

    name: str
    address: int
    length: int
    "Bytes."


def parse_url(url: str) -> LocalFile | Path:
    """Parse a URL register. Raises RemoteProtocolError for a URL that cannot be read."""
    if match := _LOCAL.match(url.strip()):
        length = int(match["length"], 16)
        if not 0 < length <= MAX_STORED_BYTES:
            raise RemoteProtocolError(
                f"'{url}' announces {length} bytes, at most {MAX_STORED_BYTES} are read"
            )
        return LocalFile(match["name"].strip(), int(match["address"], 16), length)
    if url.strip().lower().startswith("file:"):
        try:
            path = unquote(urlsplit(url.strip()).path)
        except ValueError as error:  # "File://[" begins an IPv6 address that never ends
            raise RemoteProtocolError(f"'{url}' is no URL: {error}") from error
        if "\0" in path:
            raise RemoteProtocolError(f"'{url}' has a zero byte in its path")
        return Path(path)
    raise RemoteProtocolError(f"the camera names its description '{url}'; only Local: and File: can be read")


def fetch_description(urls: Iterable[str], read: Callable[[int, int], bytes]) -> bytes:
    """Return the XML behind the first URL that works; `read(address, length)` reads the device's memory.

    Raises TransportError with the problem of each URL.
    """
    problems = []
    for url in urls:
        if not url:
            continue
        try:
            return _fetch(parse_url(url), read)
        except DeviceLostError:
            raise
        except (GrabberError, OSError) as error:
            log.info("description at '%s': %s", url, error)
            problems.append(f"{url}: {error}")
    reasons = "; ".join(problems) or "its URL registers are empty"
    raise TransportError(f"the camera's description cannot be read: {reasons}")


def _fetch(location: LocalFile | Path, read: Callable[[int, int], bytes]) -> bytes:
    if isinstance(location, LocalFile):
        return unpack(read(location.address, location.length))
    return unpack(_read_file(location))


def _read_file(path: Path) -> bytes:
    """Read a regular file below the user's folder. Raises RemoteProtocolError for others, OSError."""
    folder = os.environ.get(FOLDER_VARIABLE)
    if not folder:
        raise RemoteProtocolError(
            f"the camera names {path}, a file of this computer; "
            f"if you trust it, set {FOLDER_VARIABLE} to its folder"
        )
    path = path.resolve()
    if not path.is_relative_to(Path(folder).resolve()):
        raise RemoteProtocolError(f"{path} is not below {folder}, the folder that {FOLDER_VARIABLE} names")
    try:
        return read_bounded(path, MAX_STORED_BYTES, "description")
    except UsageError as error:
        raise RemoteProtocolError(str(error)) from error


MAX_XML_BYTES = 64 << 20
"Size limit of an unzipped description; the largest known are below 4 MiB."
_ZIP_SIGNATURE = b"PK\3\4"
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
"The methods that GenICam allows. For others zipfile does not bound what one read may unpack."


def unpack(stored: bytes) -> bytes:
    """Return the XML of a stored description, unzipped if it is a ZIP archive, without trailing zeros.

    Raises RemoteProtocolError for a damaged archive, one without XML, or one beyond MAX_XML_BYTES.
    """
    if not stored.startswith(_ZIP_SIGNATURE):
        return stored.rstrip(b"\0")
    try:
        with zipfile.ZipFile(io.BytesIO(stored)) as archive:
            names = [name for name in archive.namelist() if name.lower().endswith(".xml")]
            if not names:
                raise RemoteProtocolError("the zipped description holds no .xml file")
            method = archive.getinfo(names[0]).compress_type
            if method not in _METHODS:
                raise RemoteProtocolError(
                    f"the zipped description is compressed by method {method}; GenICam has only deflate (8)"
                )
            try:
                with archive.open(names[0]) as member:
                    # The sizes in the archive may be false, so count the bytes that come out.
                    xml = member.read(MAX_XML_BYTES + 1)
            except zipfile.BadZipFile as error:
                xml = _without_checksum(stored, archive.getinfo(names[0]))
                if not parses(xml):
                    raise
                log.warning("the zipped description has a wrong checksum but parses: %s", error)
    # zipfile raises RuntimeError for encryption and unknown versions, ValueError for impossible offsets.
    except (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, ValueError) as error:
        raise RemoteProtocolError(f"the zipped description is damaged: {error}") from error
    if len(xml) > MAX_XML_BYTES:
        raise RemoteProtocolError(f"the zipped description grows beyond {MAX_XML_BYTES} bytes")
    return xml.rstrip(b"\0")


_LOCAL_HEADER = struct.Struct("<26xHH")
"Header of a member of an archive, up to the lengths of its name and of its extra field."


def _without_checksum(stored: bytes, member: zipfile.ZipInfo) -> bytes:
    """Return a member of an archive whose CRC need not fit; at most MAX_XML_BYTES and one more.

    Raises RemoteProtocolError, zlib.error.
    """
    if len(stored) < member.header_offset + _LOCAL_HEADER.size:
        raise RemoteProtocolError("the zipped description is cut off")
    name, extra = _LOCAL_HEADER.unpack_from(stored, member.header_offset)
    begin = member.header_offset + _LOCAL_HEADER.size + name + extra
    packed = stored[begin : begin + member.compress_size]
    if member.compress_type == zipfile.ZIP_STORED:
        return packed
    return zlib.decompressobj(-zlib.MAX_WBITS).decompress(packed, MAX_XML_BYTES + 1)


def parses(xml: bytes) -> bool:
    """Return whether bytes are a well-formed document without entities of its own."""
    if len(xml) > MAX_XML_BYTES or b"<!ENTITY" in xml:
        return False
    try:
        expat.ParserCreate().Parse(xml[max(xml.find(b"<"), 0) :].rstrip(b"\0"), True)
    except expat.ExpatError:
        return False
    return True
