"""`grabbergui grab`: frames, counted and saved."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from grabbergui.cli import streaming
from grabbergui.cli.numbers import count, counted
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.recording import snapshot

_QUEUE_DEPTH = 16


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    parser = commands.add_parser("grab", help="grab frames; count them, save them")
    streaming.add_options(parser, awaited="a frame")
    parser.add_argument("-n", "--frames", type=count, default=1, metavar="FRAMES", help="how many (1)")
    parser.add_argument("--out", type=Path, metavar="FOLDER", help="save every frame there")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=_grab)


def _grab(options: argparse.Namespace) -> int:
    with streaming.frame_source(options) as source:
        queue = source.grabber.open_queue(_QUEUE_DEPTH)
        source.grabber.start(keep_trigger=options.keep_trigger)
        summary = _collect(source, queue, options)
        source.grabber.stop()
    if options.json:
        print(json.dumps(summary))
    else:
        print(
            counted(options.frames, "frame"),
            "of {width}×{height} {pixel_format} in {seconds:.2f} s, {fps:.1f} per second; "
            "{incomplete} incomplete, {lost} lost".format(**summary),
        )
    return 0


def _collect(source: streaming.FrameSource, queue: FrameQueue, options: argparse.Namespace) -> dict[str, Any]:
    first: Frame | None = None
    payload_bytes = 0
    for so_far in range(options.frames):
        frame = source.next_frame(queue, options.timeout, so_far)
        first = first or frame
        payload_bytes += frame.payload.nbytes
        if options.out is not None:
            snapshot.save(frame, options.out, source.grabber.info)
    assert first is not None
    counters = source.grabber.statistics()
    # From the first frame's own time to the last's: opening the camera is not the camera's rate.
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
