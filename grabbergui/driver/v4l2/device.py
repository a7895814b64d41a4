"""A video device behind the registers of its GenICam description; `v4l2:` sources.

The URI is `v4l2:` (the first found), `v4l2:/dev/video2`, or has a serial number, a bus or a model's name.
"""

from __future__ import annotations

import logging
import struct
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace

from typing_extensions import override

from grabbergui.core.errors import DeviceLostError, DeviceStatusError, SourceNotFoundError
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.identity import DeviceInfo, require_one, require_same, unit
from grabbergui.core.uri import NoOptions, SourceUri, read_options
from grabbergui.driver.device import Device, StreamRequest
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.v4l2 import description as layout
from grabbergui.driver.v4l2.description import PFNC_NAMES, REGISTERS, TEXT_BYTES, TEXTS, WebcamDescription
from grabbergui.driver.v4l2.finding import find
from grabbergui.driver.v4l2.stream import V4l2Stream, payload_bytes
from grabbergui.driver.v4l2.video import ControlKind, FrameSizes, VideoDevice

log = logging.getLogger(__name__)


if sys.platform != "linux":
    raise ImportError("Video4Linux is a part of Linux")


_INTEGER = struct.Struct("<q")
_DOUBLE = struct.Struct("<d")
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
        self.opener = opener
        self._video: VideoDevice | None = None
        self._layout = WebcamDescription(b"")
        self._known: DeviceInfo | None = None
        self._locked = 0

    @override
    def open(self, access: Access) -> Access:
        info = self._found()
        video = self.opener(info.address)
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
            "PayloadSize": payload_bytes(current),
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


def create(uri: SourceUri) -> FrameGrabber:
    """Return the webcam of a URI, without opening it. Raises UsageError."""
    read_options(NoOptions, uri)
    return DeviceGrabber(V4l2Device(uri.name, DeviceInfo(str(uri), bus="V4L2", address=uri.name)))


def discover(timeout: float) -> list[DeviceInfo]:
    """Return every video device of this computer."""
    return find()
