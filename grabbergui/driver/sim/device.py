"""The simulated camera in this process, without a transport; `sim:` sources.

Options of the URI set the camera's initial values: `sim:?width=640&height=480&fps=60&pixel_format=BayerRG8`.
`sim:colour` starts in colour; `sim:scene` shows a room with a person who holds a marker, in perspective; in
`sim:board` that person holds a calibration board.
"""

from __future__ import annotations

import logging
import struct
import threading
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from grabbergui.core import pfnc
from grabbergui.core.component import Component, PayloadType
from grabbergui.core.errors import (
    DeviceLostError,
    DeviceStatusError,
    LocalProtocolError,
    SourceNotFoundError,
    UsageError,
)
from grabbergui.core.frame import BufferPool, Frame
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.uri import SimulatedOptions, SourceUri, read_options
from grabbergui.driver.device import DataLayout, Device, FrameCounter, StreamRequest, deliver_or_log
from grabbergui.driver.gige.gvcp_messages import Event as Message
from grabbergui.driver.h264 import H264Stream
from grabbergui.driver.payload_contents import Contents, PayloadReader
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.camera_xml import camera_xml
from grabbergui.driver.sim.chunks import CHUNK_FEATURE
from grabbergui.driver.sim.contents import FILE_NAME, pieces
from grabbergui.driver.sim.enumerations import EVENT_ID_BASE, EventSelector, TestPattern
from grabbergui.driver.sim.memory import Refusal, Register, RegisterRefusedError, RegisterValue
from grabbergui.driver.sim.model import CameraModel, FramePlan
from grabbergui.driver.sim.rendered_scene import BoardScene, RenderedScene
from grabbergui.driver.sim.scene import Scene

log = logging.getLogger(__name__)

_STATUS = {
    Refusal.INVALID_ADDRESS: 0x8003,
    Refusal.WRITE_PROTECT: 0x8004,
    Refusal.BAD_ALIGNMENT: 0x8005,
    Refusal.INVALID_PARAMETER: 0x8002,
    Refusal.ACCESS_DENIED: 0x8006,
}
"GVCP's codes, since this transport has none of its own."

