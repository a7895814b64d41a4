"""A recording as a source: `file:folder`, `file:movie.mp4`, `file:recording.mcap`.

It is paced by the times at which its frames were recorded. Its options are in `PlaybackOptions`.
"""

from __future__ import annotations

import logging
import threading
import time
from pathlib import Path

from typing_extensions import override

from grabbergui.core.errors import DeviceLostError, FeatureError, GrabberError, UsageError
from grabbergui.core.features import Category, Feature, FeatureValue
from grabbergui.core.frame_queue import RateMeter
from grabbergui.core.grabber import Access, ConnectionState, DeviceInfo, FrameGrabber, StreamStatistics
from grabbergui.core.scan3d import Scan3d
from grabbergui.core.source_options import PlaybackOptions, read_options
from grabbergui.core.uri import SourceUri
from grabbergui.recording import playback_features as features
from grabbergui.recording.recording import Recording, open_recording

log = logging.getLogger(__name__)

NOTICE_PERIOD = 0.2
"Seconds between notices that the position has moved."
LOOP_PAUSE = 0.04
"Seconds from the last frame to the first again, where the recording gives no better."
LONGEST_GAP = 10.0
"Seconds; a longer hole in a recording is shortened to this."


class PlaybackGrabber(FrameGrabber):
    """Plays a recording. Any thread; frames come from a thread of its own while the stream is on.

    A frame's `received_ns` is when it was played, as from a camera; `timestamp_ns` and `frame_id` are those
    recorded.
    """

    def __init__(self, info: DeviceInfo, path: Path, *, loop: bool = True, speed: float = 1.0) -> None:
        super().__init__(info)
        self._path = path
        self._defaults = (loop, speed)
        self._recording: Recording | None = None
        self._state = features.PlaybackState(0, 0.0)
        self._changed = threading.Condition(threading.RLock())
        self._starting = threading.Lock()
        "Held for a whole start or stop, so that no player begins before the one before has ended."
        self._player: threading.Thread | None = None
        self._running = False
        self._shown = -1
        "Index of the frame delivered last; a position elsewhere is delivered at once."
        self._statistics = StreamStatistics()
        self._rates = RateMeter()

    # -- connection ------------------------------------------------------------------------------
    @override
    def open(self, access: Access = Access.CONTROL) -> None:
        with self._changed:
            if self._recording is not None:
                return
            self.connection_changed.emit(ConnectionState.OPENING, "")
            recording = None
            try:
                recording = open_recording(self._path)
                loop, speed = self._defaults
                state = features.PlaybackState(len(recording), recording.duration, loop=loop, speed=speed)
                first = recording.frame(0, 0)
            except BaseException:
                if recording is not None:
                    recording.close()
                self.connection_changed.emit(ConnectionState.CLOSED, "")
                raise
            state.width, state.height = first.width, first.height
            state.pixel_format = first.pixel_format.name
            self._recording, self._state = recording, state
        self.connection_changed.emit(ConnectionState.OPEN, "")

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
        """Always control: a recording is nobody else's."""
        return Access.CONTROL

    @override
    def recorded_coordinates(self) -> Scan3d | None:
        recording = self._recording
        return recording.scan if recording is not None else None

    # -- features --------------------------------------------------------------------------------
    @override
    def feature_tree(self) -> Category:
        return features.TREE

    @override
    def has_feature(self, name: str) -> bool:
        return name in features.DESCRIPTIONS

    @override
    def feature(self, name: str) -> Feature:
        self._require(name)
        with self._changed:
            return features.feature(name, self._state)

    @override
    def write_feature(self, name: str, value: FeatureValue) -> Feature:
        accepted = self.feature(name).validated(value)
        changed = {name}
        with self._changed:
            state = self._state
            if name == features.POSITION:
                state.position, self._shown = int(accepted), -1
                state.time = self._time_of(state.position)
                changed.add(features.TIME)
            elif name == features.SPEED:
                state.speed = float(accepted)
            elif name == features.LOOP:
                state.loop = bool(accepted)
            else:
                state.playing = bool(accepted)
                changed |= {features.POSITION, features.TIME}  # they moved on since the last notice
                if state.playing and state.position >= state.frames - 1:
                    state.position, self._shown = 0, -1  # play again after the end
                elif state.playing and self._shown == state.position:
                    self._shown = -1  # wound to by hand: go on from this one
            self._changed.notify_all()
        self.features_changed.emit(frozenset(changed))
        return self.feature(name)

    @override
    def execute(self, name: str) -> None:
        self._require(name)
        raise FeatureError(f"{name} is no command; a recording has none", name)

    # -- acquisition -----------------------------------------------------------------------------
    @override
    def start(self, *, keep_trigger: bool = False) -> None:
        with self._starting, self._changed:
            if self._running:
                return
            if self._recording is None:
                raise DeviceLostError(f"{self.info.title} is not open")
            self._running, self._shown = True, -1
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

    @property
    @override
    def streaming(self) -> bool:
        return self._running

    @override
    def statistics(self) -> StreamStatistics:
        rate, bandwidth = self._rates.rates()
        counted = self._statistics
        return StreamStatistics(
            frames=counted.frames,
            incomplete=counted.incomplete,
            bytes=counted.bytes,
            frame_rate=rate,
            bandwidth=bandwidth,
        )

    # -- the player's thread ------------------------------------------------------------------------
    def _play(self, recording: Recording) -> None:
        due = time.monotonic()
        noticed = 0.0
        while True:
            with self._changed:
                due, at_position = self._wait_for_turn(due)
                if not self._running:
                    return
                index = self._state.position
                self._shown = index
            self._deliver(recording, index)
            with self._changed:
                if self._state.playing and self._state.position == index:
                    due = self._advance(recording, index, due if not at_position else time.monotonic())
                at_rest = not self._state.playing
            if time.monotonic() - noticed > NOTICE_PERIOD or at_position or at_rest:
                noticed = time.monotonic()
                self.features_changed.emit(
                    frozenset({features.POSITION, features.TIME, features.PLAYING, features.WIDTH})
                )

    def _wait_for_turn(self, due: float) -> tuple[float, bool]:
        """Wait until the frame at the position is to be delivered; whether a user put the position there."""
        while self._running:
            if self._shown == -1:
                return time.monotonic(), True
            if not self._state.playing or self._shown == self._state.position:
                self._changed.wait()
                due = time.monotonic()
                continue
            wait = due - time.monotonic()
            if wait <= 0:
                return due, False
            self._changed.wait(wait)
        return due, False

    def _advance(self, recording: Recording, index: int, due: float) -> float:
        """Move on to the next frame; when it is due."""
        state = self._state
        if index + 1 < state.frames:
            gap = (recording.times_ns[index + 1] - recording.times_ns[index]) / 1e9
            state.position = index + 1
        elif state.loop:
            gap = state.duration / (state.frames - 1) if state.frames > 1 else 0.0
            gap = max(gap, LOOP_PAUSE if state.frames == 1 else 0.001)
            state.position = 0
            self._shown = state.frames  # the first follows, also where it is the only one
        else:
            state.playing = False
            return due
        state.time = self._time_of(state.position)
        # Behind by more than a moment (the machine was busy): carry on from here, hurry through nothing.
        return max(due + min(gap, LONGEST_GAP) / state.speed, time.monotonic() - LOOP_PAUSE)

    def _deliver(self, recording: Recording, index: int) -> None:
        try:
            frame = recording.frame(index, time.time_ns())
        except GrabberError as error:
            log.warning("%s: %s", self.info.uri, error)
            self._statistics.incomplete += 1
            return
        state = self._state
        state.width, state.height, state.pixel_format = frame.width, frame.height, frame.pixel_format.name
        self._statistics.frames += 1
        self._statistics.bytes += frame.payload.nbytes
        self._rates.add(frame.payload.nbytes)
        self._fanout.put(frame)

    def _time_of(self, index: int) -> float:
        times = self._recording.times_ns if self._recording is not None else []
        return (times[index] - times[0]) / 1e9 if index < len(times) else 0.0


def discover(timeout: float = 1.0) -> list[DeviceInfo]:
    """None: recordings are opened by name."""
    return []


def create(uri: SourceUri) -> FrameGrabber:
    """The recording that a URI names, not yet opened. Raises UsageError."""
    if not uri.name:
        raise UsageError("file: needs a recording, as in file:folder, file:movie.mp4 or file:recording.mcap")
    options = read_options(PlaybackOptions, uri)
    try:
        path = Path(uri.name).expanduser()
    except RuntimeError as error:
        raise UsageError(f"{uri}: there is no such home directory; write the whole path") from error
    info = DeviceInfo(
        str(uri), "Recording", model=path.name, bus="File", address=str(path), user_name=path.name
    )
    return PlaybackGrabber(info, path, loop=options.loop, speed=options.speed)
