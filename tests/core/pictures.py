"""Pictures built and read one pixel at a time: the slow, obvious way, to hold the fast one against."""

import numpy as np

from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family, Layout, PixelFormat

SECOND_LINE = {"GR": "BG", "RG": "GB", "GB": "RG", "BG": "GR"}


def random_values(pixel_format: PixelFormat, width: int, height: int, seed: int = 1) -> np.ndarray:
    shape = (height, width) if pixel_format.components == 1 else (height, width, pixel_format.components)
    return np.random.default_rng(seed).integers(0, 1 << pixel_format.depth, shape)


def encoded(
    values: np.ndarray, pixel_format: PixelFormat, padding: int = 0, big_endian: bool = False
) -> bytes:
    """The payload of a picture; every line is padded with 0xEE where padding is asked for."""
    if not padding:
        return encoded_run([int(value) for value in values.reshape(-1)], pixel_format, big_endian)
    return b"".join(
        encoded_run([int(value) for value in line.reshape(-1)], pixel_format, big_endian) + b"\xee" * padding
        for line in values
    )


def encoded_run(values: list[int], pixel_format: PixelFormat, big_endian: bool) -> bytes:
    if pixel_format.layout is Layout.PACKED_LSB:
        bits = [value >> bit & 1 for value in values for bit in range(pixel_format.depth)]
        bits += [0] * (-len(bits) % 8)
        return bytes(sum(bits[at + bit] << bit for bit in range(8)) for at in range(0, len(bits), 8))
    if pixel_format.layout is Layout.PACKED_GIGE:
        low = pixel_format.depth - 8
        data = bytearray()
        for index, value in enumerate(values):
            if index % 2 == 0:
                data += bytes((value >> low, value & (1 << low) - 1))
            else:
                data[-1] |= (value & (1 << low) - 1) << 4
                data.append(value >> low)
        return bytes(data)
    size = 2 if pixel_format.depth > 8 else 1
    return b"".join(value.to_bytes(size, "big" if big_endian else "little") for value in values)


def frame_of(values: np.ndarray, pixel_format: PixelFormat, **fields) -> Frame:
    payload = encoded(values, pixel_format, fields.get("padding_x", 0), fields.get("big_endian", False))
    height, width = values.shape[:2]
    return Frame(np.frombuffer(payload, np.uint8), width, height, pixel_format, **fields)


def bayer_colour(order: str, x: int, y: int) -> str:
    return (order if y % 2 == 0 else SECOND_LINE[order])[x % 2]


def demosaiced(mosaic: np.ndarray, order: str) -> np.ndarray:
    """Each missing colour is the mean of its pixels among the eight neighbours; edges stay zero."""
    height, width = mosaic.shape
    rgb = np.zeros((height, width, 3))
    for y in range(1, height - 1):
        for x in range(1, width - 1):
            for index, colour in enumerate("RGB"):
                if bayer_colour(order, x, y) == colour:
                    rgb[y, x, index] = mosaic[y, x]
                    continue
                near = [
                    mosaic[v, u]
                    for v in range(y - 1, y + 2)
                    for u in range(x - 1, x + 2)
                    if bayer_colour(order, u, v) == colour
                ]
                rgb[y, x, index] = sum(int(value) for value in near) / len(near)
    return rgb


def rgb_of_yuv(values: np.ndarray, order: str) -> np.ndarray:
    """BT.601, full range; chroma of a pair serves both of its pixels."""
    height, width = values.shape[:2]
    luma = order.index("Y")
    rgb = np.zeros((height, width, 3))
    for y in range(height):
        for x in range(width):
            first = x - x % 2
            u, v = float(values[y, first, 1 - luma]) - 128, float(values[y, first + 1, 1 - luma]) - 128
            light = float(values[y, x, luma])
            rgb[y, x] = light + 1.402 * v, light - 0.344136 * u - 0.714136 * v, light + 1.772 * u
    return np.clip(rgb, 0, 255)


def expected_rgb(values: np.ndarray, pixel_format: PixelFormat) -> np.ndarray:
    high = values >> pixel_format.depth - 8
    if pixel_format.family is Family.BAYER:
        return demosaiced(high, pixel_format.order)
    if pixel_format.family is Family.YUV:
        return rgb_of_yuv(high, pixel_format.order)
    if pixel_format.family is Family.RGB:
        return np.stack([high[..., pixel_format.order.index(colour)] for colour in "RGB"], axis=-1)
    return np.stack([high] * 3, axis=-1)
