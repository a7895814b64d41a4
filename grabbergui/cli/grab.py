"""`grab`: take frames from a camera, and save or count them."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
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
from grabbergui.core.errors import LocalFileError, UsageError
from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.core.grabber import FrameGrabber
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
        queue.needs_all = True
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


class _OneFile:
    """The file that all frames are saved in. Its errors name it, as those of a full disk do not."""

    def __init__(self, writer: RecordingWriter) -> None:
        self._writer = writer
        self._frames = 0

    def save(self, frame: Frame) -> None:
        """Add a frame. Raises LocalFileError, RecordingError, PixelFormatError."""
        try:
            self._writer.write(frame)
        except OSError as error:
            raise LocalFileError.of(self._writer.path, "written", error) from error
        self._frames += 1

    def finish(self) -> None:
        """Finish the file, or remove it if it has no frame. Raises LocalFileError."""
        try:
            self._writer.close()
            if not self._frames:
                self._writer.discard()
        except OSError as error:
            raise LocalFileError.of(self._writer.path, "written", error) from error


@contextmanager
def _saving(options: argparse.Namespace, grabber: FrameGrabber) -> Iterator[Callable[[Frame], None]]:
    """Yield what saves a frame as the options say; then finish the file. Raises UsageError."""
    if options.ply and options.out is None:
        raise UsageError("--ply saves into the folder of --out; name one")
    scan = read_scan3d(grabber) if options.ply else None
    writer = _writer_of(options, grabber.info)
    if writer is None:
        yield lambda frame: _save(frame, options.out, grabber, scan) if options.out is not None else None
        return
    file = _OneFile(writer)
    try:
        yield file.save
    except BaseException:
        with suppress(LocalFileError):  # the first error has the cause
            file.finish()
        raise
    file.finish()


def _collect(source: AwaitedSource, queue: FrameQueue, options: argparse.Namespace) -> dict[str, Any]:
    first: Frame | None = None
    payload_bytes = 0
    with _saving(options, source.grabber) as save, progress_note() as show:
        for so_far in range(options.frames):
            show(lambda: f"{so_far} of {counted(options.frames, 'frame')}")  # noqa: B023  # called at once
            frame = source.next_frame(queue, so_far)
            first = first or frame
            payload_bytes += frame.nbytes
            save(frame)
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
