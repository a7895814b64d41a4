"""Images published from memory of ours, as another node receives them."""

import numpy as np
import pytest

from grabbergui.core import pfnc
from grabbergui.core.frame import Frame
from grabbergui.net.ros2 import image_writer
from grabbergui.net.ros2.image_messages import encoding_of, pixels_of
from grabbergui.net.ros2.image_writer import ImageWriter
from patience import PATIENCE, until

pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")
pytestmark = pytest.mark.ros2

from rclpy.exceptions import InvalidHandle  # noqa: E402
from sensor_msgs.msg import Image  # noqa: E402


@pytest.fixture
def topic(probe):
    """A publisher that the probe's subscription has found, and the messages that come."""
    messages = probe.subscribe(Image, "/written")
    publisher = probe.node.create_publisher(Image, "/written", 5)
    until(lambda: publisher.get_subscription_count() == 1)
    return publisher, messages


def a_frame(name="Mono8", width=6, height=3, padding=0):
    pixel_format = pfnc.by_name(name)
    size = height * (pixel_format.line_bytes(width) + padding)
    return Frame(
        payload=np.arange(size).astype(np.uint8),
        width=width,
        height=height,
        pixel_format=pixel_format,
        frame_id=1,
        timestamp_ns=1,
        received_ns=1,
        padding_x=padding,
    )


def a_message():
    message = Image()
    message.header.frame_id = "camera"
    message.header.stamp.sec, message.header.stamp.nanosec = 5, 7
    return message


def assert_shows(message, frame):
    assert message.header == a_message().header
    assert (message.width, message.height) == (frame.width, frame.height)
    assert (message.encoding, message.is_bigendian) == (encoding_of(frame.pixel_format), 0)
    assert message.step * message.height == len(message.data)
    assert bytes(message.data) == pixels_of(frame).tobytes()


@pytest.mark.parametrize("padding", [0, 5])
@pytest.mark.parametrize("name", ["Mono8", "Mono16", "RGB8", "Mono12p", "Coord3D_C32f"])
def test_a_reader_gets_the_pixels(topic, name, padding):
    publisher, messages = topic
    frame, message = a_frame(name, padding=padding), a_message()

    ImageWriter().publish([publisher], message, frame)

    assert_shows(messages.get(timeout=PATIENCE), frame)
    assert not message.data, "rclpy copied the pixels"


def test_frames_of_any_size_follow_each_other(topic):
    publisher, messages = topic
    writer = ImageWriter()

    for frame in (a_frame(width=8), a_frame(width=2), a_frame(width=500, height=400)):
        writer.publish([publisher], a_message(), frame)
        assert_shows(messages.get(timeout=PATIENCE), frame)


def test_two_topics_have_the_same_image(topic, probe):
    publisher, messages = topic
    others = probe.subscribe(Image, "/written_too")
    other = probe.node.create_publisher(Image, "/written_too", 5)
    until(lambda: other.get_subscription_count() == 1)

    ImageWriter().publish([publisher, other], a_message(), a_frame())

    assert messages.get(timeout=PATIENCE) == others.get(timeout=PATIENCE)


def test_without_the_library_rclpy_publishes(topic, monkeypatch):
    publisher, messages = topic
    monkeypatch.setattr(image_writer, "_rcl", lambda: None)

    ImageWriter().publish([publisher], a_message(), a_frame())

    assert_shows(messages.get(timeout=PATIENCE), a_frame())


def test_what_rcl_refuses_rclpy_publishes_or_explains(topic, monkeypatch):
    publisher, messages = topic
    writer = ImageWriter()
    monkeypatch.setattr(writer._rcl, "_publish", lambda *_: 1)

    writer.publish([publisher], a_message(), a_frame())

    assert_shows(messages.get(timeout=PATIENCE), a_frame())


def test_a_publisher_that_is_gone_raises_as_rclpys_own(topic):
    publisher, _ = topic
    publisher.destroy()

    with pytest.raises(InvalidHandle):
        ImageWriter().publish([publisher], a_message(), a_frame())
