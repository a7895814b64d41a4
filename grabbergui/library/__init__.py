"""The Python library behind `import grabbergui`: finding cameras, and opening one or several.

An open camera is a context manager (`camera`), its frames are iterators (`streaming`). Only what
`grabbergui.__all__` lists is public. This package uses `models` for settings files and `recording` for
recordings; it imports no Qt.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from types import TracebackType
from typing import Literal, get_args

from grabbergui import sources
from grabbergui.core.errors import UsageError
from grabbergui.core.features import FeatureValue
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import Access
from grabbergui.core.identity import DeviceInfo
from grabbergui.library.camera import Camera
from grabbergui.library.streaming import await_collected

AccessName = Literal["control", "monitor", "take over"]


def discover(timeout: float = 1.0) -> list[DeviceInfo]:
    """Return every source found within `timeout` seconds, on all networks and buses at once.

    A camera on ROS 2 may take 3.5 s to be discovered.

    `grabbergui.open(info.uri)`, or `grabbergui.open(info)`, opens one of them.
    """
    return sources.discover(timeout)


def open(source: str | DeviceInfo, *, access: AccessName = "control") -> Camera:  # noqa: A001
    """Open a camera by its URI: `gige:192.168.0.10`, `u3v:SERIAL`, `sim:`, `yarp:/grabber`, `ros2:/camera`.

    A kind alone (`gige:`) opens the first one found. With access `"monitor"` features are only read, beside
    the program that has control; `"take over"` takes control from one that offers it. Nothing is written to
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
    grabber = sources.create(source.uri if isinstance(source, DeviceInfo) else source)
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
    with ThreadPoolExecutor(max(len(wanted), 1), "open camera") as pool:
        opening = [pool.submit(open, source, access=access) for source in wanted]
        problems = [error for future in opening if (error := future.exception()) is not None]
    if problems:
        for future in opening:
            if future.exception() is None:
                future.result().close()
        raise problems[0]
    return CameraGroup([future.result() for future in opening])


class CameraGroup:
    """Several open cameras: a sequence of them that is closed as one."""

    def __init__(self, cameras: list[Camera]) -> None:
        self._cameras = tuple(cameras)

    def __len__(self) -> int:
        return len(self._cameras)

    def __getitem__(self, index: int) -> Camera:
        return self._cameras[index]

    def __iter__(self) -> Iterator[Camera]:
        return iter(self._cameras)

    def start(self) -> None:
        """Start all streams."""
        self._on_each(Camera.start)

    def stop(self) -> None:
        """Stop all streams."""
        self._on_each(Camera.stop)

    def grab(self, timeout: float | None = None, **settings: FeatureValue) -> list[Frame]:
        """Return a frame of each camera, in their order, exposed from now on; see `Camera.grab`.

        The cameras are not synchronised by this: set a trigger or PTP for frames of one moment.
        """
        with ThreadPoolExecutor(max(len(self), 1), "grab") as pool:
            return list(pool.map(lambda camera: camera.grab(timeout, **settings), self))

    def frames(
        self, count: int | None = None, *, timeout: float | None = None
    ) -> Iterator[tuple[Frame, ...]]:
        """Iterate over tuples of the n-th frame of each camera. All streams start before a frame is awaited.

        A frame that one camera loses shifts its later ones; their `frame_id` and `timestamp_ns` tell.
        """
        with contextlib.ExitStack() as streams:
            loops = [camera.frames(count, timeout=timeout).started() for camera in self]
            yield from zip(*[streams.enter_context(loop) for loop in loops], strict=False)

    def close(self) -> None:
        """Close all cameras. May be called twice; never raises."""
        with ThreadPoolExecutor(max(len(self), 1), "close") as pool:
            list(pool.map(Camera.close, self))

    def __enter__(self) -> CameraGroup:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _on_each(self, call: Callable[[Camera], None]) -> None:
        with ThreadPoolExecutor(max(len(self), 1)) as pool:
            for problem in [future.exception() for future in [pool.submit(call, camera) for camera in self]]:
                if problem is not None:
                    raise problem
