"""Saves a frame at full resolution, from the sensor's data, and its point cloud."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from enum import Enum
from itertools import count
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from psygnal import Signal

from grabbergui.core.component import further_components
from grabbergui.core.coord3d import Scan3d
from grabbergui.core.errors import GrabberError, LocalFileError, PixelFormatError
from grabbergui.core.frame import Frame
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.json_text import to_json
from grabbergui.core.pfnc import Family
from grabbergui.core.point_cloud import PointCloud

_TIFF_TYPES = (np.uint16, np.int16, np.int32, np.float32, np.float64)
"Types of deep values that OpenCV writes to TIFF unchanged."


class SnapshotError(LocalFileError):
    """A file could not be written."""


class SnapshotKind(Enum):
    """The kind of files of snapshots."""

    USUAL = "usual"
    "PNG for 8 bits, TIFF for more."
    TIFF = "tiff"
    "TIFF for all: the sensor's values, a Bayer pattern unconverted."
    RAW = "raw"
    "The payload's bytes, with a description in a .json file."


def save(
    frame: Frame,
    folder: Path,
    info: DeviceInfo,
    moment: float | None = None,
    kind: SnapshotKind = SnapshotKind.USUAL,
) -> Path:
    """Write a frame into a folder, which is created if necessary, and return the file's path.

    8-bit formats are saved as PNG (Bayer and YUV in colour), deeper ones as TIFF with the sensor's values in
    the low bits (a Bayer pattern unconverted). A format that no image file can hold, or of unknown layout, is
    saved as its payload bytes (`.raw`) with a description in a `.json` file. Each component of a frame is
    saved in a file; all but the frame's own image have their kind in the name (`_range.tiff`). Another `kind`
    of file may be chosen; a format that TIFF cannot hold is saved as `.raw` then. No file is overwritten.
    `moment` is in seconds since the epoch, by default the frame's. Raises SnapshotError.
    """
    moment = _moment(frame, moment)
    stem = _stem(info, moment)
    with _folder_errors(folder):
        folder.mkdir(parents=True, exist_ok=True)
        for name, part in further_components(frame.parts):
            _save_image(frame.of_component(part), folder, f"{stem}_{name}", info, moment, kind)
        return _save_image(frame, folder, stem, info, moment, kind)


def save_points(
    frame: Frame, folder: Path, info: DeviceInfo, scan: Scan3d, moment: float | None = None
) -> Path:
    """Write the point cloud of a frame's range image as PLY into a folder, and return the file's path.

    The file is named as by `save`. Raises SnapshotError, and PixelFormatError for a frame without points.
    """
    content = PointCloud.of(frame, scan).ply()
    with _folder_errors(folder):
        folder.mkdir(parents=True, exist_ok=True)
        return _write_new(folder, _stem(info, _moment(frame, moment)), ".ply", content)


class SnapshotWriter:
    """Saves frames one after the other on threads of its own, which emit the signals."""

    saved = Signal(Path)
    failed = Signal(str)

    def __init__(self) -> None:
        self._threads: list[threading.Thread] = []
        self._order = threading.Lock()

    def save(
        self, frame: Frame, folder: Path, info: DeviceInfo, kind: SnapshotKind = SnapshotKind.USUAL
    ) -> None:
        """Save a frame on another thread. Never waits."""
        self._begin(lambda: save(frame, folder, info, kind=kind))

    def save_all(
        self, frames: Sequence[Frame], folder: Path, info: DeviceInfo, kind: SnapshotKind = SnapshotKind.USUAL
    ) -> None:
        """Save frames in a new folder of that folder, on another thread. Never waits."""

        def write() -> Path:
            own = folder / _stem(info, _moment(frames[0], None))
            for frame in frames:
                save(frame, own, info, kind=kind)
            return own

        if frames:
            self._begin(write)

    def save_points(self, frame: Frame, folder: Path, info: DeviceInfo, scan: Scan3d) -> None:
        """Save the point cloud of a frame on another thread. Never waits."""
        self._begin(lambda: save_points(frame, folder, info, scan))

    def wait(self, timeout: float) -> bool:
        """Wait until everything is saved; return whether it is within `timeout` seconds. For quitting."""
        deadline = time.monotonic() + timeout
        for thread in self._threads:
            thread.join(max(0.0, deadline - time.monotonic()))
        return not any(thread.is_alive() for thread in self._threads)

    def _begin(self, write: Callable[[], Path]) -> None:
        thread = threading.Thread(target=self._write, args=(write,), name="snapshot", daemon=True)
        self._threads = [*(t for t in self._threads if t.is_alive()), thread]
        thread.start()

    def _write(self, write: Callable[[], Path]) -> None:
        try:
            with self._order:
                path = write()
        except GrabberError as error:
            self.failed.emit(str(error))
        else:
            self.saved.emit(path)


def _moment(frame: Frame, moment: float | None) -> float:
    if moment is not None:
        return moment
    return frame.received_ns / 1e9 if frame.received_ns else time.time()


@contextmanager
def _folder_errors(folder: Path) -> Iterator[None]:
    try:
        yield
    except GrabberError:
        raise
    except OSError as error:
        raise SnapshotError(
            f"the snapshot could not be written to {folder}: {error.strerror or error}; choose another folder"
        ) from error


def _save_image(
    frame: Frame, folder: Path, stem: str, info: DeviceInfo, moment: float, kind: SnapshotKind
) -> Path:
    try:
        if kind is SnapshotKind.RAW:
            raise PixelFormatError("the payload itself was asked for")
        suffix, content = _as_tiff(frame) if kind is SnapshotKind.TIFF else _encoded(frame)
    except PixelFormatError:
        path = _write_new(folder, stem, ".raw", frame.payload.tobytes())
        path.with_suffix(".json").write_text(to_json(_particulars(frame, info, moment), indent=2) + "\n")
        return path
    return _write_new(folder, stem, suffix, content)


def _encoded(frame: Frame) -> tuple[str, bytes]:
    """Return the file's suffix and content. Raises PixelFormatError."""
    raw, family = frame.raw(), frame.pixel_format.family
    if raw.dtype.itemsize > 1 and raw.ndim == 2:
        if raw.dtype not in _TIFF_TYPES:
            raise PixelFormatError(f"no image file holds {frame.pixel_format}")
        return ".tiff", _encode(".tiff", raw)
    if raw.dtype == np.uint16 and family is Family.RGB:
        order = [frame.pixel_format.raw_order.index(name) for name in "BGR"]
        return ".tiff", _encode(".tiff", np.ascontiguousarray(raw[..., order]))
    if family is Family.COORDINATES:
        if raw.shape[2] != 3 or raw.dtype not in (np.uint8, np.uint16, np.float32):
            raise PixelFormatError(f"no image file holds {frame.pixel_format}")
        return ".tiff", _encode(".tiff", np.ascontiguousarray(raw[..., ::-1]))  # OpenCV swaps them back
    if family is Family.MONO:
        return ".png", _encode(".png", frame.mono())
    return ".png", _encode(".png", cv2.cvtColor(frame.rgb(), cv2.COLOR_RGB2BGR))


