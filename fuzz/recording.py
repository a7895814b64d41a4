"""Files that are played back or loaded: MCAP, ROS images, notes, image stills, calibrations."""

from __future__ import annotations

import io
import tempfile
from pathlib import Path

import cv2
import numpy as np
from mcap.writer import CompressionType, Writer

from fuzz._input import Input, erring, refusing
from grabbergui.calibration import camera_info
from grabbergui.calibration.opencv_yaml import read_yaml
from grabbergui.core import encoded_image, ros_image
from grabbergui.core.calibration import Calibration
from grabbergui.core.ros_image import RosImage
from grabbergui.recording.mcap_file import McapFile
from grabbergui.recording.notes import FrameNote, read_notes
from grabbergui.recording.ros_recording import RosRecording
from grabbergui.recording.stored_frames import rebuilt

FILE = Path(tempfile.gettempdir()) / f"grabbergui-fuzz-{id(object()):x}"


def seeds() -> list[bytes]:
    """Return a small recording of each compression, a message of each type, notes, images, a calibration."""
    image = RosImage(5, "camera", 4, 6, "bayer_rggb8", 0, 8, bytes(range(32)))
    pixels = np.arange(6 * 5 * 3, dtype=np.uint8).reshape(5, 6, 3)
    stills = [cv2.imencode(kind, pixels)[1].tobytes() for kind in (".png", ".jpg", ".bmp", ".tiff")]
    note = FrameNote(file="0.png", width=6, height=4, pixel_format="BayerRG8", received_ns=10**18)
    return [
        *(b"\0" + _mcap(image, kind) for kind in CompressionType),
        b"\1" + image.encode(),
        b"\1" + ros_image.encode_time_reference(5, "camera", 7, "clock"),
        b"\2" + note.line().encode() * 2,
        *(b"\3" + still for still in stills),
        b"\4" + camera_info.dump(Calibration.from_field_of_view(64, 48)).encode(),
    ]


def _mcap(image: RosImage, compression: CompressionType) -> bytes:
    file = io.BytesIO()
    writer = Writer(file, compression=compression)
    writer.start()
    for name, definition, message in (
        (ros_image.IMAGE_NAME, ros_image.IMAGE_DEFINITION, image.encode()),
        (ros_image.TIME_NAME, ros_image.TIME_DEFINITION, ros_image.encode_time_reference(5, "c", 7, "")),
    ):
        schema = writer.register_schema(name, "ros2msg", definition.encode()[:80])
        topic = "/image" if name == ros_image.IMAGE_NAME else "/image/device_time"
        channel = writer.register_channel(topic, "cdr", schema, {"pixel_format": "BayerRG8"})
        writer.add_message(channel, 1, message, 1)
    writer.finish()  # type: ignore[no-untyped-call]
    return file.getvalue()


def one_input(data: bytes) -> None:
    """Feed the part that the first byte chooses."""
    source = Input(data)
    (_recording, _message, _notes, _image, _calibration)[source.number(1) % 5](source)


def _recording(source: Input) -> None:
    FILE.write_bytes(source.rest())
    try:
        recording = erring(lambda: RosRecording(FILE, [McapFile(FILE)]))
        if recording is not None:
            for index in range(min(len(recording), 20)):
                erring(recording.frame, index, 0)
            recording.close()
    finally:
        FILE.unlink()


def _message(source: Input) -> None:
    data = source.rest()
    refusing(ros_image.decode_time_reference, data)
    image = refusing(RosImage.decode, data)
    if image is not None and len(image.data) < image.step * image.height:
        raise AssertionError(image)


def _notes(source: Input) -> None:
    FILE.write_bytes(source.rest())
    try:
        for note in erring(lambda: list(read_notes(FILE))) or ():
            erring(rebuilt, np.zeros((8, 8), np.uint8), note, 0)
    finally:
        FILE.unlink()


def _image(source: Input) -> None:
    image = refusing(encoded_image.decode, np.frombuffer(source.rest(), np.uint8))
    if image is not None and image.shape[0] * image.shape[1] > encoded_image.MOST_PIXELS:
        raise AssertionError(image.shape)


def _calibration(source: Input) -> None:
    text = source.rest().decode("utf-8", "replace")
    values = erring(read_yaml, text, "input")
    calibration = erring(camera_info.parse, text)
    if calibration is not None:
        again = camera_info.parse(camera_info.dump(calibration))
        if values is None or not np.array_equal(again.matrix, calibration.matrix):
            raise AssertionError(calibration)
