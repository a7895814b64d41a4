"""The simulated camera's registers by name, and their power-on values.

Addresses, kinds and ranges are read from `camera.xml`. They lie in the manufacturer's space from 0x0010_0000
on, clear of GigE Vision's bootstrap registers (up to 0xAFFF) and of USB3 Vision's (up to 0xFFFF), so that one
memory serves behind both.
"""

from __future__ import annotations

import ipaddress
import zlib

from grabbergui.core.pfnc import by_name
from grabbergui.driver.sim.camera_xml import DescribedRegisters, PowerOn
from grabbergui.driver.sim.enumerations import BinningMode, Chunk, PtpStatus, TransportLayer
from grabbergui.driver.sim.memory import Register

SENSOR_WIDTH, SENSOR_HEIGHT = 4096, 2160
FIRST_WIDTH, FIRST_HEIGHT = 1224, 1024
"""The region in the sensor's middle that is seen after power-on."""

FASTEST_LINK = 10**12
"Bytes per second, more than any link has; the description allows up to DeviceLinkSpeed."
LINE_TIME_US = 2.0
"Time to read out one line of the sensor."
FRAME_OVERHEAD_US = 100.0
"Time between the readouts of two frames."
EXPOSURE_OVERHEAD_US = 20.0
"Time between two exposures."
SLOWEST_RATE = 0.5
"Hz, on a link that is fast enough."
FASTEST_RATE = 1000.0
"Frames per second that are never exceeded."


_POWER_ON: dict[str, PowerOn] = {
    "DeviceVendorName": "grabbergui",
    "DeviceModelName": "Simulated camera",
    "DeviceManufacturerInfo": "A camera made of software",
    "DeviceVersion": "1.0",
    "DeviceFirmwareVersion": "1.0.0",
    "DeviceSerialNumber": "SIM001",
    "DeviceTLType": TransportLayer.CUSTOM,
    "DeviceTemperature": (35.0, 32.0),
    "DeviceLinkSpeed": 1_250_000_000,
    "DeviceLinkThroughputLimit": 1_250_000_000,
    "SensorWidth": SENSOR_WIDTH,
    "SensorHeight": SENSOR_HEIGHT,
    "WidthMax": SENSOR_WIDTH,
    "HeightMax": SENSOR_HEIGHT,
    "Width": FIRST_WIDTH,
    "Height": FIRST_HEIGHT,
    "OffsetX": (SENSOR_WIDTH - FIRST_WIDTH) // 2,
    "OffsetY": (SENSOR_HEIGHT - FIRST_HEIGHT) // 2,
    "BinningHorizontal": 1,
    "BinningVertical": 1,
    "BinningHorizontalMode": BinningMode.AVERAGE,
    "BinningVerticalMode": BinningMode.AVERAGE,
    "PixelFormat": by_name("Mono8").code,
    "AcquisitionFrameCount": 10,
    "AcquisitionFrameRateEnable": 1,
    "AcquisitionFrameRate": 30.0,
    "AcquisitionResultingFrameRate": 30.0,
    "ExposureTime": 10_000.0,
    "AcquisitionBurstFrameCount": 1,
    "SettingLatency": 1,
    "BlackLevel": 2.0,
    "Gamma": 1.0,
    "BalanceRatio": (1.6, 1.0, 1.3),
    "AutoTargetBrightness": 0.4,
    "AutoExposureTimeLowerLimit": 10.0,
    "AutoExposureTimeUpperLimit": 30_000.0,
    "AutoGainUpperLimit": 24.0,
    "ChunkSelector": Chunk.FRAME_ID,
    "ChunkEnable": (1, 1, 1, 1, 1),
    "ComponentEnable": (1, 0, 0),
    "PtpStatus": PtpStatus.DISABLED,
    "LineMode": (0, 1),
}
"""Contents of registers after power-on, by feature and, with a selector, by entry. Others hold 0."""
_LIMITS = {
    "DeviceLinkThroughputLimit": (None, FASTEST_LINK),
    "Width": (None, SENSOR_WIDTH),
    "Height": (None, SENSOR_HEIGHT),
    "OffsetX": (None, SENSOR_WIDTH),
    "OffsetY": (None, SENSOR_HEIGHT),
    "AcquisitionFrameRate": (SLOWEST_RATE, FASTEST_RATE),
    "GainRaw": (None, 2400),
}
"""Smallest and largest value of features whose limits the description computes, or that it converts. None:
the description's, or 0."""
_SAVED = {
    "DeviceTemperatureSelector",
    "TriggerSelector",
    "GainRaw",
    "BalanceRatioSelector",
    "LineSelector",
    "UserOutputSelector",
    "ChunkSelector",
    "ComponentSelector",
    "EventSelector",
}
"""Features in user sets in addition to those marked Streamable."""

