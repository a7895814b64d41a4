"""`grabbergui calibrate`: the lens of a camera, measured with a printed board."""

from __future__ import annotations

import argparse
import math
import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grabbergui.cli.arguments import count, opened, wait_time
from grabbergui.cli.gui import add_theme, importing_window
from grabbergui.cli.process import stop_on_signals
from grabbergui.core.environment import check_folder_of
from grabbergui.core.errors import CalibrationError, FrameTimeoutError, GrabberError, UsageError
from grabbergui.core.visible_text import print_line

if TYPE_CHECKING:
    from grabbergui.calibration.boards import BoardSettings
    from grabbergui.calibration.collector import Collector
    from grabbergui.core.identity import DeviceInfo

REMIND = 5.0
"Seconds without a new view after which the reason is printed."


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    parser = commands.add_parser(
        "calibrate",
        help="calibrate a camera with a printed board; writes a camera_info file",
        description="Hold the board still in many places: near, far, in every corner of the image, tilted.",
        example="grabbergui calibrate gige: --window --out camera.yaml",
    )
    parser.add_argument("source", metavar="SOURCE", nargs="?", help="the camera; sim:board to try it")
    parser.add_argument(
        "--window", action="store_true", help="open a window that shows the views still missing"
    )
    parser.add_argument(
        "--screenshot", type=Path, metavar="FILE", help="save a screenshot of the window after --seconds"
    )
    add_theme(parser)
    parser.add_argument(
        "--print", type=Path, metavar="FILE", dest="sheet", help="only save the board, as .pdf or .png"
    )
    parser.add_argument(
        "--board", choices=("charuco", "chessboard"), default="charuco", help="pattern on the board (charuco)"
    )
    parser.add_argument("--columns", type=int, default=8, help="squares in a row (8)")
    parser.add_argument("--rows", type=int, default=6, help="rows of squares (6)")
    parser.add_argument(
        "--square", type=float, default=0.03, metavar="M", help="edge of a square in metres (0.03)"
    )
    parser.add_argument(
        "--marker", type=float, default=0.022, metavar="M", help="edge of a marker in metres (0.022)"
    )
    parser.add_argument(
        "--dictionary", default="5X5_100", metavar="NAME", help="dictionary of the markers (5X5_100)"
    )
    parser.add_argument("--views", type=count, default=20, help="number of different views (20)")
    parser.add_argument(
        "--seconds", type=wait_time, default=180.0, metavar="S", help="give up after S seconds (180)"
    )
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("camera.yaml"),
        metavar="FILE",
        help="the file to write (camera.yaml)",
    )
    parser.add_argument("--name", default="camera", help="the camera's name in the file (camera)")
    parser.set_defaults(run=_calibrate)


def settings(options: argparse.Namespace) -> BoardSettings:
    """Return the board that was chosen."""
    from grabbergui.calibration.boards import BoardSettings

    return BoardSettings(
        options.board, options.columns, options.rows, options.square, options.marker, options.dictionary
    )


def _calibrate(options: argparse.Namespace) -> int:
    from grabbergui.calibration import camera_info, printed_sheet
    from grabbergui.calibration.collector import Collector

    board = settings(options).board()
    if options.sheet is not None:
        try:
            sheet = printed_sheet.save(board, options.sheet)
        except OSError as fault:
            raise GrabberError(f"{options.sheet} could not be written: {fault.strerror or fault}") from fault
        print_line(f"saved as {options.sheet}; print it on {sheet.paper} at 100 %, and measure the rule")
        return 0
    if not options.source:
        raise UsageError("calibrate which camera? Name a SOURCE, or --print FILE to print the board only")
    if options.window or options.screenshot:
        return _calibrate_in_window(options)
    check_writable(options.out)
    collector = Collector(board, options.views, still=True)
    camera = _collect(collector, options)
    result = collector.solve(options.name)
    for number, error in enumerate(result.errors, 1):
        print_line(f"view {number:3}: {'left out' if math.isnan(error) else f'{error:.3f} px'}")
    matrix, spread = result.calibration.matrix, result.uncertainty
    print_line(f"focal lengths {matrix[0, 0]:.1f} ± {spread[0]:.1f}, {matrix[1, 1]:.1f} ± {spread[1]:.1f} px")
    print_line(f"centre {matrix[0, 2]:.1f} ± {spread[2]:.1f}, {matrix[1, 2]:.1f} ± {spread[3]:.1f} px")
    print_line(f"error {result.rms:.3f} px, coverage {100 * collector.coverage.part:.0f} %")
    camera_info.save(result.calibration.made_with(camera), options.out)
    print_line(f"saved as {options.out}")
    return 0


