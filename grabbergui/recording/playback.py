"""A recording as a source: `file:folder`, `file:movie.mp4`, `file:recording.mcap`.

The times of the recorded frames determine the pace. The options are in `PlaybackOptions`; the features are
the position, the speed, and whether it loops.
"""

from __future__ import annotations

import logging
import threading
import time
from dataclasses import dataclass
from pathlib import Path

from typing_extensions import override

from grabbergui.core.calibration import Calibration
from grabbergui.core.coord3d import Scan3d
from grabbergui.core.environment import expanded
from grabbergui.core.errors import DeviceLostError, FeatureError, GrabberError, UsageError
from grabbergui.core.features import (
    AccessMode,
    Category,
    Feature,
    FeatureDescription,
    FeatureKind,
    FeatureValue,
    Representation,
)
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import RateMeter, StreamStatistics
from grabbergui.core.grabber import Access, ConnectionState, FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.sfnc import PLAYBACK_POSITION
from grabbergui.core.uri import PlaybackOptions, SourceUri, read_options
from grabbergui.recording.errors import RecordingError
from grabbergui.recording.opening import open_recording
from grabbergui.recording.reader import RecordingReader

log = logging.getLogger(__name__)

NOTICE_PERIOD = 0.2
"Seconds between signals that the position has changed."
LOOP_PAUSE = 0.04
"Seconds between repetitions of a single frame."
LOOK = 0.005
"Seconds between checks whether a consumer that needs every frame has room for another."
LONGEST_GAP = 10.0
"Seconds. A longer gap in a recording is shortened to this."


POSITION = PLAYBACK_POSITION
SPEED = "PlaybackSpeed"
LOOP = "PlaybackLoop"
PLAYING = "PlaybackActive"
TIME = "PlaybackTime"
LENGTH = "PlaybackFrameCount"
DURATION = "PlaybackDuration"
WIDTH, HEIGHT, PIXEL_FORMAT = "Width", "Height", "PixelFormat"
_PLAYED = frozenset({POSITION, TIME, PLAYING, WIDTH, HEIGHT, PIXEL_FORMAT})
"Features that change while a recording is played."

SLOWEST, FASTEST = 0.05, 20.0

_CATEGORY = "PlaybackControl"
_FORMAT = "ImageFormatControl"


@dataclass
class PlaybackValues:
    """The values of the features."""

    frames: int
    duration: float
    "Seconds."
    position: int = 0
    time: float = 0.0
    "Seconds from the first frame to the one at `position`."
    speed: float = 1.0
    loop: bool = True
    playing: bool = True
    width: int = 0
    height: int = 0
    pixel_format: str = ""


def _described(name: str, kind: FeatureKind, category: str, title: str, tooltip: str) -> FeatureDescription:
    return FeatureDescription(name=name, kind=kind, category=category, display_name=title, tooltip=tooltip)


_DESCRIPTIONS = (
    _described(PLAYING, FeatureKind.BOOLEAN, _CATEGORY, "Playing", "If off, the image stays."),
    _described(POSITION, FeatureKind.INTEGER, _CATEGORY, "Position", "The frame shown, counted from 0."),
    _described(SPEED, FeatureKind.FLOAT, _CATEGORY, "Speed", "1 plays as fast as it was recorded."),
    _described(LOOP, FeatureKind.BOOLEAN, _CATEGORY, "Loop", "Begin again at the end."),
    _described(TIME, FeatureKind.FLOAT, _CATEGORY, "Time", "From the first frame to the one shown."),
    _described(LENGTH, FeatureKind.INTEGER, _CATEGORY, "Frames", "How many frames were recorded."),
    _described(DURATION, FeatureKind.FLOAT, _CATEGORY, "Duration", "From the first frame to the last."),
    _described(WIDTH, FeatureKind.INTEGER, _FORMAT, "", "Width of the frame shown last."),
    _described(HEIGHT, FeatureKind.INTEGER, _FORMAT, "", "Height of the frame shown last."),
    _described(PIXEL_FORMAT, FeatureKind.STRING, _FORMAT, "Pixel Format", "As it was recorded."),
)

