"""Several open cameras that are set, read, triggered and closed as one."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from types import TracebackType
from typing import Any, TypeVar, overload

from grabbergui.core.errors import FeatureError, GrabberError
from grabbergui.core.features import FeatureValue
from grabbergui.core.frame import Frame
from grabbergui.core.frame_period import frame_wait
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.library.arguments import checked_count, checked_depth, checked_timeout
from grabbergui.library.camera import Camera
from grabbergui.library.features import SettingValue
from grabbergui.library.sets import next_set
from grabbergui.library.streaming import DEPTH, FrameLoop
from grabbergui.rig import rig_file
from grabbergui.rig.camera_clock import CameraClock, ClockWatch
from grabbergui.rig.frame_sets import MatchByTime
from grabbergui.rig.rig_file import TriggerEntry
from grabbergui.rig.set_frame import SetFrame
from grabbergui.rig.set_stream import SetStream, set_times

Answer = TypeVar("Answer")


class CameraGroup(Sequence[Camera]):
    """Several open cameras: a sequence of them whose settings are set, and which are closed, as one.

    `cameras.exposure_time = 5000`, or `cameras["ExposureTime"] = 5000`, sets all of them; reading returns a
    list with the value of each. `cameras[0]` is a camera. Calls reach all cameras at once.
    """

    def __init__(self, cameras: Sequence[Camera]) -> None:
        """Group open cameras; `grabbergui.open_all` is the usual way."""
        object.__setattr__(self, "_cameras", tuple(cameras))

    _cameras: tuple[Camera, ...]

    def __len__(self) -> int:
        return len(self._cameras)

    @overload
    def __getitem__(self, index: int) -> Camera: ...
    @overload
    def __getitem__(self, index: slice) -> CameraGroup: ...
    @overload
    def __getitem__(self, index: str) -> list[FeatureValue]: ...
    def __getitem__(self, index: int | slice | str) -> Camera | CameraGroup | list[FeatureValue]:
        if isinstance(index, str):
            return self.read(index)
        return CameraGroup(self._cameras[index]) if isinstance(index, slice) else self._cameras[index]

    def __setitem__(self, name: str, value: SettingValue) -> None:
        self.write(name, value)

    def __contains__(self, item: object) -> bool:
        """Whether a camera is of the group; for a name, whether all cameras have this feature."""
        if isinstance(item, str):
            return all(item in camera for camera in self)
        return item in self._cameras

    def __getattr__(self, attribute: str) -> list[Any]:
        if attribute.startswith("_"):
            raise AttributeError(f"a group of cameras has no attribute '{attribute}'")
        if callable(getattr(Camera, attribute, None)):
            raise AttributeError(
                f"a group of cameras has no method {attribute}; call that of each camera:"
                f" [camera.{attribute}(…) for camera in cameras]"
            )
        return [getattr(camera, attribute) for camera in self]

    def __setattr__(self, attribute: str, value: Any) -> None:
        if attribute.startswith("_") or hasattr(type(self), attribute):
            raise AttributeError(f"'{attribute}' of a group of cameras cannot be set")
        for camera in self:
            if attribute not in camera:
                getattr(camera, attribute)  # raises AttributeError, with what was meant
        self.write(attribute, value)

    def __repr__(self) -> str:
        return f"<grabbergui.CameraGroup of {', '.join(camera.info.uri for camera in self)}>"

    def read(self, name: str) -> list[FeatureValue]:
        """Return a feature's value of each camera, in their order. Raises as `Camera.read`."""
        return self._on_each(lambda camera: camera.read(name))

    def write(self, name: str, value: SettingValue) -> list[FeatureValue]:
        """Write a feature of all cameras, and return what each then reports.

        If a camera refuses, the others get their values back. Nothing is written if one lacks the feature.
        Raises as `Camera.write`, with the camera's name in the message.
        """
        for camera in self:
            if name not in camera:
                camera.read(name)  # raises FeatureNotFoundError
        before = [_value_before(camera, name) for camera in self]
        outcomes = self._outcomes(lambda camera: camera.write(name, value))
        refused = next((n for n, each in enumerate(outcomes) if isinstance(each, BaseException)), None)
        if refused is not None:
            for camera, old, outcome in zip(self, before, outcomes, strict=True):
                if old is not None and not isinstance(outcome, BaseException):
                    with contextlib.suppress(GrabberError):
                        camera.write(name, old)
            raise _of_camera(self[refused], outcomes[refused])
        return [each for each in outcomes if not isinstance(each, BaseException)]

    def execute(self, name: str) -> None:
        """Run a command feature of all cameras, and wait until each has done it."""
        self._on_each(lambda camera: camera.execute(name))

    def start(self) -> None:
        """Start all streams."""
        self._on_each(Camera.start)

    def stop(self) -> None:
        """Stop all streams."""
        self._on_each(Camera.stop)

    def grab(self, timeout: float | None = None, **settings: SettingValue) -> list[Frame]:
        """Return a frame of each camera, in their order, exposed from now on; see `Camera.grab`.

        The cameras are not synchronised by this: use `trigger_group`, or PTP, for frames of one moment.
        """
        return self._on_each(lambda camera: camera.grab(timeout, **settings))

    def trigger(self, timeout: float | None = None) -> list[Frame]:
        """Fire the software trigger of each camera, and return the frames; see `Camera.trigger`.

        The triggers leave this computer within about a millisecond.
        """
        return self._on_each(lambda camera: camera.trigger(timeout))

    def trigger_group(
        self,
        group_key: int = 1,
        *,
        device_key: int = 1,
        group_mask: int = 1,
        ptp: bool = True,
        ahead: float = 0.2,
        timeout: float | None = None,
    ) -> list[Frame]:
        """Expose all cameras at the same time by an action command, and return a frame of each.

        GigE Vision cameras only. The cameras are set for the action: keys, mask, and a trigger by `Action1`.
        With `ptp`, their clocks are synchronised and the action is scheduled `ahead` seconds from now;
        without, it is executed on arrival. The streams stay on. Raises UsageError for other cameras,
        FeatureError, DeviceStatusError, FrameTimeoutError.
        """
        from grabbergui.rig.action_group import ActionGroup

        keys = TriggerEntry(
            "action", group_key=group_key, device_key=device_key, group_mask=group_mask, ahead=ahead
        )
        group = ActionGroup([camera.grabber for camera in self], keys, ptp=ptp, timeout=timeout)
        with contextlib.closing(group):
            group.start()
            for camera in self:
                camera.start()  # it stays on, as after `grab`
            return list(group.fire().values())

    def frames(
        self, count: int | None = None, *, timeout: float | None = None, depth: int = DEPTH
    ) -> GroupFrames:
        """Iterate over tuples with a frame of each camera. All streams start before a frame is awaited.

        The frames of a tuple are of one moment, within half of the longest frame period, by the cameras'
        clocks; a moment of which a camera's frame is missing is left out, so that nothing is shifted. Up to
        `depth` tuples wait for a slow loop; what it was too slow for is counted by `dropped`.
        """
        return GroupFrames(self, count, timeout, depth)

    def close(self) -> None:
        """Close all cameras. May be called twice; never raises."""
        self._outcomes(Camera.close)

    def __enter__(self) -> CameraGroup:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _on_each(self, call: Callable[[Camera], Answer]) -> list[Answer]:
        """Call a function for all cameras at once; raise the first problem after all have returned."""
        outcomes = self._outcomes(call)
        for outcome in outcomes:
            if isinstance(outcome, BaseException):
                raise outcome
        return [outcome for outcome in outcomes if not isinstance(outcome, BaseException)]

    def _outcomes(self, call: Callable[[Camera], Answer]) -> list[Answer | BaseException]:
        """Call a function for all cameras at once; return what each returned or raised."""
        if not self._cameras:
            return []
        with ThreadPoolExecutor(len(self), "camera group") as pool:
            calls = [pool.submit(call, camera) for camera in self]
            return [each.exception() or each.result() for each in calls]


