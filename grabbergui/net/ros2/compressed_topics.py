"""Publishes compressed images below `image_raw`, with the parameters of image_transport's plug-ins."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from grabbergui.core.errors import UsageError
from grabbergui.core.frame import Frame
from grabbergui.net.ros2 import compressed_images
from grabbergui.net.ros2.compressed_images import COMPRESSED, COMPRESSED_DEPTH, FORMATS, JPEG, PNG

_BASE = "image_raw"
"""The name of the plain topic in the names of parameters, even if it is remapped."""
FORMAT = f"{_BASE}.{COMPRESSED}.format"
JPEG_QUALITY = f"{_BASE}.{COMPRESSED}.jpeg_quality"
PNG_LEVEL = f"{_BASE}.{COMPRESSED}.png_level"
DEPTH_PNG_LEVEL = f"{_BASE}.{COMPRESSED_DEPTH}.png_level"


def parameters() -> Iterator[tuple[str, Any, dict[str, Any]]]:
    """Yield each parameter's name and default, and the fields of its descriptor."""
    from rcl_interfaces.msg import IntegerRange

    quality = [IntegerRange(from_value=1, to_value=100, step=1)]
    level = [IntegerRange(from_value=1, to_value=9, step=1)]
    smaller = "1 is fast, 9 small."
    choices = f"one of [{', '.join(FORMATS)}]"
    kept = f"{PNG} loses nothing and keeps 16 bits."
    yield FORMAT, JPEG, {"description": kept, "additional_constraints": choices}
    described = {"description": "Higher is better and larger.", "integer_range": quality}
    yield JPEG_QUALITY, compressed_images.QUALITY, described
    for name in (PNG_LEVEL, DEPTH_PNG_LEVEL):
        yield name, compressed_images.PNG_LEVEL, {"description": smaller, "integer_range": level}


def check(name: str, value: object) -> None:
    """Raise UsageError for a value of a parameter that its descriptor does not exclude."""
    if name == FORMAT and value not in FORMATS:
        raise UsageError(f"{FORMAT} is '{str(value)[:40]}'; write {' or '.join(FORMATS)}")


class CompressedTopics:
    """`image_raw/compressed`, and for distances also `image_raw/compressedDepth`. One thread publishes."""

    def __init__(self, node: Any, place: Callable[[str], str], publisher: Callable[[Any, str], Any]) -> None:
        """`place` returns the topic of the given last part; `publisher` makes one for a type and a topic."""
        from sensor_msgs.msg import CompressedImage

        self._node, self._place, self._publisher = node, place, publisher
        self._type = CompressedImage
        self._compressed = publisher(CompressedImage, place(COMPRESSED))
        self._depth: Any = None

    @property
    def topics(self) -> list[str]:
        """The names of the topics so far. Any thread."""
        return [each.topic_name for each in (self._compressed, self._depth) if each is not None]

    @property
    def wanted(self) -> bool:
        """Whether anybody subscribes."""
        return any(
            each.get_subscription_count() for each in (self._compressed, self._depth) if each is not None
        )

    def messages(self, frame: Frame) -> Iterator[tuple[Any, Any]]:
        """Yield a publisher and its message, without header, for each topic that has subscribers.

        Raises PixelFormatError.
        """
        is_depth = compressed_images.is_depth(frame)
        if is_depth and self._depth is None:
            self._depth = self._publisher(self._type, self._place(COMPRESSED_DEPTH))
        if self._compressed.get_subscription_count():
            message = self._type()
            if self._value(FORMAT) == PNG:
                compressed_images.fill_png(message, frame, self._value(PNG_LEVEL))
            else:
                compressed_images.fill_jpeg(message, frame, self._value(JPEG_QUALITY))
            yield self._compressed, message
        if is_depth and self._depth.get_subscription_count():
            message = self._type()
            compressed_images.fill_depth(message, frame, self._value(DEPTH_PNG_LEVEL))
            yield self._depth, message

    def _value(self, name: str) -> Any:
        return self._node.get_parameter(name).value
