"""Publishes images from their own memory, without a copy into a message."""

from __future__ import annotations

import ctypes
import functools
import sys
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.frame import Frame
from grabbergui.net.ros2.image_messages import describe, message_bytes, pixels_of

_LENGTH_BYTES = 4
"""Size of the length field in front of the pixels."""


class ImageWriter:
    """Publishes `sensor_msgs/msg/Image` with one copy of the pixels. One thread.

    rclpy copies an image three times, each time into new memory, while it holds the GIL, so that the camera's
    packets wait. Here rclpy serializes the message without pixels. They are written behind that, into memory
    that is kept, and rcl publishes all of it from there, without the GIL.
    """

    def __init__(self) -> None:
        self._rcl = _rcl()
        self._memory = np.empty(0, np.uint8)

    def publish(self, publishers: Sequence[Any], message: Any, frame: Frame) -> int:
        """Publish a frame in a message of which the caller has filled the header; return its pixels' bytes.

        Raises PixelFormatError for a format without encoding, and what rclpy's `publish` raises.
        """
        pixels, left = pixels_of(frame), publishers
        describe(message, frame, pixels)
        if self._rcl is not None and (serialized := self._serialized(message, pixels)) is not None:
            left = [publisher for publisher in publishers if not self._rcl.publish(publisher, serialized)]
        if left:  # rclpy raises the reason of a failure
            message.data = message_bytes(pixels)
            for publisher in left:
                publisher.publish(message)
        return pixels.nbytes

    def _serialized(self, message: Any, pixels: NDArray[Any]) -> NDArray[np.uint8] | None:
        """Return the message in the memory that is kept; None if it does not end with its data."""
        from rclpy.serialization import serialize_message

        head: bytes = serialize_message(message)
        if head[-_LENGTH_BYTES:] != bytes(_LENGTH_BYTES):
            return None
        size = len(head) + pixels.nbytes
        if self._memory.size < size:
            self._memory = np.empty(size, np.uint8)
        serialized = self._memory[:size]
        start = head[:-_LENGTH_BYTES] + pixels.nbytes.to_bytes(_LENGTH_BYTES, sys.byteorder)
        serialized[: len(start)] = np.frombuffer(start, np.uint8)
        np.copyto(serialized[len(start) :].view(pixels.dtype).reshape(pixels.shape), pixels)
        return serialized


class _SerializedMessage(ctypes.Structure):
    """rcl_serialized_message_t; its allocator (five pointers) is not used for publishing."""

    _fields_ = (
        ("buffer", ctypes.c_void_p),
        ("length", ctypes.c_size_t),
        ("capacity", ctypes.c_size_t),
        ("allocator", ctypes.c_void_p * 5),
    )


class _Rcl:
    """The one function of rcl that rclpy offers only for `bytes`, of which it makes another copy."""

    def __init__(self, rcl: ctypes.CDLL, rcutils: ctypes.CDLL) -> None:
        self._publish = rcl.rcl_publish_serialized_message
        self._publish.argtypes = (ctypes.c_void_p, ctypes.POINTER(_SerializedMessage), ctypes.c_void_p)
        self._publish.restype = ctypes.c_int
        self._reset_error = rcutils.rcutils_reset_error
        self._reset_error.restype = None

    def publish(self, publisher: Any, serialized: NDArray[np.uint8]) -> bool:
        """Return whether rcl took the message; it has copied it by then."""
        message = _SerializedMessage(serialized.ctypes.data, serialized.size, serialized.size)
        with publisher.handle:  # keeps it from being destroyed
            if self._publish(publisher.handle.pointer, ctypes.byref(message), None) == 0:
                return True
        self._reset_error()
        return False


@functools.cache
def _rcl() -> _Rcl | None:
    """Return the library that rclpy has loaded, by its bare name; None if it has another name."""
    try:
        return _Rcl(ctypes.CDLL("librcl.so"), ctypes.CDLL("librcutils.so"))
    except (OSError, AttributeError):
        return None
