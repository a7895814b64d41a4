"""CompressedImage messages as image_transport's plug-ins write and read them.

`compressed` is JPEG or PNG; its `format` names the image's encoding and that of the file, as in
`bgr8; jpeg compressed bgr8`. JPEG has 8 bits; PNG keeps 16, and a Bayer pattern. `compressedDepth` is a
header of 12 bytes (`compressed_depth_image_transport`), then PNG with 16 bits: of 16UC1 as they are, of 32FC1
(metres) their inverse, which is finest nearby.
"""

from __future__ import annotations

import array
import struct
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core import ros_encodings, ros_pictures
from grabbergui.core.errors import PixelFormatError
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family
from grabbergui.core.ros_image import RosCompressedImage
from grabbergui.net.ros2.image_messages import frame_of_image, pixels_of

COMPRESSED, COMPRESSED_DEPTH = "compressed", "compressedDepth"
"""Last parts of the topics, below that of the plain images."""
JPEG, PNG = "jpeg", "png"
FORMATS = (JPEG, PNG)
QUALITY = 90
"""Quality of JPEG by default, 1 to 100."""
PNG_LEVEL = 3
"""Compression of PNG by default, 1 (fast) to 9 (small)."""
DEPTH_MAX, DEPTH_QUANTIZATION = 10.0, 100.0
"""The plug-in's defaults: the farthest distance in metres, and how much finer near ones are stored."""


def frame_of_compressed(message: Any, frame_id: int) -> Frame:
    """Decode a message. Raises PixelFormatError for one that is damaged or cannot be shown."""
    image = RosCompressedImage(0, message.format, memoryview(message.data))
    return frame_of_image(ros_pictures.of_compressed(image), message.header, frame_id)


def fill_jpeg(message: Any, frame: Frame, quality: int) -> None:
    """Encode a frame with 8 bits, grey or colour. Raises PixelFormatError."""
    mono = frame.pixel_format.family in (Family.MONO, Family.COORDINATES)
    image = frame.mono() if mono else cv2.cvtColor(frame.rgb(), cv2.COLOR_RGB2BGR)
    # The encoding that image_transport's subscribers give the decoded image precedes that of the JPEG.
    encoding = "mono8" if mono else "bgr8"
    message.format = f"{encoding}; jpeg compressed {encoding}"
    message.data = _file(".jpg", image, cv2.IMWRITE_JPEG_QUALITY, quality)


def fill_png(message: Any, frame: Frame, level: int) -> None:
    """Encode a frame without loss: grey and Bayer patterns with their bits, colours with 8 or 16.

    Raises PixelFormatError.
    """
    encoding = ros_encodings.encoding_of(frame.pixel_format)
    pixels = pixels_of(frame)
    if pixels.dtype.itemsize > 2 or pixels.dtype.kind != "u":
        raise PixelFormatError(f"{frame.pixel_format} has no PNG; subscribe to the plain images")
    bits = 8 * pixels.dtype.itemsize
    if pixels.ndim == 2 and encoding:
        message.format = f"{encoding}; png compressed {encoding}"
    elif encoding.startswith(("rgb", "bgr")):
        order = {"rgb": cv2.COLOR_RGB2BGR, "rgba": cv2.COLOR_RGBA2BGR, "bgra": cv2.COLOR_BGRA2BGR}
        name = encoding.rstrip("0123456789")
        pixels = pixels if name == "bgr" else np.asarray(cv2.cvtColor(pixels, order[name]))
        message.format = f"bgr{bits}; png compressed bgr{bits}"
    else:
        pixels = np.asarray(cv2.cvtColor(frame.rgb(), cv2.COLOR_RGB2BGR))
        message.format = "bgr8; png compressed bgr8"
    message.data = _file(".png", pixels, cv2.IMWRITE_PNG_COMPRESSION, level)


def is_depth(frame: Frame) -> bool:
    """Return whether `fill_depth` accepts a frame: distances of 16 or 32 bits, one for each pixel."""
    return ros_encodings.encoding_of(frame.pixel_format) in ("16UC1", "32FC1")


def fill_depth(
    message: Any,
    frame: Frame,
    level: int,
    depth_max: float = DEPTH_MAX,
    quantization: float = DEPTH_QUANTIZATION,
) -> None:
    """Encode a frame of distances, of 32FC1 those up to `depth_max` metres."""
    encoding, pixels = ros_encodings.encoding_of(frame.pixel_format), pixels_of(frame)
    a = b = 0.0
    if encoding == "32FC1":
        a = quantization * (quantization + 1.0)
        b = 1.0 - a / depth_max
        with np.errstate(divide="ignore", invalid="ignore"):
            usable = (pixels > 0) & (pixels < DEPTH_MAX)
            inverse = np.where(usable, a / np.where(usable, pixels, 1.0) + b, 0.0)
        pixels = np.clip(np.rint(inverse), 0, 65535).astype(np.uint16)
    message.format = f"{encoding}; compressedDepth png"
    message.data = array.array("B", struct.pack("<iff", 0, a, b)) + _file(
        ".png", pixels, cv2.IMWRITE_PNG_COMPRESSION, level
    )


def _file(suffix: str, image: NDArray[Any], option: int, value: int) -> array.array[int]:
    done, encoded = cv2.imencode(suffix, np.ascontiguousarray(image), [option, value])
    if not done:
        raise PixelFormatError(f"an image of {image.shape[1]}×{image.shape[0]} cannot be written as {suffix}")
    return array.array("B", encoded.tobytes())
