"""`grabbergui record`: a camera's frames into files that can be played back."""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any

from grabbergui.cli import streaming
from grabbergui.cli.numbers import count, counted, positive
from grabbergui.cli.stopping import stop_on_signals
from grabbergui.config.shipped_files import check_folder_of
from grabbergui.core.errors import FeatureError, GrabberError, UsageError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.sfnc import Role
from grabbergui.recording.recorder import Recorder, RecordingLimits
from grabbergui.recording.writer import RecordingKind, create_writer, kind_of

_CODECS = {
    kind.value: kind
    for kind in (RecordingKind.H264, RecordingKind.HEVC, RecordingKind.AV1, RecordingKind.FFV1)
}
_POLL = 0.1
"Seconds between looks at whether it shall end."


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    parser = commands.add_parser("record", help="record frames; play them back with file:PATH")
    streaming.add_options(parser, awaited="the first frame")
    parser.add_argument(
        "--out",
        type=Path,
        required=True,
        metavar="PATH",
        help="movie.mp4, messages.mcap, or a folder of pictures (no ending)",
    )
    parser.add_argument("-n", "--frames", type=count, metavar="FRAMES", help="end after so many")
    parser.add_argument("-t", "--seconds", type=positive, metavar="S", help="end after so many seconds")
    parser.add_argument("--size", type=positive, metavar="MB", help="end once so many megabytes are written")
    parser.add_argument(
        "--lossless", action="store_true", help="a movie without losses, larger: H.264 or FFV1"
    )
    parser.add_argument(
        "--codec", choices=_CODECS, help="of a movie: h264 (usual), hevc, av1 (smaller); ffv1 (lossless)"
    )
    parser.add_argument("--tiff", action="store_true", help="of a folder: TIFF, larger and faster than PNG")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=_record)


def _record(options: argparse.Namespace) -> int:
    check_folder_of(options.out)
    kind = _kind(options)
    with streaming.frame_source(options) as source, stop_on_signals() as stop:
        grabber = source.grabber
        writer = create_writer(kind, options.out, grabber.info, frame_rate(grabber))
        recorder = Recorder(grabber, writer, _limits(options))
        recorder.start()
        try:
            grabber.start(keep_trigger=options.keep_trigger)
            begun = time.monotonic()
            while not recorder.wait(_POLL) and not stop.is_set():
                source.outage.check()
                if not recorder.progress.frames and source.outage.waited(begun) > options.timeout:
                    raise source.no_frame(options.timeout)
        finally:
            recorder.stop()
            recorder.wait()
        grabber.stop()
    progress = recorder.progress
    summary = {"frames": progress.frames, "dropped": progress.dropped, "seconds": progress.seconds}
    if options.json:
        print(json.dumps({**summary, "bytes": progress.size, "path": str(options.out)}))
    elif progress.frames:
        megabytes = progress.size / 1e6
        print(
            f"{options.out}: {counted(progress.frames, 'frame')} in {progress.seconds:.2f} s, "
            f"{megabytes:.1f} MB; {progress.dropped} dropped"
        )
    elif not progress.reason:
        print("nothing was recorded")
    if progress.reason:
        raise GrabberError(progress.reason)
    return 0


def _kind(options: argparse.Namespace) -> RecordingKind:
    movie = _CODECS[options.codec or "h264"]
    if options.lossless and movie is not RecordingKind.FFV1:
        if options.codec not in (None, "h264"):
            raise UsageError(f"--lossless is h264's or ffv1's, not {options.codec}'s")
        movie = RecordingKind.LOSSLESS
    kind = kind_of(options.out, movie=movie)
    if options.tiff and kind is not RecordingKind.PNG:
        raise UsageError(f"--tiff is for a folder of pictures, not for {options.out.name}")
    if (options.lossless or options.codec) and kind is not movie:
        raise UsageError(f"--lossless and --codec are for a movie, not for {options.out.name}")
    return RecordingKind.TIFF if options.tiff else kind


def _limits(options: argparse.Namespace) -> RecordingLimits:
    size = None if options.size is None else round(options.size * 1e6)
    return RecordingLimits(options.frames, options.seconds, size)


def frame_rate(grabber: FrameGrabber) -> float:
    """What the camera says of its frames per second; 0 where it says nothing."""
    name = Role.FRAME_RATE.find(grabber.has_feature)
    try:
        value = grabber.feature(name).value if name is not None else None
    except FeatureError:
        return 0.0
    return float(value) if isinstance(value, int | float) else 0.0
