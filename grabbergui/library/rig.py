"""Several cameras as one instrument: `for images in grabbergui.open_rig([…]).sets(): …`."""

from __future__ import annotations

import contextlib
import difflib
import itertools
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Any, NoReturn

from grabbergui.core.environment import expanded
from grabbergui.core.errors import ClosedError, MissingFrameError, UsageError
from grabbergui.core.features import FeatureValue
from grabbergui.core.frame import Frame
from grabbergui.core.frame_period import frame_wait
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.uri import SourceUri
from grabbergui.library.arguments import checked_count, checked_depth, checked_timeout
from grabbergui.library.camera import Camera
from grabbergui.library.sets import next_set
from grabbergui.library.streaming import (
    DEPTH,
    Closing,
    FrameLoop,
    Recording,
    StreamUse,
    await_collected,
    begun,
)
from grabbergui.recording.recorder import RecordingLimits
from grabbergui.rig import rig_file, source
from grabbergui.rig.camera_clock import ClockState
from grabbergui.rig.frame_sets import FrameSet
from grabbergui.rig.grabber import RigGrabber
from grabbergui.rig.rig_file import RigEntry, TriggerEntry
from grabbergui.rig.set_statistics import SetCounts

Sources = str | Path | Mapping[str, str] | Iterable[str | DeviceInfo]


def open_rig(
    sources: Sources,
    *,
    access: str = "control",
    trigger: str = "free",
    rate: float = 0.0,
    clock: str = "auto",
    match: str = "auto",
    tolerance: float = 0.0,
    missing: str = "deliver",
    **settings: FeatureValue,
) -> Rig:
    """Open several cameras as one instrument, whose frames come in sets of one moment.

    `sources` is the file of a rig (`"stereo.yaml"`), a mapping of names to sources, or a list of sources,
    which are then named as in their URI (`gige:left`) or `camera1`, `camera2`. The other arguments are as in
    a rig's file and do not go with one: `trigger` is `free`, `software`, `action` or `line`, sent `rate`
    times a second, or by `Rig.trigger`; `clock` is `auto`, `ptp`, `fitted` or `host`; `match` is `auto`,
    `time`, `counter` or `action`; `tolerance` is in seconds; `missing` is `deliver`, `drop` or `stop`.
    `settings` are written to all cameras. What was set comes back when the rig is closed.

    Raises UsageError, SourceNotFoundError, AccessDeniedError, TransportError.
    """
    await_collected()  # it may be one of the same cameras
    if isinstance(sources, str | Path):
        given = (trigger, rate, clock, match, tolerance, missing) != (
            "free",
            0.0,
            "auto",
            "auto",
            0.0,
            "deliver",
        )
        if given or settings:
            raise UsageError(
                f"open_rig('{sources}'): the file says how its cameras are triggered, matched and set; change"
                " it there, or pass the cameras instead of a file"
            )
        name = str(sources).removeprefix("rig:")
        grabber: FrameGrabber = source.create(SourceUri("rig", str(expanded(name))))
    else:
        more: dict[str, Any] = {"clock": clock, "match": match, "tolerance": tolerance, "missing": missing}
        grabber = source.of_entry(
            checked_entry(named_sources(sources), settings, TriggerEntry(trigger, rate), more)
        )
    try:
        grabber.open(Access(access))
        return Rig(grabber)
    except BaseException:
        grabber.close()
        raise


def checked_entry(
    cameras: Mapping[str, str],
    settings: Mapping[str, FeatureValue],
    trigger: TriggerEntry,
    more: Mapping[str, Any],
) -> RigEntry:
    """Return what a rig's file with this content says. Raises UsageError as for a file."""
    entries = {name: rig_file.CameraEntry(uri, dict(settings)) for name, uri in cameras.items()}
    return rig_file.parse(rig_file.to_text(RigEntry(entries, trigger=trigger, **more)), "open_rig")


def named_sources(sources: Mapping[str, str] | Iterable[str | DeviceInfo]) -> dict[str, str]:
    """Return sources by name: that in the URI if all of them can be names, else `camera1` and so on."""
    if isinstance(sources, Mapping):
        return {name: str(uri) for name, uri in sources.items()}
    uris = [each.uri if isinstance(each, DeviceInfo) else str(each) for each in sources]
    names = [SourceUri.parse(uri).name for uri in uris]
    if len(set(names)) < len(uris) or not all(name.isidentifier() and name.isascii() for name in names):
        names = [f"camera{number}" for number in range(1, len(uris) + 1)]
    return dict(zip(names, uris, strict=True))


