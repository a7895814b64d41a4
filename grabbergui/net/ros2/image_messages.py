"""Image, camera_info and tf messages: frames, calibrations and a camera's place into messages and back.

A calibration comes from the file that `camera_info_url` names, or from a running camera. The URLs and the
default place are those of ROS's `camera_info_manager`: `file:///folder/front.yaml`,
`package://my_robot/config/front.yaml`; `${NAME}` and `${ROS_HOME}` are filled in.
"""

from __future__ import annotations

import array
import os
import queue
import time
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from grabbergui.core import pfnc, ros_encodings, ros_pictures
from grabbergui.core.calibration import (
    Calibration,
)
from grabbergui.core.camera_info_message import read_camera_info
from grabbergui.core.durations import duration_text
from grabbergui.core.environment import home
from grabbergui.core.errors import PixelFormatError, SourceNotFoundError, UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family, PixelFormat
from grabbergui.core.ros_image import RosImage
from grabbergui.net.ros2.runtime import Ros2Node, full_name

SAME_CLOCK = 5.0
"""Seconds by which a stamp may differ from our clock and still count as of it: images may come late."""
DEFAULT_URL = "file://${ROS_HOME}/camera_info/${NAME}.yaml"
"""The place of a camera for which no other is given."""


def encoding_of(pixel_format: PixelFormat) -> str:
    """Return ROS's encoding of the result of `pixels_of`. Raises PixelFormatError if there is none."""
    if name := ros_encodings.encoding_of(pixel_format):
        return name
    if pixel_format.convertible and not pixel_format.needs_range:
        return "mono8" if pixel_format.family is Family.MONO else "rgb8"
    raise PixelFormatError(
        f"ROS has no encoding for {pixel_format} (0x{pixel_format.code:08X}); set another PixelFormat"
    )


def pixels_of(frame: Frame) -> NDArray[Any]:
    """Return the pixels in the layout of `encoding_of`: a view of the payload except for packed formats.

    Shape (height, width) or (height, width, n); uint8, or 16 and 32 bits in little-endian order. Formats
    without an encoding of their own are converted to mono8 or rgb8.
    """
    if not ros_encodings.encoding_of(frame.pixel_format) and frame.pixel_format.convertible:
        return frame.mono() if frame.pixel_format.family is Family.MONO else frame.rgb()
    pixels = frame.raw()
    return pixels.astype(pixels.dtype.newbyteorder("<"), copy=False)


def describe(message: Any, frame: Frame, pixels: NDArray[Any]) -> None:
    """Write layout and encoding of a frame's pixels into an Image message. Raises PixelFormatError."""
    message.encoding = encoding_of(frame.pixel_format)
    message.height, message.width = frame.height, frame.width
    message.is_bigendian = 0
    message.step = pixels.nbytes // frame.height


def message_bytes(values: NDArray[Any]) -> array.array[int]:
    """Return the bytes in the type that rclpy accepts directly; others it checks and copies byte by byte."""
    data = array.array("B")
    data.frombytes(np.ascontiguousarray(values).data.cast("B"))
    return data


def frame_of(message: Any, frame_id: int) -> Frame:
    """Return an Image message as a frame that shares its bytes. Raises PixelFormatError for one that is none.

    `timestamp_ns` is the stamp; `received_ns` too, unless the publisher's clock is not ours. Encodings that
    no pixel format has, such as nv12, are converted.
    """
    pixel_format = ros_encodings.format_of(message.encoding)
    if pixel_format is None:
        size, layout = (message.height, message.width), (int(message.is_bigendian), message.step)
        image = RosImage(0, "", *size, message.encoding, *layout, memoryview(message.data))
        return frame_of_image(ros_pictures.of_image(image), message.header, frame_id)
    payload = np.frombuffer(message.data, np.uint8)
    padding = message.step - pixel_format.line_bytes(message.width)
    if padding < 0 or message.step * message.height > payload.size or not message.width * message.height:
        raise PixelFormatError(
            f"an image of {message.width}×{message.height} {message.encoding} with lines of "
            f"{message.step} bytes and {payload.size} bytes in all contradicts itself"
        )
    timestamp_ns, received_ns = _times(message.header)
    return Frame(
        payload=payload,
        width=message.width,
        height=message.height,
        pixel_format=pixel_format,
        frame_id=frame_id,
        padding_x=padding,
        big_endian=bool(message.is_bigendian),
        timestamp_ns=timestamp_ns,
        received_ns=received_ns,
    )


