"""`rig:stereo.yaml` as a source: opens the cameras that a rig's file names, or plays a rig's recording."""

from __future__ import annotations

from collections.abc import Mapping

from grabbergui import sources
from grabbergui.core.environment import expanded, find_file
from grabbergui.core.errors import UsageError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.uri import PlaybackOptions, SourceUri, read_options
from grabbergui.rig import rig_file
from grabbergui.rig.grabber import RigGrabber
from grabbergui.rig.rig_file import RigEntry

RECORDINGS = (".mcap",)
"Suffixes of recordings, which are played."


def create(uri: SourceUri) -> FrameGrabber:
    """Return the rig of a file. Raises UsageError, MissingFileError."""
    if not uri.name:
        raise UsageError(
            "rig: needs the file of a rig, as in rig:stereo.yaml; `grabbergui rig new` makes one"
        )
    path = find_file(expanded(uri.name), "rig")
    options = read_options(PlaybackOptions, uri)
    if path.suffix.lower() in RECORDINGS:
        from grabbergui.rig.recording import RigPlayback

        info = DeviceInfo(
            str(uri), "Recording", model=path.name, bus="File", address=str(path), user_name=path.name
        )
        return RigPlayback(info, path, options)
    info = DeviceInfo(str(uri), model="Rig", bus="Rig", address=str(path), user_name=path.stem)
    return of_entry(rig_file.read(path), info)


def of_entry(entry: RigEntry, info: DeviceInfo | None = None) -> RigGrabber:
    """Return a rig of what its file would say, not yet opened. Raises UsageError."""
    cameras: Mapping[str, FrameGrabber] = {
        name: sources.create(_camera_uri(name, camera.source)) for name, camera in entry.cameras.items()
    }
    return RigGrabber(info or DeviceInfo(uri="rig:", bus="Rig", model="rig"), entry, cameras)


def _camera_uri(name: str, uri: str) -> str:
    if SourceUri.parse(uri).scheme == "rig":
        raise UsageError(f"cameras.{name}: a rig cannot contain a rig")
    return uri


def discover(timeout: float) -> list[DeviceInfo]:
    """Return no rigs: they are files."""
    return []