class Rig:
    """Open cameras whose frames come in sets. Its cameras are items: `rig["left"].exposure_time = 5000`."""

    def __init__(self, grabber: FrameGrabber) -> None:
        """Wrap an open rig or recording of one; `grabbergui.open_rig` is the usual way."""
        self._grabber = grabber
        members = grabber.cameras if isinstance(grabber, RigGrabber) else {}
        self._cameras = {name: Camera(each) for name, each in members.items()}
        self._stream = StreamUse(grabber)
        self._closed = False
        self._closing = Closing(self, grabber.close)

    @property
    def cameras(self) -> dict[str, Camera]:
        """The cameras by name; empty for a recording."""
        return dict(self._cameras)

    def __getitem__(self, name: str) -> Camera:
        if name not in self._cameras:
            raise UsageError(f"there is no camera {name}; there are {', '.join(self._cameras) or 'none'}")
        return self._cameras[name]

    def __getattr__(self, name: str) -> NoReturn:
        raise AttributeError(self._no_attribute(name))

    def __setattr__(self, name: str, value: Any) -> None:
        if not name.startswith("_"):
            raise AttributeError(self._no_attribute(name))
        object.__setattr__(self, name, value)

    def _no_attribute(self, name: str) -> str:
        """Return why an attribute cannot be read or set, with the nearest one or that of a camera."""
        cameras = self.__dict__.get("_cameras", {})
        if name.startswith("_") or not cameras:
            return f"a rig has no attribute {name}"
        if hasattr(type(self), name):
            return f"{name} of a rig cannot be set"
        first, camera = next(iter(cameras.items()))
        known = {attribute: f"rig['{first}'].{attribute}" for attribute in dir(camera)}
        known |= {attribute: f"rig.{attribute}" for attribute in dir(type(self))}
        near = [name] if name in known else difflib.get_close_matches(name, list(known), n=1)
        hint = f"did you mean {known[near[0]]}?" if near else f"its cameras are rig['{first}'] and so on"
        return f"a rig has no attribute {name}; {hint}"

    def __iter__(self) -> Iterator[str]:
        return iter(self._cameras)

    def __len__(self) -> int:
        return len(self._cameras)

    def __repr__(self) -> str:
        return f"<grabbergui.Rig of {', '.join(self._cameras) or self._grabber.info.title}>"

    def sets(
        self, count: int | None = None, *, timeout: float | None = None, depth: int = DEPTH
    ) -> Iterator[FrameSet[Frame]]:
        """Iterate over sets: a dict of frames by camera, with `skew_ns`, `missing`, `time_ns`, `state`.

        Up to `depth` sets wait for a slow loop. The stream runs while the loop does. Raises FrameTimeoutError
        after `timeout` seconds without a set, DeviceLostError if all cameras are lost, and
        MissingFrameError for a missing frame if the rig's file says `missing: stop`.
        """
        self._check_open()
        count, timeout = checked_count("sets", count), checked_timeout("sets", timeout)
        depth = checked_depth("sets", depth)
        stack = contextlib.ExitStack()
        try:
            queue = stack.enter_context(contextlib.closing(self._grabber.open_queue(depth)))
            stack.enter_context(self._stream.loop(self._start))
        except BaseException:
            stack.close()
            raise
        times = () if count is None else (count,)
        return FrameLoop(map(partial(self._next, queue), itertools.repeat(timeout, *times)), stack)

    def trigger(self, timeout: float | None = None) -> FrameSet[Frame]:
        """Trigger all cameras once and return the set that it made; the stream stays on.

        The rig's trigger must be `software` or `action`. Raises UsageError, FrameTimeoutError, ClosedError.
        """
        timeout = checked_timeout("trigger", timeout)
        rig = self._rig("trigger")
        self.start()
        queue = self._grabber.open_queue(4)
        with contextlib.closing(queue):
            rig.send_trigger()
            return self._next(queue, timeout)

    def _next(self, queue: FrameQueue, timeout: float | None) -> FrameSet[Frame]:
        if timeout is None:
            timeout = max((frame_wait(camera.grabber) for camera in self._cameras.values()), default=5.0)
        images = next_set(queue, timeout, self._cameras, needs_all=self._missing != "deliver").images
        if images.missing and self._missing == "stop":
            raise MissingFrameError(f"set {images.index} has no frame of {', '.join(images.missing)}")
        return images

    @property
    def _missing(self) -> str:
        """The treatment of sets without a camera's frame, as in a rig's file."""
        return self._grabber.entry.missing if isinstance(self._grabber, RigGrabber) else "deliver"

    def start(self) -> None:
        """Start all cameras and the trigger; `sets` does so by itself. The stream runs until `stop`."""
        self._check_open()
        self._stream.keep()
        self._start()

    def _start(self) -> None:
        self._grabber.start()

    def stop(self) -> None:
        """Stop the trigger and all cameras."""
        self._grabber.stop()

    @property
    def statistics(self) -> SetCounts:
        """Complete, late and incomplete sets since the start, and the skew within them."""
        return self._rig("statistics").counts()

    @property
    def clocks(self) -> dict[str, ClockState]:
        """Facts about each camera's clock: PTP, uncertainty, drift."""
        return self._rig("clocks").clock_states()

    def lead(self, camera: str) -> None:
        """Let the other cameras follow this one from now on. Raises UsageError."""
        self._check_open()
        self._rig("lead").lead(camera)

    def record(
        self,
        path: str | Path,
        *,
        sets: int | None = None,
        seconds: float | None = None,
        megabytes: float | None = None,
    ) -> Recording:
        """Record all cameras into one MCAP file, with a topic for each; `open_rig` plays it.

        It ends by itself at the first of its limits. Raises GrabberError.
        """
        from grabbergui.rig.recording import begin

        self._check_open()
        size = None if megabytes is None else megabytes * 1e6
        file = expanded(path)
        recorder = begin(self._grabber, file, RecordingLimits(sets, seconds, size))
        return begun(recorder, lambda: self._stream.loop(self._start))

    def close(self) -> None:
        """Stop, put the cameras' settings back, and close them. May be called twice; never raises."""
        self._closed = True
        self._closing.now()
        for camera in self._cameras.values():
            camera.close()

    def _check_open(self) -> None:
        if self._closed:
            raise ClosedError(
                f"{self._grabber.info.title} was closed by this program; open it again with"
                " grabbergui.open_rig"
            )

    def __enter__(self) -> Rig:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _rig(self, what: str) -> RigGrabber:
        if not isinstance(self._grabber, RigGrabber):
            raise UsageError(f"{what}: a recording has no cameras")
        return self._grabber
