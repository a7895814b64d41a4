"""A Linux video device: its identity, controls, formats, frame rates and buffers, by ioctls (linuxpy)."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Any, TypeVar

from linuxpy.video import device as v4l2
from linuxpy.video import raw

from grabbergui.core.device_text import text_field
from grabbergui.core.errors import AccessDeniedError, DeviceLostError, DeviceStatusError, TransportError

if sys.platform != "linux":
    raise ImportError("Video4Linux is a part of Linux")

CAPTURE = v4l2.BufferType.VIDEO_CAPTURE
_GONE = (errno.ENODEV, errno.ENXIO, errno.EIO, errno.ESHUTDOWN)
"Error numbers of a device that was unplugged."
Result = TypeVar("Result")
_BIG_ENDIAN = 1 << 31
"Flag in a format's code; no camera sends such pixels."
_LOCKED = v4l2.ControlFlag.GRABBED | v4l2.ControlFlag.READ_ONLY | v4l2.ControlFlag.INACTIVE
_FORMATS = frozenset(int(code) for code in v4l2.PixelFormat)
_TYPES = frozenset(int(kind) for kind in v4l2.ControlType)


class ControlKind(Enum):
    """The type of a control's value."""

    INTEGER = "integer"
    BOOLEAN = "boolean"
    MENU = "menu"
    BUTTON = "button"


_KINDS = {
    v4l2.ControlType.INTEGER: ControlKind.INTEGER,
    v4l2.ControlType.BITMASK: ControlKind.INTEGER,
    v4l2.ControlType.BOOLEAN: ControlKind.BOOLEAN,
    v4l2.ControlType.MENU: ControlKind.MENU,
    v4l2.ControlType.INTEGER_MENU: ControlKind.MENU,
    v4l2.ControlType.BUTTON: ControlKind.BUTTON,
}
"""Supported types of controls; not strings, arrays, 64 bits or codecs' tables."""


@dataclass(frozen=True)
class Control:
    """One control as the driver describes it (VIDIOC_QUERY_EXT_CTRL)."""

    id: int
    "V4L2_CID_…, e.g. 0x009A0902 for the absolute exposure."
    name: str
    kind: ControlKind
    minimum: int = 0
    maximum: int = 1
    step: int = 1
    menu: dict[int, str] = field(default_factory=dict)
    "Entries by value."


@dataclass(frozen=True)
class FrameSizes:
    """The sizes of one pixel format, in pixels: a list, or a range of each direction."""

    discrete: tuple[tuple[int, int], ...] = ()
    "(width, height), as the driver lists them."
    widths: tuple[int, int, int] = (0, 0, 1)
    "Minimum, maximum, step; a maximum of 0 if the driver does not report it."
    heights: tuple[int, int, int] = (0, 0, 1)

    @classmethod
    def listed(cls, sizes: Sequence[tuple[int, int]]) -> FrameSizes:
        """Return the sizes of a driver that lists them."""
        limits = [(min(numbers), max(numbers), 1) for numbers in zip(*sizes, strict=True)] or [(0, 0, 1)] * 2
        return cls(tuple(sizes), *limits)


@dataclass(frozen=True)
class CurrentFormat:
    """The current format (VIDIOC_G_FMT)."""

    fourcc: str
    width: int
    height: int
    line_bytes: int
    image_bytes: int


@dataclass(frozen=True)
class Filled:
    """A buffer that the driver filled."""

    index: int
    size: int
    sequence: int
    timestamp_ns: int
    "Monotonic clock; 0 if the driver uses another."
    damaged: bool


