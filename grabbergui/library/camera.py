"""A camera for programs: settings as attributes, frames as iterators, closed by `with`."""

from __future__ import annotations

import asyncio
import contextlib
import os
import time
import weakref
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Literal, NoReturn, overload

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.component import Component, ComponentKind
from grabbergui.core.environment import expanded, write_whole
from grabbergui.core.errors import (
    ClosedError,
    DeviceLostError,
    FrameTimeoutError,
    GrabberError,
    LocalFileError,
    MissingFileError,
    PixelFormatError,
    StreamEndedError,
    UsageError,
)
from grabbergui.core.feature_instances import instances_of
from grabbergui.core.features import FeatureValue
from grabbergui.core.frame import Frame
from grabbergui.core.frame_period import frame_period, frame_wait
from grabbergui.core.frame_queue import FrameQueue, StreamStatistics
from grabbergui.core.grabber import DeviceEvent, FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.point_cloud import PointCloud, required_range_image
from grabbergui.core.scan3d import read_scan3d
from grabbergui.core.settings import SettingKey
from grabbergui.library.arguments import checked_timeout
from grabbergui.library.callbacks import Callback, Callbacks, Occasion
from grabbergui.library.collected import await_ends
from grabbergui.library.effect import LATENCY, ChunkData, SettingEffect, restored
from grabbergui.library.features import CameraFiles, FeatureAccess, SettingValue
from grabbergui.library.stand_in import StandIn
from grabbergui.library.streaming import DEPTH, AsyncFrames, Closing, Frames, Recording, StreamUse
from grabbergui.models.settings import files as settings_files
from grabbergui.models.settings.feature_set import capture
from grabbergui.models.settings.loading import LoadReport, load_onto
from grabbergui.recording.kinds import kind_of
from grabbergui.recording.recorder import RecordingLimits

RETRIGGER = 0.5
"Seconds without a frame, besides a frame period, until the software trigger is fired again."
LOOK = 0.1
"Seconds between two looks, while no frame comes, at whether the camera is lost."

CameraState = Literal["open", "streaming", "lost", "closed"]

_OF_DISTANCES = (ComponentKind.RANGE, ComponentKind.DISPARITY)
"Kinds of components that are in the camera's Scan3d coordinates in whatever format."

_WATCHED: set[Camera] = set()
"Open cameras with callbacks, which keep them open though nobody else may refer to them."
_MADE: weakref.WeakSet[Camera] = weakref.WeakSet()
_COMES_BACK = "it is opened again, and set as before, as soon as it answers"


