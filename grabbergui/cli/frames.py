"""Commands that take what a camera sends: frames (`grab`, `record`) and its event messages (`events`)."""

from __future__ import annotations

import argparse
import functools
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from queue import Empty, Queue
from typing import Any

from grabbergui.cli import PartialResultError
from grabbergui.cli.arguments import (
    Outage,
    add_lost_timeout,
    add_monitor,
    add_source,
    count,
    counted,
    opened,
    positive,
    wait_time,
)
from grabbergui.cli.features import assignment, write
from grabbergui.cli.process import stop_on_signals
from grabbergui.core.coord3d import Scan3d
from grabbergui.core.environment import check_folder_of
from grabbergui.core.errors import (
    FeatureError,
    FeatureValueError,
    FrameTimeoutError,
    GrabberError,
    UsageError,
)
from grabbergui.core.frame import Frame
from grabbergui.core.frame_period import FRAME_WAIT, frame_wait
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.core.grabber import Access, DeviceEvent, FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.json_text import to_json
from grabbergui.core.scan3d import read_scan3d
from grabbergui.core.settings import SettingKey
from grabbergui.core.uri import SourceUri
from grabbergui.core.visible_text import print_json, print_line
from grabbergui.recording import snapshot
from grabbergui.recording.kinds import CODECS, RecordingKind, kind_of
from grabbergui.recording.recorder import RecordingLimits, create_recorder, create_writer
from grabbergui.recording.writer import RecordingWriter

_LOOK = 0.5
"Seconds between checks whether the source is still there."
_POLL = 0.1
"Seconds between checks whether the user or the recording has ended."
_QUEUE_DEPTH = 16


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    _add_grab(commands)
    _add_record(commands)
    _add_events(commands)


def _add_options(parser: argparse.ArgumentParser, *, awaited: str) -> None:
    """Add SOURCE and the options for taking frames; `awaited` is what `--timeout` waits for."""
    add_source(parser)
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        dest="assignments",
        help="write a feature before; repeatable",
    )
    parser.add_argument(
        "--timeout",
        type=wait_time,
        metavar="S",
        help=f"longest wait for {awaited} ({FRAME_WAIT:g}, and two frame periods)",
    )
    add_lost_timeout(parser)
    parser.add_argument("--keep-trigger", action="store_true", help="leave TriggerMode as it is")
    add_monitor(parser)


class _AwaitedSource:
    """An open grabber that may be lost, and waits for its return."""

    def __init__(
        self, grabber: FrameGrabber, timeout: float | None = None, lost_timeout: float | None = None
    ) -> None:
        """Without a `timeout` in seconds, a frame is waited for as long as the camera's settings suggest."""
        self.grabber = grabber
        self.outage = Outage(grabber, lost_timeout)
        self._timeout = timeout

    def next_frame(self, queue: FrameQueue, so_far: int) -> Frame:
        """Wait for a frame until the timeout, not counting seconds in which the source is lost.

        Raises FrameTimeoutError, or TransportError if the source was lost for too long.
        """
        begun, timeout = time.monotonic(), self.timeout
        while True:
            try:
                return queue.get(min(timeout, _LOOK))
            except FrameTimeoutError:
                self.outage.check()
                if queue.closed or self.outage.waited(begun) >= timeout:
                    raise self.no_frame(so_far) from None

    @functools.cached_property
    def timeout(self) -> float:
        """Seconds to wait for a frame, by the settings at the first use."""
        return frame_wait(self.grabber) if self._timeout is None else self._timeout

    def no_frame(self, so_far: int = 0) -> FrameTimeoutError:
        """Return the error for a missing frame, with its cause or what to check."""
        title, came = self.grabber.info.title, counted(so_far, "frame")
        scheme = SourceUri.parse(self.grabber.info.uri).scheme
        if scheme == "file":
            return FrameTimeoutError(f"{title} ended after {came}")
        late = f"{title}: no frame within {round(self.timeout, 2):g} s after {came}"
        if scheme in ("yarp", "ros2"):
            look = "whether its program sends images, and whether a camera there waits for a trigger"
            return FrameTimeoutError(f"{late}: {self.grabber.silence()}; see {look}")
        counters = self.grabber.statistics()
        if reason := self.grabber.silence():
            return FrameTimeoutError(f"{late}: {reason}")
        if counters.incomplete and scheme == "gige":
            look = (
                "whether smaller packets arrive (?packet_size=1400 behind the source), or longer pauses help"
            )
            look += " (?packet_delay=20us)"
        elif self.grabber.access is Access.MONITOR:
            look = "whether the application that controls it streams"
        else:
            look = "whether it waits for a trigger, and whether a firewall drops its packets"
        return FrameTimeoutError(
            f"{late} ({counters.packets} packets, {counters.incomplete} incomplete frames); see {look}"
        )


@contextmanager
def _awaited_source(options: argparse.Namespace) -> Iterator[_AwaitedSource]:
    """Yield the source of `_add_options`, set and not started; close it after the block."""
    assignments = [assignment(text) for text in options.assignments]
    with opened(options.source, monitor=options.monitor) as grabber:
        source = _AwaitedSource(grabber, options.timeout, options.lost_timeout)
        for key, text in assignments:
            write(grabber, key, text)
        try:
            yield source
        finally:
            source.outage.close()


