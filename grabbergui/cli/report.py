"""The command that makes the report of a camera."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from grabbergui.cli.arguments import add_source, count_or_none
from grabbergui.cli.process import passing_note
from grabbergui.core.environment import check_folder_of, write_whole
from grabbergui.core.errors import ExistingFileError
from grabbergui.core.visible_text import print_json, print_line, print_lines


def add_commands(commands: Any) -> None:
    """Add the parser of `report`."""
    parser = commands.add_parser(
        "report",
        help="write all about a camera to one file, to attach to a bug report",
        description="Says what is inside before it writes. `twin:FILE.zip` makes the camera again.",
        example="grabbergui report gige: --out camera.zip",
    )
    add_source(parser)
    parser.add_argument(
        "--out", type=Path, metavar="FILE.zip", help="the file to write (report-MODEL-TIME.zip)"
    )
    parser.add_argument(
        "--keep-names",
        action="store_true",
        help="keep names, serial numbers, MAC and IP addresses instead of replacing them by stand-ins",
    )
    parser.add_argument("--pixels", action="store_true", help="also keep the pixels of the first frames")
    parser.add_argument(
        "--frames",
        type=count_or_none,
        default=200,
        metavar="N",
        help="record headers and times of N frames (200); 0 does not start the stream",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=_report)


def _report(options: argparse.Namespace) -> int:
    # Not at the top: they import the drivers.
    from grabbergui.driver.twin import report_file
    from grabbergui.report.collect import ReportOptions, report_on
    from grabbergui.report.stand_ins import without_names
    from grabbergui.report.summary import contents, file_name, with_readme

    if options.out is not None:
        _check_new(options.out)
    wanted = ReportOptions(min(options.frames, report_file.MOST_FRAMES), pixels=options.pixels)
    with passing_note("asking the camera …") as show:
        report = report_on(options.source, wanted, lambda step: show(f"{step} …"))
    kept = options.keep_names
    if not kept:
        report = without_names(report)
    lines = contents(report, names_kept=kept)
    path = options.out or Path(file_name(report))
    _check_new(path)
    if not options.json:
        print_lines((f"{path} will contain", *(f"  {line}" for line in lines)), flush=True)
    write_whole(path, report_file.encode(with_readme(report, names_kept=kept)))
    if options.json:
        result = {"file": str(path), "contents": lines, "problems": list(report.problems)}
        print_json(result, indent=2)
    else:
        print_line(f"wrote {path}")
    return 0


def _check_new(path: Path) -> None:
    check_folder_of(path)
    if path.exists():
        raise ExistingFileError(f"{path} exists already; give another name with --out")