_described = DescribedRegisters(_POWER_ON, _LIMITS, _SAVED)
ALL: tuple[Register, ...] = tuple(_described)
"Every register."
_one, _each = _described.one, _described.each


# DeviceControl
DEVICE_VENDOR_NAME = _one("DeviceVendorName")
DEVICE_MODEL_NAME = _one("DeviceModelName")
DEVICE_MANUFACTURER_INFO = _one("DeviceManufacturerInfo")
DEVICE_VERSION = _one("DeviceVersion")
DEVICE_FIRMWARE_VERSION = _one("DeviceFirmwareVersion")
DEVICE_SERIAL_NUMBER = _one("DeviceSerialNumber")
DEVICE_USER_ID = _one("DeviceUserID")
DEVICE_TL_TYPE = _one("DeviceTLType")
DEVICE_TEMPERATURE = _each("DeviceTemperature")
"Sensor, mainboard."
DEVICE_RESET = _one("DeviceReset")
TIMESTAMP_LATCH = _one("TimestampLatch")
TIMESTAMP_RESET = _one("TimestampReset")
TIMESTAMP_LATCH_VALUE = _one("TimestampLatchValue")
DEVICE_LINK_SPEED = _one("DeviceLinkSpeed")
LINK_THROUGHPUT_LIMIT_MODE = _one("DeviceLinkThroughputLimitMode")
LINK_THROUGHPUT_LIMIT = _one("DeviceLinkThroughputLimit")
LINK_CURRENT_THROUGHPUT = _one("DeviceLinkCurrentThroughput")

# ImageFormatControl
SENSOR_WIDTH_REGISTER = _one("SensorWidth")
WIDTH_MAX = _one("WidthMax")
HEIGHT_MAX = _one("HeightMax")
WIDTH = _one("Width")
HEIGHT = _one("Height")
OFFSET_X = _one("OffsetX")
OFFSET_Y = _one("OffsetY")
BINNING_HORIZONTAL = _one("BinningHorizontal")
BINNING_VERTICAL = _one("BinningVertical")
BINNING_HORIZONTAL_MODE = _one("BinningHorizontalMode")
BINNING_VERTICAL_MODE = _one("BinningVerticalMode")
REVERSE_X = _one("ReverseX")
REVERSE_Y = _one("ReverseY")
PIXEL_FORMAT = _one("PixelFormat")
PIXEL_COLOR_FILTER = _one("PixelColorFilter")
IS_COLOR = _one("IsColor")
TEST_PATTERN = _one("TestPattern")
COMPONENT_ENABLE = _each("ComponentEnable")
"Intensity, range, confidence."
IMAGE_COMPRESSION_MODE = _one("ImageCompressionMode")

# AcquisitionControl
ACQUISITION_MODE = _one("AcquisitionMode")
ACQUISITION_START = _one("AcquisitionStart")
ACQUISITION_STOP = _one("AcquisitionStop")
ACQUISITION_FRAME_COUNT = _one("AcquisitionFrameCount")
FRAME_RATE_ENABLE = _one("AcquisitionFrameRateEnable")
FRAME_RATE = _one("AcquisitionFrameRate")
RESULTING_FRAME_RATE = _one("AcquisitionResultingFrameRate")
EXPOSURE_AUTO = _one("ExposureAuto")
EXPOSURE_TIME = _one("ExposureTime")
TRIGGER_MODE = _each("TriggerMode")
"FrameStart, FrameBurstStart; so are all that follow."
TRIGGER_SOFTWARE = _each("TriggerSoftware")
TRIGGER_SOURCE = _each("TriggerSource")
TRIGGER_ACTIVATION = _each("TriggerActivation")
TRIGGER_DELAY = _each("TriggerDelay")
TRIGGER_OVERLAP = _each("TriggerOverlap")
BURST_FRAME_COUNT = _one("AcquisitionBurstFrameCount")
SETTING_LATENCY = _one("SettingLatency")