def check_writable(path: Path) -> None:
    """Raise UsageError if the result could not be written, before minutes are spent on it."""
    check_folder_of(path)
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise UsageError(f"{path} could not be written; choose another --out")


def _calibrate_in_window(options: argparse.Namespace) -> int:
    """Calibrate in a window, which asks where to save. Raises CalibrationError if nothing was saved."""
    with importing_window("or leave out --window"):
        from grabbergui.ui.run import standalone
        from grabbergui.ui.theme import Theme
    seconds = options.seconds if options.screenshot else None
    theme = Theme(options.theme)
    with opened(options.source) as grabber, stop_on_signals() as stop:
        grabber.start()
        saved = standalone.calibrate(grabber, settings(options), options.screenshot, seconds, theme, stop)
    if saved is not None:
        print_line(f"saved as {saved}")
    elif seconds is None and not stop.is_set():
        raise CalibrationError("the window was closed, and no calibration saved")
    return 0


def _collect(collector: Collector, options: argparse.Namespace) -> DeviceInfo:
    """Collect views from the source until there are enough, or the time is up; return the camera."""
    from grabbergui.calibration.collector import ViewVerdict
    from grabbergui.calibration.frame_geometry import GeometryReader

    wrong = "--columns, --rows" + (" and --dictionary" if options.board == "charuco" else "")
    waiting = {
        ViewVerdict.NOT_SEEN: "no board is seen: bring all of it into the image, lit and in focus, "
        f"and check {wrong}",
        ViewVerdict.MOVING: "the board moves: hold it still for a moment",
        ViewVerdict.KNOWN: "this view is known: hold the board elsewhere, nearer, farther or tilted",
    }
    with opened(options.source) as grabber:
        queue = grabber.open_queue(1)
        geometries = GeometryReader(grabber)
        grabber.start()
        print_line(
            f"show the {options.board} board ({options.columns}×{options.rows} squares of "
            f"{options.square:g} m) to {grabber.info.title} and hold it still; "
            f"different views wanted: {collector.wanted}, within {options.seconds:g} s",
            flush=True,
        )
        last_report = time.monotonic()
        deadline = last_report + options.seconds
        seen = False
        try:
            while not collector.complete and time.monotonic() < deadline:
                frame = queue.get(min(5.0, max(0.1, deadline - time.monotonic())))
                if not frame.complete:
                    continue
                verdict, now = collector.look(frame.mono(), geometry=geometries.of(frame)), time.monotonic()
                seen |= verdict is not ViewVerdict.NOT_SEEN
                if verdict is ViewVerdict.KEPT:
                    hint = collector.coverage.missing()
                    last_report = now
                    print_line(
                        f"view {len(collector.views)} of {collector.wanted}, "
                        f"coverage {100 * collector.coverage.part:.0f} %"
                        f"{f'; next, hold it {hint}' if hint else ''}",
                        flush=True,
                    )
                elif now - last_report > REMIND:
                    last_report = now
                    print_line(f"{waiting[verdict]}; {max(0, deadline - now):.0f} s are left", flush=True)
        except FrameTimeoutError:
            if time.monotonic() < deadline:
                raise
        finally:
            queue.close()
            geometries.close()
            grabber.stop()
    if not seen:
        raise CalibrationError(
            f"no {options.board} board of {options.columns}×{options.rows} squares was seen; "
            f"check {wrong}, and the image in the window"
        )
    return grabber.info
