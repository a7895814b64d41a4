"""A video device behind the registers of its GenICam description, and its stream; `v4l2:` sources.

The URI is `v4l2:` (the first found), `v4l2:/dev/video2`, or has a serial number, a bus or a model's name.
"""

from __future__ import annotations

import logging
import select
import struct
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from grabbergui.core import pfnc
from grabbergui.core.errors import (
    DeviceLostError,
    DeviceStatusError,
    GrabberError,
    SourceNotFoundError,
    TransportError,
)
from grabbergui.core.frame import BufferPool, Frame, FrameStatus, time_of_day
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.identity import DeviceInfo, require_one, require_same, unit
from grabbergui.core.uri import NoOptions, SourceUri, read_options
from grabbergui.driver.device import Device, FrameCounter, StreamRequest, deliver_or_log
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.v4l2 import description as layout
from grabbergui.driver.v4l2.description import (
    COMPRESSED,
    PFNC_NAMES,
    REGISTERS,
    TEXT_BYTES,
    TEXTS,
    WebcamDescription,
)
from grabbergui.driver.v4l2.finding import find
from grabbergui.driver.v4l2.video import ControlKind, CurrentFormat, Filled, FrameSizes, VideoDevice

log = logging.getLogger(__name__)


if sys.platform != "linux":
    raise ImportError("Video4Linux is a part of Linux")


BUFFERS = 8
"Number of mapped buffers. Frames are copied out of them, so that consumers may keep frames."
_INTEGER = struct.Struct("<q")
_DOUBLE = struct.Struct("<d")
_STOP_PERIOD = 0.1
"Seconds after which the receiving thread checks whether it should end."
_WIDEST_RATES = (0.1, 1000.0)
"Hz; limits for drivers that do not list their frame rates."
_NAMES = {address: name for name, address in REGISTERS.items()}


