"""ROS 2 images in MCAP files, and in rosbag2's folders and databases."""

from __future__ import annotations

import logging
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from typing_extensions import override

from grabbergui.core import camera_info_message, ros_image
from grabbergui.core.calibration import Calibration
from grabbergui.core.camera_info_message import CameraInfoFields, read_camera_info
from grabbergui.core.component import Component, ComponentKind, PayloadType
from grabbergui.core.errors import PixelFormatError, RemoteProtocolError, UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.ros_image import (
    COMPRESSED_NAME,
    STRING_NAME,
    TIME_NAME,
    RosCompressedImage,
    RosImage,
    decode_string,
    decode_time_reference,
    plain_topic,
)
from grabbergui.core.ros_pictures import Picture, of_compressed, of_image
from grabbergui.recording.errors import RecordingError
from grabbergui.recording.message_store import IMAGE_TYPES, MessageStore, Place
from grabbergui.recording.notes import MAX_LINE, FrameNote, parse_note
from grabbergui.recording.reader import RecordingReader
from grabbergui.recording.stored_frames import format_named, rebuilt
from grabbergui.recording.times import DEFAULT_RATE, in_order_of_receipt, rising

log = logging.getLogger(__name__)

DEVICE_TIME = "/device_time"
"Suffix of the topic with the camera's clock, after the images' topic."
NOTE = "/note"
"Suffix of the topic with the notes of frames, as in `frames.jsonl`."
CAMERA_INFO = "camera_info"
"Last part of the topic with the calibration, beside the images' (image_transport)."
PIXEL_FORMAT_KEY = "pixel_format"
"Key in a channel's metadata: the PFNC name, which ROS's encoding does not contain (Mono12 is mono16)."
BESIDE_KEY = "beside"
"Key in the metadata of a channel with further components: the topic of their frames."
ALL_TOPICS = "all"
"The choice of all topics: the images of the others are further components of a frame."
INFO_LATE_NS = 1_000_000_000
"Nanoseconds by which the first camera_info may follow the first image."
_Key = tuple[int, int]
"Sequence number and time: the number alone is not unique, as a camera that restarts counts from one again."