# -- grab ----------------------------------------------------------------------------------------
def _add_grab(commands: Any) -> None:
    parser = commands.add_parser(
        "grab",
        help="grab frames, count them and save them",
        example="grabbergui grab gige: -n 100 --out frames",
    )
    _add_options(parser, awaited="a frame")
    parser.add_argument(
        "-n", "--frames", type=count, default=1, metavar="FRAMES", help="number of frames (1)"
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="PATH",
        help="save every frame in this folder, or all in stack.tiff or array.npy",
    )
    parser.add_argument(
        "--ply", action="store_true", help="also save the point clouds of range images, as PLY"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=_grab)


def _grab(options: argparse.Namespace) -> int:
    with _awaited_source(options) as source:
        queue = source.grabber.open_queue(_QUEUE_DEPTH)
        source.grabber.start(keep_trigger=options.keep_trigger)
        summary = _collect(source, queue, options)
        source.grabber.stop()
    if options.json:
        print_json(summary)
    else:
        print_line(
            f"{counted(options.frames, 'frame')} of "
            "{width}×{height} {pixel_format} in {seconds:.2f} s, {fps:.1f} per second; "
            "{incomplete} incomplete, {lost} lost".format(**summary)
        )
    return 0


def _save(frame: Frame, folder: Path, grabber: FrameGrabber, scan: Scan3d | None) -> None:
    snapshot.save(frame, folder, grabber.info)
    if scan is not None:
        snapshot.save_points(frame, folder, grabber.info, scan)


def _writer_of(options: argparse.Namespace, info: DeviceInfo) -> RecordingWriter | None:
    """Return the writer of one file for all frames; None if `--out` is a folder. Raises UsageError."""
    suffix = options.out.suffix.lower() if options.out is not None else ""
    if not suffix or options.out.is_dir():
        return None
    kind = kind_of(options.out)  # refuses .png and others, of which a folder would be made
    if kind not in (RecordingKind.STACK, RecordingKind.NUMPY):
        if kind.suffix == suffix:
            raise UsageError(f"--out {options.out}: grab saves into a folder, .tiff or .npy; use record")
        return None
    if options.ply:
        raise UsageError("--ply saves into the folder of --out; name one")
    check_folder_of(options.out)
    return create_writer(kind, options.out, info)


def _collect(source: _AwaitedSource, queue: FrameQueue, options: argparse.Namespace) -> dict[str, Any]:
    if options.ply and options.out is None:
        raise UsageError("--ply saves into the folder of --out; name one")
    scan = read_scan3d(source.grabber) if options.ply else None
    writer = _writer_of(options, source.grabber.info)
    first: Frame | None = None
    payload_bytes = 0
    for so_far in range(options.frames):
        frame = source.next_frame(queue, so_far)
        first = first or frame
        payload_bytes += frame.nbytes
        if writer is not None:
            writer.write(frame)
        elif options.out is not None:
            _save(frame, options.out, source.grabber, scan)
    if writer is not None:
        writer.close()
    assert first is not None
    counters = source.grabber.statistics()
    # From the first frame to the last, so that the rate excludes opening the camera.
    seconds = max(0.0, frame.captured - first.captured)
    return {
        "frames": options.frames,
        "incomplete": counters.incomplete,
        "lost": counters.lost + queue.dropped,
        "width": first.width,
        "height": first.height,
        "pixel_format": first.pixel_format.name,
        "fps": (options.frames - 1) / seconds if seconds > 0 else 0.0,
        "seconds": seconds,
        "bytes": payload_bytes,
    }


# -- record --------------------------------------------------------------------------------------
def _add_record(commands: Any) -> None:
    parser = commands.add_parser(
        "record",
        help="record frames; play them back with file:PATH",
        example="grabbergui record gige: --out scene.mcap -t 10",
    )
    _add_options(parser, awaited="the first frame")
    parser.add_argument(
        "--out",
        type=Path,
        required=True,
        metavar="PATH",
        help="the recording: movie.mp4, messages.mcap, stack.tiff, array.npy, or a folder (no ending)",
    )
    parser.add_argument("-n", "--frames", type=count, metavar="FRAMES", help="end after this many frames")
    parser.add_argument("-t", "--seconds", type=wait_time, metavar="S", help="end after this many seconds")
    parser.add_argument("--size", type=positive, metavar="MB", help="end after this many megabytes")
    parser.add_argument("--lossless", action="store_true", help="lossless movie, larger: H.264 or FFV1")
    parser.add_argument(
        "--codec",
        choices=CODECS,
        help="codec of a movie: h264 (default), hevc or av1 (smaller), ffv1 (lossless)",
    )
    parser.add_argument("--tiff", action="store_true", help="in a folder: TIFF, larger and faster than PNG")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=_record)


