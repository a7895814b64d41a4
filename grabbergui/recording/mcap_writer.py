"""Frames into an MCAP file, as ROS 2 messages."""

from __future__ import annotations

import contextlib
import os
from io import BufferedWriter
from pathlib import Path

import numpy as np
from mcap.writer import CompressionType, Writer
from typing_extensions import override

from grabbergui.core.errors import PixelFormatError
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import DeviceInfo
from grabbergui.core.pfnc import PixelFormat
from grabbergui.recording import ros_image
from grabbergui.recording.recording import unpacked
from grabbergui.recording.ros_image import RosImage
from grabbergui.recording.writer import RecordingWriter


class McapWriter(RecordingWriter):
    """`sensor_msgs/msg/Image`, a chunk a frame, not compressed; the camera's clock on a topic beside."""

    TOPIC = "/grabbergui/image_raw"
    FRAME_ID = "camera"

    def __init__(self, path: Path, info: DeviceInfo) -> None:
        self.path = path
        self._source = info.title
        self._file: BufferedWriter = path.open("xb")
        # A chunk ends after each image: the file on the disk is readable, and nothing is copied twice.
        self._writer = Writer(self._file, chunk_size=1, compression=CompressionType.NONE)
        self._writer.start(profile="ros2", library="grabbergui")
        self._writer.add_metadata("grabbergui", info.as_dict())
        self._image_schema = self._schema(ros_image.IMAGE_NAME, ros_image.IMAGE_DEFINITION)
        self._time_schema = self._schema(ros_image.TIME_NAME, ros_image.TIME_DEFINITION)
        self._channels: dict[str, int] = {}
        self._clock: int | None = None
        self._broken = False

    @override
    def write(self, frame: Frame) -> None:
        pixels, pixel_format = unpacked(frame)
        encoding = ros_image.encoding_of(pixel_format)
        if encoding is None:
            raise PixelFormatError(f"ROS has no encoding for {pixel_format}; record a folder instead")
        pixels = np.ascontiguousarray(pixels)
        step = pixels.nbytes // frame.height
        image = RosImage(
            frame.received_ns,
            self.FRAME_ID,
            frame.height,
            frame.width,
            encoding,
            0,
            step,
            pixels.data.cast("B"),
        )
        whole = self._file.tell()
        try:
            if frame.timestamp_ns:
                self._add(self._clock_channel(), frame, self._time_of(frame))
            self._add(self._image_channel(pixel_format), frame, image.encode())
            self._writer.flush()  # type: ignore[no-untyped-call]
        except OSError:
            self._abandon(whole)
            raise

    @override
    def close(self) -> None:
        """After a failed write the summary is left out; readers do without."""
        if self._file.closed:
            return
        try:
            if not self._broken:
                self._writer.finish()  # type: ignore[no-untyped-call]
        finally:
            self._file.close()

    @override
    def size(self) -> int:
        return self._file.tell() if not self._file.closed else self.path.stat().st_size

    def _add(self, channel: int, frame: Frame, message: bytes) -> None:
        sequence = frame.frame_id & 0xFFFF_FFFF
        self._writer.add_message(channel, frame.received_ns, message, frame.received_ns, sequence)

    def _time_of(self, frame: Frame) -> bytes:
        return ros_image.encode_time_reference(
            frame.received_ns, self.FRAME_ID, frame.timestamp_ns, self._source
        )

    def _schema(self, name: str, definition: str) -> int:
        return int(self._writer.register_schema(name, "ros2msg", definition.encode()))

    def _image_channel(self, pixel_format: PixelFormat) -> int:
        if pixel_format.name not in self._channels:
            metadata = {"offered_qos_profiles": "", "pixel_format": pixel_format.name}
            channel = self._writer.register_channel(self.TOPIC, "cdr", self._image_schema, metadata)
            self._channels[pixel_format.name] = int(channel)
        return self._channels[pixel_format.name]

    def _clock_channel(self) -> int:
        if self._clock is None:
            metadata = {"offered_qos_profiles": ""}
            topic = f"{self.TOPIC}/device_time"
            self._clock = int(self._writer.register_channel(topic, "cdr", self._time_schema, metadata))
        return self._clock

    def _abandon(self, size: int) -> None:
        """Take away the half of a frame that did not fit any more."""
        self._broken = True
        with contextlib.suppress(OSError):
            self._file.close()  # tries to write the rest once more
        os.truncate(self.path, size)
