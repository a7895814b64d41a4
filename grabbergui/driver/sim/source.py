"""`sim:`, the built-in simulated camera as a source.

Options set the camera's initial values: `sim:?width=640&height=480&fps=60&pixel_format=BayerRG8`.
`sim:colour` starts in colour; `sim:scene` shows a room with a person who holds a marker, in perspective; in
`sim:board` that person holds a calibration board.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from grabbergui.core import pfnc
from grabbergui.core.errors import SourceNotFoundError, UsageError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.uri import SimulatedOptions, SourceUri, read_options
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.device import SimulatedDevice
from grabbergui.driver.sim.memory import Register, RegisterRefusedError, RegisterValue
from grabbergui.driver.sim.model import CameraModel
from grabbergui.driver.sim.rendered.scene import BoardScene, RenderedScene
from grabbergui.driver.sim.scene import Scene

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


def discover(timeout: float = 1.0) -> list[DeviceInfo]:
    """Return the built-in camera and the one in colour; they are always there."""
    uris = (SourceUri("sim"), SourceUri("sim", COLOUR_NAME))
    return [_info(uri, _power_on(uri)) for uri in uris]


def create(uri: SourceUri) -> FrameGrabber:
    """Return a simulated camera of its own for each call. Raises UsageError, SourceNotFoundError."""
    # Not at the top: it loads the GenApi runtime, which a server of simulated cameras does without.
    from grabbergui.driver.camera import Camera

    return Camera(create_device(uri))


def create_device(uri: SourceUri) -> SimulatedDevice:
    """Return the device alone, with the URI's options as its power-on values."""
    if uri.name not in ("", COLOUR_NAME, *_SCENES, reg.DEVICE_SERIAL_NUMBER.default):
        raise SourceNotFoundError(
            f"there is no simulated camera '{uri.name}'; write sim: for the built-in one, "
            f"sim:{COLOUR_NAME} for one in colour, sim:{SCENE_NAME} for one in a room, sim:{BOARD_NAME} for "
            "one that is shown a board to calibrate by"
        )
    scene = _SCENES[uri.name]() if uri.name in _SCENES else None
    power_on = _power_on(uri)
    return SimulatedDevice(_info(uri, power_on), CameraModel(scene=scene, power_on=power_on))


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


_REGISTERS: dict[str, tuple[Register, Callable[[str], RegisterValue]]] = {
    "width": (reg.WIDTH, int),
    "height": (reg.HEIGHT, int),
    "fps": (reg.FRAME_RATE, float),
    "pixel_format": (reg.PIXEL_FORMAT, _pixel_format),
    "exposure": (reg.EXPOSURE_TIME, float),
    "gain": (reg.GAIN_RAW, lambda text: round(float(text) * 100)),
    "setting_latency": (reg.SETTING_LATENCY, int),
    "test_pattern": (reg.TEST_PATTERN, lambda text: reg.TestPattern[_upper(text)]),
    "serial": (reg.DEVICE_SERIAL_NUMBER, str),
    "user_id": (reg.DEVICE_USER_ID, str),
}


def _upper(camel: str) -> str:
    """Convert `GreyHorizontalRamp` to `GREY_HORIZONTAL_RAMP`."""
    return "".join(f"_{letter}" if letter.isupper() else letter for letter in camel).strip("_").upper()


def power_on_values(uri: SourceUri) -> dict[Register, RegisterValue]:
    """Return the register values that a URI's options ask for. Raises UsageError with the allowed ones."""
    read_options(SimulatedOptions, uri)  # refuses an unknown option; the registers check the values
    values: dict[Register, RegisterValue] = {}
    for name, text in uri.options.items():
        register, convert = _REGISTERS[name]
        try:
            value = convert(text)
            register.check(value)
        except (ValueError, OverflowError, KeyError, RegisterRefusedError):
            raise UsageError(f"sim: cannot start with {name}={text}{_allowed(register)}") from None
        values[register] = value
    if reg.FRAME_RATE in values:
        # The default exposure time must not limit the requested rate.
        longest = 1e6 / float(values[reg.FRAME_RATE]) - reg.EXPOSURE_OVERHEAD_US
        values.setdefault(reg.EXPOSURE_TIME, min(float(reg.EXPOSURE_TIME.default), max(longest, 10.0)))
    return values


def _allowed(register: Register) -> str:
    if register.minimum is None or register.maximum is None:
        return ""
    step = f" in steps of {register.step}" if register.step > 1 else ""
    return f"; allowed is {register.minimum:g} to {register.maximum:g}{step}"


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