def _record(options: argparse.Namespace) -> int:
    check_folder_of(options.out)
    kind = kind_of(options.out, codec=options.codec, lossless=options.lossless, tiff=options.tiff)
    size = None if options.size is None else options.size * 1e6
    limits = RecordingLimits(options.frames, options.seconds, size)
    with _awaited_source(options) as source, stop_on_signals() as stop:
        grabber = source.grabber
        recorder = create_recorder(grabber, options.out, kind, limits)
        recorder.start()
        failure: GrabberError | None = None
        try:
            grabber.start(keep_trigger=options.keep_trigger)
            begun = time.monotonic()
            while not recorder.wait(_POLL) and not stop.is_set():
                source.outage.check()
                if not recorder.progress.frames and source.outage.waited(begun) > source.timeout:
                    raise source.no_frame()
        except GrabberError as error:
            failure = error
        finally:
            recorder.stop()
            recorder.wait()
        if failure is None:
            grabber.stop()
    progress = recorder.progress
    reason = str(failure) if failure is not None else progress.reason
    summary = {
        "frames": progress.frames,
        "dropped": progress.dropped,
        "seconds": progress.seconds,
        "bytes": progress.size,
        "path": str(options.out),
    }
    if options.json:
        if not reason:
            print_json(summary)
    elif progress.frames:
        megabytes = progress.size / 1e6
        print_line(
            f"{options.out}: {counted(progress.frames, 'frame')} in {progress.seconds:.2f} s, "
            f"{megabytes:.1f} MB; {progress.dropped} dropped"
        )
        if progress.left_out:
            print_line(f"only the first of {progress.left_out + 1} images in each frame; .mcap keeps all")
    elif not reason:
        print_line("nothing was recorded")
    if reason:
        raise PartialResultError(reason, summary) from failure or progress.error
    return 0


# -- events --------------------------------------------------------------------------------------
_SELECTOR, _SWITCH = "EventSelector", "EventNotification"
_MOST_WAITING = 1000
"Most events that wait for a slow reader; further ones are dropped."


def _add_events(commands: Any) -> None:
    parser = commands.add_parser(
        "events",
        help="print a camera's events as they arrive, or list its events",
        example="grabbergui events gige: ExposureEnd --start",
    )
    add_source(parser)
    parser.add_argument(
        "names",
        metavar="NAME",
        nargs="*",
        help="an event, such as ExposureEnd; without a name, list the events",
    )
    parser.add_argument("-n", "--count", type=count, help="end after this many events")
    parser.add_argument("--duration", type=wait_time, metavar="S", help="end after this many seconds")
    parser.add_argument("--start", action="store_true", help="stream while listening")
    parser.add_argument("--json", action="store_true", help="print one JSON object per line")
    parser.set_defaults(run=_events)


def _events(options: argparse.Namespace) -> int:
    if not options.names and (options.start or options.count or options.duration):
        raise UsageError(f"print which events? `grabbergui events {options.source}` lists them")
    with opened(options.source, reading=not options.names) as grabber:
        known = _known_events(grabber)
        if not options.names:
            for name in known:
                print_line(name)
            return 0
        for name in options.names:
            if name not in known:
                names = ", ".join(known)
                raise FeatureValueError(f"this camera has no event {name}; it has {names}", _SELECTOR)
        waiting: Queue[DeviceEvent] = Queue(_MOST_WAITING)
        grabber.event_received.connect(lambda event: _keep(waiting, event))
        with stop_on_signals() as stop, _switched_on(grabber, options.names):
            if options.start:
                grabber.start()
            deadline = time.monotonic() + options.duration if options.duration else float("inf")
            printed = 0
            while not stop.is_set() and time.monotonic() < deadline:
                try:
                    event = waiting.get(timeout=_POLL)
                except Empty:
                    continue
                print_line(_event_line(event, as_json=options.json), flush=True)
                printed += 1
                if printed == options.count:
                    break
            if options.start:
                grabber.stop()
    return 0


def _known_events(grabber: FrameGrabber) -> list[str]:
    if not grabber.has_feature(_SELECTOR) or not grabber.has_feature(_SWITCH):
        raise FeatureError(f"{grabber.info.title} has no {_SELECTOR}, so it sends no events", _SELECTOR)
    return [entry.name for entry in grabber.feature(_SELECTOR).entries if entry.available]


def _keep(waiting: Queue[DeviceEvent], event: DeviceEvent) -> None:
    if not waiting.full():
        waiting.put_nowait(event)


@contextmanager
def _switched_on(grabber: FrameGrabber, names: list[str]) -> Iterator[None]:
    """Switch the events on for the block; those that were off are switched off again."""
    switches = [SettingKey(_SWITCH, ((_SELECTOR, name),)) for name in names]
    before = [(key, grabber.read_setting(key).value) for key in switches]
    try:
        for key in switches:
            grabber.write_setting(key, "On")
        yield
    finally:
        for key, value in before:
            if value is not None:
                grabber.write_setting(key, value)


def _event_line(event: DeviceEvent, *, as_json: bool) -> str:
    if as_json:
        return to_json({"event": event.name, "id": event.event_id, "values": event.values})
    return str(event)
