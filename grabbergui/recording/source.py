"""`file:`, a recording as a source: `file:folder`, `file:movie.mp4`, `file:recording.mcap`.

Options: `loop=0` plays once, `speed=2` twice as fast.
"""

from __future__ import annotations

from pathlib import Path

from grabbergui.core.errors import UsageError
from grabbergui.core.grabber import DeviceInfo, FrameGrabber
from grabbergui.core.uri import SourceUri
from grabbergui.recording.playback import PlaybackGrabber
from grabbergui.recording.playback_features import FASTEST, SLOWEST


def discover(timeout: float = 1.0) -> list[DeviceInfo]:
    """None: recordings are opened by name."""
    return []


def create(uri: SourceUri) -> FrameGrabber:
    """The recording that a URI names, not yet opened. Raises UsageError."""
    if not uri.name:
        raise UsageError("file: needs a recording, as in file:folder, file:movie.mp4 or file:recording.mcap")
    unknown = uri.options.keys() - {"loop", "speed"}
    if unknown:
        raise UsageError(f"file: has no option '{min(unknown)}'; there are loop and speed")
    try:
        path = Path(uri.name).expanduser()
    except RuntimeError as error:
        raise UsageError(f"{uri}: there is no such home directory; write the whole path") from error
    info = DeviceInfo(
        str(uri), "Recording", model=path.name, bus="File", address=str(path), user_name=path.name
    )
    return PlaybackGrabber(
        info, path, loop=_loop(uri.option("loop", "1")), speed=_speed(uri.option("speed", "1"))
    )


def _loop(text: str) -> bool:
    if text.lower() not in ("0", "1", "false", "true", "off", "on", "no", "yes"):
        raise UsageError(f"file:?loop={text}: allowed is 0 or 1")
    return text.lower() in ("1", "true", "on", "yes")


def _speed(text: str) -> float:
    try:
        speed = float(text)
    except ValueError:
        speed = 0.0
    if not SLOWEST <= speed <= FASTEST:
        raise UsageError(f"file:?speed={text}: allowed is {SLOWEST:g} to {FASTEST:g}")
    return speed
