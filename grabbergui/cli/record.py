"""`record`: write a camera's frames to files until a limit or a signal ends it."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grabbergui.cli import PartialResultError
from grabbergui.cli.arguments import (
    count,
    counted,
    positive,
    wait_time,
)
from grabbergui.cli.awaited_source import add_options, awaited_source
from grabbergui.cli.process import progress_note, stop_on_signals
from grabbergui.core.environment import check_folder_of, find_file
from grabbergui.core.errors import (
    GrabberError,
    UsageError,
)
from grabbergui.core.visible_text import print_json, print_line
from grabbergui.recording.kinds import CODECS, RecordingKind, kind_of
from grabbergui.recording.recorder import RecordingLimits, RecordingProgress, create_recorder
from grabbergui.recording.thinning import Thinning

if TYPE_CHECKING:
    from grabbergui.core.grabber import FrameGrabber
    from grabbergui.recording.writer import CalibrationOf

_POLL = 0.1
"Seconds between checks whether the user or the recording has ended."


def add_commands(commands: Any) -> None:
    """Add the parser."""
    parser = commands.add_parser(
        "record",
        help="record frames; play them back with file:PATH",
        example="grabbergui record gige: --out scene.mcap -t 10",
    )
    add_options(parser, awaited="the first frame")
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
    parser.add_argument("--every", type=count, default=1, metavar="N", help="only every N-th frame")
    parser.add_argument(
        "--interval", type=positive, default=0.0, metavar="S", help="time-lapse: a frame every S seconds"
    )
    parser.add_argument("--lossless", action="store_true", help="lossless movie, larger: H.264 or FFV1")
    parser.add_argument(
        "--codec",
        choices=CODECS,
        help="codec of a movie: h264 (default), ffv1 (lossless)",
    )
    parser.add_argument("--tiff", action="store_true", help="in a folder: TIFF, larger and faster than PNG")
    parser.add_argument(
        "--bag", action="store_true", help="a folder as of `ros2 bag record`: messages.mcap and metadata.yaml"
    )
    parser.add_argument(
        "--calibration", type=Path, metavar="FILE", help="camera_info YAML, for .mcap and --bag"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=_record)


def _so_far(progress: RecordingProgress) -> str:
    dropped = f", {progress.dropped} dropped" if progress.dropped else ""
    size = f"{progress.size / 1e6:.1f} MB"
    return f"{counted(progress.frames, 'frame')} in {progress.seconds:.1f} s, {size}{dropped}; Ctrl-C ends it"


def _calibration(
    grabber: FrameGrabber, kind: RecordingKind, options: argparse.Namespace
) -> CalibrationOf | None:
    """Return the given calibration for each frame; None for that of the source. Raises UsageError."""
    from grabbergui.calibration.camera_info import load_for
    from grabbergui.calibration.fitting import FittedCalibration

    if options.calibration is None:
        return None
    if kind not in (RecordingKind.MCAP, RecordingKind.BAG):
        raise UsageError(f"--calibration: only .mcap and --bag have a place for it, not {options.out}")
    fitted = FittedCalibration(grabber)
    fitted.calibration = load_for(grabber.info, find_file(options.calibration, "calibration"))
    return fitted.forms


def _record(options: argparse.Namespace) -> int:
    check_folder_of(options.out)
    kind = kind_of(
        options.out, codec=options.codec, lossless=options.lossless, tiff=options.tiff, bag=options.bag
    )
    size = None if options.size is None else options.size * 1e6
    limits = RecordingLimits(options.frames, options.seconds, size)
    thinning = Thinning(options.every, options.interval)
    with awaited_source(options) as source, stop_on_signals() as stop:
        grabber = source.grabber
        calibration = _calibration(grabber, kind, options)
        recorder = create_recorder(grabber, options.out, kind, limits, calibration, thinning)
        recorder.start()
        failure: GrabberError | None = None
        try:
            grabber.start(keep_trigger=options.keep_trigger)
            begun = time.monotonic()
            with progress_note() as show:
                while not recorder.wait(_POLL) and not stop.is_set():
                    show(lambda: _so_far(recorder.progress))
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