class GroupFrames:
    """The frames of a group of cameras, as an iterable of tuples: see `CameraGroup.frames`."""

    def __init__(self, cameras: CameraGroup, count: int | None, timeout: float | None, depth: int) -> None:
        self._cameras = cameras
        self._count = checked_count("frames", count)
        self._timeout = checked_timeout("frames", timeout)
        self._depth = checked_depth("frames", depth)
        self._queue: FrameQueue | None = None
        self._dropped = 0

    @property
    def dropped(self) -> tuple[int, ...]:
        """Frames of each camera that the loop was too slow for, so far or in the last loop."""
        dropped = self._queue.dropped if self._queue is not None else self._dropped
        return (dropped,) * len(self._cameras)

    def __iter__(self) -> FrameLoop[tuple[Frame, ...]]:
        stack = contextlib.ExitStack()
        try:
            return FrameLoop(self._started(stack), stack)
        except BaseException:
            stack.close()
            raise

    def _started(self, stack: contextlib.ExitStack) -> Iterator[tuple[Frame, ...]]:
        """Start gathering sets, then the streams, until the stack is closed."""
        cameras = {f"camera{number}": camera for number, camera in enumerate(self._cameras, 1)}
        grabbers = {name: camera.grabber for name, camera in cameras.items()}
        names = tuple(grabbers)
        clocks = {name: CameraClock(grabber, wanted="fitted") for name, grabber in grabbers.items()}
        times = set_times(rig_file.of_sources(dict.fromkeys(names, "")), grabbers.values())
        matcher: MatchByTime[Frame] = MatchByTime(names, times, deliver_incomplete=False)
        queue = self._queue = FrameQueue(self._depth)
        stack.callback(self._end, queue)
        watch = ClockWatch(clocks, lambda: None)
        watch.start()
        stack.callback(watch.stop)
        sets = SetStream(grabbers, clocks, matcher, lambda images: queue.put(SetFrame.of(images)))
        sets.start()
        stack.callback(sets.stop)
        for camera in self._cameras:
            stack.enter_context(camera.streamed())
        timeout = self._timeout
        if timeout is None:
            timeout = max(frame_wait(grabber) for grabber in grabbers.values())
        count = () if self._count is None else (self._count,)

        def images(seconds: float) -> tuple[Frame, ...]:
            return tuple(next_set(queue, seconds, cameras).images.values())

        return map(images, itertools.repeat(timeout, *count))

    def _end(self, queue: FrameQueue) -> None:
        self._queue, self._dropped = None, queue.dropped
        queue.close()


def _of_camera(camera: Camera, problem: object) -> BaseException:
    """Return an error with the name of the camera that raised it."""
    if isinstance(problem, FeatureError):
        return type(problem)(f"{camera.info.title}: {problem}", problem.feature)
    assert isinstance(problem, BaseException)
    return problem


def _value_before(camera: Camera, name: str) -> FeatureValue | None:
    feature = camera.feature(name)
    return feature.spelled(feature.value)
