"""ROS's images, plain and compressed, recorded or received, as pixels in PFNC's formats.

Encodings without a PFNC format become one that holds the same samples: the chroma of 4:2:0 (nv12, nv21, i420)
is repeated in every second line of YUV422_8, nv24 is interleaved as YUV8_UYV, and 32FC4 loses its fourth
value.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grabbergui.core import encoded_image, pfnc, ros_encodings
from grabbergui.core.errors import PixelFormatError, RemoteProtocolError
from grabbergui.core.pfnc import Family, PixelFormat
from grabbergui.core.ros_image import RosCompressedImage, RosImage

Picture = tuple[NDArray[Any], str, int, int]
"Lines of pixels, the PFNC name of their format, width, height."

_SEMIPLANAR = {"nv12": (0, 1), "nv21": (1, 0)}
"Where U and V are in a pair."
_PLANAR = ("i420", "yuv420", "yuv420p", "iyuv")
KNOWN = (*ros_encodings.FORMATS, *_SEMIPLANAR, *_PLANAR, "nv24", "32FC4")
"Encodings of images that can be shown."
_OF_FILES = {(1, "u1"): "Mono8", (1, "u2"): "Mono16", (3, "u1"): "BGR8", (3, "u2"): "BGR16",
             (4, "u1"): "BGRa8", (4, "u2"): "BGRa16", (1, "i1"): "Data8s", (1, "i2"): "Data16s",
             (1, "i4"): "Data32s", (1, "f4"): "Coord3D_C32f", (1, "f8"): "Data64f"}  # fmt: skip
"Pixel formats of decoded image files, by number of components and type of values."


def of_file(pixels: NDArray[Any]) -> str:
    """Return the PFNC name for pixels of an image file in OpenCV's layout; empty for unknown ones."""
    components = pixels.shape[2] if pixels.ndim == 3 else 1
    return _OF_FILES.get((components, pixels.dtype.str[1:]), "")


def of_image(
    image: RosImage, recorded_format: str = "", *, named: Callable[[str], PixelFormat] = pfnc.by_name
) -> Picture:
    """Return an image's pixels, in the format that a recorder noted if it did. Raises PixelFormatError.

    `named` returns the format that a name means, and raises as it likes for one that means none.
    """
    encoding = image.encoding
    if not recorded_format:
        if encoding in _SEMIPLANAR or encoding in _PLANAR:
            return _of_subsampled(image), "YUV422_8", image.width, image.height
        if encoding == "nv24":
            return _of_nv24(image), "YUV8_UYV", image.width, image.height
        if encoding == "32FC4":
            lines = _of_lines(image, 16 * image.width).view(">f4" if image.is_bigendian else "<f4")
            points = lines.reshape(image.height, image.width, 4)[..., :3].astype("<f4")
            return np.ascontiguousarray(points), "Coord3D_ABC32f", image.width, image.height
    name = recorded_format or ros_encodings.FORMATS.get(encoding, "")
    if not name:
        raise PixelFormatError(
            f"images with the encoding '{encoding[:40]}' cannot be shown; known are {', '.join(KNOWN)}"
        )
    pixel_format = named(name)
    line = pixel_format.line_bytes(image.width)
    lines = _of_lines(image, line)
    size = pixel_format.sample_bytes
    # The flag is meaningless for 8-bit components, including YUV.
    if image.is_bigendian and size > 1 and not pixel_format.packed:
        sample = f"{pixel_format.kind}{size}"
        lines = lines.view(f">{sample}").astype(f"<{sample}")
    return lines, name, image.width, image.height


def _of_lines(
    image: RosImage, line: int, offset: int = 0, count: int = 0, step: int = 0
) -> NDArray[np.uint8]:
    """Return lines without padding: (count, line) uint8, by default of the whole image."""
    count, step = count or image.height, step or image.step
    if not count or not line or line > step or offset + count * step > len(image.data):
        raise PixelFormatError(
            f"an image of {image.width}×{image.height} {image.encoding[:40]} in lines of "
            f"{image.step} bytes is impossible"
        )
    padded = np.frombuffer(image.data, np.uint8)[offset : offset + count * step]
    return np.ascontiguousarray(padded.reshape(count, step)[:, :line])


def _of_subsampled(image: RosImage) -> NDArray[np.uint8]:
    width, height = image.width, image.height
    if width % 2 or height % 2:
        raise PixelFormatError(f"an image of {width}×{height} {image.encoding} needs even sides")
    luma, offset = _of_lines(image, width), image.step * height
    pixels = np.empty((height, width, 2), np.uint8)
    pixels[..., 0] = luma
    if image.encoding in _PLANAR:
        step = image.step // 2
        chroma_u = _of_lines(image, width // 2, offset, height // 2, step)
        chroma_v = _of_lines(image, width // 2, offset + step * (height // 2), height // 2, step)
    else:
        pairs = _of_lines(image, width, offset, height // 2).reshape(height // 2, width // 2, 2)
        u, v = _SEMIPLANAR[image.encoding]
        chroma_u, chroma_v = pairs[..., u], pairs[..., v]
    pixels[:, 0::2, 1] = np.repeat(chroma_u, 2, axis=0)
    pixels[:, 1::2, 1] = np.repeat(chroma_v, 2, axis=0)
    return pixels


def _of_nv24(image: RosImage) -> NDArray[np.uint8]:
    width, height = image.width, image.height
    luma = _of_lines(image, width)
    pairs = _of_lines(image, 2 * width, image.step * height, height, 2 * image.step)
    pixels = np.empty((height, width, 3), np.uint8)
    pixels[..., 1] = luma
    pixels[..., [0, 2]] = pairs.reshape(height, width, 2)
    return pixels


def of_compressed(image: RosCompressedImage) -> Picture:
    """Return the pixels of a compressed image. Raises PixelFormatError."""
    described, _, how = (part.strip() for part in image.format.partition(";"))
    try:
        if "compressedDepth" in how:
            pixels = _of_depth(described, image.data)
        else:
            pixels = encoded_image.decode(np.frombuffer(image.data, np.uint8))
    except RemoteProtocolError as error:
        raise PixelFormatError(f"a compressed image ('{image.format[:60]}'): {error}") from None
    name = of_file(pixels)
    plain = ros_encodings.FORMATS.get(described, "")
    # Files tell grey from colour; Bayer patterns, depth and signed values are only in the encoding.
    if plain and pixels.ndim == 2:
        named = pfnc.by_name(plain)
        if (
            named.family is not Family.RGB
            and named.sample_bytes == pixels.dtype.itemsize
            and named.components == 1
        ):
            name = plain
    if not name:
        raise PixelFormatError(
            f"a compressed image of {pixels.dtype} ('{image.format[:60]}') cannot be shown"
        )
    return pixels, name, pixels.shape[1], pixels.shape[0]


def _of_depth(encoding: str, data: memoryview) -> NDArray[Any]:
    """Decode compressed_depth_image_transport: a header of 12 bytes, then PNG.

    Distances as 32-bit floats (metres) are stored as inverse depth: a / (value - b), and 0 where nothing was
    measured. Raises RemoteProtocolError.
    """
    if len(data) < 12:
        raise RemoteProtocolError(f"only {len(data)} bytes")
    _, a, b = struct.unpack_from("<iff", data)
    stored = encoded_image.decode(np.frombuffer(data[12:], np.uint8))
    if encoding != "32FC1" or stored.dtype != np.uint16:
        return stored
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        depth = np.float32(a) / (stored.astype(np.float32) - np.float32(b))
    return np.where(stored > 0, depth, np.float32(np.nan)).astype(np.float32)
