"""Takes the place of a camera's grabber that this process may not use: it is closed, or its parent's."""

from __future__ import annotations

from typing import NoReturn, cast

from grabbergui.core.errors import GrabberError
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.identity import DeviceInfo


class StandIn:
    """Raises the same error whatever it is asked for, except what the camera was."""

    streaming = False
    lost = ""

    def __init__(self, info: DeviceInfo, error: type[GrabberError], problem: str) -> None:
        self.info = info
        self._error = error
        self._problem = problem

    @classmethod
    def of(cls, grabber: FrameGrabber, error: type[GrabberError], problem: str) -> FrameGrabber:
        """Return a stand-in for a grabber; `problem` follows the camera's title."""
        return cast(FrameGrabber, cls(grabber.info, error, f"{grabber.info.title} {problem}"))

    def statistics(self) -> StreamStatistics:
        """Counters that count nothing."""
        return StreamStatistics()

    def __getattr__(self, name: str) -> NoReturn:
        if name.startswith("__"):
            raise AttributeError(name)
        raise self._error(self._problem)
