"""Writes frames to an MCAP file as ROS 2 messages."""

from __future__ import annotations

import contextlib
import os
from dataclasses import dataclass
from io import BufferedWriter
from pathlib import Path

import numpy as np
from mcap.writer import CompressionType, Writer
from typing_extensions import override

from grabbergui.core import ros_image
from grabbergui.core.calibration import FrameCalibration
from grabbergui.core.camera_info_message import NAME, CameraInfoFields, fill_camera_info
from grabbergui.core.component import Component, own_component
from grabbergui.core.coord3d import Scan3d
from grabbergui.core.errors import PixelFormatError
from grabbergui.core.frame import Frame
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.pfnc import PixelFormat
from grabbergui.core.ros_encodings import encoding_of
from grabbergui.core.ros_image import RosImage
from grabbergui.recording.mcap_file import SCAN_METADATA
from grabbergui.recording.ros_recording import BESIDE_KEY, CAMERA_INFO, DEVICE_TIME, NOTE
from grabbergui.recording.stored_frames import note_of, unpacked
from grabbergui.recording.writer import CalibrationOf, RecordingWriter

SETS_TOPIC = "/rig/sets"
"""Which frames of several cameras belong together (`std_msgs/String`, JSON). It follows the images, so a file
that was cut short has whole sets only."""


@dataclass
class RecordedTopic:
    """A topic of a recording, and how much was written there."""

    topic: str
    type: str
    messages: int = 0


