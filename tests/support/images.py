"""Images built and read bit by bit and pixel by pixel: the slow, obvious way, to hold the fast one against.

Everything follows from a format's name as the convention's text reads it, not from our table.
"""

import re
import struct

import numpy as np

from every_case import every_case
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family, PixelFormat

SECOND_LINE = {"GR": "BG", "RG": "GB", "GB": "RG", "BG": "GR"}
MATRICES = {  # ITU-R BT.601, 709, 2020 in limited range: luma, V to red, U and V to green, U to blue
    "601": (1.164384, 1.596027, -0.391762, -0.812968, 2.017232),
    "709": (1.164384, 1.792741, -0.213249, -0.532909, 2.112402),
    "2020": (1.164384, 1.678674, -0.187326, -0.650424, 2.141772),
}


def bits_of(name: str) -> int:
    """Bits of a sample: the number behind the components and the standard."""
    if "565" in name:
        return 6
    name = re.sub(r"^(YCbCr601|YCbCr709|YCbCr2020|SCF1|Coord3D)", "", name)
    name = re.sub(r"4(11|20|22)_", "", name)
    return int(re.search(r"\d+", name).group())


def dtype_of(name: str) -> np.dtype:
    bits = bits_of(name)
    size = 1 if bits <= 8 else 2 if bits <= 16 else bits // 8
    kind = "f" if re.search(r"\df", name) else "i" if re.search(r"\ds$", name) else "u"
    return np.dtype(f"{kind}{size}")


def random_values(pixel_format: PixelFormat, width: int, height: int, seed: int = 1) -> np.ndarray:
    """Values as `Frame.raw` should give them; pixels that share chroma have the same."""
    name, random = pixel_format.name, np.random.default_rng(seed)
    shape = (height, width) if pixel_format.components == 1 else (height, width, pixel_format.components)
    dtype, bits = dtype_of(name), bits_of(name)
    if dtype.kind == "f":
        return random.normal(800.0, 300.0, shape).astype(dtype)
    low, high = (-(1 << bits - 1), 1 << bits - 1) if dtype.kind == "i" else (0, 1 << bits)
    if re.match(r"YCbCr(601|709|2020)_", name):
        low = 16 << bits - 8  # below black a standard leaves open what is shown
    values = random.integers(low, high, shape, dtype)
    if "565" in name:
        values[..., 0] &= 31
        values[..., 2] &= 31
    across, down = shared_chroma(name)
    if across > 1:
        for y in range(height):
            for x in range(width):
                values[y, x, 1:] = values[y - y % down, x - x % across, 1:]
    return values


def shared_chroma(name: str) -> tuple[int, int]:
    """Pixels of a line and lines that share chroma, where raw arrays repeat it."""
    if "411_" in name:
        return 4, 1
    if "420_" in name:
        return 2, 2
    return (2, 1) if "Semiplanar" in name else (1, 1)


def encoded(
    values: np.ndarray, pixel_format: PixelFormat, padding: int = 0, big_endian: bool = False
) -> bytes:
    """The payload of an image; every line is padded with 0xEE where padding is asked for."""
    name = pixel_format.name
    planes = [
        [encoded_run(line, name, big_endian) for line in plane]
        if padding
        else flattened(plane, name, big_endian)
        for plane in planes_of(values, name)
    ]
    return b"".join(line + b"\xee" * padding for plane in planes for line in plane)


def flattened(plane: list[list], name: str, big_endian: bool) -> list[bytes]:
    return [encoded_run([value for line in plane for value in line], name, big_endian)]


def planes_of(values: np.ndarray, name: str) -> list[list[list]]:
    """Samples in memory order: planes of lines."""
    if name.endswith("_Planar"):
        return [values[..., channel].tolist() for channel in range(values.shape[2])]
    if "Semiplanar" in name:
        order = (1, 2) if "CbCr" in name.removeprefix("YCbCr") else (2, 1)
        down = shared_chroma(name)[1]
        chroma = [
            [line[x][channel] for x in range(0, len(line), 2) for channel in order]
            for line in values[::down].tolist()
        ]
        return [values[..., 0].tolist(), chroma]
    if "411_" in name:
        return [[with_411_order(line, name) for line in values.tolist()]]
    return [values.reshape(len(values), -1).tolist()]


def with_411_order(line: list, name: str) -> list:
    samples = []
    for x in range(0, len(line), 4):
        luma = [pixel[0] for pixel in line[x : x + 4]]
        _, u, v = line[x]
        samples += (
            [u, *luma[:2], v, *luma[2:]]
            if "YYCrYY" in name or "UYY" in name
            else [*luma[:2], u, *luma[2:], v]
        )
    return samples