class VideoDevice:
    """An open `/dev/video…`. One thread at a time accesses controls and formats, the stream's its buffers."""

    def __init__(self, path: str) -> None:
        """Open it. Raises AccessDeniedError, DeviceLostError, TransportError."""
        self.path = path
        try:
            self._fd = os.open(path, os.O_RDWR | os.O_NONBLOCK | os.O_CLOEXEC)
        except PermissionError as error:
            raise AccessDeniedError(
                f"{path} may not be opened: add yourself to the group video (sudo usermod -aG video $USER), "
                "then log in again"
            ) from error
        except OSError as error:
            raise _translated(error, path) from error

    def close(self) -> None:
        """Close the device. May be called twice."""
        fd, self._fd = self._fd, -1
        if fd >= 0:
            with suppress(OSError):
                os.close(fd)

    def fileno(self) -> int:
        """Return the file descriptor, for `select`."""
        return self._fd

    def controls(self) -> list[Control]:
        """Return the supported controls, in the driver's order."""
        found = []
        with self._asking("its controls"):
            for info in v4l2.iter_read_controls(self._fd):
                kind = _KINDS.get(v4l2.ControlType(info.type)) if info.type in _TYPES else None
                if kind is None or info.flags & v4l2.ControlFlag.DISABLED or info.nr_of_dims:
                    continue
                limits = (int(info.minimum), int(info.maximum), max(int(info.step), 1))
                menu = self._menu(info) if kind is ControlKind.MENU else {}
                found.append(Control(info.id, text_field(info.name), kind, *limits, menu))
        return found

    def _menu(self, info: Any) -> dict[int, str]:
        entries = {}
        for value in range(info.minimum, info.maximum + 1):
            entry = raw.v4l2_querymenu()
            entry.id, entry.index = info.id, value
            try:
                v4l2.ioctl(self._fd, v4l2.IOC.QUERYMENU, entry)
            except OSError:
                continue  # menus have gaps
            by_number = info.type == v4l2.ControlType.INTEGER_MENU
            entries[value] = str(entry.m1.value) if by_number else text_field(entry.m1.name)
        return entries

    def control(self, control_id: int) -> int:
        """Read a control's value."""
        return self._ask("a control", lambda: int(v4l2.get_control(self._fd, control_id)))

    def set_control(self, control_id: int, value: int) -> None:
        """Write a control. Raises DeviceStatusError if the driver refuses."""
        self._ask("a control", lambda: v4l2.set_control(self._fd, control_id, value))

    def locked(self, control_id: int) -> bool:
        """Whether a control is currently not writable, e.g. because an automatic mode is on."""
        query = raw.v4l2_query_ext_ctrl()
        query.id = control_id
        self._ask("a control", lambda: v4l2.ioctl(self._fd, v4l2.IOC.QUERY_EXT_CTRL, query))
        return bool(query.flags & _LOCKED)

    def formats(self) -> list[str]:
        """Return the four-character codes of the pixel formats, in the driver's order."""
        with self._asking("its formats"):
            found = [int(each.pixel_format) for each in v4l2.iter_read_formats(self._fd, CAPTURE)]
        return [_fourcc(code) for code in found if not code & _BIG_ENDIAN]

    def sizes(self, fourcc: str) -> FrameSizes:
        """Return the sizes of a pixel format from `formats`."""
        with self._asking("its sizes"):
            found = list(v4l2.iter_read_frame_sizes(self._fd, _code(fourcc)))
        if found and found[0].type != v4l2.FrameSizeType.DISCRETE:
            info = found[0].info
            return FrameSizes(
                widths=(info.min_width, info.max_width, max(info.step_width, 1)),
                heights=(info.min_height, info.max_height, max(info.step_height, 1)),
            )
        return FrameSizes.listed([(size.info.width, size.info.height) for size in found])

    def rates(self, fourcc: str, width: int, height: int) -> tuple[float, float]:
        """Return the slowest and the fastest frame rate of a format in Hz; zeros if unknown."""
        if _number(fourcc) not in _FORMATS:
            return 0.0, 0.0
        with self._asking("its frame rates"):
            found = list(v4l2.iter_read_frame_intervals(self._fd, _code(fourcc), width, height))
        rates = [float(rate) for one in found for rate in (one.min_fps, one.max_fps)]
        return (min(rates), max(rates)) if rates else (0.0, 0.0)

    def format(self) -> CurrentFormat:
        """Return the current format."""
        with self._asking("its format"):
            pix = v4l2.get_raw_format(self._fd, CAPTURE).fmt.pix
        return CurrentFormat(_fourcc(pix.pixelformat), pix.width, pix.height, pix.bytesperline, pix.sizeimage)

    def set_format(self, fourcc: str, width: int, height: int) -> None:
        """Set a format; the driver chooses its nearest size. Refused while buffers are queued."""
        self._ask("its format", lambda: v4l2.set_format(self._fd, CAPTURE, width, height, fourcc))

    def rate(self) -> float:
        """Return the current frame rate in Hz; 0 if the driver does not report it."""
        try:
            return float(v4l2.get_fps(self._fd, CAPTURE))
        except (OSError, ZeroDivisionError):
            return 0.0

    def set_rate(self, rate: float) -> None:
        """Set the frame rate in Hz; the driver chooses its nearest."""
        self._ask("its frame rate", lambda: v4l2.set_fps(self._fd, CAPTURE, rate))

    def begin(self, count: int) -> list[memoryview]:
        """Map buffers, queue them and start. Raises AccessDeniedError if another program streams."""
        maps: list[memoryview] = []
        with self._asking("its stream"):
            try:
                maps += map(memoryview, v4l2.create_mmap_buffers(self._fd, CAPTURE, v4l2.Memory.MMAP, count))
                for index in range(len(maps)):
                    self.queue(index)
                v4l2.stream_on(self._fd, CAPTURE)
            except BaseException:
                self.end(maps)  # while buffers are allocated, the driver refuses other formats
                raise
        return maps

    def end(self, maps: Iterable[memoryview]) -> None:
        """Stop and unmap. Never raises."""
        with suppress(OSError):
            v4l2.stream_off(self._fd, CAPTURE)
        for each in maps:
            mapped: Any = each.obj
            each.release()
            mapped.close()
        with suppress(OSError):
            v4l2.free_buffers(self._fd, CAPTURE, v4l2.Memory.MMAP)

    def queue(self, index: int) -> None:
        """Give a buffer to the driver. Raises DeviceLostError."""
        buffer = raw.v4l2_buffer()
        buffer.type, buffer.memory, buffer.index = CAPTURE, v4l2.Memory.MMAP, index
        with self._asking("a buffer"):
            v4l2.ioctl(self._fd, v4l2.IOC.QBUF, buffer)

    def take(self) -> Filled | None:
        """Return the next filled buffer; None if there is none. Raises DeviceLostError."""
        try:
            buffer = v4l2.dequeue_buffer(self._fd, CAPTURE, v4l2.Memory.MMAP)
        except BlockingIOError:
            return None
        except OSError as error:
            raise _translated(error, self.path) from error
        stamp = buffer.timestamp
        monotonic = buffer.flags & v4l2.BufferFlag.TIMESTAMP_MONOTONIC
        stamp_ns = stamp.secs * 1_000_000_000 + stamp.usecs * 1000 if monotonic else 0
        damaged = bool(buffer.flags & v4l2.BufferFlag.ERROR)
        return Filled(buffer.index, buffer.bytesused, buffer.sequence, stamp_ns, damaged)

    def _ask(self, what: str, call: Callable[[], Result]) -> Result:
        with self._asking(what):
            return call()

    @contextmanager
    def _asking(self, what: str) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise _translated(error, self.path, what) from error


def _translated(error: OSError, path: str, what: str = "it") -> Exception:
    if error.errno in _GONE or not Path(path).exists():
        return DeviceLostError(f"{path} was unplugged")
    if error.errno == errno.EBUSY:
        return AccessDeniedError(f"{path}: another program streams from it; close that one first")
    if error.errno in (errno.EINVAL, errno.ERANGE, errno.EACCES):
        return DeviceStatusError(f"{path}: the driver refuses {what}: {error.strerror}", error.errno or 0)
    if error.errno == errno.ENOSPC:
        return TransportError(
            f"{path}: its USB bus has too little bandwidth left; choose a smaller size, MJPG or a lower rate,"
            " or plug it in elsewhere"
        )
    return TransportError(f"{path}: {error.strerror or error}")


def _fourcc(code: int) -> str:
    return bytes((int(code) >> shift) & 0x7F for shift in (0, 8, 16, 24)).decode()


def _number(fourcc: str) -> int:
    return int(raw.v4l2_fourcc(*fourcc))


def _code(fourcc: str) -> Any:
    return v4l2.PixelFormat(_number(fourcc))
