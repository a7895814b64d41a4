"""Playback of a recording."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import partial

from psygnal import Signal

from grabbergui.core.errors import GrabberError
from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.features import FeatureValue
from grabbergui.core.sfnc import PLAYBACK_POSITION
from grabbergui.models.open_source import OpenSource

_PLAYBACK_FEATURES = {
    "playing": "PlaybackActive",
    "position": PLAYBACK_POSITION,
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
    "Index of the frame shown, from 0."
    frames: int = 1
    time: float = 0.0
    "Seconds from the first frame to the one shown."
    duration: float = 0.0
    "Seconds from the first frame to the last."
    speed: float = 1.0
    "Multiple of the recorded speed."
    loop: bool = True


def is_recording(grabber: FeatureSource) -> bool:
    """Return whether a source is a recording."""
    return all(grabber.has_feature(name) for name in _PLAYBACK_FEATURES.values())


class PlaybackModel:
    """Follows and controls an open source that is a recording.

    No call waits; signals come from the source's thread. Writes bypass the change tracking, because playback
    is nothing to undo.
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
        """The last known state."""
        return self._state

    def close(self) -> None:
        """Stop following the source."""
        self._grabber.features_changed.disconnect(self._on_grabber_features_changed, missing_ok=True)

    def play(self, playing: bool) -> None:
        """Play, or pause."""
        self._set("playing", playing)

    def go_to(self, position: int) -> None:
        """Show the frame at this position, or the nearest one."""
        self._set("position", min(max(position, 0), self._state.frames - 1))

    def step(self, steps: int) -> None:
        """Pause, and move by a number of frames."""
        self.play(False)
        self._source.worker.submit(partial(self._step, steps), failed=self.failed.emit)

    def set_speed(self, speed: float) -> None:
        """Set the speed as a multiple of the recorded one."""
        self._set("speed", speed)

    def set_loop(self, loop: bool) -> None:
        """Set whether playback starts over at the end."""
        self._set("loop", loop)

    def _step(self, steps: int) -> None:
        position = self._grabber.feature(_PLAYBACK_FEATURES["position"])
        if isinstance(position.value, int) and position.maximum is not None:
            wanted = min(max(position.value + steps, 0), int(position.maximum))
            self._grabber.write_feature(position.name, wanted)

    def _read(self) -> PlaybackState:
        return PlaybackState(
            **{f.name: self._grabber.feature(_PLAYBACK_FEATURES[f.name]).value for f in fields(PlaybackState)}  # type: ignore[arg-type]
        )

    def _publish(self, state: PlaybackState) -> None:
        if state != self._state:
            self._state = state
            self.changed.emit(state)

    def _set(self, attribute: str, value: FeatureValue) -> None:
        name = _PLAYBACK_FEATURES[attribute]
        self._source.worker.submit(
            lambda: self._grabber.write_feature(name, value),
            key=f"playback {name}",
            done=lambda _: self._look(),
            failed=self.failed.emit,
        )

    def _look(self) -> None:
        self._source.worker.submit(self._read, key="playback", done=self._publish)

    def _on_grabber_features_changed(self, names: frozenset[str]) -> None:
        if not names.isdisjoint(_PLAYBACK_FEATURES.values()):
            self._look()
