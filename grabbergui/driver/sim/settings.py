"""Settings as registers: those that shape a frame, derived ones, and those that user sets contain."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

from grabbergui.core.component import ComponentKind, PayloadType
from grabbergui.core.pfnc import Family, PixelFormat, by_code
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.contents import payload_bytes
from grabbergui.driver.sim.files import FileStore
from grabbergui.driver.sim.memory import (
    Kind,
    Refusal,
    Register,
    RegisterMemory,
    RegisterRefusedError,
    RegisterValue,
)
from grabbergui.driver.sim.registers import BinningMode, Chunk, TestPattern


class Optics(NamedTuple):
    """The processing between scene and pixel apart from exposure; the key of cached images."""

    binning_horizontal: int = 1
    binning_vertical: int = 1
    reverse_x: bool = False
    reverse_y: bool = False
    gamma: float = 1.0
    ratios: tuple[float, float, float] = (1.0, 1.0, 1.0)
    "Amplification of red, green, blue; ones for a monochrome format."


@dataclass(frozen=True)
class FrameSettings:
    """All that the sensor needs to know to make a frame."""

    width: int
    height: int
    offset_x: int
    offset_y: int
    pixel_format: PixelFormat
    optics: Optics
    exposure_us: float
    gain_db: float
    black_level: float
    "In values of an 8-bit pixel."
    test_pattern: TestPattern = TestPattern.OFF
    binning_modes: tuple[BinningMode, BinningMode] = (BinningMode.AVERAGE, BinningMode.AVERAGE)
    "Horizontal, vertical."
    payload_type: PayloadType = PayloadType.IMAGE
    components: tuple[ComponentKind, ...] = (ComponentKind.INTENSITY,)
    lut: bytes | None = field(default=None, repr=False)
    "The look-up table, 16 bits big-endian; None while it is off."

    @property
    def image_bytes(self) -> int:
        """Bytes of the image without chunks."""
        return self.pixel_format.image_bytes(self.width, self.height)

    @property
    def amplification(self) -> float:
        """Gain and summing pixels, as a factor."""
        horizontal, vertical = self.binning_modes
        factor: float = 10 ** (self.gain_db / 20)
        if horizontal is BinningMode.SUM:
            factor *= self.optics.binning_horizontal
        if vertical is BinningMode.SUM:
            factor *= self.optics.binning_vertical
        return factor


def settings_of(memory: RegisterMemory) -> FrameSettings:
    """Return the settings in the registers at the moment. The caller holds the lock."""
    pixel_format = by_code(memory.integer(reg.PIXEL_FORMAT))
    red, green, blue = (memory.number(ratio) for ratio in reg.BALANCE_RATIO)
    optics = Optics(
        memory.integer(reg.BINNING_HORIZONTAL),
        memory.integer(reg.BINNING_VERTICAL),
        bool(memory.integer(reg.REVERSE_X)),
        bool(memory.integer(reg.REVERSE_Y)),
        memory.number(reg.GAMMA),
        (1.0, 1.0, 1.0) if pixel_format.family is Family.MONO else (red, green, blue),
    )
    horizontal, vertical = reg.BINNING_HORIZONTAL_MODE, reg.BINNING_VERTICAL_MODE
    return FrameSettings(
        memory.integer(reg.WIDTH),
        memory.integer(reg.HEIGHT),
        memory.integer(reg.OFFSET_X),
        memory.integer(reg.OFFSET_Y),
        pixel_format,
        optics,
        memory.number(reg.EXPOSURE_TIME),
        memory.integer(reg.GAIN_RAW) / 100,
        memory.number(reg.BLACK_LEVEL),
        TestPattern(memory.integer(reg.TEST_PATTERN)),
        (BinningMode(memory.integer(horizontal)), BinningMode(memory.integer(vertical))),
        _payload_type(memory),
        _components(memory),
        memory.read(*reg.LUT_VALUE_ALL) if memory.integer(reg.LUT_ENABLE) else None,
    )


_COMPONENTS = {
    reg.Component.INTENSITY: ComponentKind.INTENSITY,
    reg.Component.RANGE: ComponentKind.RANGE,
    reg.Component.CONFIDENCE: ComponentKind.CONFIDENCE,
}


def _components(memory: RegisterMemory) -> tuple[ComponentKind, ...]:
    return tuple(kind for which, kind in _COMPONENTS.items() if memory.integer(reg.COMPONENT_ENABLE[which]))


def _payload_type(memory: RegisterMemory) -> PayloadType:
    """Return what frames carry; USB3 Vision has fewer kinds than GigE Vision."""
    usb = memory.integer(reg.DEVICE_TL_TYPE) == reg.TransportLayer.USB3_VISION
    content = reg.FrameContent(memory.integer(reg.PAYLOAD_TYPE))
    if content is reg.FrameContent.CHUNK_ONLY:
        return PayloadType.CHUNK
    if memory.integer(reg.GENDC_STREAMING_MODE):
        return PayloadType.GENDC
    if usb:
        return PayloadType.IMAGE
    if content is not reg.FrameContent.IMAGE:
        return PayloadType[content.name]
    if compression := memory.integer(reg.IMAGE_COMPRESSION_MODE):
        return PayloadType[reg.Compression(compression).name]
    return PayloadType.MULTI_PART if len(_components(memory)) > 1 else PayloadType.IMAGE


DECIDING = (
    reg.WIDTH,
    reg.HEIGHT,
    reg.BINNING_HORIZONTAL,
    reg.BINNING_VERTICAL,
    reg.PIXEL_FORMAT,
    reg.CHUNK_MODE_ACTIVE,
    *reg.CHUNK_ENABLE,
    *reg.COMPONENT_ENABLE,
    reg.IMAGE_COMPRESSION_MODE,
    reg.GENDC_STREAMING_MODE,
    reg.PAYLOAD_TYPE,
)
"Features that decide the payload's size, locked while streaming."

_AXES = (
    (reg.SENSOR_WIDTH, reg.BINNING_HORIZONTAL, reg.WIDTH_MAX, reg.WIDTH, reg.OFFSET_X),
    (reg.SENSOR_HEIGHT, reg.BINNING_VERTICAL, reg.HEIGHT_MAX, reg.HEIGHT, reg.OFFSET_Y),
)


def update_geometry(memory: RegisterMemory) -> None:
    """Recompute everything that depends on the `DECIDING` registers."""
    for sensor, binning, limit, size, offset in _AXES:
        most = sensor // memory.integer(binning)
        most -= (most - int(size.minimum or 0)) % size.step
        memory.set(limit, most)
        memory.set(size, min(memory.integer(size), most))
        # A larger image reduces the offset.
        room = most - memory.integer(size)
        memory.set(offset, min(memory.integer(offset), room - room % offset.step))
    pixel_format = by_code(memory.integer(reg.PIXEL_FORMAT))
    memory.set(reg.IS_COLOR, int(pixel_format.family is not Family.MONO))
    colour_filter = reg.ColorFilter.NONE
    if pixel_format.family is Family.BAYER:
        colour_filter = reg.ColorFilter[f"BAYER_{pixel_format.order}"]
    memory.set(reg.PIXEL_COLOR_FILTER, colour_filter)
    memory.set(reg.PAYLOAD_SIZE, payload_bytes(settings_of(memory), active_chunks(memory)))


def active_chunks(memory: RegisterMemory) -> tuple[Chunk, ...]:
    """Return the chunks that are enabled at the moment."""
    alone = memory.integer(reg.PAYLOAD_TYPE) == reg.FrameContent.CHUNK_ONLY
    if not memory.integer(reg.CHUNK_MODE_ACTIVE) and not alone:
        return ()
    enabled = (chunk for chunk in Chunk if memory.integer(reg.CHUNK_ENABLE[chunk]))
    return tuple(chunk for chunk in enabled if chunk is not Chunk.IMAGE)


def fastest_rate(memory: RegisterMemory) -> float:
    """Return the frame rate (Hz) that exposure, readout and link allow; the XML has the same formula."""
    exposed = memory.number(reg.EXPOSURE_TIME) + reg.EXPOSURE_OVERHEAD_US
    lines = memory.integer(reg.HEIGHT) * memory.integer(reg.BINNING_VERTICAL)
    slowest = max(exposed, lines * reg.LINE_TIME_US + reg.FRAME_OVERHEAD_US)
    if memory.integer(reg.LINK_THROUGHPUT_LIMIT_MODE):
        payload = memory.integer(reg.PAYLOAD_SIZE)
        slowest = max(slowest, payload * 1e6 / memory.integer(reg.LINK_THROUGHPUT_LIMIT))
    return min(1e6 / slowest, reg.FASTEST_RATE)


class UserSets:
    """The user sets stored by UserSetSave: files of the camera, which survive resets and power cuts.

    A file has a line `register = value` for each setting; omitted settings have the factory's values.
    """

    def __init__(self, memory: RegisterMemory, store: FileStore) -> None:
        self._memory = memory
        self._store = store
        self._factory = self._present()
        for file in _FILE_OF_SET.values():
            if store.state(file) is reg.FileState.EMPTY:
                store.replace(file, _encode(self._factory))

    def save(self) -> None:
        """Keep the present settings in the selected set. Raises RegisterRefusedError for the factory's."""
        selected = reg.UserSet(self._memory.integer(reg.USER_SET_SELECTOR))
        if selected is reg.UserSet.DEFAULT:
            raise RegisterRefusedError(Refusal.ACCESS_DENIED, "the factory's user set cannot be overwritten")
        self._store.replace(_FILE_OF_SET[selected], _encode(self._present()))

    def apply(self, which: Register) -> None:
        """Take over the set that a register names.

        Raises RegisterRefusedError, and changes nothing, if its file is incomplete or makes no sense.
        """
        selected = reg.UserSet(self._memory.integer(which))
        settings = dict(self._factory)
        if selected in _FILE_OF_SET:
            file = _FILE_OF_SET[selected]
            if self._store.state(file) is not reg.FileState.INTACT:
                raise RegisterRefusedError(
                    Refusal.ACCESS_DENIED, f"the file of {selected.name} is incomplete"
                )
            settings |= _decode(self._store.content(file))
        for register, value in settings.items():
            self._memory.set(register, value)

    def apply_or_factory(self, which: Register) -> None:
        """Take over the set that a register names; the factory's if that one is damaged."""
        try:
            self.apply(which)
        except RegisterRefusedError as error:
            self._store.note(f"the factory's settings are used: {error}")
            for register, value in self._factory.items():
                self._memory.set(register, value)

    def _present(self) -> dict[Register, RegisterValue]:
        return {register: self._memory.stored(register) for register in reg.ALL if register.saved}


_FILE_OF_SET = {reg.UserSet.USER_SET1: reg.File.USER_SET1, reg.UserSet.USER_SET2: reg.File.USER_SET2}
_SAVED = {register.name: register for register in reg.ALL if register.saved}


def _encode(settings: dict[Register, RegisterValue]) -> bytes:
    return "".join(f"{register.name} = {value}\n" for register, value in settings.items()).encode()


def _decode(content: bytes) -> dict[Register, RegisterValue]:
    """Raises RegisterRefusedError."""
    settings: dict[Register, RegisterValue] = {}
    for line in content.decode("utf-8", "replace").splitlines():
        name, _, text = line.partition(" = ")
        register = _SAVED.get(name)
        if register is None:
            raise RegisterRefusedError(
                Refusal.INVALID_PARAMETER, f"the user set has no setting {name[:40]!r}"
            )
        value: RegisterValue = text
        try:
            if register.kind is not Kind.STRING:
                value = float(text) if register.kind is Kind.FLOAT64 else int(text)
        except ValueError as error:
            message = f"the user set's {name} is no number: {text[:40]!r}"
            raise RegisterRefusedError(Refusal.INVALID_PARAMETER, message) from error
        register.check(value)
        settings[register] = value
    return settings
