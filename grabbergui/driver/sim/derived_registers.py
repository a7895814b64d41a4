"""Registers of the simulated camera that follow from others: sizes, chunks, rates."""

from __future__ import annotations

from grabbergui.core.pfnc import Family, by_code
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.enumerations import Chunk, ColorFilter, FrameContent
from grabbergui.driver.sim.memory import RegisterMemory

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
    """Recompute the sizes and colours that depend on the `DECIDING` registers."""
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
    colour_filter = ColorFilter.NONE
    if pixel_format.family is Family.BAYER:
        colour_filter = ColorFilter[f"BAYER_{pixel_format.order}"]
    memory.set(reg.PIXEL_COLOR_FILTER, colour_filter)


def active_chunks(memory: RegisterMemory) -> tuple[Chunk, ...]:
    """Return the chunks that are enabled at the moment."""
    alone = memory.integer(reg.PAYLOAD_TYPE) == FrameContent.CHUNK_ONLY
    if not memory.integer(reg.CHUNK_MODE_ACTIVE) and not alone:
        return ()
    enabled = (chunk for chunk in Chunk if memory.integer(reg.CHUNK_ENABLE[chunk]))
    return tuple(chunk for chunk in enabled if chunk is not Chunk.IMAGE)


def unoverlapped_period_us(memory: RegisterMemory) -> float:
    """Return the time between triggers that the sensor needs if it reads out before the next exposure."""
    lines = memory.integer(reg.HEIGHT) * memory.integer(reg.BINNING_VERTICAL)
    exposed = memory.number(reg.EXPOSURE_TIME) + reg.EXPOSURE_OVERHEAD_US
    return exposed + lines * reg.LINE_TIME_US + reg.FRAME_OVERHEAD_US


def fastest_rate(memory: RegisterMemory) -> float:
    """Return the frame rate (Hz) that exposure, readout and link allow; the XML has the same formula."""
    exposed = memory.number(reg.EXPOSURE_TIME) + reg.EXPOSURE_OVERHEAD_US
    lines = memory.integer(reg.HEIGHT) * memory.integer(reg.BINNING_VERTICAL)
    slowest = max(exposed, lines * reg.LINE_TIME_US + reg.FRAME_OVERHEAD_US)
    if memory.integer(reg.LINK_THROUGHPUT_LIMIT_MODE):
        payload = memory.integer(reg.PAYLOAD_SIZE)
        slowest = max(slowest, payload * 1e6 / memory.integer(reg.LINK_THROUGHPUT_LIMIT))
    return min(1e6 / slowest, reg.FASTEST_RATE)
