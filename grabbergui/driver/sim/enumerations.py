"""The entries of the simulated camera's enumerations, with their values in `camera.xml`."""

from __future__ import annotations

from enum import IntEnum

CHUNK_ID_BASE = 0x1000
EVENT_ID_BASE = 0x9000


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
    LINE1 = 3


class TriggerOverlap(IntEnum):
    """Values of TriggerOverlap: when the sensor takes the next trigger."""

    READ_OUT = 0
    OFF = 1


class LineSource(IntEnum):
    """Values of LineSource: the signal that an output carries."""

    OFF = 0
    EXPOSURE_ACTIVE = 1
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

    __test__ = False  # no test class, despite its name


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


class ComponentSelector(IntEnum):
    """Values of ComponentSelector."""

    INTENSITY = 0
    RANGE = 1
    CONFIDENCE = 2


class Compression(IntEnum):
    """Values of ImageCompressionMode."""

    OFF = 0
    JPEG = 1
    JPEG2000 = 2
    H264 = 3


class FrameContent(IntEnum):
    """Values of PayloadType."""

    IMAGE = 0
    RAW_DATA = 1
    FILE = 2
    CHUNK_ONLY = 3


class EventSelector(IntEnum):
    """Values of EventSelector; the event's id is `EVENT_ID_BASE` more."""

    FRAME_START = 0
    EXPOSURE_END = 1
    FRAME_TRIGGER_MISSED = 2
    TEST = 3
    LINE1_RISING_EDGE = 4
    LINE1_FALLING_EDGE = 5


class UserSetSelector(IntEnum):
    """Values of UserSetSelector and UserSetDefault."""

    DEFAULT = 0
    USER_SET1 = 1
    USER_SET2 = 2


class File(IntEnum):
    """Values of FileSelector."""

    USER_SET1 = 0
    USER_SET2 = 1
    LUT_LUMINANCE = 2
    SHADING_CORRECTION = 3
    DEVICE_LOG = 4
    FIRMWARE = 5


class FileOperation(IntEnum):
    """Values of FileOperationSelector."""

    OPEN = 0
    CLOSE = 1
    READ = 2
    WRITE = 3
    DELETE = 4


class FileOpenMode(IntEnum):
    """Values of FileOpenMode."""

    READ = 0
    WRITE = 1
    READ_WRITE = 2


class FileOperationStatus(IntEnum):
    """Values of FileOperationStatus."""

    SUCCESS = 0
    FAILURE = 1
    OVERFLOW = 2


class FileState(IntEnum):
    """Values of FileState: the result of the last upload."""

    INTACT = 0
    EMPTY = 1
    INCOMPLETE = 2
    "The upload was not finished; the file is unusable."
    DISCARDED = 3
    "The upload was not finished or not valid; the previous file is unchanged."


class PtpStatus(IntEnum):
    """Values of PtpStatus: IEEE 1588's port states, as far as this clock has them."""

    DISABLED = 3
    SLAVE = 9


class TransportLayer(IntEnum):
    """Values of DeviceTLType."""

    GIGE_VISION = 0
    USB3_VISION = 1
    CUSTOM = 2
