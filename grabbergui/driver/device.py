"""What a transport provides: registers, a description, a stream.

GigE Vision, USB3 Vision, GenTL and the simulated camera each implement `Device`; `driver.camera.Camera`
turns any of them into a `FrameGrabber`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from grabbergui.core.frame import Frame
from grabbergui.core.grabber import Access, DeviceInfo, StreamStatistics


class DataLayout(Enum):
    """How chunks lie behind a picture in the payload, and events in the messages that carry them."""

    GIGE_VISION = "GigE Vision"
    USB3_VISION = "USB3 Vision"


@dataclass(frozen=True)
class StreamRequest:
    """What the stream must be ready for before the camera is told to send."""

    payload_size: int
    "Bytes of the largest payload (feature PayloadSize), chunks included."
    deliver_incomplete: bool = False
    "Whether frames with missing packets are delivered (with their status) or only counted."


class Device(ABC):
    """One camera on one transport. Registers are addressed in bytes; their content is as on the device.

    Register calls may come from any thread and are serialised by the caller (`Camera`); stream callbacks
    run on the device's own receiving thread.
    """

    info: DeviceInfo

    on_lost: Callable[[str], None] | None = None
    """Called once, from any thread, when the device vanished or our control was taken; says why."""

    on_event: Callable[[int, bytes], None] | None = None
    """Called on any thread with (event id, the message that carried it) for each event; returns at once."""

    chunk_layout: DataLayout | None = None
    """Of the payloads it delivers; None where it has no chunks, or reads them itself."""

    event_layout: DataLayout | None = None
    """Of the messages that `on_event` gets: one event each, its header included; None where it has none."""

    take_over = False
    """Whether `open` may take control from a program that offers it; most transports know no such offer."""

    @abstractmethod
    def open(self, access: Access) -> Access:
        """Connect and return what was granted; CONTROL or MONITOR is asked for, see `take_over`.

        A device object stands for one camera: opened again, it is the same unit (`core.identity`), or
        OtherCameraError names the one that answers. Raises SourceNotFoundError, AccessDeniedError (control
        asked for, held by another), TransportError.
        """

    @abstractmethod
    def close(self) -> None:
        """Release control and sockets or handles. May be called twice; never raises."""

    @abstractmethod
    def read(self, address: int, length: int) -> bytes:
        """Exactly `length` bytes. Raises DeviceStatusError, AckTimeoutError, DeviceLostError."""

    @abstractmethod
    def write(self, address: int, data: bytes) -> None:
        """Write all of `data`. Raises as `read`; AccessDeniedError without control."""

    @abstractmethod
    def description(self) -> bytes:
        """The GenICam XML, unzipped, as the device stores it (junk before `<?xml` included)."""

    def open_events(self) -> None:  # noqa: B027 - most transports need nothing
        """Get ready to hear events, before one is switched on. May be called again; raises as `write`."""

    @abstractmethod
    def open_stream(self, request: StreamRequest, deliver: Callable[[Frame], None]) -> None:
        """Get ready to receive; `deliver` is called on the receiving thread and returns at once.

        Called before AcquisitionStart. Counters start anew.
        """

    @abstractmethod
    def close_stream(self) -> None:
        """Stop receiving; called after AcquisitionStop. `deliver` is not called any more on return."""

    @abstractmethod
    def stream_statistics(self) -> StreamStatistics:
        """A snapshot of the counters of the current or the last stream. Any thread; never waits."""
