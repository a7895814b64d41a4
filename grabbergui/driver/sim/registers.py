"""The simulated camera's registers: addresses, kinds, ranges, power-on values.

They lie in the manufacturer's space from 0x0010_0000 on, clear of GigE Vision's bootstrap registers (up to
0xAFFF) and of USB3 Vision's (up to 0xFFFF), so that one memory serves behind both. `camera.xml` describes
the same registers; a test holds the two together.
"""

from __future__ import annotations

import ipaddress
import zlib
from enum import IntEnum

from grabbergui.core.pfnc import CONVERTIBLE, by_name
from grabbergui.driver.sim.memory import Kind, Register, RegisterValue

SENSOR_WIDTH, SENSOR_HEIGHT = 4096, 2160
WIDTH_STEP, HEIGHT_STEP, OFFSET_STEP = 8, 2, 2
SMALLEST_WIDTH, SMALLEST_HEIGHT = 16, 2
FIRST_WIDTH, FIRST_HEIGHT = 1224, 1024
"""The region in the sensor's middle that is seen after power-on."""

LINE_TIME_US = 2.0
"Time to read out one line of the sensor."
FRAME_OVERHEAD_US = 100.0
"Time between the readouts of two frames."
EXPOSURE_OVERHEAD_US = 20.0
"Time between two exposures."
FASTEST_RATE = 1000.0
"Frames per second that are never exceeded."


class Auto(IntEnum):
    """Values of ExposureAuto, GainAuto and BalanceWhiteAuto."""

    OFF = 0
    ONCE = 1
    CONTINUOUS = 2


class AcquisitionMode(IntEnum):
    """Values of AcquisitionMode."""

    CONTINUOUS = 0
    SINGLE_FRAME = 1
    MULTI_FRAME = 2


class TriggerSource(IntEnum):
    """Values of TriggerSource."""

    SOFTWARE = 0
    ACTION1 = 1
    USER_OUTPUT0 = 2


class TriggerActivation(IntEnum):
    """Values of TriggerActivation: which change of a signal triggers."""

    RISING_EDGE = 0
    FALLING_EDGE = 1
    ANY_EDGE = 2


class BinningMode(IntEnum):
    """Values of BinningHorizontalMode and BinningVerticalMode."""

    SUM = 0
    AVERAGE = 1


class TestPattern(IntEnum):
    """Values of TestPattern."""

    OFF = 0
    BLACK = 1
    WHITE = 2
    GREY_HORIZONTAL_RAMP = 3
    GREY_VERTICAL_RAMP = 4
    GREY_HORIZONTAL_RAMP_MOVING = 5
    GREY_VERTICAL_RAMP_MOVING = 6
    COLOR_BAR = 7
    FRAME_COUNTER = 8

    __test__ = False  # not a class of tests, whatever pytest thinks of its name


class ColorFilter(IntEnum):
    """Values of PixelColorFilter."""

    NONE = 0
    BAYER_RG = 1
    BAYER_GB = 2
    BAYER_GR = 3
    BAYER_BG = 4


class Chunk(IntEnum):
    """Values of ChunkSelector; the chunk's id is `CHUNK_ID_BASE` more."""

    IMAGE = 0
    FRAME_ID = 1
    TIMESTAMP = 2
    EXPOSURE_TIME = 3
    GAIN = 4


CHUNK_ID_BASE = 0x1000


class Event(IntEnum):
    """Values of EventSelector; the event's id is `EVENT_ID_BASE` more."""

    FRAME_START = 0
    EXPOSURE_END = 1
    FRAME_TRIGGER_MISSED = 2
    TEST = 3


EVENT_ID_BASE = 0x9000


class UserSet(IntEnum):
    """Values of UserSetSelector and UserSetDefault."""

    DEFAULT = 0
    USER_SET1 = 1
    USER_SET2 = 2


class PtpStatus(IntEnum):
    """Values of PtpStatus: IEEE 1588's port states, as far as this clock has them."""

    DISABLED = 3
    SLAVE = 9


class TransportLayer(IntEnum):
    """Values of DeviceTLType."""

    GIGE_VISION = 0
    USB3_VISION = 1
    CUSTOM = 2


_all: list[Register] = []


def _add(register: Register) -> Register:
    _all.append(register)
    return register


def _uint32(
    name: str,
    address: int,
    default: int = 0,
    low: int | None = None,
    high: int | None = None,
    step: int = 1,
    *,
    writable: bool = True,
    choices: frozenset[int] | None = None,
    saved: bool = True,
) -> Register:
    saved = saved and writable
    return _add(
        Register(name, address, Kind.UINT32, 4, default, writable, low, high, step, choices, saved),
    )