class V4l2Device(Device):
    """A webcam as a GenICam device."""

    def __init__(
        self, name: str, info: DeviceInfo, opener: Callable[[str], VideoDevice] = VideoDevice
    ) -> None:
        """`name`: a path, a serial number, a bus or a model's name; empty means the first found."""
        super().__init__(info)
        self._name = name
        self._opener = opener
        self._video: VideoDevice | None = None
        self._layout = WebcamDescription(b"")
        self._known: DeviceInfo | None = None
        self._locked = 0

    @override
    def open(self, access: Access) -> Access:
        info = self._found()
        video = self._opener(info.address)
        try:
            formats = [code for code in video.formats() if code in PFNC_NAMES]
            current = video.format().fourcc
            # Open the device even if another program left it in a format that we cannot show.
            shown = current if current in formats else next(iter(formats), "")
            sizes = video.sizes(shown) if shown else FrameSizes()
            self._layout = layout.describe(info.model, formats, sizes, video.controls())
        except BaseException:
            video.close()
            raise
        self._video, self._known, self.lost = video, info, ""
        self.info = replace(info, uri=self.info.uri)
        return access

    def _found(self) -> DeviceInfo:
        present = find()
        candidates = [info for info in present if _answers_to(info, self._name)]
        if self._known is not None:
            same = [info for info in candidates if unit(info) == unit(self._known)]
            if candidates and not same:
                require_same(self._known, candidates[0])
            candidates = same
        if self._name:
            require_one(self._name, candidates)
        if candidates:
            return candidates[0]
        there = ", ".join(info.address for info in present) or "none"
        wanted = f"video device '{self._name}'" if self._name else "video device"
        raise SourceNotFoundError(f"there is no {wanted}; found: {there}")

    @override
    def close(self) -> None:
        self.close_stream()
        video, self._video = self._video, None
        if video is not None:
            video.close()

    @override
    def description(self) -> bytes:
        return self._layout.xml

    @override
    def read(self, address: int, length: int) -> bytes:
        for name, place in TEXTS.items():
            if address == place:
                return self._texts()[name].encode()[: TEXT_BYTES - 1].ljust(TEXT_BYTES, b"\0")[:length]
        with self._detecting_loss():
            return self._read(address)[:length]

    def _read(self, address: int) -> bytes:
        video = self._opened()
        if address in self._layout.controls:
            control = self._layout.controls[address]
            button = control.kind is ControlKind.BUTTON
            return _INTEGER.pack(0 if button else video.control(control.id))
        if address - 8 in self._layout.controls:
            return _INTEGER.pack(video.locked(self._layout.controls[address - 8].id))
        name = _NAMES.get(address, "")
        if name in ("AcquisitionFrameRate", "FrameRateMin", "FrameRateMax"):
            return _DOUBLE.pack(self._rate(name))
        return _INTEGER.pack(self._value(name, address))

    @override
    def write(self, address: int, data: bytes) -> None:
        with self._detecting_loss():
            self._write(address, data)

    def _write(self, address: int, data: bytes) -> None:
        video = self._opened()
        name = _NAMES.get(address, "")
        if name == "AcquisitionFrameRate":
            video.set_rate(_DOUBLE.unpack(data)[0])
            return
        (value,) = _INTEGER.unpack(data)
        if address in self._layout.controls:
            video.set_control(self._layout.controls[address].id, value)
        elif name in ("PixelFormat", "Resolution", "Width", "Height"):
            self._set_format(name, value)
        elif name == "TLParamsLocked":
            self._locked = value
        elif name not in ("AcquisitionStart", "AcquisitionStop", "AcquisitionMode"):
            raise DeviceStatusError(f"there is no register at {address:#x} to write", 0x8003)

    def _set_format(self, name: str, value: int) -> None:
        video = self._opened()
        current = video.format()
        fourcc, width, height = current.fourcc, current.width, current.height
        if name == "PixelFormat":
            fourcc = value.to_bytes(4, "little").decode("ascii")
        elif name == "Resolution":
            width, height = value >> 32, value & 0xFFFFFFFF
        elif name == "Width":
            width = value
        else:
            height = value
        video.set_format(fourcc, width, height)

    def _value(self, name: str, address: int) -> int:
        current = self._opened().format()
        values = {
            "PixelFormat": layout.code_value(current.fourcc),
            "Width": current.width,
            "Height": current.height,
            "Resolution": layout.resolution_value(current.width, current.height),
            "PayloadSize": _payload_bytes(current),
            "TLParamsLocked": self._locked,
            "AcquisitionStart": 0,
            "AcquisitionStop": 0,
            "AcquisitionMode": 0,
        }
        if name not in values:
            raise DeviceStatusError(f"there is no register at {address:#x}", 0x8003)
        return values[name]

    def _rate(self, name: str) -> float:
        video = self._opened()
        if name == "AcquisitionFrameRate":
            return video.rate()
        current = video.format()
        slowest, fastest = video.rates(current.fourcc, current.width, current.height)
        if not fastest:
            slowest, fastest = _WIDEST_RATES
        return slowest if name == "FrameRateMin" else fastest

    def _texts(self) -> dict[str, str]:
        info = self.info
        return {
            "DeviceVendorName": info.vendor,
            "DeviceModelName": info.model,
            "DeviceSerialNumber": info.serial,
            "DeviceVersion": info.version,
            "DeviceID": info.hardware_id,
        }

    def _opened(self) -> VideoDevice:
        if self._video is None:
            raise DeviceLostError(f"{self.info.title} is not open")
        return self._video

    @override
    def open_stream(self, request: StreamRequest, deliver: Callable[[Frame], None]) -> None:
        self._receiving = V4l2Stream(self._opened(), request, deliver, self.report_lost)

    @contextmanager
    def _detecting_loss(self) -> Iterator[None]:
        """Report the loss of a device that was unplugged. Without a stream nothing else notices it."""
        self._opened()
        try:
            yield
        except DeviceLostError as error:
            self.report_lost(str(error))
            raise


def _answers_to(info: DeviceInfo, name: str) -> bool:
    known = (info.address, info.address.removeprefix("/dev/"), info.serial, info.hardware_id, info.model)
    return not name or name.lower() in [text.lower() for text in known if text]


def _payload_bytes(current: CurrentFormat) -> int:
    """Return the size of the largest delivered frame; compressed frames are decoded to BGR8."""
    compressed = current.fourcc in COMPRESSED
    return current.width * current.height * 3 if compressed else current.image_bytes


