"""Recordings of a rig: one MCAP file with a topic for each camera, and the sets by time.

The images of a set have one stamp, that of the set, so that ROS's exact synchroniser matches them. Messages
on `/rig/sets` (`std_msgs/String`, JSON) name the frames of each set, also of incomplete ones; they follow the
images, so a file that was cut short has whole sets only.
"""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

from typing_extensions import override

from grabbergui.core.errors import ExistingFileError, RemoteProtocolError, UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameSource
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.ros_image import STRING_NAME, decode_string
from grabbergui.core.uri import PlaybackOptions
from grabbergui.recording.errors import RecordingError
from grabbergui.recording.mcap_file import McapFile
from grabbergui.recording.mcap_writer import SETS_TOPIC, McapWriter
from grabbergui.recording.opening import open_recording
from grabbergui.recording.playback import PlaybackGrabber
from grabbergui.recording.reader import RecordingReader
from grabbergui.recording.recorder import UNLIMITED, Recorder, RecordingLimits
from grabbergui.recording.segments import SegmentedWriter
from grabbergui.rig.frame_sets import FrameSet, FrameStamp, SetState
from grabbergui.rig.grabber import RigGrabber
from grabbergui.rig.set_frame import SetFrame

MOST_TEXT = 64 << 10
"Bytes of the description of a set."


def begin(
    grabber: FrameGrabber,
    path: Path,
    limits: RecordingLimits = UNLIMITED,
    *,
    source: FrameSource | None = None,
    segment: float | None = None,
) -> Recorder:
    """Return a recorder of a rig's next sets, not yet started. Raises UsageError, RecordingError.

    `source` delivers the sets instead of the rig itself; with `segment` a file ends after so many seconds.
    """
    if path.suffix.lower() != ".mcap":
        raise UsageError(f"{path}: a rig is recorded into one file, .mcap")
    members = grabber.cameras if isinstance(grabber, RigGrabber) else {}

    def create(file: Path) -> McapWriter:
        if file.exists():
            raise ExistingFileError(
                f"{file} is there already; a recording overwrites nothing, choose another name"
            )
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            writer = McapWriter(file, grabber.info)
        except OSError as error:
            raise RecordingError(f"{file} could not be created: {error.strerror or error}") from error
        for name, each in members.items():
            writer.add_camera(name, each.info)
        return writer

    writer = create(path) if segment is None else SegmentedWriter(path, create, segment)
    return Recorder(source or grabber, writer, limits)


class RigRecording(RecordingReader):
    """The sets of a rig's recording."""

    def __init__(self, path: Path) -> None:
        """Raises UsageError for a file without sets, RecordingError."""
        self.path = path
        self.title = path.name
        self._sets = _read_sets(path)
        self.cameras = tuple(dict.fromkeys(name for _, each in self._sets for name in _names(each)))
        self.times_ns = [time_ns for time_ns, _ in self._sets]
        self._readers: dict[str, RecordingReader] = {}
        self._places: dict[str, dict[int, int]] = {}
        try:
            for name in self.cameras:
                self._readers[name] = reader = open_recording(path, topic=f"/{name}/image_raw")
                self._places[name] = {time_ns: index for index, time_ns in enumerate(reader.times_ns)}
        except BaseException:
            self.close()
            raise

    @override
    def frame(self, index: int, received_ns: int) -> Frame:
        time_ns, text = self._sets[index]
        moment = time.monotonic_ns()
        found: FrameSet[Frame] = FrameSet(
            int(text.get("index", index)), FrameStamp(moment), moment, self.cameras
        )
        for name, offset in text["offsets_ns"].items():
            if (place := self._places[name].get(time_ns)) is not None:
                frame = self._readers[name].frame(place, received_ns)
                found.put(name, frame, FrameStamp(moment + int(offset)), moment)
        found.put_in_order()
        if not found:
            raise RecordingError(f"{self.path}: set {index} has no image")
        if not found.missing:
            late = text.get("state") == SetState.LATE.value
            found.state = SetState.LATE if late else SetState.COMPLETE
        frame = SetFrame.of(found)
        frame.received_ns = received_ns
        return frame

    @override
    def close(self) -> None:
        for reader in self._readers.values():
            reader.close()


def _read_sets(path: Path) -> list[tuple[int, dict[str, Any]]]:
    """Return time and description of each set in the order of time."""
    store = McapFile(path)
    try:
        topics = {
            number
            for number, channel in store.channels.items()
            if channel.topic == SETS_TOPIC and channel.type == STRING_NAME
        }
        found = []
        for place in store.messages:
            if place.channel in topics and place.length <= MOST_TEXT:
                try:
                    text = json.loads(decode_string(store.content(place)))
                except (RemoteProtocolError, ValueError) as error:
                    raise RecordingError(f"{path}: a set cannot be read: {error}") from error
                if not _is_description(text):
                    raise RecordingError(f"{path}: a set is not described as one")
                found.append((place.log_time, text))
    finally:
        store.close()
    if not found:
        raise UsageError(f"{path} is no recording of a rig; play its images by file:{path}")
    return sorted(found, key=lambda pair: pair[0])


def _is_description(text: object) -> bool:
    if not isinstance(text, dict) or not isinstance(text.get("missing"), list):
        return False
    offsets = text.get("offsets_ns")
    if not isinstance(text.get("cameras", []), list):
        return False
    whole = isinstance(offsets, dict) and all(isinstance(value, int) for value in offsets.values())
    return whole and isinstance(text.get("index", 0), int) and all(map(_is_name, _names(text)))


def _names(text: dict[str, Any]) -> list[Any]:
    return [*text.get("cameras", ()), *text["offsets_ns"], *text["missing"]]


def _is_name(name: object) -> bool:
    return isinstance(name, str) and 0 < len(name) <= 60


class RigPlayback(PlaybackGrabber):
    """Plays a rig's recording as a rig: its frames are sets."""

    def __init__(self, info: DeviceInfo, path: Path, options: PlaybackOptions) -> None:
        super().__init__(info, path, loop=options.loop, speed=options.speed)
        self._file = path

    @override
    def _opened_recording(self) -> RecordingReader:
        return RigRecording(self._file)