def _as_tiff(frame: Frame) -> tuple[str, bytes]:
    """Return the suffix and content of a TIFF with the sensor's values. Raises PixelFormatError."""
    raw = frame.raw()
    if raw.dtype == np.uint8 and raw.ndim == 2:
        return ".tiff", _encode(".tiff", raw)
    suffix, content = _encoded(frame)
    if suffix == ".tiff":
        return suffix, content
    return ".tiff", _encode(".tiff", cv2.cvtColor(frame.rgb(), cv2.COLOR_RGB2BGR))


def _encode(suffix: str, pixels: NDArray[Any]) -> bytes:
    done, content = cv2.imencode(suffix, pixels)
    if not done:
        raise SnapshotError(f"an image of shape {pixels.shape} could not be encoded as {suffix}")
    return bytes(content.tobytes())


def _stem(info: DeviceInfo, moment: float) -> str:
    """Return a file name such as `Model_Serial_20260801-142530.125`."""
    second = time.strftime("%Y%m%d-%H%M%S", time.localtime(moment))
    return f"{info.file_name or 'frame'}_{second}.{int(moment * 1000) % 1000:03d}"


def _write_new(folder: Path, stem: str, suffix: str, content: bytes) -> Path:
    for attempt in count():
        path = folder / (f"{stem}_{attempt}{suffix}" if attempt else f"{stem}{suffix}")
        try:
            file = path.open("xb")
        except FileExistsError:
            continue
        try:
            with file:
                file.write(content)
        except OSError:
            path.unlink(missing_ok=True)  # an incomplete file
            raise
        return path
    raise AssertionError("unreachable")


def _particulars(frame: Frame, info: DeviceInfo, moment: float) -> dict[str, object]:
    return {
        "time": moment,
        "source": asdict(info),
        "width": frame.width,
        "height": frame.height,
        "pixel_format": frame.pixel_format.name,
        "pixel_format_code": f"0x{frame.pixel_format.code:08X}",
        "bytes": int(frame.payload.nbytes),
        "frame_id": frame.frame_id,
        "timestamp_ns": frame.timestamp_ns,
        "complete": frame.complete,
        "padding_x": frame.padding_x,
        "big_endian": frame.big_endian,
    }