def frame_of_image(image: ros_pictures.Picture, header: Any, frame_id: int) -> Frame:
    """Return decoded pixels as a frame with the times of a message's header."""
    pixels, name, width, height = image
    timestamp_ns, received_ns = _times(header)
    return Frame(
        payload=np.ascontiguousarray(pixels).reshape(-1).view(np.uint8),
        width=width,
        height=height,
        pixel_format=pfnc.by_name(name),
        frame_id=frame_id,
        timestamp_ns=timestamp_ns,
        received_ns=received_ns,
    )


def _times(header: Any) -> tuple[int, int]:
    stamp = header.stamp.sec * 1_000_000_000 + header.stamp.nanosec
    now = time.time_ns()
    ours = abs(now - stamp) < SAME_CLOCK * 1e9
    return max(stamp, 0), stamp if ours else now


class Continuity:
    """Compares each frame with the one before. One thread."""

    def __init__(self) -> None:
        self._last: Frame | None = None
        self._foreign_clock = False

    def remarks(self, frame: Frame) -> dict[str, str]:
        """Describe differences from earlier frames, by kind: size or format, and the publisher's clock."""
        last, self._last = self._last, frame
        found = {}
        if last is not None and _layout(last) != _layout(frame):
            found["layout"] = f"images are {_layout(frame)} now, they were {_layout(last)}"
        back = (last.timestamp_ns - frame.timestamp_ns) / 1e9 if last is not None else 0
        if back > 0 and frame.timestamp_ns:
            found["jump"] = (
                f"stamps went back by {duration_text(back)}: the publisher's clock was set, or a recording"
                " started again"
            )
        foreign = bool(frame.timestamp_ns) and frame.received_ns != frame.timestamp_ns
        if foreign and not self._foreign_clock:
            off = (frame.timestamp_ns - frame.received_ns) / 1e9
            side = "ahead of" if off > 0 else "behind"
            found["clock"] = (
                f"stamps are {duration_text(abs(off))} {side} this machine's clock; times of arrival are used"
            )
        self._foreign_clock = foreign
        return found


def _layout(frame: Frame) -> str:
    return f"{frame.width}×{frame.height} {frame.pixel_format}"


def path_of(url: str, camera: str) -> Path:
    """Return the file that a URL means for the camera of that full name. Raises UsageError.

    The file is named after the camera with `_` for `/`, so that cameras of two namespaces have two files.
    """
    filled = (url or DEFAULT_URL).replace("${NAME}", camera.strip("/").replace("/", "_"))
    filled = filled.replace("${ROS_HOME}", os.environ.get("ROS_HOME") or str(home() / ".ros"))
    scheme, _, rest = filled.partition("://")
    if scheme == "file" and rest.startswith("/"):
        return Path(unquote(rest))
    package, _, inside = rest.partition("/")
    if scheme == "package" and package and inside:
        return _share_of(package, url) / unquote(inside)
    raise UsageError(
        f"camera_info_url {url}: write file:///folder/camera.yaml or package://PACKAGE/camera.yaml"
    )


def _share_of(package: str, url: str) -> Path:
    from ament_index_python.packages import PackageNotFoundError, get_package_share_directory

    try:
        return Path(get_package_share_directory(package))
    except (PackageNotFoundError, ValueError, OSError) as error:  # no name of a package; no index to look in
        raise UsageError(f"camera_info_url {url}: package {package} is not found: {error}") from error


def receive_camera_info(camera: str, timeout: float = 15.0) -> tuple[Calibration, str]:
    """Wait for one `sensor_msgs/CameraInfo` of a camera, named as itself or by its `image_raw`.

    Returns its calibration and the frame that its images are taken in, empty if it names none.
    Raises SourceNotFoundError where none comes within `timeout` seconds, UsageError where it is empty, or the
    name is none.
    """
    name, _, last = full_name(camera.partition("?")[0], camera).rpartition("/")
    topic = f"{name}/camera_info" if last.startswith("image") else f"{name}/{last}/camera_info"
    ros = Ros2Node(f"grabbergui_calibration_{time.time_ns() % 10**9}")
    try:
        from rclpy.qos import qos_profile_sensor_data
        from sensor_msgs.msg import CameraInfo

        messages: queue.Queue[Any] = queue.Queue()
        ros.node.create_subscription(CameraInfo, topic, messages.put, qos_profile_sensor_data)
        ros.start()
        try:
            message = messages.get(timeout=timeout)
            return read_camera_info(message, camera), message.header.frame_id.lstrip("/")
        except queue.Empty:
            raise SourceNotFoundError(f"nobody publishes {topic}; give --calibration FILE") from None
        except UsageError as error:
            raise UsageError(f"{topic}: {error}; give --calibration FILE") from error
    finally:
        ros.close()