class Camera(FeatureAccess):
    """An open source of frames and features, local or remote.

    Features are attributes in Python's spelling (`camera.exposure_time`, `camera.device_serial_number`) or
    items by name (`camera["ExposureTime"]`, `camera["Gain[GainSelector=Red]"]`). Values are `int`, `float`,
    `bool` and `str`; a text may carry a unit (`"20ms"`).

    Any thread may call; calls that reach the camera wait for each other. Errors are `GrabberError`s. A camera
    that is lost is opened again when it is back and set as before; meanwhile calls raise `DeviceLostError`,
    or another `TransportError`. After `close` they raise `ClosedError`.

    A camera that is not closed is closed when nobody refers to it any more, and at the program's end.
    """

    def __init__(self, grabber: FrameGrabber) -> None:
        """Wrap an open grabber; `grabbergui.open` is the way to get a camera."""
        if not isinstance(grabber, FrameGrabber):
            raise UsageError(f"a camera is opened by grabbergui.open({grabber!r})")
        super().__init__(grabber)
        self._busy_until = 0.0
        "Moment of the monotonic clock until which triggers are lost."
        self._stream = StreamUse(grabber)
        self._chunk_data = chunk_data = ChunkData(grabber)
        self._callbacks = callbacks = Callbacks(grabber)

        def close() -> None:
            callbacks.close()
            chunk_data.undo()
            grabber.close()

        self._closing = Closing(self, close)
        _MADE.add(self)

    @property
    def info(self) -> DeviceInfo:
        """Vendor, model, serial number, address and URI."""
        return self._grabber.info

    def close(self) -> None:
        """Stop, and release the camera. May be called twice; never raises.

        Chunk data that `grab` switched on are switched off again.
        """
        self._closing.now()
        _WATCHED.discard(self)
        if not isinstance(self._grabber, StandIn):
            problem = "was closed by this program; open it again with grabbergui.open"
            self._grabber = StandIn.of(self._grabber, ClosedError, problem)

    def __enter__(self) -> Camera:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    async def __aenter__(self) -> Camera:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await asyncio.to_thread(self.close)

    def __reduce__(self) -> NoReturn:
        raise TypeError(f"a camera cannot be sent to another process; open it there: '{self.info.uri}'")

    def __iter__(self) -> NoReturn:
        raise TypeError("a camera is not a sequence of frames; write: for frame in camera.frames()")

    def __repr__(self) -> str:
        state: str = self.state
        if state == "streaming":
            state += f" at {self.statistics.frame_rate:.1f} frames/s"
        elif state == "lost":
            state += f": {self._grabber.lost}"
        return f"<grabbergui.Camera '{self.info.uri}' {self.info.title}, {state}>"

    @property
    def state(self) -> CameraState:
        """`"open"`, `"streaming"`, `"lost"` until the camera is back, or `"closed"`. Never waits long."""
        if isinstance(self._grabber, StandIn):
            return "closed"
        if self._grabber.lost:
            return "lost"
        return "streaming" if self.streaming else "open"

    @property
    def streaming(self) -> bool:
        """Whether the camera sends frames."""
        await_ends()  # of loops that have just ended
        return self._grabber.streaming

    @property
    def statistics(self) -> StreamStatistics:
        """Counters of the stream: frames, losses, resent packets, rates."""
        return self._grabber.statistics()

    def start(self) -> None:
        """Start streaming; `grab` and `frames` do so by themselves. Does nothing where it runs already.

        The camera then runs free, unless this program has set its trigger. The stream runs until `stop`.
        """
        self._stream.keep()
        self._start()

    def _start(self) -> None:
        self._grabber.start(keep_trigger=self._keep_trigger)

    def streamed(self) -> contextlib.AbstractContextManager[None]:
        """Have the stream on during the block, as a loop over `frames` has."""
        return self._use_stream()

    def why_no_frame(self) -> str:
        """Return why no frame comes, as the end of a sentence; empty if unknown."""
        return self._why_no_frame()

    def _use_stream(self) -> contextlib.AbstractContextManager[None]:
        return self._stream.loop(self._start)

    def stop(self) -> None:
        """Stop streaming."""
        self._grabber.stop()

    def grab(self, timeout: float | None = None, **settings: SettingValue) -> Frame:
        """Return the next frame that is exposed from now on; with settings, one that was exposed with them.

        `camera.grab(ExposureTime=5000, Gain=3)` writes the settings, then returns the first frame that was
        really exposed so: by chunk data where the camera has them (they are switched on at the first such
        call), else by skipping four frames after the acknowledge. The stream stays on; `stop` ends it.

        `timeout` is in seconds, by default 5 and the periods of the frames waited for. Raises
        FrameTimeoutError, what `write` raises, and DeviceLostError.
        """
        timeout = checked_timeout("grab", timeout)
        wanted = {self._existing_key_of(name): value for name, value in settings.items()}
        frames = self._grabber.open_queue(depth=4)
        with contextlib.closing(frames), self._stream.grab():
            if wanted:
                self._chunk_data.switch_on()
            self._start()
            written = time.monotonic()
            features = [self._write(key, value) for key, value in wanted.items()]
            values = {feature.name: feature.value for feature in features if feature.value is not None}
            acknowledged = time.monotonic()
            effect = SettingEffect(values, written, acknowledged)
            deadline = acknowledged + (self._effect_wait() if timeout is None else timeout)
            while True:
                frame = self._get(frames, max(0.0, deadline - time.monotonic()))
                if effect.accepts(frame):
                    return frame
                if time.monotonic() > deadline:
                    raise FrameTimeoutError(f"{self.info.title}: no frame was exposed after the write")

    def _effect_wait(self) -> float:
        """Return the seconds in which a frame with the latest settings must have come."""
        return frame_wait(self._grabber) + LATENCY * frame_period(self._grabber)

    def bracket(self, timeout: float | None = None, **settings: Sequence[SettingValue]) -> list[Frame]:
        """Return a frame for each value: `camera.bracket(ExposureTime=[1000, 4000, 16000])`.

        Several settings are stepped together and need lists of one length. Afterwards the settings
        and automatic modes are restored.
        """
        lengths = {None if isinstance(each, str | int | float) else len(each) for each in settings.values()}
        if len(lengths) != 1 or None in lengths:
            raise UsageError("bracket: write lists of one length, as in bracket(ExposureTime=[1000, 4000])")
        keys = [self._existing_key_of(name) for name in settings]
        steps = [dict(zip(settings, step, strict=True)) for step in zip(*settings.values(), strict=True)]
        with contextlib.ExitStack() as stack:
            for key in keys:
                self.read(str(key))  # a value that cannot be read cannot be restored
                shown = key if key.selected else self._grabber.setting(key.name)
                stack.enter_context(restored(self._grabber, shown))
            return [self.grab(timeout, **step) for step in steps]

    def frames(self, count: int | None = None, *, timeout: float | None = None, depth: int = DEPTH) -> Frames:
        """Iterate over the next `count` frames, or without end: `for frame in camera.frames(100)`.

        Up to `depth` frames wait for a slow loop; what it was too slow for is counted by `dropped`.
        """
        timeout = checked_timeout("frames", timeout)
        return Frames(
            self._grabber,
            self._use_stream,
            self._get,
            count,
            frame_wait(self._grabber) if timeout is None else timeout,
            depth,
        )

    def trigger(self, timeout: float | None = None) -> Frame:
        """Fire the software trigger and return the frame that it made.

        The first call sets TriggerMode, TriggerSource and TriggerSelector for it. A camera loses triggers
        that come while it is busy with the frame before: the call waits for that, and fires again if no
        frame comes. Raises FrameTimeoutError.
        """
        timeout = checked_timeout("trigger", timeout)
        self._set_software_trigger()
        frames = self._grabber.open_queue(depth=4)
        with contextlib.closing(frames), self._stream.grab():
            self._start()
            fired = time.monotonic()
            deadline = fired + (frame_wait(self._grabber) if timeout is None else timeout)
            period = frame_period(self._grabber)
            while True:
                time.sleep(max(0.0, self._busy_until - time.monotonic()))
                self.execute("TriggerSoftware")
                self._busy_until = time.monotonic() + period
                again = min(self._busy_until + RETRIGGER, deadline)
                with contextlib.suppress(FrameTimeoutError):
                    while True:
                        frame = self._get(frames, max(0.0, again - time.monotonic()))
                        if frame.complete and frame.captured >= fired:
                            return frame
                if time.monotonic() >= deadline:
                    problem = f"{self.info.title}: the software trigger made no frame{self._other_trigger()}"
                    raise FrameTimeoutError(problem)

    def _get(self, frames: FrameQueue, timeout: float) -> Frame:
        """Return the next frame. Raises as soon as the camera is known to be lost or closed."""
        deadline = time.monotonic() + timeout
        while True:
            left = max(0.0, deadline - time.monotonic())
            try:
                return frames.get(min(left, LOOK))
            except StreamEndedError as error:
                raise StreamEndedError(f"{self.info.title} has ended") from error
            except FrameTimeoutError as error:
                if frames.closed:
                    raise ClosedError(f"{self.info.title} was closed while frames were awaited") from error
                if loss := self._grabber.lost:
                    raise DeviceLostError(f"{self.info.title} is lost: {loss}; {_COMES_BACK}") from error
                if left <= LOOK:
                    problem = f"no frame arrived within {timeout:.3g} s{self._why_no_frame()}"
                    raise FrameTimeoutError(f"{self.info.title}: {problem}") from error

    def _why_no_frame(self) -> str:
        with contextlib.suppress(GrabberError):
            for key in self._triggers_on():
                return f"; it waits for a trigger: use camera.trigger(), or set {key} to Off"
        reason = self._grabber.silence()
        return f"; {reason}" if reason else ""

    def _other_trigger(self) -> str:
        """Name a trigger that the camera waits for besides the one that `trigger` fires."""
        with contextlib.suppress(GrabberError):
            fired = self._grabber.setting("TriggerMode")
            for key in self._triggers_on():
                if key != fired:
                    return f"; the camera waits for another trigger, too: set {key} to Off"
        return ""

    def _triggers_on(self) -> Iterator[SettingKey]:
        """Yield TriggerMode of each trigger that is on."""
        for key in instances_of(self._grabber, "TriggerMode"):
            if self._grabber.read_setting(key).value == "On":
                yield key

    def _set_software_trigger(self) -> None:
        names = {"TriggerSelector": "FrameStart", "TriggerSource": "Software", "TriggerMode": "On"}
        for name, value in names.items():
            if self._grabber.has_feature(name) and self._grabber.feature(name).value != value:
                self.write(name, value)
                # A frame that ran free may still be exposed.
                self._busy_until = time.monotonic() + frame_period(self._grabber)

    async def agrab(self, timeout: float | None = None, **settings: SettingValue) -> Frame:
        """As `grab`, for asyncio."""
        return await asyncio.to_thread(self.grab, timeout, **settings)

    async def aread(self, name: str) -> FeatureValue:
        """As `read`, for asyncio."""
        return await asyncio.to_thread(self.read, name)

    async def awrite(self, name: str, value: SettingValue) -> FeatureValue:
        """As `write`, for asyncio."""
        return await asyncio.to_thread(self.write, name, value)

    async def atrigger(self, timeout: float | None = None) -> Frame:
        """As `trigger`, for asyncio."""
        return await asyncio.to_thread(self.trigger, timeout)

    def aframes(
        self, count: int | None = None, *, timeout: float | None = None, depth: int = DEPTH
    ) -> AsyncFrames:
        """As `frames`, for asyncio: `async for frame in camera.aframes(100)`."""
        return AsyncFrames(self.frames(count, timeout=timeout, depth=depth))

    @overload
    def on(
        self, occasion: Literal["change"], callback: Callable[[frozenset[str]], object]
    ) -> Callable[[], None]: ...
    @overload
    def on(
        self, occasion: Literal["event"], callback: Callable[[DeviceEvent], object]
    ) -> Callable[[], None]: ...
    @overload
    def on(
        self, occasion: Literal["lost", "back", "notice"], callback: Callable[[str], object]
    ) -> Callable[[], None]: ...
    def on(self, occasion: Occasion, callback: Callback) -> Callable[[], None]:
        """Call a function whenever something happens; the returned function ends that.

        - `"change"`: a `frozenset[str]` of features whose value, range or access may have changed
        - `"event"`: a `DeviceEvent` that the camera sent; switch it on with EventNotification
        - `"lost"` and `"back"`: a sentence; a lost camera is opened again and set as before by itself
        - `"notice"`: a sentence about a problem of the stream

        Callbacks run one after the other on a thread of the library and may use the camera.
        """
        end = self._callbacks.add(occasion, callback)
        _WATCHED.add(self)
        return end

    @property
    def files(self) -> CameraFiles:
        """The files in the camera: `camera.files.list()`, `read`, `write`, `delete`."""
        return CameraFiles(self)

    def record(
        self,
        path: str | Path,
        *,
        frames: int | None = None,
        seconds: float | None = None,
        megabytes: float | None = None,
        codec: str | None = None,
        lossless: bool = False,
        tiff: bool = False,
    ) -> Recording:
        """Record the stream: a movie (`.mp4`), ROS 2 messages (`.mcap`), or a folder of images (no ending).

        `camera.record("run.mcap", seconds=5).wait()`, or `with camera.record("run.mcap"): …`. It ends by
        itself at the first of its limits: `frames`, `seconds` or `megabytes`. A movie's `codec` is `h264`
        (default), which can be `lossless`, or `ffv1`, which always is. A folder has PNG, or with `tiff`
        TIFF. Nothing is overwritten. Raises GrabberError.
        """
        size = None if megabytes is None else megabytes * 1e6
        file = expanded(path)
        kind = kind_of(file, codec=codec, lossless=lossless, tiff=tiff)
        limits = RecordingLimits(frames, seconds, size)
        return Recording.begin(self._grabber, file, kind, limits, self._use_stream)

    def points(self, frame: Frame) -> PointCloud:
        """Compute the points of a frame's range image by the camera's Scan3d features.

        `camera.points(frame).points` is (n, 3) float32 in millimetres, `colours` the intensity there. Raises
        PixelFormatError if the frame has no range image, or the camera does not report enough.
        """
        return PointCloud.of(frame, read_scan3d(self._grabber))

    def save_points(self, frame: Frame, path: str | Path) -> None:
        """Write the points of a frame's range image to a PLY file, binary and little-endian, in millimetres.

        Raises as `points` does, and LocalFileError or MissingFileError if the file cannot be written.
        """
        file, content = expanded(path), self.points(frame).ply()
        try:
            write_whole(file, content)
        except FileNotFoundError as error:
            raise MissingFileError(f"there is no folder {file.absolute().parent} for {file.name}") from error
        except OSError as error:
            raise LocalFileError.of(file, "written", error) from error

    def distances(self, image: Frame | Component) -> NDArray[np.float32]:
        """Return a range image, or that of a frame, in millimetres: (height, width) float32.

        NaN is where nothing was measured. Raises PixelFormatError for any other image.
        """
        if isinstance(image, Frame):
            image = required_range_image(image)
        elif not (image.pixel_format.is_coordinate or image.kind in _OF_DISTANCES):
            raise PixelFormatError(f"{image.kind.name} of {image.pixel_format} is no range image")
        return read_scan3d(self._grabber).distances(image.raw(), image.pixel_format)

    def save_settings(self, path: str | Path) -> None:
        """Write every setting to a file: GenICam's feature stream, or YAML for `.yaml`."""
        settings_files.save(capture(self._grabber), expanded(path))

    def load_settings(self, path: str | Path, *, dry_run: bool = False) -> LoadReport:
        """Set the camera as a file says and report what became of each setting; see `LoadReport.lines`.

        With `dry_run` nothing is written. Settings that the camera refuses are reported, the others written.
        If the camera is lost meanwhile, the report is `interrupted` and says what was written until then.
        """
        features = settings_files.load(expanded(path), self._grabber.selectors.of)
        report = load_onto(self._grabber, features, dry_run=dry_run)
        self._keep_trigger |= not dry_run and any(key.name == "TriggerMode" for key in features.settings)
        return report


def _leave_to_parent() -> None:
    """Forget the cameras in a forked process, which shares their sockets, but has no thread."""
    problem = (
        "is open in the process that this one was forked from;"
        " use it there, or close it there and open it here"
    )
    for camera in _MADE:
        if not isinstance(camera._grabber, StandIn):
            camera._grabber = StandIn.of(camera._grabber, GrabberError, problem)


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_leave_to_parent)