class RosRecording(RecordingReader):
    """The images of one topic, by default the one with the most images; or of all topics."""

    def __init__(self, path: Path, stores: Sequence[MessageStore], topic: str = "") -> None:
        """Play files that are one after the other; closes them. Raises UsageError, RecordingError."""
        self.path = path
        self._stores = stores
        self._beside: dict[_Key, list[Place]] = {}
        "Further components of a frame."
        self._others: list[tuple[list[int], list[Place]]] = []
        "Times and images of the other topics, if all are played."
        try:
            self._choose(topic)
        except BaseException:
            self.close()
            raise

    @override
    def close(self) -> None:
        for store in self._stores:
            store.close()

    @override
    def frame(self, index: int, received_ns: int) -> Frame:
        place = self._images[index]
        frame = self._image(place, index, received_ns)
        beside = self._beside.get(_key(place), ())
        images = [(frame, place), *((self._image(one, index, received_ns), one) for one in beside)]
        parts = [
            part for _, part in sorted((self._component(*one) for one in images), key=lambda part: part[0])
        ]
        for number, (times, places) in enumerate(self._others, 1):
            if at := bisect_right(times, self._clock[index]):
                _, part = self._component(self._image(places[at - 1], index, received_ns), places[at - 1])
                parts.append(replace(part, source=number))
        if len(parts) > 1:
            frame = replace(frame, parts=tuple(parts), payload_type=PayloadType.MULTI_PART)
        return frame

    @override
    def calibration(self, index: int) -> Calibration | None:
        place = self._images[index]
        at = bisect_right(self._info_times, place.log_time)
        if not at and not (self._infos and self._info_times[0] - place.log_time < INFO_LATE_NS):
            return None
        info = self._infos[max(at - 1, 0)]
        try:
            content = self._stores[info.store].content(info)
            return read_camera_info(CameraInfoFields.decode(content), self.title)
        except (RemoteProtocolError, RecordingError, UsageError) as error:
            log.debug("%s: %s", self.path, error)  # zeros, of a camera that is not calibrated
            return None

    def _image(self, place: Place, index: int, received_ns: int) -> Frame:
        try:
            pixels, name, width, height = self._picture(place)
        except (RemoteProtocolError, PixelFormatError, RecordingError) as error:
            raise RecordingError(f"{self._stores[place.store].path}: frame {index}: {error}") from error
        note = replace(
            self._note(place),
            width=width,
            height=height,
            pixel_format=name,
            timestamp_ns=self._device_time(place),
        )
        return rebuilt(pixels, note, received_ns)

    def _picture(self, place: Place) -> Picture:
        """Raises RemoteProtocolError, PixelFormatError, RecordingError."""
        store = self._stores[place.store]
        content = store.content(place)
        if store.type_of(place) == COMPRESSED_NAME:
            return of_compressed(RosCompressedImage.decode(content))
        noted = self._metadata(place, PIXEL_FORMAT_KEY)
        return of_image(RosImage.decode(content), noted, named=format_named)

    def _component(self, image: Frame, place: Place) -> tuple[int, Component]:
        """Return an image as a component, after its index in the frame."""
        by_format = ComponentKind.RANGE if image.pixel_format.is_coordinate else ComponentKind.UNDEFINED
        kind = ComponentKind.__members__.get(self._metadata(place, "component"), by_format)
        numbers = (_number(self._metadata(place, name)) for name in ("index", "region", "source", "purpose"))
        index, region, source, purpose = numbers
        return index, Component(
            image.payload,
            image.width,
            image.height,
            image.pixel_format,
            kind,
            region=region,
            source=source,
            purpose=purpose,
        )

    def _device_time(self, place: Place) -> int:
        time_place = self._times.get(_key(place))
        if time_place is None:
            return 0
        try:
            return max(0, decode_time_reference(self._stores[time_place.store].content(time_place)))
        except RemoteProtocolError:
            return 0

    def _note(self, place: Place) -> FrameNote:
        """Return the note that was recorded of an image, or the little that is known without one."""
        note_place = self._notes.get(_key(place))
        if note_place is not None and note_place.length <= 2 * MAX_LINE:
            try:
                return parse_note(decode_string(self._stores[note_place.store].content(note_place)), "a note")
            except (RemoteProtocolError, UsageError) as error:
                log.debug("%s: %s", self.path, error)  # another program's topic
        return FrameNote(width=0, height=0, pixel_format="", frame_id=place.sequence)

    def _metadata(self, place: Place, key: str) -> str:
        channel = self._stores[place.store].channels.get(place.channel)
        return channel.note(key) if channel is not None else ""

    def _choose(self, wanted: str) -> None:
        by_topic = self._by_topic(IMAGE_TYPES)
        if not by_topic:
            raise UsageError(self._without_images())
        frames = [topic for topic, places in by_topic.items() if self._frame_topic(places[0]) not in by_topic]
        topic = self._chosen(wanted, frames or list(by_topic), by_topic)
        self.scan = next((store.scan for store in self._stores if store.scan is not None), None)
        for places in by_topic.values():
            if self._frame_topic(places[0]) == topic:
                for place in places:
                    self._beside.setdefault(_key(place), []).append(place)
        self.title = f"{self.path.name} {topic}"
        self._images, self._clock = self._in_order(by_topic[topic])
        self.times_ns = rising(self._clock)
        self._times, self._notes = (
            {_key(place): place for place in self._by_topic((kind,)).get(topic + suffix, [])}
            for kind, suffix in ((TIME_NAME, DEVICE_TIME), (STRING_NAME, NOTE))
        )
        beside = f"{plain_topic(topic).rpartition('/')[0]}/{CAMERA_INFO}"
        self._infos = sorted(
            self._by_topic((camera_info_message.NAME,)).get(beside, []), key=lambda place: place.log_time
        )
        self._info_times = [place.log_time for place in self._infos]
        others = [each for each in frames if each != topic]
        if wanted == ALL_TOPICS:
            for each in others:
                places, times = self._in_order(by_topic[each])
                self._others.append((rising(times), places))
            self._clock = self.times_ns
        elif others and not wanted:
            shown = ", ".join(f"{each} ({len(by_topic[each])})" for each in others[:8])
            self.remark = f"playing {topic}; add ?topic=NAME for another one, or ?topic={ALL_TOPICS}: {shown}"

    def _chosen(self, wanted: str, frames: list[str], by_topic: dict[str, list[Place]]) -> str:
        """Return a topic. Raises UsageError for one that is not there."""
        if not wanted or wanted == ALL_TOPICS:
            # Of equally many, the plain images before the compressed ones of the same camera.
            return max(frames, key=lambda each: (len(by_topic[each]), self._is_plain(by_topic[each][0])))
        if wanted in by_topic:
            return wanted
        raise UsageError(
            f"{self.path} has no images on {wanted[:60]}; there are {', '.join(sorted(by_topic)[:20])}"
        )

    def _is_plain(self, place: Place) -> bool:
        return self._stores[place.store].type_of(place) != COMPRESSED_NAME

    def _by_topic(self, types: Sequence[str]) -> dict[str, list[Place]]:
        found: dict[str, list[Place]] = {}
        for store in self._stores:
            topics = {
                number: channel.topic
                for number, channel in store.channels.items()
                if channel.type in types and channel.encoding == "cdr"
            }
            for place in store.messages:
                if place.channel in topics:
                    found.setdefault(topics[place.channel], []).append(place)
        return found

    def _without_images(self) -> str:
        wanted = " or ".join(IMAGE_TYPES)
        channels = [channel for store in self._stores for channel in store.channels.values()]
        images = [channel for channel in channels if channel.type.endswith(("Image", "CompressedImage"))]
        if images:
            one = images[0]
            found = f"{one.type[:60]} in the encoding '{one.encoding[:20]}'"
            return f"{self.path} holds images of the type {found}; {wanted} in 'cdr' are played"
        types = ", ".join(sorted({channel.type[:60] for channel in channels})[:8])
        return f"{self.path} holds no images of the type {wanted}" + (f", but {types}" if types else "")

    def _in_order(self, places: list[Place]) -> tuple[list[Place], list[int]]:
        """Return images in the order of their times, and these: of the log, or else of the headers."""
        times = {place.log_time for place in places}
        if len(times) == 1 and len(places) > 1:
            stamped = [(self._stamp(place), place) for place in places]
            if len({stamp for stamp, _ in stamped}) == 1:
                return places, [round(index * 1e9 / DEFAULT_RATE) for index in range(len(places))]
            stamped = in_order_of_receipt(stamped, lambda item: item[0])
            return [place for _, place in stamped], [stamp for stamp, _ in stamped]
        places = in_order_of_receipt(places, lambda place: place.log_time)
        return places, [place.log_time for place in places]

    def _stamp(self, place: Place) -> int:
        try:
            return max(0, ros_image.decode_stamp(self._stores[place.store].content(place)))
        except (RemoteProtocolError, RecordingError):
            return 0

    def _frame_topic(self, place: Place) -> str:
        """Return the topic of the frames that a component belongs to; empty for frames themselves."""
        return self._metadata(place, BESIDE_KEY)


def _key(place: Place) -> _Key:
    return place.sequence, place.log_time


def _number(text: str) -> int:
    return int(text) if text.isascii() and text.isdigit() and len(text) < 20 else 0
