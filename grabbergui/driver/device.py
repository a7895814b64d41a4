"""The interface of a transport (registers, description, stream), and code that transports share.

GigE Vision, USB3 Vision, GenTL and the simulated camera each implement `Device`; `DeviceGrabber`
combines any of them with a node map into a `FrameGrabber`.
"""

from __future__ import annotations

import logging
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from enum import Enum
from typing import Protocol

from grabbergui.core.errors import TransportError
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import RateMeter, StreamStatistics
from grabbergui.core.grabber import Access
from grabbergui.core.identity import DeviceInfo

log = logging.getLogger(__name__)

MAX_PAYLOAD_BYTES = 1 << 30
"Largest payload of a frame; a camera that announces more is faulty."
FARTHEST_BLOCK = 10_000
"Steps between the ids of two blocks; a camera with a larger gap has restarted its ids."


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


class DeviceStream(Protocol):
    """Receives from its construction until it is closed."""

    def close(self) -> None:
        """Stop. Nothing is delivered after return."""

    def statistics(self) -> StreamStatistics:
        """Return a snapshot of the counters. Any thread."""


class Device(ABC):
    """One camera on one transport. Registers are addressed in bytes; their content is as on the device.

    The exception are cameras whose description declares another byte order than they have: see
    `use_description`.

    Register calls may come from any thread and are serialised by the caller (`DeviceGrabber`); stream
    callbacks run on the device's own receiving thread.
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
        self._receiving: DeviceStream | None = None
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


def check_payload_size(size: int) -> None:
    """Raise TransportError for a size of payloads that no stream can be opened for."""
    if not 0 < size <= MAX_PAYLOAD_BYTES:
        raise TransportError(f"the camera announces frames of {size} bytes; check PayloadSize")


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
