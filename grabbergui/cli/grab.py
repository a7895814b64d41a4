"""`grab`: take frames from a camera, and save or count them."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from grabbergui.cli.arguments import (
    count,
    counted,
)
from grabbergui.cli.awaited_source import AwaitedSource, add_options, awaited_source
from grabbergui.cli.process import progress_note
from grabbergui.core.coord3d import Scan3d
from grabbergui.core.environment import check_folder_of
from grabbergui.core.errors import (
    UsageError,
)
from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.scan3d import read_scan3d
from grabbergui.core.visible_text import print_json, print_line
from grabbergui.recording import snapshot
from grabbergui.recording.kinds import RecordingKind, kind_of
from grabbergui.recording.recorder import create_writer
from grabbergui.recording.writer import RecordingWriter

_QUEUE_DEPTH = 16


def add_commands(commands: Any) -> None:
    """Add the parser."""
    parser = commands.add_parser(
        "grab",
        help="grab frames, count them and save them",
        example="grabbergui grab gige: -n 100 --out frames",
    )
    add_options(parser, awaited="a frame")
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
    with awaited_source(options) as source:
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
            + (f", and all of {away:.1f} s without the source" if (away := summary["away"]) else "")
        )
    return 0


def _save(frame: Frame, folder: Path, grabber: FeatureSource, scan: Scan3d | None) -> None:
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


def _collect(source: AwaitedSource, queue: FrameQueue, options: argparse.Namespace) -> dict[str, Any]:
    if options.ply and options.out is None:
        raise UsageError("--ply saves into the folder of --out; name one")
    scan = read_scan3d(source.grabber) if options.ply else None
    writer = _writer_of(options, source.grabber.info)
    first: Frame | None = None
    payload_bytes = 0
    with progress_note() as show:
        for so_far in range(options.frames):
            show(lambda: f"{so_far} of {counted(options.frames, 'frame')}")  # noqa: B023  # called at once
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
        "away": source.outage.seconds,
    }