class V4l2Stream:
    """Takes filled buffers on its own thread, from construction until `close`."""

    def __init__(
        self,
        video: VideoDevice,
        request: StreamRequest,
        deliver: Callable[[Frame], None],
        on_gone: Callable[[str], None],
    ) -> None:
        """Start. Raises AccessDeniedError if another program streams from the device, TransportError."""
        self._video = video
        self._deliver = deliver
        self._on_gone = on_gone
        self._deliver_incomplete = request.deliver_incomplete
        self._format = video.format()
        if self._format.fourcc not in PFNC_NAMES:
            raise TransportError(
                f"{video.path} is set to {self._format.fourcc}, which cannot be shown; choose another"
                " PixelFormat"
            )
        self._pool = BufferPool(max(_payload_bytes(self._format), 1))
        self._counter = FrameCounter()
        self._stopping = threading.Event()
        self._buffers = video.begin(BUFFERS)
        self._thread = threading.Thread(target=self._run, name="v4l2 receiver", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop. Nothing is delivered after return."""
        self._stopping.set()
        self._thread.join()
        self._video.end(self._buffers)

    def statistics(self) -> StreamStatistics:
        """Return a snapshot of the counters. Any thread."""
        return self._counter.statistics()

    def _run(self) -> None:
        poll = select.poll()
        poll.register(self._video.fileno(), select.POLLIN | select.POLLPRI)
        try:
            while not self._stopping.is_set():
                if not poll.poll(_STOP_PERIOD * 1000):
                    continue
                filled = self._video.take()
                if filled is None:
                    continue
                frame = self._frame(filled)
                self._video.queue(filled.index)
                if frame is not None:
                    deliver_or_log(self._deliver, frame)
                del frame
        except (GrabberError, OSError) as error:
            if not self._stopping.is_set():
                self._on_gone(str(error))

    def _frame(self, filled: Filled) -> Frame | None:
        self._counter.note_id(filled.sequence)
        buffer = self._pool.take()
        if buffer is None:
            self._counter.counts.underruns += 1
            return None
        payload = None if filled.damaged or not filled.size else self._payload(filled, buffer)
        if payload is None:
            self._counter.counts.incomplete += 1
            return None
        self._counter.note_complete(payload.nbytes)
        current = self._format
        compressed = current.fourcc in COMPRESSED
        pixel_format = pfnc.by_name("BGR8" if compressed else PFNC_NAMES[current.fourcc])
        line = pixel_format.line_bytes(current.width)
        stamp = filled.timestamp_ns
        frame = Frame(
            payload=payload,
            width=current.width,
            height=current.height,
            pixel_format=pixel_format,
            frame_id=filled.sequence,
            timestamp_ns=stamp,
            received_ns=time.time_ns(),
            status=FrameStatus.COMPLETE,
            padding_x=0 if compressed else max(0, current.line_bytes - line),
        )
        if stamp:
            frame.received_ns, frame.captured = time_of_day(stamp), stamp / 1e9
        return frame

    def _payload(self, filled: Filled, buffer: NDArray[np.uint8]) -> NDArray[np.uint8] | None:
        """Copy a frame into `buffer`, decoded if it is compressed; return None if it is damaged."""
        content = np.frombuffer(self._buffers[filled.index], np.uint8, filled.size)
        current = self._format
        if current.fourcc not in COMPRESSED:
            size = min(filled.size, buffer.size)
            buffer[:size] = content[:size]
            return buffer[:size] if size >= current.line_bytes * current.height else None
        try:
            image = cv2.imdecode(content, cv2.IMREAD_COLOR)
        except cv2.error:  # e.g. a header with an impossible size
            return None
        if image is None or image.shape != (current.height, current.width, 3):
            return None
        buffer[:] = image.reshape(-1)
        return buffer


def create(uri: SourceUri) -> FrameGrabber:
    """Return the webcam of a URI, without opening it. Raises UsageError."""
    read_options(NoOptions, uri)
    return DeviceGrabber(V4l2Device(uri.name, DeviceInfo(str(uri), bus="V4L2", address=uri.name)))


def discover(timeout: float) -> list[DeviceInfo]:
    """Return every video device of this computer."""
    return find()
