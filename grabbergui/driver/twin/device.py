"""A camera made of a report, in this process; `twin:` sources.

`twin:FILE.zip` opens the report that `grabbergui report` wrote. Register accesses take as long as with the
original; `?answer_times=0` answers at once.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from grabbergui.core.component import PayloadType
from grabbergui.core.environment import expanded, find_file
from grabbergui.core.errors import DeviceLostError, LocalProtocolError, TransportError, UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.uri import SourceUri, TwinOptions, read_options
from grabbergui.driver.device import Device, StreamRequest, check_payload_size
from grabbergui.driver.sim.model import FramePlan
from grabbergui.driver.sim.planned_stream import PlannedStream
from grabbergui.driver.twin import report_file
from grabbergui.driver.twin.model import LARGEST_FRAME, TwinModel
from grabbergui.driver.twin.report_file import CameraReport


class TwinDevice(Device):
    """A report as a device. Each opening begins with the registers as they were recorded."""

    def __init__(self, info: DeviceInfo, report: CameraReport, *, answer_times: bool = True) -> None:
        super().__init__(info)
        self.report = report
        self.chunk_layout, self.event_layout = report.chunk_layout, report.event_layout
        self._answer_times = answer_times
        self._model: TwinModel | None = None

    @override
    def open(self, access: Access) -> Access:
        """Every access is granted, as no other program can hold this camera."""
        self.close()
        self._model = TwinModel(self.report)
        return access

    @override
    def close(self) -> None:
        self.close_stream()
        model, self._model = self._model, None
        if model is not None:
            model.close()

    @override
    def read(self, address: int, length: int) -> bytes:
        model = self._opened()
        self._take_time(model, address, length)
        return model.read(address, length)

    @override
    def write(self, address: int, data: bytes) -> None:
        model = self._opened()
        self._take_time(model, address, len(data))
        model.write(address, data)

    @override
    def description(self) -> bytes:
        if not self.report.description:
            raise TransportError("the report has no description: the original's could not be read")
        return self.report.description

    @override
    def bootstrap_registers(self) -> list[tuple[str, int, int]]:
        return [(each.name, each.address, each.length) for each in self.report.bootstrap]

    @override
    def open_stream(self, request: StreamRequest, deliver: Callable[[Frame], None]) -> None:
        if self._receiving is not None:
            raise LocalProtocolError("the stream is open already")
        check_payload_size(request.payload_size)
        self._receiving = TwinStream(self._opened(), request, deliver)

    def _take_time(self, model: TwinModel, address: int, length: int) -> None:
        if self._answer_times:
            time.sleep(model.memory.answer_time(address, length))

    def _opened(self) -> TwinModel:
        if self._model is None:
            raise DeviceLostError(f"{self.info.title} is not open")
        return self._model


class TwinStream(PlannedStream):
    """Makes images, or raw data where the report knows no size."""

    def __init__(self, model: TwinModel, request: StreamRequest, deliver: Callable[[Frame], None]) -> None:
        super().__init__(model, min(request.payload_size, LARGEST_FRAME), deliver)

    @override
    def _frame(self, plan: FramePlan, payload: NDArray[np.uint8]) -> Frame:
        settings = plan.settings
        self._counter.note_id(plan.frame_id)
        return Frame(
            payload=payload,
            width=settings.width,
            height=settings.height,
            pixel_format=settings.pixel_format,
            frame_id=plan.frame_id,
            timestamp_ns=plan.timestamp_ns,
            received_ns=time.time_ns(),
            payload_type=PayloadType.IMAGE if settings.width else PayloadType.RAW_DATA,
        )


def create(uri: SourceUri) -> FrameGrabber:
    """Return the camera of a report. Raises UsageError, MissingFileError."""
    # Not at the top: it loads the GenApi runtime, which `simulate` needs later.
    from grabbergui.driver.device_grabber import DeviceGrabber

    options = read_options(TwinOptions, uri)
    if not uri.name:
        raise UsageError("write a report's file, as in twin:camera.zip; `grabbergui report` makes it")
    path = find_file(expanded(uri.name), "camera report")
    return DeviceGrabber(device_of(load(path), str(uri), answer_times=options.answer_times))


def load(path: Path) -> CameraReport:
    """Read the report of a camera. Raises UsageError also for a report without registers."""
    try:
        report = report_file.load(path)
    except IsADirectoryError as error:
        raise UsageError(f"{path} is a folder, not a camera report") from error
    if not report.registers and not report.bootstrap:
        reason = "; ".join(report.problems[:1]) or f"{report.scheme}: sources have none"
        raise UsageError(f"{path} has no registers, of which a twin is made: {reason}")
    return report


def device_of(report: CameraReport, uri: str, *, answer_times: bool = True) -> TwinDevice:
    """Return the device of a report."""
    # Not the same camera as the original, which may be open beside it.
    info = replace(
        report.info,
        uri=uri,
        model=f"{report.info.model} (twin)",
        bus="Twin",
        address="",
        hardware_id="",
        interface="this process",
        note="",
    )
    return TwinDevice(info, report, answer_times=answer_times)


def discover(timeout: float) -> list[DeviceInfo]:
    """Return nothing: reports are opened by their files."""
    return []