DESCRIPTIONS = {description.name: description for description in _DESCRIPTIONS}

TREE = Category(
    "Root",
    members=(
        Category(
            _CATEGORY,
            "Playback",
            members=tuple(d for d in _DESCRIPTIONS if d.category == _CATEGORY),
        ),
        Category(
            _FORMAT,
            "Image Format Control",
            members=tuple(d for d in _DESCRIPTIONS if d.category == _FORMAT),
        ),
    ),
)


def feature(name: str, state: PlaybackValues) -> Feature:
    """Return the current feature. `name` must be one of DESCRIPTIONS."""
    last = max(0, state.frames - 1)
    readings: dict[str, tuple[FeatureValue, dict[str, object]]] = {
        PLAYING: (state.playing, {}),
        POSITION: (state.position, {"minimum": 0, "maximum": last, "increment": 1}),
        SPEED: (
            state.speed,
            {"minimum": SLOWEST, "maximum": FASTEST, "representation": Representation.LOGARITHMIC},
        ),
        LOOP: (state.loop, {}),
        TIME: (state.time, {"unit": "s"}),
        LENGTH: (state.frames, {}),
        DURATION: (state.duration, {"unit": "s"}),
        WIDTH: (state.width, {"unit": "px"}),
        HEIGHT: (state.height, {"unit": "px"}),
        PIXEL_FORMAT: (state.pixel_format, {}),
    }
    value, more = readings[name]
    writable = name in (PLAYING, POSITION, SPEED, LOOP)
    known = {**vars(DESCRIPTIONS[name]), **more}
    access = AccessMode.READ_WRITE if writable else AccessMode.READ_ONLY
    return Feature(access=access, value=value, **known)


