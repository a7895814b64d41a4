"""Asks a source everything that a report contains.

A camera that opens only half is reported as far as it answers: each step that fails becomes a problem of the
report. Registers are read once (`RecordedDevice`). Nothing is written but what a stream needs: the privilege,
the stream's destination and packet size, AcquisitionMode, which is restored, and the commands that start and
stop. Selectors and triggers stay as they are.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

from grabbergui import sources
from grabbergui.core.errors import (
    AccessDeniedError,
    DeviceLostError,
    FrameTimeoutError,
    GrabberError,
    SourceNotFoundError,
)
from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.features import Feature
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.driver import acquisition
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.genapi.node_map import CameraNodeMap
from grabbergui.driver.genapi.register_names import register_names
from grabbergui.driver.gige.device import GigeDevice
from grabbergui.driver.twin.recorded_device import RecordedDevice
from grabbergui.driver.twin.report_file import (
    MAX_PIXEL_BYTES,
    MOST_PIXELS,
    CameraReport,
    FrameRecord,
    PacketTest,
)
from grabbergui.models.log_book import LogBook
from grabbergui.report import computer

log = logging.getLogger(__name__)

FRAMES = 200
STREAM_SECONDS = 10.0
"Longest time that frames are awaited."
LONGEST_PLAIN_REGISTER = 1 << 20
"Bytes; longer registers of plain bytes, such as tables, are left out."
Progress = Callable[[str], None]
"""Called with the name of each step as display text."""
_QUEUE_DEPTH = 32
"Frames that wait while one is recorded."


@dataclass(frozen=True)
class ReportOptions:
    """The extent of a report."""

    frames: int = FRAMES
    "Frames to receive; 0: the stream is not started."
    seconds: float = STREAM_SECONDS
    pixels: bool = False
    "Whether the first frames' pixels are kept."


def report_on(uri: str, options: ReportOptions, progress: Progress) -> CameraReport:
    """Open a source, and return its report with all names. Raises UsageError, SourceUnavailableError.

    A source that cannot be opened is no error: the report says why.
    """
    return report_of(sources.create(uri), options, progress)


def report_of(grabber: FrameGrabber, options: ReportOptions, progress: Progress) -> CameraReport:
    """Open a grabber, and return its report; see `report_on`."""
    with _logged() as book:
        draft = _Draft(grabber.info, options, progress)
        draft.ask_network()
        if isinstance(grabber, DeviceGrabber):
            draft.ask_camera(grabber)
        else:
            draft.ask_remote(grabber)
        draft.ask_computer()
        return draft.report(_log_text(book))


def report_of_open(
    grabber: FrameGrabber | None, book: LogBook, options: ReportOptions, progress: Progress
) -> CameraReport:
    """Return the report of an open grabber that others use, with the log in `book`; takes seconds.

    None: of this computer alone. A stream that runs is recorded; none is started, and no packet is tested.
    """
    draft = _Draft(grabber.info if grabber is not None else DeviceInfo(""), options, progress)
    draft.ask_network()
    if isinstance(grabber, DeviceGrabber):
        draft.ask_open(grabber)
    elif grabber is not None:
        draft.ask_open_remote(grabber)
    draft.ask_computer()
    return draft.report(_log_text(book))


@contextmanager
def _logged() -> Iterator[LogBook]:
    book = LogBook()
    book.open()
    try:
        yield book
    finally:
        book.close()


def _log_text(book: LogBook) -> str:
    lines = []
    for line in book.lines:
        moment = time.strftime("%H:%M:%S", time.localtime(line.time))
        lines.append(f"{moment} {logging.getLevelName(line.level)} {line.origin}: {line.text}\n")
    return "".join(lines)


class _Draft:
    """A report in progress."""

    def __init__(self, info: DeviceInfo, options: ReportOptions, progress: Progress) -> None:
        self._report = CameraReport(info, made=computer.versions())
        self._options = options
        self._progress = progress
        self._problems: list[str] = []
        self._answered = True
        "False once nothing answered at all."
        self._computer: dict[str, Any] = {}
        self._bootstrap: list[tuple[str, int, int]] = []

    def report(self, log_text: str) -> CameraReport:
        """Return the finished report."""
        return replace(self._report, problems=tuple(self._problems), computer=self._computer, log=log_text)

    def ask_network(self) -> None:
        """Note the interfaces, and who answers on them."""
        with self._step("looking for GigE Vision cameras"):
            self._computer |= computer.network()

    def ask_computer(self) -> None:
        """Note the findings of `doctor`."""
        with self._step("checking this computer"):
            self._computer["doctor"] = computer.findings()

    def ask_remote(self, grabber: FrameGrabber) -> None:
        """Ask a source that is no camera of this computer: features and frames."""
        with self._step("opening the source"):
            _open(grabber)
            try:
                self._ask_features(grabber)
                self._ask_stream(grabber)
            finally:
                grabber.close()
                self._report = replace(self._report, info=grabber.info)

    def ask_camera(self, listed: DeviceGrabber) -> None:
        """Open a camera and ask it, or as much of it as can be opened."""
        recorder = RecordedDevice(listed.device)
        camera = DeviceGrabber(recorder, deliver_incomplete=True)
        try:
            with self._step("opening the camera"):
                _open(camera)
                self._ask_open_camera(camera, recorder)
                return
            if self._answered:
                with self._step("opening the camera without its description"):
                    recorder.open(Access.MONITOR)
                    self._ask_bootstrap(recorder)
        finally:
            camera.close()
            recorder.close()
            self._take(recorder, {})

    def ask_open(self, camera: DeviceGrabber) -> None:
        """Ask a camera that is open and in use."""
        recorder = RecordedDevice(camera.device)
        with self._step("reading the registers"), camera.exclusive():
            recorder.description()
            self._ask_bootstrap(recorder)
            self._take(recorder, self._ask_nodes(recorder))
        if camera.streaming:
            self._ask_frames(camera)

    def ask_open_remote(self, grabber: FrameGrabber) -> None:
        """Ask an open source that is no camera of this computer."""
        self._ask_features(grabber)
        if grabber.streaming:
            self._ask_frames(grabber)

    def _ask_open_camera(self, camera: DeviceGrabber, recorder: RecordedDevice) -> None:
        self._ask_bootstrap(recorder)
        names = self._ask_nodes(recorder)
        self._take(recorder, names)
        if camera.access is Access.CONTROL and self._options.frames:
            recorder.follow()
            self._test_packets(recorder)
            self._ask_stream(camera)
            stream = replace(self._report.stream, accesses=tuple(recorder.accesses))
            self._report = replace(self._report, stream=stream)

    def _take(self, recorder: RecordedDevice, names: dict[tuple[int, int], str]) -> None:
        """Put what was recorded into the report."""
        standard = {(address, length): name for name, address, length in self._bootstrap}
        reads = [
            replace(read, name=standard.get(place) or names.get(place, read.name))
            for place, read in sorted(recorder.reads.items())
        ]
        device = recorder.device
        little_endian, numbers = device.word_order if isinstance(device, GigeDevice) else (False, False)
        kept = {(read.address, read.length): read.name for read in self._report.registers if read.name}
        self._report = replace(
            self._report,
            info=recorder.info,
            chunk_layout=recorder.chunk_layout,
            event_layout=recorder.event_layout,
            little_endian=little_endian,
            numbers=numbers,
            description=recorder.described,
            bootstrap=tuple(read for read in reads if (read.address, read.length) in standard),
            registers=tuple(
                replace(read, name=read.name or kept.get((read.address, read.length), ""))
                for read in reads
                if (read.address, read.length) not in standard
            ),
        )

    def _ask_bootstrap(self, recorder: RecordedDevice) -> None:
        with self._step("reading the standard's registers"):
            self._bootstrap = recorder.bootstrap_registers()
            for _, address, length in self._bootstrap:
                _read(recorder, address, length)

    def _ask_nodes(self, recorder: RecordedDevice) -> dict[tuple[int, int], str]:
        """Read every register of the description, then every feature; return the registers' names."""
        names: dict[tuple[int, int], str] = {}
        with self._step("reading the registers"):
            registers = register_names(recorder.described)
            nodes = CameraNodeMap(recorder, recorder.described, lambda names: None)
            try:
                for name, plain in registers:
                    recorder.last = None
                    _read_node(nodes, name, plain=plain)
                    if recorder.last is not None:
                        names.setdefault(recorder.last, name)
                features = [nodes.feature(each.name) for each in nodes.root.descriptions()]
            finally:
                nodes.close()
            self._report = replace(self._report, features=tuple(map(_feature_row, features)))
        return names

    def _ask_features(self, grabber: FrameGrabber) -> None:
        with self._step("reading the features"):
            self._report = replace(self._report, features=tuple(map(_feature_row, grabber.features())))

    def _test_packets(self, recorder: RecordedDevice) -> None:
        device = recorder.device
        if isinstance(device, GigeDevice):
            with self._step("testing packet sizes"):
                tests = tuple(PacketTest(size, arrived) for size, arrived in device.test_packets())
                self._report = replace(self._report, stream=replace(self._report.stream, packet_tests=tests))

    def _ask_stream(self, grabber: FrameGrabber) -> None:
        """Stream for a moment, with the triggers as they are."""
        with self._step("receiving frames"), _mode_restored(grabber):
            self._report = replace(self._report, stream=replace(self._report.stream, started=True))
            grabber.start(keep_trigger=True)
            try:
                self._ask_frames(grabber)
            finally:
                grabber.stop()

    def _ask_frames(self, grabber: FrameGrabber) -> None:
        records: list[FrameRecord] = []
        pixels: list[bytes] = []
        deadline = time.monotonic() + self._options.seconds
        queue = grabber.open_queue(_QUEUE_DEPTH)
        try:
            while len(records) < self._options.frames and (left := deadline - time.monotonic()) > 0:
                try:
                    frame = queue.get(left)
                except FrameTimeoutError as error:
                    self._problems.append(f"receiving frames: {error}")
                    break
                records.append(_record(frame))
                room = MAX_PIXEL_BYTES - sum(map(len, pixels)) >= frame.payload.nbytes
                if self._options.pixels and room and len(pixels) < MOST_PIXELS and frame.complete:
                    pixels.append(frame.payload.tobytes())
                del frame
        finally:
            queue.close()
            statistics = grabber.statistics().as_dict()
            stream = replace(self._report.stream, frames=tuple(records), statistics=statistics, started=True)
            self._report = replace(self._report, stream=stream, pixels=tuple(pixels))

    @contextmanager
    def _step(self, what: str) -> Iterator[None]:
        """Announce a step; an error in it becomes a problem of the report."""
        self._progress(what)
        try:
            yield
        except (GrabberError, OSError) as error:
            log.info("%s: %s", what, error)
            self._answered = self._answered and not isinstance(error, SourceNotFoundError)
            self._problems.append(f"{what}: {type(error).__name__}: {error}")