class McapWriter(RecordingWriter):
    """Writes `sensor_msgs/msg/Image`; the camera's clock, notes and further components on other topics.

    A frame has a note if it has chunk data or an offset, or is incomplete.

    Nothing is compressed; each image has a chunk. The components of a frame share sequence number and time.
    """

    keeps_components = True
    camera = "grabbergui"
    "First part of the topics of the frames that are written now."
    frame_id = "camera"
    "In the headers of their images."

    def __init__(
        self,
        path: Path,
        info: DeviceInfo,
        scan: Scan3d | None = None,
        calibration: CalibrationOf = lambda frame: None,
    ) -> None:
        """`calibration` returns that of a frame, for `camera_info`."""
        self.path = path
        self._calibration = calibration
        self._info: tuple[FrameCalibration | None, CameraInfoFields] = (None, CameraInfoFields())
        "The newest calibration and its message."
        self.topics: dict[int, RecordedTopic] = {}
        "Topics written so far, by channel."
        self.times = (0, 0)
        "Times of the first and last message, nanoseconds."
        self._source = _utf8(info.title)
        self._file: BufferedWriter = path.open("xb")
        # A chunk ends after each image, so that the file is always readable and nothing is copied twice.
        self._writer = Writer(self._file, chunk_size=1, compression=CompressionType.NONE)
        self._writer.start(profile="ros2", library="grabbergui")
        self._writer.add_metadata("grabbergui", {key: _utf8(text) for key, text in info.as_dict().items()})
        if scan is not None and scan.calibrated:
            self._writer.add_metadata(SCAN_METADATA, {"json": scan.as_json()})
        self._image_schema = self._schema(ros_image.IMAGE_NAME, ros_image.IMAGE_DEFINITION)
        self._channels: dict[tuple[str, ...], int] = {}
        self._broken = False

    @property
    def topic(self) -> str:
        """The topic of the images."""
        return f"/{self.camera}/image_raw"

    @override
    def write(self, frame: Frame) -> None:
        """Add a frame, or the frames of several cameras, each on topics of its camera, and which they are."""
        members = frame.members()
        for name, member in members.items():
            self.camera = self.frame_id = name
            self._write(member)
        if members:
            self._write_text(SETS_TOPIC, frame.set_description(), frame.received_ns, frame.frame_id)
        else:
            self._write(frame)

    def _write(self, frame: Frame) -> None:
        own = own_component(frame.parts)
        messages: list[tuple[int, bytes]] = []
        for index, part in enumerate(frame.parts):
            if part is not own:
                messages.append(self._message(frame.of_component(part), part, index))
        # Last, so that a file that was cut short has no frame without its components.
        messages.append(self._message(frame, own, frame.parts.index(own) if own is not None else 0))
        whole = self._file.tell()
        try:
            if frame.timestamp_ns:
                channel = self._channel_below(DEVICE_TIME, ros_image.TIME_NAME, ros_image.TIME_DEFINITION)
                self._add(channel, frame, self._time_of(frame))
            note = note_of(frame, frame.pixel_format)
            if note.chunks or not note.complete or note.offset_x or note.offset_y:
                channel = self._channel_below(NOTE, ros_image.STRING_NAME, ros_image.STRING_DEFINITION)
                self._add(channel, frame, ros_image.encode_string(note.line()))
            if (calibration := self._calibration(frame)) is not None:
                topic = f"/{self.camera}/{CAMERA_INFO}"
                channel = self._channel_of(topic, NAME, ros_image.CAMERA_INFO_DEFINITION)
                self._add(channel, frame, self._camera_info(frame, calibration))
            for channel, message in messages:
                self._add(channel, frame, message)
            self._writer.flush()  # type: ignore[no-untyped-call]
        except OSError:
            self._abandon(whole)
            raise

    @override
    def close(self) -> None:
        """Finish the file; without a summary after a failed write, which readers do not need."""
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

    def _camera_info(self, frame: Frame, calibration: FrameCalibration) -> bytes:
        known, fields = self._info
        if known is not calibration:
            fields = CameraInfoFields()
            fill_camera_info(fields, calibration)
            self._info = calibration, fields
        fields.stamp_ns, fields.frame_id = frame.received_ns, self.frame_id
        return fields.encode()

    def _add(self, channel: int, frame: Frame, message: bytes) -> None:
        self._add_at(channel, frame.received_ns, message, frame.frame_id)

    def _add_at(self, channel: int, time_ns: int, message: bytes, sequence: int) -> None:
        self.topics[channel].messages += 1
        self.times = self.times[0] or time_ns, time_ns
        self._writer.add_message(channel, time_ns, message, time_ns, sequence & 0xFFFF_FFFF)

    def _time_of(self, frame: Frame) -> bytes:
        return ros_image.encode_time_reference(
            frame.received_ns, self.frame_id, frame.timestamp_ns, self._source
        )

    def _schema(self, name: str, definition: str) -> int:
        return int(self._writer.register_schema(name, "ros2msg", definition.encode()))

    def _message(self, image: Frame, part: Component | None, index: int) -> tuple[int, bytes]:
        """Return an image's channel, and the image as a message; `part` is its component, at `index`."""
        pixels, pixel_format = unpacked(image)
        encoding = encoding_of(pixel_format)
        if not encoding:
            raise PixelFormatError(f"ROS has no encoding for {pixel_format}; record a folder instead")
        pixels = np.ascontiguousarray(pixels)
        step, data = pixels.nbytes // image.height, pixels.data.cast("B")
        stamp, frame_id = image.received_ns, self.frame_id
        message = RosImage(stamp, frame_id, image.height, image.width, encoding, 0, step, data)
        return self._image_channel(pixel_format, part, index, own=bool(image.parts)), message.encode()

    def _image_channel(
        self, pixel_format: PixelFormat, part: Component | None, index: int, *, own: bool
    ) -> int:
        metadata = {"offered_qos_profiles": "", "pixel_format": pixel_format.name}
        topic = self.topic
        if part is not None:
            metadata |= {"component": part.kind.name, "index": str(index), "source": str(part.source)}
            metadata |= {"region": str(part.region), "purpose": str(part.purpose)}
            if not own:
                metadata[BESIDE_KEY] = self.topic
                topic = f"/{self.camera}/{part.kind.name.lower()}_{index}/image_raw"
        key = (topic, *metadata.values())
        if key not in self._channels:
            self._channels[key] = self._register(topic, ros_image.IMAGE_NAME, self._image_schema, metadata)
        return self._channels[key]

    def _write_text(self, topic: str, text: str, time_ns: int, sequence: int) -> None:
        """Write a `std_msgs/msg/String` and flush it. Raises OSError."""
        channel = self._channel_of(topic, ros_image.STRING_NAME, ros_image.STRING_DEFINITION)
        self._add_at(channel, time_ns, ros_image.encode_string(text), sequence)
        self._writer.flush()  # type: ignore[no-untyped-call]

    def add_camera(self, name: str, info: DeviceInfo) -> None:
        """Write which camera it is that a name stands for."""
        texts = {key: _utf8(text) for key, text in info.as_dict().items()}
        self._writer.add_metadata(f"camera {name}", texts)

    def _channel_below(self, suffix: str, name: str, definition: str) -> int:
        """Return the channel of what is known of a frame, on a topic below the images'."""
        return self._channel_of(self.topic + suffix, name, definition)

    def _channel_of(self, topic: str, name: str, definition: str) -> int:
        if (topic,) not in self._channels:
            schema, metadata = self._schema(name, definition), {"offered_qos_profiles": ""}
            self._channels[(topic,)] = self._register(topic, name, schema, metadata)
        return self._channels[(topic,)]

    def _register(self, topic: str, name: str, schema: int, metadata: dict[str, str]) -> int:
        channel = int(self._writer.register_channel(topic, "cdr", schema, metadata))
        self.topics[channel] = RecordedTopic(topic, name)
        return channel

    def _abandon(self, size: int) -> None:
        """Remove the part of a frame that was written before the disk was full."""
        self._broken = True
        with contextlib.suppress(OSError):
            self._file.close()  # tries to write the rest again
        os.truncate(self.path, size)


def _utf8(text: str) -> str:
    """Return a text with `?` for characters of file names that are not UTF-8, which MCAP requires."""
    return text.encode("utf-8", "replace").decode("utf-8")
