"""`grabbergui calibrate`: a camera's calibration from views of a printed board."""

from __future__ import annotations

import argparse
import math
import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grabbergui.cli.gui import add_theme, importing_window
from grabbergui.cli.opening import opened
from grabbergui.cli.parsing import count, positive
from grabbergui.cli.process import stop_on_signals
from grabbergui.core.errors import FrameTimeoutError, GrabberError, UsageError

if TYPE_CHECKING:
    from grabbergui.calibration.boards import BoardSettings
    from grabbergui.calibration.collector import Collector

REMIND = 5.0
"Seconds without a new view, after which it says what it waits for."


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    parser = commands.add_parser(
        "calibrate",
        help="calibrate a camera with a printed board; writes a camera_info file",
        description="Hold the board still, then elsewhere: near and far, in every corner, tilted.",
        example="grabbergui calibrate gige: --window --out camera.yaml",
    )
    parser.add_argument("source", metavar="SOURCE", nargs="?", help="the camera; sim:board to try it")
    parser.add_argument(
        "--window", action="store_true", help="open a window that shows the views still missing"
    )
    parser.add_argument(
        "--screenshot", type=Path, metavar="FILE", help="save the window's own picture after --seconds"
    )
    add_theme(parser)
    parser.add_argument(
        "--print", type=Path, metavar="FILE", dest="sheet", help="only save the board, as .pdf or .png"
    )
    parser.add_argument(
        "--board", choices=("charuco", "chessboard"), default="charuco", help="pattern on the board (charuco)"
    )
    parser.add_argument("--columns", type=int, default=8, help="fields across (8)")
    parser.add_argument("--rows", type=int, default=6, help="fields down (6)")
    parser.add_argument("--square", type=float, default=0.03, metavar="M", help="edge of a field (0.03)")
    parser.add_argument("--marker", type=float, default=0.022, metavar="M", help="edge of a marker (0.022)")
    parser.add_argument("--dictionary", default="5X5_100", metavar="NAME", help="of the markers (5X5_100)")
    parser.add_argument("--views", type=count, default=20, help="how many different views (20)")
    parser.add_argument("--seconds", type=positive, default=180.0, metavar="S", help="give up after (180)")
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("camera.yaml"),
        metavar="FILE",
        help="the result (camera.yaml)",
    )
    parser.add_argument("--name", default="camera", help="the camera's name in the file (camera)")
    parser.set_defaults(run=_run)


def settings(options: argparse.Namespace) -> BoardSettings:
    """The board that was chosen."""
    from grabbergui.calibration.boards import BoardSettings

    return BoardSettings(
        options.board, options.columns, options.rows, options.square, options.marker, options.dictionary
    )


def _run(options: argparse.Namespace) -> int:
    from grabbergui.calibration import board_sheet, camera_info
    from grabbergui.calibration.collector import Collector

    board = settings(options).board()
    if options.sheet is not None:
        try:
            sheet = board_sheet.save(board, options.sheet)
        except OSError as fault:
            raise GrabberError(f"{options.sheet} could not be written: {fault.strerror or fault}") from fault
        print(f"saved as {options.sheet}; print it on {sheet.paper} at 100 %, and measure the rule")
        return 0
    if not options.source:
        raise UsageError("calibrate which camera? Name a SOURCE, or --print FILE to print the board only")
    if options.window or options.screenshot:
        return _show(options)
    if not options.out.parent.is_dir():
        raise UsageError(f"there is no folder {options.out.parent} for the calibration")
    if not os.access(options.out if options.out.exists() else options.out.parent, os.W_OK):
        raise UsageError(f"the calibration could not be written to {options.out}; choose another --out")
    collector = Collector(board, options.views, still=True)
    _collect(collector, options)
    result = collector.solve(options.name)
    for number, error in enumerate(result.errors, 1):
        print(f"view {number:3}: {'left out' if math.isnan(error) else f'{error:.3f} px'}")
    matrix, spread = result.calibration.matrix, result.uncertainty
    print(f"focal lengths {matrix[0, 0]:.1f} ± {spread[0]:.1f}, {matrix[1, 1]:.1f} ± {spread[1]:.1f} px")
    print(f"centre {matrix[0, 2]:.1f} ± {spread[2]:.1f}, {matrix[1, 2]:.1f} ± {spread[3]:.1f} px")
    print(f"error {result.rms:.3f} px, coverage {100 * collector.coverage.part:.0f} %")
    camera_info.save(result.calibration, options.out)
    print(f"saved as {options.out}")
    return 0


def _show(options: argparse.Namespace) -> int:
    """The same in a window, which asks where to save."""
    with importing_window("or leave out --window"):
        from grabbergui.ui.run import standalone
        from grabbergui.ui.theme import Theme
    seconds = options.seconds if options.screenshot else None
    theme = Theme(options.theme)
    with opened(options.source) as grabber, stop_on_signals() as stop:
        grabber.start()
        saved = standalone.calibrate(grabber, settings(options), options.screenshot, seconds, theme, stop)
    if saved is not None:
        print(f"saved as {saved}")
    return 0


def _collect(collector: Collector, options: argparse.Namespace) -> None:
    """Look at the source until there are enough views, or the time is up."""
    from grabbergui.calibration.collector import Verdict

    waiting = {
        Verdict.NOT_SEEN: "no board is seen: bring all of it into the picture, lit and in focus",
        Verdict.MOVING: "the board moves: hold it still for a moment",
        Verdict.KNOWN: "this view is known: hold the board elsewhere, nearer, farther or tilted",
    }
    deadline = time.monotonic() + options.seconds
    with opened(options.source) as grabber:
        queue = grabber.open_queue(1)
        grabber.start()
        print(
            f"show the {options.board} board ({options.columns}×{options.rows} fields of "
            f"{options.square:g} m) to {grabber.info.title} and hold it still; "
            f"{collector.wanted} different views are wanted, within {options.seconds:g} s",
            flush=True,
        )
        said = time.monotonic()
        try:
            while not collector.complete and time.monotonic() < deadline:
                frame = queue.get(min(5.0, max(0.1, deadline - time.monotonic())))
                if not frame.complete:
                    continue
                verdict, now = collector.look(frame.mono()), time.monotonic()
                if verdict is Verdict.KEPT:
                    hint = collector.missing()
                    said = now
                    print(
                        f"view {len(collector.views)} of {collector.wanted}, "
                        f"coverage {100 * collector.coverage.part:.0f} %"
                        f"{f'; next, hold it {hint}' if hint else ''}",
                        flush=True,
                    )
                elif now - said > REMIND:
                    said = now
                    print(f"{waiting[verdict]}; {deadline - now:.0f} s are left", flush=True)
        except FrameTimeoutError:
            if time.monotonic() < deadline:
                raise
        finally:
            queue.close()
            grabber.stop()
