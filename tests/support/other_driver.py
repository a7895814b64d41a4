"""Somebody else's camera driver on ROS 2, for tests with real rclpy."""

import struct
import threading
import time

import cv2
import numpy as np
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CameraInfo, CompressedImage, Image

from grabbergui.net.ros2.runtime import Ros2Node

PIXELS = bytes(range(16))


class Driver:
    """Somebody else's camera driver, written with rclpy alone."""

    def __init__(
        self,
        name="other",
        reliability=ReliabilityPolicy.RELIABLE,
        kind=Image,
        callbacks=True,
        topic="image_raw",
        node="",
        **options,
    ):
        """Without `callbacks` it publishes from a thread of its own and answers no service."""
        self.ros = Ros2Node(node or f"{name}_driver", **options)
        self.node = self.ros.node
        qos = QoSProfile(depth=5, reliability=reliability, durability=DurabilityPolicy.VOLATILE)
        self._images = self.node.create_publisher(kind, f"/{name}/{topic}", qos)
        self._info = self.node.create_publisher(CameraInfo, f"/{name}/camera_info", qos)
        self.message = kind() if kind is not Image else image()
        self.info = None
        self.stamp = time.time
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run)
        if callbacks:
            self.node.create_timer(0.02, self._publish)
            self.ros.start()
        else:
            self._thread.start()

    def _publish(self):
        if isinstance(self.message, Image):
            now = self.stamp()
            self.message.header.stamp.sec = int(now)
            self.message.header.stamp.nanosec = int(now % 1 * 1e9)
        self._images.publish(self.message)
        if self.info is not None:
            self._info.publish(self.info)

    def _run(self):
        while not self._closing.wait(0.02):
            self._publish()

    def close(self):
        self._closing.set()
        if self._thread.is_alive():
            self._thread.join()
        self.ros.close()


def image(width=4, height=2, encoding="mono8"):
    return Image(width=width, height=height, encoding=encoding, step=8, data=PIXELS)


def information(**changes):
    matrix = [500.0, 0.0, 319.5, 0.0, 500.0, 239.5, 0.0, 0.0, 1.0]
    return CameraInfo(
        width=640, height=480, distortion_model="plumb_bob", k=matrix, d=[0.1, 0.0, 0.0, 0.0], **changes
    )


def said(notices, words):
    return lambda: any(words in notice for notice in notices)


DEEP = [[1, 300, 20_000, 65_535], [0, 1, 2, 3]]
"Values of an image with 16 bits."


def compressed(form, suffix, values, before=b""):
    """As image_transport's plug-ins write it: with OpenCV."""
    done, content = cv2.imencode(suffix, np.array(values))
    assert done
    return CompressedImage(format=form, data=before + content.tobytes())


def jpeg(form, channels=3):
    return compressed(form, ".jpg", np.full((2, 4, channels), 100, np.uint8).squeeze())


def png(form):
    return compressed(form, ".png", np.array(DEEP, np.uint16))


def depth(form):
    return compressed(form, ".png", np.array(DEEP, np.uint16), struct.pack("<iff", 0, 0, 0))