_POLL_S = 0.1
_EVENT_DATA = struct.Struct(">qq")
"Frame id, timestamp."
SCENE_NAME = "scene"
BOARD_NAME = "board"
COLOUR_NAME = "colour"
_SCENES: dict[str, Callable[[], Scene]] = {SCENE_NAME: RenderedScene, BOARD_NAME: BoardScene}
_KINDS: dict[str, dict[Register, RegisterValue]] = {
    SCENE_NAME: {reg.DEVICE_SERIAL_NUMBER: "SIM003"},
    COLOUR_NAME: {
        reg.DEVICE_MODEL_NAME: "Simulated colour camera",
        reg.DEVICE_SERIAL_NUMBER: "SIM002",
        reg.PIXEL_FORMAT: pfnc.by_name("BayerRG8").code,
    },
    # Half of the resolution, so that a board in motion is drawn as fast as it moves.
    BOARD_NAME: {
        reg.DEVICE_SERIAL_NUMBER: "SIM004",
        reg.BINNING_HORIZONTAL: 2,
        reg.BINNING_VERTICAL: 2,
        reg.WIDTH: 1216,
        reg.HEIGHT: 1024,
        reg.OFFSET_X: (reg.SENSOR_WIDTH // 2 - 1216) // 2,
        reg.OFFSET_Y: (reg.SENSOR_HEIGHT // 2 - 1024) // 2,
        reg.FRAME_RATE: 15.0,
    },
}
"""Register values in which the named cameras differ from the built-in one."""
_Show = Callable[[float], str]
"Returns a register's number as a URI has it."
_RAW_GAIN = 100
"The register's value for 1 dB."


class SimulatedDevice(Device):
    """A `CameraModel` as a device."""

    event_layout = DataLayout.GIGE_VISION

    def __init__(self, info: DeviceInfo, model: CameraModel) -> None:
        super().__init__(info)
        self.model = model
        self._open = False
        self._granted = Access.MONITOR

    def open(self, access: Access) -> Access:
        """Connect. Every access is granted, as no other program can hold this camera."""
        self._open = True
        self._granted = access
        self.model.on_event = self._send_event
        return access

    def close(self) -> None:
        """Stop the acquisition and disconnect."""
        self.close_stream()
        if self._granted is Access.CONTROL:
            self.model.stop()
        self.model.on_event = None
        self._open = False

    def read(self, address: int, length: int) -> bytes:
        """Register bytes."""
        self._require_open()
        try:
            return self.model.read(address, length)
        except RegisterRefusedError as error:
            raise DeviceStatusError(f"the camera refused to read: {error}", _STATUS[error.reason]) from error

    def write(self, address: int, data: bytes) -> None:
        """Write registers."""
        self._require_open()
        try:
            self.model.write(address, data)
        except RegisterRefusedError as error:
            raise DeviceStatusError(f"the camera refused to write: {error}", _STATUS[error.reason]) from error

    def description(self) -> bytes:
        """Return the GenICam XML."""
        return camera_xml()

    def open_stream(self, request: StreamRequest, deliver: Callable[[Frame], None]) -> None:
        """Start the thread that renders and delivers."""
        if self._receiving is not None:
            raise LocalProtocolError("the simulated camera's stream is open already")
        self._receiving = SimulatedStream(self.model, request, deliver)

    def _require_open(self) -> None:
        if not self._open:
            raise DeviceLostError("the simulated camera is closed")

    def _send_event(self, event: EventSelector, frame_id: int, timestamp: int) -> None:
        event_id = EVENT_ID_BASE + event
        message = Message(event_id, frame_id, timestamp, data=_EVENT_DATA.pack(frame_id, timestamp))
        self.report_event(event_id, message.encode(1, ack_required=False))


class SimulatedStream:
    """Renders frames straight into the pool's buffers on its own thread, from construction until `close`."""

    def __init__(self, model: CameraModel, request: StreamRequest, deliver: Callable[[Frame], None]) -> None:
        self._model = model
        self._deliver = deliver
        self._pool = BufferPool(max(request.payload_size, 1))
        self._counter = FrameCounter()
        self._reader = PayloadReader()
        self._decoder = H264Stream()
        self._stopping = False
        model.prepare()
        self._thread = threading.Thread(target=self._run, name="simulated camera", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop. Nothing is delivered after return."""
        self._stopping = True
        self._model.wake()
        self._thread.join()

    def statistics(self) -> StreamStatistics:
        """Return a snapshot of the counters. Any thread."""
        return self._counter.statistics()

    def _run(self) -> None:
        while not self._stopping:
            plan = self._model.next_frame(_POLL_S)
            if plan is None:
                continue
            if plan.payload_bytes > self._pool.size:
                # The stream was opened for smaller frames, as if packets beyond the buffer were dropped.
                self._counter.counts.incomplete += 1
                continue
            buffer = self._pool.take()
            if buffer is None:
                self._counter.counts.underruns += 1
                continue
            used = self._model.render(plan, buffer)
            self._counter.note_complete(used)
            frame = self._frame(plan, buffer[:used])
            del buffer
            deliver_or_log(self._deliver, frame)
            del frame  # else its buffer would be in use until the next one is made

    def _frame(self, plan: FramePlan, payload: NDArray[np.uint8]) -> Frame:
        settings = plan.settings
        frame = Frame(
            payload=payload,
            width=settings.width,
            height=settings.height,
            pixel_format=settings.pixel_format,
            frame_id=plan.frame_id,
            timestamp_ns=plan.timestamp_ns,
            received_ns=time.time_ns() - (self._model.timestamp() - plan.timestamp_ns),
            offset_x=settings.offset_x,
            offset_y=settings.offset_y,
            chunks={CHUNK_FEATURE[chunk]: value for chunk, value in plan.chunk_values.items()},
        )
        if settings.payload_type is PayloadType.IMAGE:
            return frame
        return self._contents(plan, payload).frame(frame)

    def _contents(self, plan: FramePlan, payload: NDArray[np.uint8]) -> Contents:
        settings, kind = plan.settings, plan.settings.payload_type
        if kind is PayloadType.GENDC:
            return self._reader.container(payload)
        if kind in (PayloadType.JPEG, PayloadType.JPEG2000):
            return self._reader.compressed(kind, payload)
        if kind is PayloadType.H264:
            image = self._decoder.add(plan.frame_id, payload)
            return Contents(kind, payload, () if image is None else (image,))
        if kind is not PayloadType.MULTI_PART:
            return self._reader.plain(kind, payload, FILE_NAME if kind is PayloadType.FILE else "")
        parts = tuple(
            Component(
                payload[piece.begin : piece.begin + piece.length],
                settings.width,
                settings.height,
                piece.pixel_format,
                piece.kind,
                offset_x=settings.offset_x,
                offset_y=settings.offset_y,
            )
            for piece in pieces(settings, ())
        )
        return Contents(kind, payload, parts)


def discover(timeout: float = 1.0) -> list[DeviceInfo]:
    """Return the built-in camera and the one in colour; they are always there."""
    uris = (SourceUri("sim"), SourceUri("sim", COLOUR_NAME))
    return [_info(uri, _power_on(uri)) for uri in uris]


def create(uri: SourceUri) -> FrameGrabber:
    """Return a simulated camera of its own for each call. Raises UsageError, SourceNotFoundError."""
    # Not at the top: it loads the GenApi runtime, which a server of simulated cameras does without.
    from grabbergui.driver.device_grabber import DeviceGrabber

    return DeviceGrabber(create_device(uri))


def create_device(uri: SourceUri) -> SimulatedDevice:
    """Return the device alone, with the URI's options as its power-on values."""
    scene = scene_of(uri)
    power_on = _power_on(uri)
    return SimulatedDevice(
        _info(uri, power_on), CameraModel(scene=scene() if scene else None, power_on=power_on)
    )


def scene_of(uri: SourceUri) -> Callable[[], Scene] | None:
    """Return what makes the scene of a named camera, None for the usual one. Raises SourceNotFoundError."""
    if uri.name not in ("", COLOUR_NAME, *_SCENES, reg.DEVICE_SERIAL_NUMBER.default):
        raise SourceNotFoundError(
            f"there is no simulated camera '{uri.name}'; write sim: for the built-in one, "
            f"sim:{COLOUR_NAME} for one in colour, sim:{SCENE_NAME} for one in a room, sim:{BOARD_NAME} for "
            "one that is shown a board to calibrate by"
        )
    return _SCENES.get(uri.name)


def power_on_at_address(uri: SourceUri) -> dict[Register, RegisterValue]:
    """Return the power-on values of a camera whose serial number, unless given, follows from its address."""
    kind = {
        key: value for key, value in _KINDS.get(uri.name, {}).items() if key is not reg.DEVICE_SERIAL_NUMBER
    }
    return {**kind, **power_on_values(uri)}


def served_at(uri: SourceUri, place: str) -> SourceUri:
    """Return the URI of a simulated camera that others reach at `place`, with a serial number of its own."""
    return replace(uri, options={"serial": reg.serial_at(place), **uri.options})


def _power_on(uri: SourceUri) -> dict[Register, RegisterValue]:
    return {**_KINDS.get(uri.name, {}), **power_on_values(uri)}


def _pixel_format(text: str) -> int:
    try:
        return pfnc.by_name(text).code
    except KeyError:
        raise ValueError("no such pixel format") from None


_REGISTERS: dict[str, tuple[Register, Callable[[str], RegisterValue], _Show]] = {
    "width": (reg.WIDTH, int, "{:g}".format),
    "height": (reg.HEIGHT, int, "{:g}".format),
    "fps": (reg.FRAME_RATE, float, "{:g}".format),
    "pixel_format": (reg.PIXEL_FORMAT, _pixel_format, lambda code: pfnc.by_code(int(code)).name),
    "exposure": (reg.EXPOSURE_TIME, float, "{:.0f}".format),
    "gain": (
        reg.GAIN_RAW,
        lambda text: round(float(text) * _RAW_GAIN),
        lambda raw: f"{raw / _RAW_GAIN:g}",
    ),
    "setting_latency": (reg.SETTING_LATENCY, int, "{:g}".format),
    "test_pattern": (
        reg.TEST_PATTERN,
        lambda text: TestPattern[_upper(text)],
        lambda number: _camel(TestPattern(int(number)).name),
    ),
    "serial": (reg.DEVICE_SERIAL_NUMBER, str, str),
    "user_id": (reg.DEVICE_USER_ID, str, str),
}


def _upper(camel: str) -> str:
    """Convert `GreyHorizontalRamp` to `GREY_HORIZONTAL_RAMP`."""
    return "".join(f"_{letter}" if letter.isupper() else letter for letter in camel).strip("_").upper()


def _camel(upper: str) -> str:
    """Convert `GREY_HORIZONTAL_RAMP` to `GreyHorizontalRamp`."""
    return "".join(word.capitalize() for word in upper.split("_"))


def power_on_values(uri: SourceUri) -> dict[Register, RegisterValue]:
    """Return the register values that a URI's options ask for. Raises UsageError with the allowed ones."""
    read_options(SimulatedOptions, uri)  # refuses an unknown option; the registers check the values
    values: dict[Register, RegisterValue] = {}
    for name, text in uri.options.items():
        register, convert, show = _REGISTERS[name]
        try:
            value = convert(text)
            register.check(value)
        except (ValueError, OverflowError, KeyError, RegisterRefusedError):
            raise UsageError(f"sim: cannot start with {name}={text}{_allowed(register, show)}") from None
        values[register] = value
    if reg.FRAME_RATE in values:
        # The default exposure time must not limit the requested rate.
        longest = 1e6 / float(values[reg.FRAME_RATE]) - reg.EXPOSURE_OVERHEAD_US
        values.setdefault(reg.EXPOSURE_TIME, min(float(reg.EXPOSURE_TIME.default), max(longest, 10.0)))
    return values


def _allowed(register: Register, show: _Show) -> str:
    if register.choices is not None:
        return f"; allowed: {', '.join(show(choice) for choice in sorted(register.choices))}"
    if register.minimum is None or register.maximum is None:
        return ""
    step = f" in steps of {register.step}" if register.step > 1 else ""
    return f"; allowed: {show(register.minimum)} to {show(register.maximum)}{step}"


def _info(uri: SourceUri, power_on: dict[Register, RegisterValue]) -> DeviceInfo:
    def text(register: Register) -> str:
        # As the register keeps it: a string that is too long is cut.
        return str(register.decode(register.encode(power_on.get(register, register.default))))

    return DeviceInfo(
        uri=str(uri),
        vendor=text(reg.DEVICE_VENDOR_NAME),
        model=text(reg.DEVICE_MODEL_NAME),
        serial=text(reg.DEVICE_SERIAL_NUMBER),
        bus="Simulated",
        version=str(reg.DEVICE_VERSION.default),
        interface="this process",
        user_name=text(reg.DEVICE_USER_ID),
    )
