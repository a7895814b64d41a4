"""Writes a rosbag2: a folder with an MCAP file and `metadata.yaml`, as `ros2 bag record` does."""

from __future__ import annotations

import shutil
from pathlib import Path

from typing_extensions import override

from grabbergui.core.coord3d import Scan3d
from grabbergui.core.environment import write_whole
from grabbergui.core.frame import Frame
from grabbergui.core.identity import DeviceInfo
from grabbergui.recording.bag_folder import METADATA
from grabbergui.recording.mcap_writer import McapWriter, RecordedTopic
from grabbergui.recording.writer import CalibrationOf, RecordingWriter

_VERSION = 5
"""Version of the metadata: the newest that Humble reads; later releases read it as well."""


class BagWriter(RecordingWriter):
    """Writes the messages of `McapWriter`."""

    keeps_components = True

    def __init__(self, path: Path, info: DeviceInfo, scan: Scan3d | None, calibration: CalibrationOf) -> None:
        self.path = path
        path.mkdir(exist_ok=True)
        self._messages = McapWriter(path / f"{path.name}_0.mcap", info, scan, calibration)
        self._closed = False

    @override
    def write(self, frame: Frame) -> None:
        self._messages.write(frame)

    @override
    def close(self) -> None:
        if self._closed:
            return
        self._closed = True
        self._messages.close()
        write_whole(self.path / METADATA, self._metadata())

    @override
    def discard(self) -> None:
        shutil.rmtree(self.path, ignore_errors=True)

    @override
    def size(self) -> int:
        return self._messages.size()

    def _metadata(self) -> str:
        begin, end = self._messages.times
        by_topic: dict[tuple[str, str], int] = {}
        for each in self._messages.topics.values():  # a topic has a channel for each pixel format
            by_topic[each.topic, each.type] = by_topic.get((each.topic, each.type), 0) + each.messages
        topics = [RecordedTopic(*key, count) for key, count in by_topic.items()]
        count, file = sum(each.messages for each in topics), self._messages.path.name
        # As rosbag2 writes it: not all readers know other styles of YAML.
        lines = [
            f"rosbag2_bagfile_information:\n  version: {_VERSION}\n  storage_identifier: mcap\n"
            f"  duration:\n    nanoseconds: {end - begin}\n"
            f"  starting_time:\n    nanoseconds_since_epoch: {begin}\n"
            f"  message_count: {count}\n  topics_with_message_count:\n"
        ]
        lines.extend(
            f"    - topic_metadata:\n        name: {each.topic}\n        type: {each.type}\n"
            '        serialization_format: cdr\n        offered_qos_profiles: ""\n'
            f"      message_count: {each.messages}\n"
            for each in topics
        )
        lines.append(
            '  compression_format: ""\n  compression_mode: ""\n'
            f"  relative_file_paths:\n    - {file}\n  files:\n    - path: {file}\n"
            f"      starting_time:\n        nanoseconds_since_epoch: {begin}\n"
            f"      duration:\n        nanoseconds: {end - begin}\n      message_count: {count}\n"
        )
        return "".join(lines)