class PlaybackGrabber(FrameGrabber):
    """Plays a recording. Any thread; while the stream is on, another thread delivers the frames.

    A frame's `received_ns` is the time of playing, as from a camera; `timestamp_ns` and `frame_id` are the
    recorded ones.
    """

    def __init__(
        self, info: DeviceInfo, path: Path, *, loop: bool = True, speed: float = 1.0, topic: str = ""
    ) -> None:
        super().__init__(info)
        self._path = path
        self._topic = topic
        self._defaults = (loop, speed)
        self._recording: RecordingReader | None = None
        self._state = PlaybackValues(0, 0.0)
        self._changed = threading.Condition(threading.RLock())
        self._starting = threading.Lock()
        "Held during start and stop, so that no player starts before the previous one has ended."
        self._player: threading.Thread | None = None
        self._running = False
        self._calibration: Calibration | None = None
        "Calibration of the frame delivered last."
        self._shown = -1
        "Index of the frame delivered last; -1 if the one at the position is to be delivered at once."
        self._ended = False
        "Whether it was played to its end, and neither the position nor playing was written since."
        self._readable = True
        "Whether the last frame was."
        self._due = 0.0
        "When the next frame is to be delivered, by `time.monotonic`."
        self._statistics = StreamStatistics()
        self._rates = RateMeter()

    @override
    def open(self, access: Access = Access.CONTROL) -> None:
        with self._changed:
            if self._recording is not None:
                return
            self.connection_changed.emit(ConnectionState.OPENING, "")
            recording = None
            try:
                recording = self._opened_recording()
                loop, speed = self._defaults
                state = PlaybackValues(len(recording), recording.duration, loop=loop, speed=speed)
                first, fault = _first_readable(recording)
            except BaseException:
                if recording is not None:
                    recording.close()
                self.connection_changed.emit(ConnectionState.CLOSED, "")
                raise
            state.width, state.height = first.width, first.height
            state.pixel_format = first.pixel_format.name
            self._recording, self._state, self._readable = recording, state, not fault
        self.connection_changed.emit(ConnectionState.OPEN, "")
        if recording.remark:
            log.info("%s: %s", self.info.uri, recording.remark)
            self.noticed.emit(recording.remark)
        if fault:
            self._report(fault)

    def _opened_recording(self) -> RecordingReader:
        return open_recording(self._path, topic=self._topic)

    @override
    def close(self) -> None:
        self.stop()
        with self._changed:
            recording, self._recording = self._recording, None
        if recording is None:
            return
        recording.close()
        self._fanout.close()
        self.connection_changed.emit(ConnectionState.CLOSED, "")

    @property
    def access(self) -> Access:
        """Always control, as nobody else uses the recording."""
        return Access.CONTROL

    @override
    def recorded_coordinates(self) -> Scan3d | None:
        recording = self._recording
        return recording.scan if recording is not None else None

    @override
    def calibration(self) -> Calibration | None:
        return self._calibration

    @override
    def feature_tree(self) -> Category:
        return TREE

    @override
    def has_feature(self, name: str) -> bool:
        return name in DESCRIPTIONS

    @override
    def feature(self, name: str) -> Feature:
        self._require(name)
        with self._changed:
            return feature(name, self._state)

    @override
    def write_feature(self, name: str, value: FeatureValue) -> Feature:
        accepted = self.feature(name).validated(value)
        changed = {name}
        with self._changed:
            state = self._state
            self._ended = self._ended and name in (SPEED, LOOP)
            if name == POSITION:
                state.position, self._shown = int(accepted), -1
                state.time = self._time_of(state.position)
                changed.add(TIME)
            elif name == SPEED:
                now = time.monotonic()
                # The rest of the wait for the next frame passes at the new speed.
                self._due = now + (self._due - now) * state.speed / float(accepted)
                state.speed = float(accepted)
            elif name == LOOP:
                state.loop = bool(accepted)
            else:
                state.playing = bool(accepted)
                changed |= {POSITION, TIME}  # they have changed since the last signal
                if state.playing and state.position >= state.frames - 1:
                    state.position, self._shown = 0, -1  # play again after the end
                elif state.playing and self._shown == state.position:
                    self._shown = -1  # continue from the position that was sought
            self._changed.notify_all()
        self.features_changed.emit(frozenset(changed))
        return self.feature(name)

    @override
    def execute(self, name: str) -> None:
        self._require(name)
        raise FeatureError(f"{name} is no command; a recording has none", name)

    @override
    def start(self, *, keep_trigger: bool = False) -> None:
        with self._starting, self._changed:
            if self._running:
                return
            if self._recording is None:
                raise DeviceLostError(f"{self.info.title} is not open")
            self._running, self._shown = True, -1
            if self._ended:
                self._ended, self._state.position, self._state.playing = False, 0, True
            self._fanout.clear()
            self._statistics = StreamStatistics()
            self._rates.clear()
            self._player = threading.Thread(
                target=self._play, args=(self._recording,), name=f"playback {self._path.name}", daemon=True
            )
            self._player.start()

    @override
    def stop(self) -> None:
        with self._starting:
            with self._changed:
                self._running = False
                self._changed.notify_all()
                player, self._player = self._player, None
            if player is not None and player is not threading.current_thread():
                player.join()
            self._rates.clear()

    @property
    @override
    def streaming(self) -> bool:
        return self._running

    @override
    def silence(self) -> str:
        if self._state.playing:
            return ""
        return "it was played to its end" if self._ended else "its playback is paused (PlaybackActive)"

    @override
    def statistics(self) -> StreamStatistics:
        return self._statistics.snapshot(self._rates)

    def _play(self, recording: RecordingReader) -> None:
        signalled = 0.0
        while True:
            with self._changed:
                at_position = self._wait_for_turn()
                if not self._running:
                    return
                index = self._state.position
                self._shown = index
                self._wait_for_consumers()
                if not self._running:
                    return
            self._deliver(recording, index)
            with self._changed:
                # While it was delivered, the same position may have been sought again.
                if self._state.playing and self._state.position == self._shown == index:
                    if at_position:
                        self._due = time.monotonic()
                    self._advance(recording, index)
                paused = not self._state.playing
            if time.monotonic() - signalled > NOTICE_PERIOD or at_position or paused:
                signalled = time.monotonic()
                self.features_changed.emit(_PLAYED)

    def _wait_for_turn(self) -> bool:
        """Wait until the frame at the position is due; return whether it was sought rather than reached."""
        while self._running:
            if self._shown == -1:
                return True
            if not self._state.playing or self._shown == self._state.position:
                self._changed.wait()
                self._due = time.monotonic()
                continue
            wait = self._due - time.monotonic()
            if wait <= 0:
                return False
            self._changed.wait(wait)
        return False

    def _wait_for_consumers(self) -> None:
        """Wait while a consumer that needs every frame is behind; not if another frame was sought."""
        while self._running and self._shown != -1 and self._fanout.awaited:
            self._changed.wait(LOOK)

    def _advance(self, recording: RecordingReader, index: int) -> None:
        """Move on to the next frame, and set when it is due."""
        state = self._state
        if index + 1 < state.frames:
            gap = (recording.times_ns[index + 1] - recording.times_ns[index]) / 1e9
            state.position = index + 1
        elif state.loop:
            gap = state.duration / (state.frames - 1) if state.frames > 1 else 0.0
            gap = max(gap, LOOP_PAUSE if state.frames == 1 else 0.001)
            state.position = 0
            self._shown = state.frames  # so that the first one follows, even if it is the only one
        else:
            state.playing, self._ended = False, True
            self._fanout.end()
            return
        state.time = self._time_of(state.position)
        # After a longer delay (on a busy computer), continue from now instead of catching up.
        self._due = max(self._due + min(gap, LONGEST_GAP) / state.speed, time.monotonic() - LOOP_PAUSE)

    def _deliver(self, recording: RecordingReader, index: int) -> None:
        try:
            frame = recording.frame(index, time.time_ns())
            self._calibration = recording.calibration(index)
        except GrabberError as error:
            self._statistics.incomplete += 1
            if self._readable:  # the disk may be gone, and a notice for each frame would fill another one
                self._readable = False
                self._report(str(error))
            return
        self._readable = True
        state = self._state
        state.width, state.height, state.pixel_format = frame.width, frame.height, frame.pixel_format.name
        self._statistics.frames += 1
        self._statistics.bytes += frame.payload.nbytes
        self._rates.add(frame.payload.nbytes)
        self._fanout.put(frame)

    def _report(self, fault: str) -> None:
        log.warning("%s: %s", self.info.uri, fault)
        self.noticed.emit(fault)

    def _time_of(self, index: int) -> float:
        times = self._recording.times_ns if self._recording is not None else []
        return (times[index] - times[0]) / 1e9 if index < len(times) else 0.0


def _first_readable(recording: RecordingReader) -> tuple[Frame, str]:
    """Return a frame that can be read, and why an earlier one cannot, or "". Raises RecordingError.

    The first frames are all tried, those behind them in growing steps.
    """
    index, fault = 0, RecordingError(f"{recording.path} holds no frames")
    while index < len(recording):
        try:
            return recording.frame(index, 0), str(fault) if index else ""
        except RecordingError as error:
            fault = fault if index else error
        index += 1 + index // 8
    raise fault


def discover(timeout: float = 1.0) -> list[DeviceInfo]:
    """Return no sources, as recordings are opened by name."""
    return []


def create(uri: SourceUri) -> FrameGrabber:
    """Return a grabber for the recording of a URI, not yet opened. Raises UsageError."""
    if not uri.name:
        raise UsageError("file: needs a recording, as in file:folder, file:movie.mp4 or file:recording.mcap")
    options = read_options(PlaybackOptions, uri)
    path = expanded(uri.name)
    info = DeviceInfo(
        str(uri), "Recording", model=path.name, bus="File", address=str(path), user_name=path.name
    )
    return PlaybackGrabber(info, path, loop=options.loop, speed=options.speed, topic=options.topic)
