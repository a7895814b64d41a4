"""Our MCAP files in the hands of readers that others wrote, as users' tools would read them."""

import json

import numpy as np
import pytest

from grabbergui import sources
from grabbergui.recording.kinds import RecordingKind
from grabbergui.recording.recorder import Recorder, RecordingLimits, create_writer
from patience import PATIENCE

TOPIC = "/grabbergui/image_raw"
FRAMES = 6


@pytest.fixture(params=["Mono8", "BayerRG8", "RGB8", "Mono12p", "YUV422_8"])
def recorded(request, tmp_path):
    """A recording of the simulated camera, and the frames that went into it."""
    camera = sources.create(f"sim:?width=64&height=48&fps=100&pixel_format={request.param}")
    camera.open()
    camera.write_feature("OffsetX", 8)
    camera.write_feature("ChunkModeActive", True)
    frames, path = [], tmp_path / "recorded.mcap"
    writer = create_writer(RecordingKind.MCAP, path, camera.info)
    write = writer.write
    writer.write = lambda frame: (frames.append(frame), write(frame))
    recorder = Recorder(camera, writer, RecordingLimits(frames=FRAMES))
    recorder.start()
    camera.start()
    assert recorder.wait(PATIENCE)
    camera.close()
    return path, frames


def same_image(message, frame):
    """Whether a message has a frame's pixels; packed formats are unpacked in it."""
    raw = frame.raw()
    assert (message.width, message.height) == (frame.width, frame.height)
    data = np.frombuffer(bytes(message.data), raw.dtype.newbyteorder("<"))
    return np.array_equal(data, raw.reshape(-1))


def test_rosbags_reads_it_as_a_rosbag2(recorded):
    highlevel = pytest.importorskip("rosbags.highlevel", reason="needs the package rosbags")
    typesys = pytest.importorskip("rosbags.typesys")
    path, frames = recorded
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    with highlevel.AnyReader([path], default_typestore=store) as reader:
        assert {c.topic: (c.msgtype, c.msgcount) for c in reader.connections} == {
            TOPIC: ("sensor_msgs/msg/Image", FRAMES),
            f"{TOPIC}/device_time": ("sensor_msgs/msg/TimeReference", FRAMES),
            f"{TOPIC}/note": ("std_msgs/msg/String", FRAMES),
        }
        images = [c for c in reader.connections if c.topic == TOPIC]
        read = [(time, reader.deserialize(raw, c.msgtype)) for c, time, raw in reader.messages(images)]
        times = [c for c in reader.connections if c.topic == f"{TOPIC}/device_time"]
        clocks = [reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages(times)]
        notes = [c for c in reader.connections if c.topic == f"{TOPIC}/note"]
        noted = [json.loads(reader.deserialize(raw, c.msgtype).data) for c, _, raw in reader.messages(notes)]
    assert [time for time, _ in read] == [frame.received_ns for frame in frames]
    for (_, image), frame in zip(read, frames, strict=True):
        assert same_image(image, frame)
        assert image.header.stamp.sec * 10**9 + image.header.stamp.nanosec == frame.received_ns
    assert [note["chunks"] for note in noted] == [frame.chunks for frame in frames]
    assert [note["offset_x"] for note in noted] == [frame.offset_x for frame in frames]
    for clock, frame in zip(clocks, frames, strict=True):
        assert clock.time_ref.sec * 10**9 + clock.time_ref.nanosec == frame.timestamp_ns


def test_foxgloves_own_decoder_reads_it(recorded):
    ros2 = pytest.importorskip("mcap_ros2.reader", reason="needs the package mcap-ros2-support")
    path, frames = recorded
    images = [message.ros_msg for message in ros2.read_ros2_messages(str(path), topics=[TOPIC])]
    assert len(images) == FRAMES
    assert all(same_image(image, frame) for image, frame in zip(images, frames, strict=True))