def _choice(
    name: str, address: int, default: IntEnum, *, saved: bool = True, writable: bool = True
) -> Register:
    return _uint32(
        name,
        address,
        int(default),
        choices=frozenset(map(int, type(default))),
        saved=saved,
        writable=writable,
    )


def _switch(name: str, address: int, default: int = 0, *, saved: bool = True) -> Register:
    return _uint32(name, address, default, 0, 1, saved=saved)


def _command(name: str, address: int) -> Register:
    """Writing 1 executes; it reads 0 again at once."""
    return _uint32(name, address, saved=False)


def _int64(
    name: str, address: int, default: int = 0, low: int | None = None, high: int | None = None
) -> Register:
    writable = low is not None
    return _add(Register(name, address, Kind.INT64, 8, default, writable, low, high, saved=writable))


def _float64(
    name: str, address: int, default: float, low: float | None = None, high: float | None = None
) -> Register:
    writable = low is not None
    return _add(Register(name, address, Kind.FLOAT64, 8, default, writable, low, high, saved=writable))


def _string(
    name: str, address: int, length: int, default: RegisterValue, *, writable: bool = False
) -> Register:
    return _add(Register(name, address, Kind.STRING, length, default, writable))


# -- DeviceControl -------------------------------------------------------------------------------
DEVICE_VENDOR_NAME = _string("DeviceVendorName", 0x100000, 32, "grabbergui")
DEVICE_MODEL_NAME = _string("DeviceModelName", 0x100020, 32, "Simulated camera")
DEVICE_MANUFACTURER_INFO = _string("DeviceManufacturerInfo", 0x100040, 48, "A camera made of software")
DEVICE_VERSION = _string("DeviceVersion", 0x100080, 32, "1.0")
DEVICE_FIRMWARE_VERSION = _string("DeviceFirmwareVersion", 0x1000A0, 32, "1.0.0")
DEVICE_SERIAL_NUMBER = _string("DeviceSerialNumber", 0x1000C0, 16, "SIM001")
DEVICE_USER_ID = _string("DeviceUserID", 0x1000D0, 16, "", writable=True)
DEVICE_TL_TYPE = _choice("DeviceTLType", 0x100100, TransportLayer.CUSTOM, writable=False)
DEVICE_TEMPERATURE_SELECTOR = _uint32("DeviceTemperatureSelector", 0x100104, 0, choices=frozenset((0, 1)))
DEVICE_TEMPERATURE = (
    _float64("DeviceTemperature", 0x100110, 35.0),
    _float64("DeviceTemperature[1]", 0x100118, 32.0),
)
"Sensor, mainboard."
DEVICE_RESET = _command("DeviceReset", 0x100120)
TIMESTAMP_LATCH = _command("TimestampLatch", 0x100124)
TIMESTAMP_RESET = _command("TimestampReset", 0x100128)
TIMESTAMP_LATCH_VALUE = _int64("TimestampLatchValue", 0x100130)
DEVICE_LINK_SPEED = _int64("DeviceLinkSpeed", 0x100138, 1_250_000_000)
LINK_THROUGHPUT_LIMIT_MODE = _switch("DeviceLinkThroughputLimitMode", 0x100140)
LINK_THROUGHPUT_LIMIT = _int64("DeviceLinkThroughputLimit", 0x100148, 1_250_000_000, 1_000_000, 1_250_000_000)
LINK_CURRENT_THROUGHPUT = _int64("DeviceLinkCurrentThroughput", 0x100150)

# -- ImageFormatControl --------------------------------------------------------------------------
SENSOR_WIDTH_REGISTER = _uint32("SensorWidth", 0x100200, SENSOR_WIDTH, writable=False)
SENSOR_HEIGHT_REGISTER = _uint32("SensorHeight", 0x100204, SENSOR_HEIGHT, writable=False)
WIDTH_MAX = _uint32("WidthMax", 0x100208, SENSOR_WIDTH, writable=False)
HEIGHT_MAX = _uint32("HeightMax", 0x10020C, SENSOR_HEIGHT, writable=False)
WIDTH = _uint32("Width", 0x100210, FIRST_WIDTH, SMALLEST_WIDTH, SENSOR_WIDTH, WIDTH_STEP)
HEIGHT = _uint32("Height", 0x100214, FIRST_HEIGHT, SMALLEST_HEIGHT, SENSOR_HEIGHT, HEIGHT_STEP)
OFFSET_X = _uint32(
    "OffsetX",
    0x100218,
    (SENSOR_WIDTH - FIRST_WIDTH) // 2,
    0,
    SENSOR_WIDTH - SMALLEST_WIDTH,
    OFFSET_STEP,
)
OFFSET_Y = _uint32(
    "OffsetY",
    0x10021C,
    (SENSOR_HEIGHT - FIRST_HEIGHT) // 2,
    0,
    SENSOR_HEIGHT - SMALLEST_HEIGHT,
    OFFSET_STEP,
)

