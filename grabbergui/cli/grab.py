"""`grabbergui grab`: frames, counted and saved."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from grabbergui.cli.features import assignment
from grabbergui.cli.numbers import count, counted, positive
from grabbergui.cli.opening import add_source, no_frame, opened
from grabbergui.core.errors import FrameTimeoutError
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.core.grabber import FrameGrabber
from grabbergui.models.recording import snapshot

_QUEUE_DEPTH = 16


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    parser = commands.add_parser("grab", help="grab frames; count them, save them")
    add_source(parser)
    parser.add_argument("-n", "--frames", type=count, default=1, metavar="FRAMES", help="how many (1)")
    parser.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", dest="assignments", help="set it first"
    )
    parser.add_argument("--out", type=Path, metavar="FOLDER", help="save every frame there")
    parser.add_argument(
        "--timeout", type=positive, default=5.0, metavar="S", help="longest wait for a frame (5)"
    )
    parser.add_argument("--keep-trigger", action="store_true", help="leave TriggerMode as it is")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=_grab)


def _grab(options: argparse.Namespace) -> int:
    assignments = [assignment(text) for text in options.assignments]
    with opened(options.source) as grabber:
        for name, value in assignments:
            grabber.write_feature(name, value)
        queue = grabber.open_queue(_QUEUE_DEPTH)
        grabber.start(keep_trigger=options.keep_trigger)
        summary = _collect(grabber, queue, options)
        grabber.stop()
    if options.json:
        print(json.dumps(summary))
    else:
        print(
            counted(options.frames, "frame"),
            "of {width}×{height} {pixel_format} in {seconds:.2f} s, {fps:.1f} per second; "
            "{incomplete} incomplete, {lost} lost".format(**summary),
        )
    return 0


def _collect(grabber: FrameGrabber, queue: FrameQueue, options: argparse.Namespace) -> dict[str, Any]:
    first: Frame | None = None
    payload_bytes = 0
    for so_far in range(options.frames):
        frame = _next(grabber, queue, options.timeout, so_far)
        first = first or frame
        payload_bytes += frame.payload.nbytes
        if options.out is not None:
            snapshot.save(frame, options.out, grabber.info)
    assert first is not None
    counters = grabber.statistics()
    # From the first frame's own time to the last's: opening the camera is not the camera's rate.
    seconds = max(0.0, (frame.received_ns - first.received_ns) / 1e9)
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


def _next(grabber: FrameGrabber, queue: FrameQueue, timeout: float, so_far: int) -> Frame:
    try:
        return queue.get(timeout)
    except FrameTimeoutError:
        raise no_frame(grabber, timeout, so_far) from None