def encoded_run(values: list, name: str, big_endian: bool) -> bytes:
    bits, dtype = bits_of(name), dtype_of(name)
    if dtype.kind == "f":
        return b"".join(
            struct.pack((">" if big_endian else "<") + ("f" if bits == 32 else "d"), v) for v in values
        )
    values = [int(value) & (1 << bits) - 1 for value in values]
    if "565" in name:
        words = [r | g << 5 | b << 11 for r, g, b in zip(*[iter(values)] * 3, strict=True)]
        return b"".join(word.to_bytes(2, "big" if big_endian else "little") for word in words)
    if "10p32" in name:
        words = [r | g << 10 | b << 20 for r, g, b in zip(*[iter(values)] * 3, strict=True)]
        return b"".join(word.to_bytes(4, "big" if big_endian else "little") for word in words)
    if re.search(r"\dp(_|$)|_Deprecated$", name):
        digits = "".join(f"{value:0{bits}b}" for value in reversed(values))  # the first sample is lowest
        return int(digits or "0", 2).to_bytes(-(-len(digits) // 8), "little")
    if name.endswith("Packed"):
        low = bits - 8
        data = bytearray()
        for index, value in enumerate(values):
            if index % 2 == 0:
                data += bytes((value >> low, value & (1 << low) - 1))
            else:
                data[-1] |= (value & (1 << low) - 1) << 4
                data.append(value >> low)
        return bytes(data)
    return b"".join(value.to_bytes(dtype.itemsize, "big" if big_endian else "little") for value in values)


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


def eight_bit(values: np.ndarray, name: str) -> np.ndarray:
    """The eight highest bits; fewer bits stretched to 0…255, signed values about 128."""
    bits = bits_of(name)
    if "565" in name:
        return np.stack(
            [values[..., i].astype(int) * 255 // top for i, top in enumerate((31, 63, 31))], axis=-1
        )
    if dtype_of(name).kind == "i":
        return values.astype(int) + (1 << bits - 1) >> bits - 8
    return values.astype(int) >> bits - 8 if bits >= 8 else values.astype(int) * 255 // ((1 << bits) - 1)


def yuv_at(high: np.ndarray, name: str, x: int, y: int) -> tuple[float, float, float]:
    """Luma and chroma of one pixel; a pair of YUV 4:2:2 shares its chroma."""
    if high.shape[2] == 3:
        first_is_u = name.endswith(("_CbYCr", "_UYV"))
        at = (1, 0, 2) if first_is_u else (0, 1, 2)
        return tuple(float(high[y, x, index]) for index in at)
    luma = 1 if name.endswith(("_CbYCrY", "_UYVY")) else 0
    first = x - x % 2
    return float(high[y, x, luma]), float(high[y, first, 1 - luma]), float(high[y, first + 1, 1 - luma])


def rgb_of_yuv(high: np.ndarray, name: str) -> np.ndarray:
    """BT.601 in full range, or the named standard in its limited range."""
    height, width = high.shape[:2]
    standard = re.match(r"YCbCr(601|709|2020)_", name)
    gain, v_red, u_green, v_green, u_blue = (
        MATRICES[standard[1]] if standard else (1.0, 1.402, -0.344136, -0.714136, 1.772)
    )
    rgb = np.zeros((height, width, 3))
    for y in range(height):
        for x in range(width):
            luma, u, v = yuv_at(high, name, x, y)
            light, u, v = gain * (luma - (16 if standard else 0)), u - 128, v - 128
            rgb[y, x] = light + v_red * v, light + u_green * u + v_green * v, light + u_blue * u
    return np.clip(rgb, 0, 255)


def rgb_of_bicolor(high: np.ndarray, name: str) -> np.ndarray:
    """Green in each pixel, the other colours once a pair."""
    first_is_red = "RGBG" in name
    rgb = np.zeros((*high.shape[:2], 3))
    for y in range(high.shape[0]):
        for x in range(high.shape[1]):
            one, two = high[y, x - x % 2, 0], high[y, x - x % 2 + 1, 0]
            rgb[y, x] = (one if first_is_red else two), high[y, x, 1], (two if first_is_red else one)
    return rgb


def expected_rgb(values: np.ndarray, pixel_format: PixelFormat) -> np.ndarray:
    name, family = pixel_format.name, pixel_format.family
    high = eight_bit(values, name)
    if family is Family.BAYER:
        return demosaiced(high, name[5:7])
    if family is Family.YUV:
        return rgb_of_yuv(high, name)
    if family is Family.BICOLOR:
        return rgb_of_bicolor(high, name)
    if family is Family.RGB:
        order = re.match("[RGBa]+", name)[0]
        return np.stack([high[..., order.index(colour)] for colour in "RGB"], axis=-1)
    return np.stack([high] * 3, axis=-1)


def each_format(formats):
    """Run a test with every `pixel_format`."""
    return every_case("pixel_format", formats, ids=str)