BINNING_HORIZONTAL = _uint32("BinningHorizontal", 0x100220, 1, 1, 4)
BINNING_VERTICAL = _uint32("BinningVertical", 0x100224, 1, 1, 4)
BINNING_HORIZONTAL_MODE = _choice("BinningHorizontalMode", 0x100228, BinningMode.AVERAGE)
BINNING_VERTICAL_MODE = _choice("BinningVerticalMode", 0x10022C, BinningMode.AVERAGE)
REVERSE_X = _switch("ReverseX", 0x100230)
REVERSE_Y = _switch("ReverseY", 0x100234)
SENSOR_FORMATS = tuple(known for known in CONVERTIBLE if not known.name.startswith("Coord3D"))
"What the sensor can send: it sees no distances."
PIXEL_FORMAT = _uint32(
    "PixelFormat",
    0x100238,
    by_name("Mono8").code,
    choices=frozenset(pixel_format.code for pixel_format in SENSOR_FORMATS),
)
PIXEL_COLOR_FILTER = _choice("PixelColorFilter", 0x10023C, ColorFilter.NONE, writable=False)
IS_COLOR = _uint32("IsColor", 0x100240, 0, writable=False)
TEST_PATTERN = _choice("TestPattern", 0x100244, TestPattern.OFF)

# -- AcquisitionControl --------------------------------------------------------------------------
ACQUISITION_MODE = _choice("AcquisitionMode", 0x100300, AcquisitionMode.CONTINUOUS)
ACQUISITION_START = _command("AcquisitionStart", 0x100304)
ACQUISITION_STOP = _command("AcquisitionStop", 0x100308)
ACQUISITION_FRAME_COUNT = _uint32("AcquisitionFrameCount", 0x10030C, 10, 1, 65535)
FRAME_RATE_ENABLE = _switch("AcquisitionFrameRateEnable", 0x100310, 1)
FRAME_RATE = _float64("AcquisitionFrameRate", 0x100318, 30.0, 0.5, FASTEST_RATE)
RESULTING_FRAME_RATE = _float64("AcquisitionResultingFrameRate", 0x100320, 30.0)
EXPOSURE_MODE = _uint32("ExposureMode", 0x100328, 0, choices=frozenset((0,)))
EXPOSURE_AUTO = _choice("ExposureAuto", 0x10032C, Auto.OFF)
EXPOSURE_TIME = _float64("ExposureTime", 0x100330, 10_000.0, 10.0, 1_000_000.0)
TRIGGER_SELECTOR = _uint32("TriggerSelector", 0x100338, 0, choices=frozenset((0, 1)))
_TRIGGERS = (("", 0x100340), ("[1]", 0x100360))
TRIGGER_MODE = tuple(_switch(f"TriggerMode{suffix}", at) for suffix, at in _TRIGGERS)
"FrameStart, FrameBurstStart; so are all that follow."
TRIGGER_SOFTWARE = tuple(_command(f"TriggerSoftware{suffix}", at + 4) for suffix, at in _TRIGGERS)
TRIGGER_SOURCE = tuple(
    _choice(f"TriggerSource{suffix}", at + 8, TriggerSource.SOFTWARE) for suffix, at in _TRIGGERS
)
TRIGGER_ACTIVATION = tuple(
    _choice(f"TriggerActivation{suffix}", at + 0xC, TriggerActivation.RISING_EDGE) for suffix, at in _TRIGGERS
)
TRIGGER_DELAY = tuple(
    _float64(f"TriggerDelay{suffix}", at + 0x10, 0.0, 0.0, 1_000_000.0) for suffix, at in _TRIGGERS
)
BURST_FRAME_COUNT = _uint32("AcquisitionBurstFrameCount", 0x100380, 1, 1, 255)
SETTING_LATENCY = _uint32("SettingLatency", 0x100384, 1, 1, 4)

