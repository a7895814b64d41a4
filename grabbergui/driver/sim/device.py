"""The simulated camera in this process, without a transport; `sim:` sources.

Options of the URI set the camera's initial values: `sim:?width=640&height=480&fps=60&pixel_format=BayerRG8`.
`sim:colour` starts in colour; `sim:scene` shows a room with a person who holds a marker, in perspective; in
`sim:board` that person holds a calibration board.
"""

from __future__ import annotations

import logging
import struct
from collections.abc import Callable
from dataclasses import replace

from grabbergui.core import pfnc
from grabbergui.core.errors import DeviceLostError, DeviceStatusError, LocalProtocolError, SourceNotFoundError
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.uri import SourceUri
from grabbergui.driver.device import DataLayout, Device, StreamRequest
from grabbergui.driver.gige.gvcp_messages import Event as Message
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.camera_xml import camera_xml
from grabbergui.driver.sim.enumerations import EVENT_ID_BASE, EventSelector
from grabbergui.driver.sim.memory import Refusal, Register, RegisterRefusedError, RegisterValue
from grabbergui.driver.sim.model import CameraModel
from grabbergui.driver.sim.power_on import power_on_values
from grabbergui.driver.sim.rendered_scene import BoardScene, RenderedScene
from grabbergui.driver.sim.scene import Scene
from grabbergui.driver.sim.stream import SimulatedStream

log = logging.getLogger(__name__)

_STATUS = {
    Refusal.INVALID_ADDRESS: 0x8003,
    Refusal.WRITE_PROTECT: 0x8004,
    Refusal.BAD_ALIGNMENT: 0x8005,
    Refusal.INVALID_PARAMETER: 0x8002,
    Refusal.ACCESS_DENIED: 0x8006,
}
"GVCP's codes, since this transport has none of its own."

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
