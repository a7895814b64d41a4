"""A recording's knobs: where it plays, how fast, whether again and again."""

from __future__ import annotations

from dataclasses import dataclass

from grabbergui.core.features import (
    AccessMode,
    Category,
    Feature,
    FeatureDescription,
    FeatureKind,
    FeatureValue,
    Representation,
)

POSITION = "PlaybackPosition"
SPEED = "PlaybackSpeed"
LOOP = "PlaybackLoop"
PLAYING = "PlaybackActive"
TIME = "PlaybackTime"
LENGTH = "PlaybackFrameCount"
DURATION = "PlaybackDuration"
WIDTH, HEIGHT, PIXEL_FORMAT = "Width", "Height", "PixelFormat"

SLOWEST, FASTEST = 0.05, 20.0

_CATEGORY = "PlaybackControl"
_FORMAT = "ImageFormatControl"


@dataclass
class PlaybackState:
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
    _described(PLAYING, FeatureKind.BOOLEAN, _CATEGORY, "Playing", "Off holds the picture at the position."),
    _described(POSITION, FeatureKind.INTEGER, _CATEGORY, "Position", "The frame shown, counted from 0."),
    _described(SPEED, FeatureKind.FLOAT, _CATEGORY, "Speed", "1 plays as fast as it was recorded."),
    _described(LOOP, FeatureKind.BOOLEAN, _CATEGORY, "Loop", "Begin again at the end."),
    _described(TIME, FeatureKind.FLOAT, _CATEGORY, "Time", "From the first frame to the one shown."),
    _described(LENGTH, FeatureKind.INTEGER, _CATEGORY, "Frames", "How many frames were recorded."),
    _described(DURATION, FeatureKind.FLOAT, _CATEGORY, "Duration", "From the first frame to the last."),
    _described(WIDTH, FeatureKind.INTEGER, _FORMAT, "", "Of the frame shown last."),
    _described(HEIGHT, FeatureKind.INTEGER, _FORMAT, "", "Of the frame shown last."),
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


def feature(name: str, state: PlaybackState) -> Feature:
    """A feature as it is now. `name` must be one of DESCRIPTIONS."""
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