# -- AnalogControl -------------------------------------------------------------------------------
GAIN_AUTO = _choice("GainAuto", 0x100400, Auto.OFF)
GAIN_RAW = _uint32("GainRaw", 0x100404, 0, 0, 2400)
"Hundredths of a decibel."
BLACK_LEVEL = _float64("BlackLevel", 0x100408, 2.0, 0.0, 64.0)
"In values of an 8-bit pixel."
GAMMA = _float64("Gamma", 0x100410, 1.0, 0.25, 4.0)
BALANCE_WHITE_AUTO = _choice("BalanceWhiteAuto", 0x100418, Auto.OFF)
BALANCE_RATIO_SELECTOR = _uint32("BalanceRatioSelector", 0x10041C, 0, choices=frozenset((0, 1, 2)))
BALANCE_RATIO = (
    _float64("BalanceRatio", 0x100420, 1.6, 0.25, 4.0),
    _float64("BalanceRatio[1]", 0x100428, 1.0, 0.25, 4.0),
    _float64("BalanceRatio[2]", 0x100430, 1.3, 0.25, 4.0),
)
"Red, green, blue; neutral under the scene's light when the camera leaves its factory."

# -- AutoFunctionControl -------------------------------------------------------------------------
AUTO_TARGET_BRIGHTNESS = _float64("AutoTargetBrightness", 0x100480, 0.4, 0.05, 0.95)
AUTO_EXPOSURE_LOWER = _float64("AutoExposureTimeLowerLimit", 0x100488, 10.0, 10.0, 1_000_000.0)
AUTO_EXPOSURE_UPPER = _float64("AutoExposureTimeUpperLimit", 0x100490, 30_000.0, 10.0, 1_000_000.0)
AUTO_GAIN_LOWER = _float64("AutoGainLowerLimit", 0x100498, 0.0, 0.0, 24.0)
AUTO_GAIN_UPPER = _float64("AutoGainUpperLimit", 0x1004A0, 24.0, 0.0, 24.0)

# -- DigitalIOControl ----------------------------------------------------------------------------
USER_OUTPUT_SELECTOR = _uint32("UserOutputSelector", 0x100580, 0, choices=frozenset((0,)))
USER_OUTPUT_VALUE = _switch("UserOutputValue", 0x100584, saved=False)

# -- UserSetControl ------------------------------------------------------------------------------
USER_SET_SELECTOR = _choice("UserSetSelector", 0x100600, UserSet.DEFAULT, saved=False)
USER_SET_LOAD = _command("UserSetLoad", 0x100604)
USER_SET_SAVE = _command("UserSetSave", 0x100608)
USER_SET_DEFAULT = _choice("UserSetDefault", 0x10060C, UserSet.DEFAULT, saved=False)

# -- ChunkDataControl ----------------------------------------------------------------------------
CHUNK_MODE_ACTIVE = _switch("ChunkModeActive", 0x100700)
CHUNK_SELECTOR = _choice("ChunkSelector", 0x100704, Chunk.FRAME_ID)
CHUNK_ENABLE = tuple(
    _switch(f"ChunkEnable[{chunk}]" if chunk else "ChunkEnable", 0x100710 + 4 * chunk, 1) for chunk in Chunk
)

# -- EventControl --------------------------------------------------------------------------------
EVENT_SELECTOR = _choice("EventSelector", 0x100800, Event.FRAME_START)
TEST_EVENT_GENERATE = _command("TestEventGenerate", 0x100804)
EVENT_NOTIFICATION = tuple(
    _switch(
        f"EventNotification[{event}]" if event else "EventNotification", 0x100810 + 4 * event, saved=False
    )
    for event in Event
)

# -- TransportLayerControl -----------------------------------------------------------------------
PAYLOAD_SIZE = _uint32("PayloadSize", 0x100900, 0, writable=False)
TL_PARAMS_LOCKED = _switch("TLParamsLocked", 0x100904, saved=False)

# -- PtpControl ----------------------------------------------------------------------------------
PTP_ENABLE = _switch("PtpEnable", 0x100A00, saved=False)
PTP_STATUS = _choice("PtpStatus", 0x100A04, PtpStatus.DISABLED, writable=False)
PTP_DATA_SET_LATCH = _command("PtpDataSetLatch", 0x100A08)
PTP_OFFSET_FROM_MASTER = _int64("PtpOffsetFromMaster", 0x100A10)

ALL: tuple[Register, ...] = tuple(_all)
"Every register, in the order of their addresses."


def serial_at(place: str) -> str:
    """Return the serial number of a camera that is given none, which follows from where it answers.

    The cameras of several programs so differ, and one that is restarted is the same camera. `place` is an IP
    address, a port's name or the like.
    """
    try:
        key = int(ipaddress.IPv4Address(place))
    except ValueError:
        key = zlib.crc32(place.encode())
    return f"SIM{key:08X}"
