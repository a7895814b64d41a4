"""The region of the sensor that a camera sends: Width, Height, OffsetX and OffsetY (SFNC 4.1).

Cameras lock these features while they stream, so the stream is paused for the writes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from grabbergui.core.errors import FeatureNotFoundError, GrabberError
from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.features import Feature
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.pixels import Region
from grabbergui.models.image.region_edit import AxisLimits, RegionLimits


@contextmanager
def stream_paused(
    grabber: FrameGrabber, needed: bool = True, stays: Callable[[GrabberError], None] | None = None
) -> Iterator[None]:
    """Stop a running stream for the block, and start it again with the trigger modes set by then.

    Does nothing if the stream does not run or the pause is not `needed`. Raises GrabberError; if the stream
    does not start again, calls `stays` with the error instead. A camera that is lost within the block streams
    again when it is back.
    """
    if not needed or not grabber.streaming:
        yield
        return
    try:
        grabber.stop()
        yield
    finally:
        try:
            grabber.start(keep_trigger=True)
        except GrabberError as error:
            if stays is None:
                raise
            stays(error)


_AXES = (("Width", "OffsetX"), ("Height", "OffsetY"))


def has_region(grabber: FeatureSource) -> bool:
    """Return whether the camera's region can be chosen."""
    return all(grabber.has_feature(name) for axis in _AXES for name in axis)


def apply(grabber: FrameGrabber, region: Region) -> Region:
    """Reduce the camera's region to a part of the present frames, and return the resulting region.

    `region` is in pixels of the present frames; it is adjusted to the camera's increments and minimum size. A
    running stream continues afterwards. On the thread that makes the camera's calls. Raises FeatureError,
    TransportError.
    """
    _require(grabber)
    return _paused(grabber, lambda axis: _cut(grabber, axis, region))


def place_of(grabber: FeatureSource) -> tuple[Region, RegionLimits]:
    """Return the camera's region, and what it accepts. Thread and errors as in `apply`."""
    _require(grabber)
    region, limits = [], []
    for size_name, offset_name in _AXES:
        size, offset = grabber.feature(size_name), grabber.feature(offset_name)
        most = f"{size_name}Max"
        sensor = _number(grabber.feature(most).value) if grabber.has_feature(most) else 0
        sensor = max(sensor, _number(offset.maximum) + _number(size.value), _number(size.value))
        least, step = max(1, _number(size.minimum)), max(1, _number(size.increment))
        limits.append(AxisLimits(sensor, least, step, max(1, _number(offset.increment))))
        region.append((_number(offset.value), _number(size.value)))
    (x, width), (y, height) = region
    return Region(x, y, width, height), RegionLimits(*limits)


def apply_on_sensor(grabber: FrameGrabber, region: Region) -> Region:
    """Set the camera's region, in pixels of the sensor, and return it. Thread and errors as in `apply`."""
    _require(grabber)
    places = {"Width": (region.x, region.width), "Height": (region.y, region.height)}
    return _paused(grabber, lambda axis: _place(grabber, axis, *places[axis[0]]))


def apply_full(grabber: FrameGrabber) -> Region:
    """Set the camera's region to the whole sensor, and return it. Thread and errors as in `apply`."""
    _require(grabber)
    return _paused(grabber, lambda axis: _full(grabber, axis))


def fitted(start: int, length: int, size: Feature, offset: Feature) -> tuple[int, int]:
    """Return size and offset along one axis for `length` pixels from pixel `start` of the frame on.

    The size is rounded to its increment and at least its minimum; the offset is rounded down to its
    increment, and reduced until the region lies within the current one.
    """
    before, first = _number(size.value), _number(offset.value)
    step, least = max(1, _number(size.increment)), max(1, _number(size.minimum))
    length = least + max(0, round((length - least) / step)) * step
    while length > before and length - step >= least:
        length -= step
    offset_step, lowest = max(1, _number(offset.increment)), _number(offset.minimum)
    begin = first + min(max(start, 0), max(0, before - length))
    begin = lowest + (begin - lowest) // offset_step * offset_step
    return length, max(lowest, begin)


def _cut(grabber: FeatureSource, axis: tuple[str, str], region: Region) -> None:
    size_name, offset_name = axis
    size, offset = grabber.feature(size_name), grabber.feature(offset_name)
    start, length = (region.x, region.width) if size_name == "Width" else (region.y, region.height)
    new_size, new_offset = fitted(start, length, size, offset)
    _place(grabber, axis, new_offset, new_size)


def _place(grabber: FeatureSource, axis: tuple[str, str], new_offset: int, new_size: int) -> None:
    size_name, offset_name = axis
    # Offset and size limit each other, so their sum must stay within the sensor after each write.
    writes = [(size_name, new_size), (offset_name, new_offset)]
    if new_size > _number(grabber.feature(size_name).value):
        writes.reverse()
    for name, value in writes:
        if grabber.feature(name).value != value:
            grabber.write_feature(name, value)


def _full(grabber: FeatureSource, axis: tuple[str, str]) -> None:
    size_name, offset_name = axis
    offset = grabber.feature(offset_name)
    if offset.value != offset.minimum and offset.minimum is not None:
        grabber.write_feature(offset_name, offset.minimum)
    size = grabber.feature(size_name)
    if size.maximum is not None and size.value != size.maximum:
        grabber.write_feature(size_name, size.maximum)


def _paused(grabber: FrameGrabber, change: Callable[[tuple[str, str]], None]) -> Region:
    with stream_paused(grabber):  # pause once, not for each of four writes
        for axis in _AXES:
            change(axis)
    x, y, width, height = (
        _number(grabber.feature(name).value) for name in ("OffsetX", "OffsetY", "Width", "Height")
    )
    return Region(x, y, width, height)


def _require(grabber: FeatureSource) -> None:
    for name in (name for axis in _AXES for name in axis):
        if not grabber.has_feature(name):
            raise FeatureNotFoundError(
                f"{grabber.info.title} has no {name}, so its region cannot be chosen", name
            )


def _number(value: object) -> int:
    return int(value) if isinstance(value, (int, float)) else 0
