"""Looking back: the last frames of a stream, and position and speed of a recording that is a source."""

from __future__ import annotations

import threading
from collections import deque
from dataclasses import dataclass, fields
from functools import partial

from psygnal import Signal

from grabbergui.core.errors import GrabberError
from grabbergui.core.features import FeatureValue
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameSink
from grabbergui.core.grabber import FrameGrabber
from grabbergui.models.open_source import OpenSource

MOST_FRAMES = 100
MOST_BYTES = 256 * 1024 * 1024
"Of all frames kept: 51 of five megapixels, a hundred of two and a half."
FRAME_WAIT = 0.2


class FrameHistory:
    """Keeps copies of the last frames while it runs: the stream's own buffers must go back to it.

    All methods may be called from any thread.
    """

    def __init__(self, most_frames: int = MOST_FRAMES, most_bytes: int = MOST_BYTES) -> None:
        self._most_bytes = most_bytes
        self._frames: deque[Frame] = deque(maxlen=most_frames)
        self._bytes = 0
        self._paused = False
        self._sink: FrameSink | None = None
        self._lock = threading.Lock()

    @property
    def frames(self) -> tuple[Frame, ...]:
        """The stored frames, the oldest first."""
        with self._lock:
            return tuple(self._frames)

    @property
    def paused(self) -> bool:
        """Whether the history is frozen."""
        return self._paused

    def pause(self, paused: bool) -> None:
        """Freeze the history, or go on with the frames that arrive from now on."""
        with self._lock:
            self._paused = paused

    def attach(self, grabber: FrameGrabber) -> None:
        """Keep this source's frames, and none from before."""
        self.detach()
        with self._lock:
            self._paused = False
        self._clear()
        self._sink = FrameSink(grabber, self.add, name="history", depth=4, wait=FRAME_WAIT)
        self._sink.start()

    def detach(self, timeout: float = 0.0) -> bool:
        """Stop; return whether the thread ended within `timeout` seconds. May be called again."""
        return self._sink is None or self._sink.stop(timeout)

    def add(self, frame: Frame) -> None:
        """Keep a copy of a frame, unless paused; the oldest make way."""
        size = frame.nbytes
        if self._paused or size > self._most_bytes:
            return
        copy = frame.detached()
        with self._lock:
            if self._paused:
                return
            while self._frames and (
                len(self._frames) == self._frames.maxlen or self._bytes + size > self._most_bytes
            ):
                self._bytes -= self._frames.popleft().nbytes
            self._frames.append(copy)
            self._bytes += size

    def _clear(self) -> None:
        with self._lock:
            self._frames.clear()
            self._bytes = 0


_FEATURES = {
    "playing": "PlaybackActive",
    "position": "PlaybackPosition",
    "frames": "PlaybackFrameCount",
    "time": "PlaybackTime",
    "duration": "PlaybackDuration",
    "speed": "PlaybackSpeed",
    "loop": "PlaybackLoop",
}


@dataclass(frozen=True)
class PlaybackState:
    """State of a recording in playback."""

    playing: bool = False
    position: int = 0
    "The frame shown, counted from 0."
    frames: int = 1
    time: float = 0.0
    "Seconds from the first frame to the one shown."
    duration: float = 0.0
    "Seconds from the first frame to the last."
    speed: float = 1.0
    "1 is as fast as it was recorded."
    loop: bool = True


def is_recording(grabber: FrameGrabber) -> bool:
    """Return whether a source is a recording."""
    return all(grabber.has_feature(name) for name in _FEATURES.values())


class PlaybackModel:
    """Follows an open source that is a recording. No call waits; signals come from the source's thread.

    Values go to the recording itself and not through the change tracking: winding back and forth is
    nothing to be undone.
    """

    changed = Signal(PlaybackState)
    failed = Signal(GrabberError)

    def __init__(self, source: OpenSource) -> None:
        assert source.grabber is not None
        self._source = source
        self._grabber = source.grabber
        self._state = PlaybackState()
        self._grabber.features_changed.connect(self._on_grabber_features_changed)
        self._look()

    @property
    def state(self) -> PlaybackState:
        """As last known."""
        return self._state

    def close(self) -> None:
        """Follow it no longer."""
        self._grabber.features_changed.disconnect(self._on_grabber_features_changed, missing_ok=True)

    def play(self, playing: bool) -> None:
        """Go on, or hold the picture."""
        self._set("playing", playing)

    def go_to(self, position: int) -> None:
        """Show this frame; the nearest one there is."""
        self._set("position", min(max(position, 0), self._state.frames - 1))

    def step(self, steps: int) -> None:
        """Hold the picture, so many frames further."""
        self.play(False)
        self._source.worker.submit(partial(self._step, steps), failed=self.failed.emit)

    def set_speed(self, speed: float) -> None:
        """Set the speed as a multiple of the recorded one."""
        self._set("speed", speed)

    def set_loop(self, loop: bool) -> None:
        """Begin again at the end, or stay there."""
        self._set("loop", loop)

    # -- on the source's thread -------------------------------------------------------------------
    def _step(self, steps: int) -> None:
        position = self._grabber.feature(_FEATURES["position"])
        if isinstance(position.value, int) and position.maximum is not None:
            wanted = min(max(position.value + steps, 0), int(position.maximum))
            self._grabber.write_feature(position.name, wanted)

    def _read(self) -> PlaybackState:
        return PlaybackState(
            **{f.name: self._grabber.feature(_FEATURES[f.name]).value for f in fields(PlaybackState)}  # type: ignore[arg-type]
        )

    def _publish(self, state: PlaybackState) -> None:
        if state != self._state:
            self._state = state
            self.changed.emit(state)

    # -- from anywhere ----------------------------------------------------------------------------
    def _set(self, what: str, value: FeatureValue) -> None:
        name = _FEATURES[what]
        self._source.worker.submit(
            lambda: self._grabber.write_feature(name, value),
            key=f"playback {name}",
            done=lambda _: self._look(),
            failed=self.failed.emit,
        )

    def _look(self) -> None:
        self._source.worker.submit(self._read, key="playback", done=self._publish)

    def _on_grabber_features_changed(self, names: frozenset[str]) -> None:
        if not names.isdisjoint(_FEATURES.values()):
            self._look()
