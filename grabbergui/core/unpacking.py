"""Converts payload bytes to arrays of whole lines (PFNC 2.4), by views if possible, else by copies."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.errors import PixelFormatError
from grabbergui.core.pfnc import PixelFormat, SampleLayout
from grabbergui.core.pixel_loops import (
    bytes_per_group,
    packed_bits,
    samples_per_group,
    unpack,
    unpack_high,
)


class SensorImage(Protocol):
    """The fields of a `Frame` that determine its pixels; `Frame` documents them."""

    payload: NDArray[np.uint8]
    width: int
    height: int
    pixel_format: PixelFormat
    padding_x: int
    big_endian: bool


def check(frame: SensorImage) -> None:
    """Raise PixelFormatError unless the payload contains an image of a known layout."""
    pixel_format, size = frame.pixel_format, f"{frame.width}×{frame.height}"
    if not pixel_format.convertible:
        code = f" (0x{pixel_format.code:08X})" if not pixel_format.name.startswith("0x") else ""
        raise PixelFormatError(
            f"pixel format {pixel_format.name}{code} cannot be shown; the raw bytes can still be saved, "
            f"or choose another PixelFormat such as Mono8"
        )
    if frame.width < 1 or frame.height < 1 or frame.padding_x < 0:
        raise PixelFormatError(f"an image of {size} pixels with {frame.padding_x} bytes of padding is empty")
    needed = _needed_bytes(frame)
    if frame.payload.size < needed:
        raise PixelFormatError(
            f"a {pixel_format.name} image of {size} needs {needed} bytes, the payload has "
            f"{frame.payload.size}; the raw bytes can still be saved"
        )


def lines(frame: SensorImage, first: int = 0, last: int | None = None) -> NDArray[Any]:
    """Return the sensor's values of the lines from `first` up to, but excluding, `last`.

    Shape (lines, width), or (lines, width, n) for n components in the order of `PixelFormat.raw_order`. Up
    to 8 bits are uint8, up to 16 native uint16 with the value in the low bits, 32 and 64 bits likewise;
    signed and floating-point formats have the corresponding types. For YUV 4:2:2 and BiColor n is 2; for YUV
    4:1:1, 4:2:0 and semiplanar chroma is repeated and n is 3. The array is a view of the payload, but a copy
    of packed, big-endian or unaligned samples. Raises PixelFormatError.
    """
    check(frame)
    last = frame.height if last is None else last
    pixel_format = frame.pixel_format
    if pixel_format.semiplanar:
        return _semiplanar_lines(frame, first, last)
    if pixel_format.expands_chroma:
        return _yuv411_lines(frame, first, last)
    if pixel_format.layout is SampleLayout.FIELDS:
        return _field_lines(frame, first, last)
    if pixel_format.planar:
        return _planar_lines(frame, first, last)
    samples = _sample_lines(frame, frame.payload, frame.width * pixel_format.components, first, last)
    return _by_pixel(samples, pixel_format.components)


def high_lines(frame: SensorImage, first: int, last: int) -> NDArray[np.uint8] | None:
    """Return the eight highest bits of `lines` if they can be unpacked separately; else None."""
    check(frame)
    pixel_format = frame.pixel_format
    if not pixel_format.packed or pixel_format.planar or pixel_format.depth <= 8:
        return None
    count = frame.width * pixel_format.components
    return _by_pixel(
        _packed_lines(frame, frame.payload, count, first, last, high=True), pixel_format.components
    )


def value_at(frame: SensorImage, x: int, y: int) -> tuple[float, ...]:
    """Return the components of one pixel in the order of `lines`, reading one line at most.

    Raises PixelFormatError.
    """
    pixel_format, count = frame.pixel_format, frame.pixel_format.components
    if pixel_format.packed and not pixel_format.planar and not frame.padding_x:
        check(frame)
        begin = (y * frame.width + x) * count
        return tuple(_packed_run(frame, frame.payload, begin, begin + count).tolist())
    values = lines(frame, y, y + 1)[0, x].tolist()
    return tuple(values) if isinstance(values, list) else (values,)


def _by_pixel(samples: NDArray[Any], components: int) -> NDArray[Any]:
    return samples if components == 1 else samples.reshape(len(samples), -1, components)


def _needed_bytes(frame: SensorImage) -> int:
    """Return the bytes of the image; the padding of its last line may be missing."""
    pixel_format, width, height, padding = frame.pixel_format, frame.width, frame.height, frame.padding_x
    if not padding:
        return pixel_format.image_bytes(width, height)
    if pixel_format.semiplanar:
        chroma_lines, chroma_bytes = _chroma_plane(frame)
        return height * (width + padding) + chroma_lines * (chroma_bytes + padding) - padding
    planes = pixel_format.components if pixel_format.planar else 1
    return planes * height * (pixel_format.line_bytes(width) + padding) - padding


def _sample_lines(
    frame: SensorImage, data: NDArray[np.uint8], count: int, first: int, last: int
) -> NDArray[Any]:
    """Return lines of `count` samples each, of an image or plane that begins with `data`: (lines, count)."""
    if frame.pixel_format.packed:
        return _packed_lines(frame, data, count, first, last)
    return _whole_lines(frame, data, count, first, last)


def _whole_lines(
    frame: SensorImage, data: NDArray[np.uint8], count: int, first: int, last: int
) -> NDArray[Any]:
    item = frame.pixel_format.sample_bytes
    dtype = np.dtype(f"{'>' if frame.big_endian else '<'}{frame.pixel_format.kind}{item}")
    stride = count * item + frame.padding_x
    data = np.ascontiguousarray(data)
    array: NDArray[Any] = np.ndarray((last - first, count), dtype, data, first * stride, (stride, item))
    native = dtype.newbyteorder("=")
    return array if array.flags.aligned and dtype == native else array.astype(native)


def _packed_lines(
    frame: SensorImage, data: NDArray[np.uint8], count: int, first: int, last: int, *, high: bool = False
) -> NDArray[Any]:
    if not frame.padding_x:
        # The bit stream continues across the ends of lines.
        run = _packed_run(frame, data, first * count, last * count, high=high)
        return run.reshape(last - first, count)
    layout, depth = frame.pixel_format.layout, frame.pixel_format.depth
    to_samples = unpack_high if high else unpack
    data, group = np.ascontiguousarray(data), samples_per_group(layout, depth)
    # Each line begins on a byte: extend it to whole groups, unpack, and truncate it.
    line = (count * packed_bits(layout, depth) + 7) // 8
    groups, stride = -(-count // group), line + frame.padding_x
    stretched = np.zeros((last - first, groups * bytes_per_group(layout, depth)), np.uint8)
    stretched[:, :line] = np.ndarray((last - first, line), np.uint8, data, first * stride, (stride, 1))
    samples = to_samples(stretched.reshape(-1), layout, depth, len(stretched) * groups * group)
    return np.ascontiguousarray(samples.reshape(last - first, -1)[:, :count])


def _packed_run(
    frame: SensorImage, data: NDArray[np.uint8], begin: int, end: int, *, high: bool = False
) -> NDArray[Any]:
    """Return samples of a stream without padding; `begin` may lie within a group of bytes."""
    layout, depth = frame.pixel_format.layout, frame.pixel_format.depth
    skipped = begin % samples_per_group(layout, depth)
    start = begin // samples_per_group(layout, depth) * bytes_per_group(layout, depth)
    to_samples = unpack_high if high else unpack
    return to_samples(np.ascontiguousarray(data)[start:], layout, depth, end - begin + skipped)[skipped:]


def _planar_lines(frame: SensorImage, first: int, last: int) -> NDArray[Any]:
    """Return (lines, width, components) from separate planes; a view of the payload if they are unpacked."""
    pixel_format, width, height = frame.pixel_format, frame.width, frame.height
    if not frame.padding_x:
        plane = pixel_format.image_bytes(width, height) // pixel_format.components
    else:
        plane = height * (pixel_format.line_bytes(width) + frame.padding_x)
    starts = [plane * index for index in range(pixel_format.components)]
    if pixel_format.packed:
        return np.stack(
            [_packed_lines(frame, frame.payload[at:], width, first, last) for at in starts], axis=-1
        )
    planes = [_whole_lines(frame, frame.payload[at:], width, first, last) for at in starts]
    one = planes[0]
    if one.base is None:  # copied for its byte order or address
        return np.stack(planes, axis=-1)
    item, data = pixel_format.sample_bytes, np.ascontiguousarray(frame.payload)
    stride = pixel_format.line_bytes(width) + frame.padding_x
    shape, strides = (last - first, width, pixel_format.components), (stride, item, plane)
    return np.ndarray(shape, one.dtype, data, first * stride, strides)


def _field_lines(frame: SensorImage, first: int, last: int) -> NDArray[Any]:
    """Return (lines, width, 3) from bit fields of words, 16 or 32 bits per pixel."""
    pixel_format = frame.pixel_format
    item = pixel_format.bits_per_pixel // 8
    stride = pixel_format.line_bytes(frame.width) + frame.padding_x
    order = ">" if frame.big_endian else "<"
    words: NDArray[Any] = np.ndarray(
        (last - first, frame.width),
        f"{order}u{item}",
        np.ascontiguousarray(frame.payload),
        first * stride,
        (stride, item),
    )
    values = np.empty((*words.shape, 3), np.uint8 if pixel_format.depth <= 8 else np.uint16)
    shift = 0
    for index, bits in enumerate(pixel_format.fields):
        values[..., index] = words >> shift & (1 << bits) - 1
        shift += bits
    return values


def _yuv411_lines(frame: SensorImage, first: int, last: int) -> NDArray[Any]:
    """Return (lines, width, 3) Y U V from groups of six bytes, in which four pixels share chroma.

    Without padding, groups continue across the ends of lines. Pixels of an incomplete last group take the
    chroma of the group before it, or have none.
    """
    pixel_format, width = frame.pixel_format, frame.width
    data, line = np.ascontiguousarray(frame.payload), pixel_format.line_bytes(width)
    stride = line + frame.padding_x
    if width % 4 and not frame.padding_x:
        run = data[None, : pixel_format.image_bytes(width, frame.height)]
        values = _spread_411(run, pixel_format.order, width * frame.height)
        return values.reshape(frame.height, width, 3)[first:last]
    rows = np.ndarray((last - first, line), np.uint8, data, first * stride, (stride, 1))
    if width % 4:
        return _spread_411(rows, pixel_format.order, width)
    groups = rows.reshape(last - first, -1, 6)
    values = np.empty((last - first, width // 4, 4, 3), np.uint8)
    luma = [index for index, name in enumerate(pixel_format.order) if name == "Y"]
    for place, index in enumerate(luma):
        values[:, :, place, 0] = groups[:, :, index]
    for channel, name in enumerate("UV", 1):
        values[:, :, :, channel] = groups[:, :, pixel_format.order.index(name), None]
    return values.reshape(last - first, width, 3)


def _spread_411(rows: NDArray[np.uint8], order: str, width: int) -> NDArray[np.uint8]:
    luma = np.array([index for index, name in enumerate(order) if name == "Y"])
    groups, place = np.divmod(np.arange(width), 4)
    values = np.empty((len(rows), width, 3), np.uint8)
    at = np.minimum(6 * groups + luma[place], rows.shape[1] - 1)
    values[..., 0] = rows[:, at]
    for channel, name in enumerate("UV", 1):
        at = 6 * groups + order.index(name)
        at = np.where(at < rows.shape[1], at, at - 6)
        values[..., channel] = np.where(at >= 0, rows[:, np.maximum(at, 0)], 128)
    return values


def _chroma_plane(frame: SensorImage) -> tuple[int, int]:
    """Return the number of lines of the chroma plane, and the bytes of a line."""
    vertical = frame.pixel_format.cell[1]
    return -(-frame.height // vertical), 2 * -(-frame.width // 2)


def _semiplanar_lines(frame: SensorImage, first: int, last: int) -> NDArray[Any]:
    """Return (lines, width, 3) Y U V from a plane of luma and one of interleaved chroma."""
    width, height, padding = frame.width, frame.height, frame.padding_x
    data, vertical = np.ascontiguousarray(frame.payload), frame.pixel_format.cell[1]
    luma_stride, (chroma_lines, chroma_bytes) = width + padding, _chroma_plane(frame)
    luma = np.ndarray((last - first, width), np.uint8, data, first * luma_stride, (luma_stride, 1))
    chroma = np.ndarray(
        (chroma_lines, chroma_bytes // 2, 2),
        np.uint8,
        data,
        height * luma_stride,
        (chroma_bytes + padding, 2, 1),
    )
    values = np.empty((last - first, width, 3), np.uint8)
    values[..., 0] = luma
    shared = chroma[first // vertical : -(-last // vertical)].repeat(2, axis=1)
    skipped = first % vertical
    shared = shared.repeat(vertical, axis=0)[skipped : skipped + last - first, :width]
    values[..., 1:] = shared if frame.pixel_format.order == "YUV" else shared[..., ::-1]
    return values