# AnalogControl
GAIN_AUTO = _one("GainAuto")
GAIN_RAW = _one("GainRaw")
"Hundredths of a decibel."
BLACK_LEVEL = _one("BlackLevel")
"In values of an 8-bit pixel."
GAMMA = _one("Gamma")
BALANCE_WHITE_AUTO = _one("BalanceWhiteAuto")
BALANCE_RATIO = _each("BalanceRatio")
"Red, green, blue; neutral under the scene's light when the camera leaves its factory."

# AutoFunctionControl
AUTO_TARGET_BRIGHTNESS = _one("AutoTargetBrightness")
AUTO_EXPOSURE_LOWER = _one("AutoExposureTimeLowerLimit")
AUTO_EXPOSURE_UPPER = _one("AutoExposureTimeUpperLimit")
AUTO_GAIN_LOWER = _one("AutoGainLowerLimit")
AUTO_GAIN_UPPER = _one("AutoGainUpperLimit")

# DigitalIOControl
USER_OUTPUT_VALUE = _one("UserOutputValue")
LINE_MODE = _each("LineMode")
"Line1, Line2; so are all that follow."
LINE_INVERTER = _each("LineInverter")
LINE_STATUS = _each("LineStatus")
LINE_SOURCE = _each("LineSource")

# UserSetControl
USER_SET_SELECTOR = _one("UserSetSelector")
USER_SET_LOAD = _one("UserSetLoad")
USER_SET_SAVE = _one("UserSetSave")
USER_SET_DEFAULT = _one("UserSetDefault")

# FileAccessControl
FILE_SELECTOR = _one("FileSelector")
FILE_OPERATION_SELECTOR = _one("FileOperationSelector")
FILE_OPERATION_EXECUTE = _one("FileOperationExecute")
FILE_OPEN_MODE = _one("FileOpenMode")
FILE_OPERATION_STATUS = _one("FileOperationStatus")
FILE_OPERATION_RESULT = _one("FileOperationResult")
FILE_STATE = _one("FileState")
FILE_SIZE = _one("FileSize")
FILE_ACCESS_OFFSET = _one("FileAccessOffset")
FILE_ACCESS_LENGTH = _one("FileAccessLength")
FILE_ACCESS_BUFFER = _described.buffer("FileAccessBuffer")
"Address and length."

# LUTControl
LUT_ENABLE = _one("LUTEnable")
LUT_INDEX = _one("LUTIndex")
LUT_VALUE = _one("LUTValue")
LUT_VALUE_ALL = _described.buffer("LUTValueAll")
"Address and length."

# ChunkDataControl
CHUNK_MODE_ACTIVE = _one("ChunkModeActive")
CHUNK_ENABLE = _each("ChunkEnable")

# EventControl
TEST_EVENT_GENERATE = _one("TestEventGenerate")
EVENT_NOTIFICATION = _each("EventNotification")

# TransportLayerControl
PAYLOAD_SIZE = _one("PayloadSize")
PAYLOAD_TYPE = _one("PayloadType")
GENDC_STREAMING_MODE = _one("GenDCStreamingMode")
TL_PARAMS_LOCKED = _one("TLParamsLocked")

# PtpControl
PTP_ENABLE = _one("PtpEnable")
PTP_STATUS = _one("PtpStatus")
PTP_DATA_SET_LATCH = _one("PtpDataSetLatch")
PTP_OFFSET_FROM_MASTER = _one("PtpOffsetFromMaster")


def serial_at(place: str) -> str:
    """Return a serial number that follows from the place at which a camera answers.

    So the cameras of several programs differ, and a restarted one keeps its number. `place` is an IP address,
    a port's name or the like.
    """
    try:
        key = int(ipaddress.IPv4Address(place))
    except ValueError:
        key = zlib.crc32(place.encode())
    return f"SIM{key:08X}"
