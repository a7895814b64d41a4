"""The messages of a recorded file of any format: the common interface of `mcap_file` and `db3_file`."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from pathlib import Path

from grabbergui.core import camera_info_message, ros_image
from grabbergui.core.coord3d import Scan3d
from grabbergui.core.errors import UsageError

IMAGE_TYPES = (ros_image.IMAGE_NAME, ros_image.COMPRESSED_NAME)
WANTED_TYPES = (*IMAGE_TYPES, ros_image.TIME_NAME, ros_image.STRING_NAME, camera_info_message.NAME)
"The types of messages that are played, or describe those that are."
MOST_MESSAGES = 10_000_000
"Most messages of all topics; a small compressed file could contain any number."


@dataclass(frozen=True)
class TopicChannel:
    """A topic of a file."""

    topic: str
    type: str
    "ROS 2's name, as in `sensor_msgs/msg/Image`."
    encoding: str = "cdr"
    "How its messages are encoded; only `cdr` is read."
    metadata: dict[str, str] | None = None

    def note(self, key: str) -> str:
        """Return a value of the metadata; empty if there is none."""
        return (self.metadata or {}).get(key, "")


@dataclass(frozen=True, slots=True)
class Place:
    """Where a message is: in the file itself (chunk < 0), or in the chunk at an offset.

    In a database, `offset` is its id.
    """

    store: int
    "Index of the file in its recording."
    chunk: int
    offset: int
    length: int
    channel: int
    sequence: int
    log_time: int
    "Nanoseconds."


class MessageStore(ABC):
    """A file with messages. One thread at a time."""

    path: Path
    number: int
    "Its index in the recording."
    scan: Scan3d | None = None
    channels: dict[int, TopicChannel]
    messages: list[Place]

    def type_of(self, place: Place) -> str:
        """Return the type of a message; empty if its channel is not described."""
        channel = self.channels.get(place.channel)
        return channel.type if channel is not None else ""

    @abstractmethod
    def content(self, place: Place) -> bytes | memoryview:
        """Return the bytes of a message. Raises RecordingError."""

    @abstractmethod
    def close(self) -> None:
        """Close the file. May be called twice."""

    def add(self, place: Place) -> None:
        """Keep a message, unless it is of a type that is not wanted. Raises UsageError for too many."""
        channel = self.channels.get(place.channel)
        if channel is not None and channel.type not in WANTED_TYPES:
            return
        if len(self.messages) >= MOST_MESSAGES:
            raise UsageError(
                f"{self.path} holds more than {MOST_MESSAGES} messages; cut a part out (`mcap filter`)"
            )
        self.messages.append(place)
