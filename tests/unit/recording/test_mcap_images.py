"""Images that others put into MCAP files, as their fields allow it."""

import numpy as np
import pytest
from mcap.writer import CompressionType, Writer

from grabbergui.core.errors import UsageError
from grabbergui.core.ros_image import IMAGE_DEFINITION, IMAGE_NAME, RosImage
from grabbergui.recording import message_store
from grabbergui.recording.errors import RecordingError
from grabbergui.recording.mcap_file import McapFile
from grabbergui.recording.ros_recording import RosRecording


@pytest.fixture
def written(tmp_path):
    recordings = []

    def write(*images, name="recording.mcap", zeros=0):
        path = tmp_path / name
        with path.open("wb") as file:
            writer = Writer(file, chunk_size=1, compression=CompressionType.NONE)
            writer.start()
            schema = writer.register_schema(IMAGE_NAME, "ros2msg", IMAGE_DEFINITION.encode())
            channel = writer.register_channel("/image", "cdr", schema)
            for index, image in enumerate(images):
                writer.add_message(channel, index, image.encode(), index)
            if zeros:  # as after a power cut: no end, and zeros where the file was to grow
                file.truncate(file.tell() + zeros)
            else:
                writer.finish()
        recordings.append(RosRecording(path, [McapFile(path)]))
        return recordings[-1]

    yield write
    for recording in recordings:
        recording.close()


def image(data, encoding, width, height, step, *, big=0):
    return RosImage(0, "camera", height, width, encoding, big, step, data)


@pytest.mark.parametrize(
    ("encoding", "width", "height", "step", "size"),
    [
        ("mono8", 4, 0, 4, 16),
        ("mono8", 0, 4, 4, 16),
        ("mono8", 4, 4, 0, 16),
        ("mono16", 4, 3, 5, 15),
        ("mono16", 4, 3, 5, 32),
        ("rgb8", 4, 4, 11, 44),
        ("mono8", 2**31, 2**31, 0, 0),
    ],
)
@pytest.mark.parametrize("big", [0, 1])
def test_images_with_impossible_lines_are_refused(written, encoding, width, height, step, size, big):
    recording = written(image(bytes(size), encoding, width, height, step, big=big))
    with pytest.raises(RecordingError, match="is impossible"):
        recording.frame(0, 0)


def test_big_endian_pixels_of_16_bits_are_turned_with_padded_lines_too(written):
    values = np.arange(12, dtype=np.uint16).reshape(3, 4) * 1000
    lines = np.zeros((3, 11), np.uint8)  # three bytes of padding: an odd number
    lines[:, :8] = values.astype(">u2").view(np.uint8)
    frame = written(image(lines.tobytes(), "mono16", 4, 3, 11, big=1)).frame(0, 0)
    assert np.array_equal(frame.raw(), values)


@pytest.mark.parametrize(
    ("encoding", "sample", "channels"),
    [("16UC3", "u2", 3), ("16SC1", "i2", 1), ("32FC1", "f4", 1), ("64FC1", "f8", 1), ("rgba16", "u2", 4)],
)
def test_big_endian_samples_of_any_size_and_kind_are_turned(written, encoding, sample, channels):
    values = np.arange(2 * 3 * channels).reshape(2, 3, channels).squeeze() * 100 - 50 * ("u" not in sample)
    data = values.astype(f">{sample}").tobytes()
    frame = written(image(data, encoding, 3, 2, len(data) // 2, big=1)).frame(0, 0)
    assert np.array_equal(frame.raw(), values)


def test_an_unknown_encoding_is_named(written):
    recording = written(image(bytes(64), "64FC4", 2, 1, 64))
    with pytest.raises(RecordingError, match="'64FC4' cannot be shown"):
        recording.frame(0, 0)


@pytest.mark.parametrize("encoding", ["yuv422", "yuv422_yuy2", "rgb8", "mono8"])
def test_the_byte_order_of_single_bytes_is_ignored(written, encoding):
    data = np.random.default_rng(1).integers(0, 256, 4 * 2 * 3, np.uint8).tobytes()
    step = 12 if encoding == "rgb8" else 8
    images = (image(data, encoding, 4, 2, step, big=flag) for flag in (0, 1))
    little, big = (written(one, name=f"{one.is_bigendian}.mcap").frame(0, 0) for one in images)
    assert np.array_equal(little.rgb(), big.rgb())


def test_more_messages_than_memory_could_hold_are_refused(written, monkeypatch):
    monkeypatch.setattr(message_store, "MOST_MESSAGES", 2)
    images = [image(bytes(16), "mono8", 4, 4, 4)] * 3
    assert len(written(*images[:2], name="two.mcap")) == 2
    with pytest.raises(UsageError, match="more than 2 messages"):
        written(*images, name="three.mcap")


def test_zeros_at_the_end_are_ignored(written):
    recording = written(image(bytes(16), "mono8", 4, 4, 4), zeros=4 << 30)  # sparse
    assert len(recording) == 1
    assert recording.frame(0, 0).complete
