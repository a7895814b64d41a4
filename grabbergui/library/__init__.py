"""The Python library behind `import grabbergui`: finding cameras, and opening one or several.

An open camera is a context manager (`camera`), several are a sequence (`group`), frames are iterators
(`streaming`). Only what `grabbergui.__all__` lists is public. This package uses `models` for settings files
and `recording` for recordings; it imports no Qt.
"""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Literal, get_args

from grabbergui import sources
from grabbergui.core.errors import UsageError
from grabbergui.core.grabber import Access
from grabbergui.core.identity import DeviceInfo
from grabbergui.library.camera import Camera
from grabbergui.library.group import CameraGroup
from grabbergui.library.streaming import await_collected

AccessName = Literal["control", "monitor", "take over"]

SEARCH = 1.0
"Seconds to search for a camera that is named without its kind."


def discover(timeout: float = 1.0) -> list[DeviceInfo]:
    """Return every source found within `timeout` seconds, on all networks and buses at once.

    A camera on ROS 2 may take 3.5 s to be discovered.

    `grabbergui.open(info.uri)`, or `grabbergui.open(info)`, opens one of them.
    """
    return sources.discover(timeout)


def open(source: str | DeviceInfo, *, access: AccessName = "control") -> Camera:  # noqa: A001
    """Open a camera by its URI: `gige:192.168.0.10`, `u3v:SERIAL`, `sim:`, `yarp:/grabber`, `ros2:/camera`.

    A kind alone (`gige:`) opens the first one found. A serial number, user-defined name or address without a
    kind is searched among all kinds for a second. With access `"monitor"` features are only read, beside the
    program that has control; `"take over"` takes control from one that offers it. Nothing is written to
    the camera. Use it as a context manager, or call `close`; otherwise it is closed when nobody refers to it
    any more, and at the program's end.

    Raises UsageError for a malformed URI, SourceNotFoundError, AccessDeniedError, TransportError.
    """
    if not isinstance(source, str | DeviceInfo):
        raise UsageError(
            f"{source!r} is not a source; write its URI, as in 'gige:192.168.0.10' or 'file:run.mcap'"
        )
    if access not in get_args(AccessName):
        raise UsageError(f"access={access!r}: there are {', '.join(get_args(AccessName))}")
    await_collected()  # it may be the same camera
    grabber = sources.create(source.uri if isinstance(source, DeviceInfo) else sources.named(source, SEARCH))
    try:
        grabber.open(Access(access))
        return Camera(grabber)
    except BaseException:  # Ctrl-C may come when it is just open
        grabber.close()
        raise


def open_all(sources: Iterable[str | DeviceInfo], *, access: AccessName = "control") -> CameraGroup:
    """Open several cameras at once; if one of them fails, none stays open. Raises as `open`."""
    if isinstance(sources, str):
        raise UsageError(f"open_all takes several sources, as in open_all(['{sources}'])")
    wanted = list(sources)
    if not wanted:
        raise UsageError("open_all([]): name at least one source; grabbergui.discover() lists them")
    with ThreadPoolExecutor(len(wanted), "open camera") as pool:
        opening = [pool.submit(open, source, access=access) for source in wanted]
        problems = [error for future in opening if (error := future.exception()) is not None]
    if problems:
        for future in opening:
            if future.exception() is None:
                future.result().close()
        raise problems[0]
    return CameraGroup([future.result() for future in opening])