def _open(grabber: FrameGrabber) -> None:
    """Open with control, or without if another program has it."""
    try:
        grabber.open(Access.CONTROL)
    except AccessDeniedError as denied:
        try:
            grabber.open(Access.MONITOR)
        except GrabberError:
            raise denied from None


def _read(recorder: RecordedDevice, address: int, length: int) -> None:
    """Read a register; a refusal is recorded. Raises DeviceLostError."""
    try:
        recorder.read(address, length)
    except DeviceLostError:
        raise
    except GrabberError as error:
        log.debug("0x%X: %s", address, error)


def _read_node(nodes: CameraNodeMap, name: str, *, plain: bool) -> None:
    """Read a register by its name, if its access mode allows that. Raises DeviceLostError."""
    try:
        if not plain:
            nodes.value(name)
        elif (length := nodes.register_length(name)) <= LONGEST_PLAIN_REGISTER:
            nodes.read_register(name, length)
    except DeviceLostError:
        raise
    except GrabberError as error:
        log.debug("%s: %s", name, error)


@contextmanager
def _mode_restored(grabber: FeatureSource) -> Iterator[None]:
    """Restore AcquisitionMode, which a start may change."""
    mode = acquisition.MODE
    before = grabber.feature(mode).value if grabber.has_feature(mode) else None
    try:
        yield
    finally:
        if before is not None and grabber.feature(mode).value != before:
            grabber.write_feature(mode, before)


def _feature_row(feature: Feature) -> dict[str, Any]:
    return {
        "name": feature.name,
        "kind": feature.kind.value,
        "access": feature.access.value,
        "value": feature.value,
        "minimum": feature.minimum,
        "maximum": feature.maximum,
        "increment": feature.increment,
        "unit": feature.unit,
        "entries": [entry.name for entry in feature.entries if entry.available],
        "problem": feature.problem,
    }


def _record(frame: Frame) -> FrameRecord:
    return FrameRecord(
        frame_id=frame.frame_id,
        timestamp_ns=max(frame.timestamp_ns, 0),
        received_ns=frame.received_ns,
        width=frame.width,
        height=frame.height,
        pixel_format=frame.pixel_format.code,
        payload_bytes=frame.nbytes,
        payload_type=frame.payload_type.value,
        complete=frame.complete,
        missing_bytes=frame.missing_bytes,
        offset_x=frame.offset_x,
        offset_y=frame.offset_y,
        padding_x=frame.padding_x,
        big_endian=frame.big_endian,
        stream_channel=frame.stream_channel,
        components=len(frame.parts),
        chunks=dict(frame.chunks),
    )
