"""`grabbergui save`, `load` and `diff`: all settings of a camera, kept and brought back."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from grabbergui.cli.opening import add_source, opened
from grabbergui.cli.stopping import stop_on_signals
from grabbergui.core.errors import GrabberError
from grabbergui.models.settings import files
from grabbergui.models.settings.feature_set import FeatureSet, capture, compare
from grabbergui.models.settings.loading import SETTLED, load_onto, roll_back

EXIT_DIFFERENT = 1


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    saving = commands.add_parser("save", help="save all settings to a file (.yaml, or GenICam's own format)")
    add_source(saving)
    saving.add_argument("file", metavar="FILE", type=Path)
    saving.set_defaults(run=_save)

    loading = commands.add_parser("load", help="load settings from a file; say what became of each")
    add_source(loading)
    loading.add_argument("file", metavar="FILE", type=Path)
    loading.add_argument("--dry-run", action="store_true", help="only say what would be written")
    loading.add_argument("--all-or-nothing", action="store_true", help="roll back if any setting is refused")
    loading.set_defaults(run=_load)

    differing = commands.add_parser(
        "diff", help="compare a camera or a file with a file; exit code 1 if unlike"
    )
    differing.add_argument("first", metavar="SOURCE|FILE")
    differing.add_argument("second", metavar="FILE", type=Path)
    differing.set_defaults(run=_diff)


def _save(options: argparse.Namespace) -> int:
    with opened(options.source, reading=True) as grabber:
        features = capture(grabber)
    files.save(features, options.file)
    for text in features.left_out:
        print(f"left out {text}")
    print(f"saved {len(features)} settings to {options.file}")
    return 0


def _load(options: argparse.Namespace) -> int:
    with opened(options.source) as grabber, stop_on_signals() as cancelled:
        features = files.load(options.file, grabber.selectors.of)
        report = load_onto(grabber, features, dry_run=options.dry_run, cancelled=cancelled)
        print("\n".join(report.lines()))
        if options.all_or_nothing and not report.settled and not options.dry_run:
            print(f"rolled back: {roll_back(grabber, report).summary()}")
    unsettled = [setting for setting in report.settings if setting.outcome not in SETTLED]
    if not report.settled:
        raise GrabberError(
            f"{len(unsettled) + len(report.lost_lines)} of {len(report.settings) + len(report.lost_lines)}"
            f" settings are not as {options.file} has them"
        )
    return 0


def _diff(options: argparse.Namespace) -> int:
    first, second = _two_sets(options.first, options.second)
    for line in (*first.lost_lines, *second.lost_lines):
        print(line)
    differences = compare(first, second)
    for difference in differences:
        print(difference)
    return EXIT_DIFFERENT if differences else 0


def _two_sets(first: str, second: Path) -> tuple[FeatureSet, FeatureSet]:
    """A camera and a file, or two files; the one that knows what selectors select tells the other."""
    if ":" in first and not Path(first).is_file():
        with opened(first, reading=True) as grabber:
            return capture(grabber), files.load(second, grabber.selectors.of)
    one, other = files.load(Path(first)), files.load(second)
    if _is_yaml(first) and not _is_yaml(second):
        other = files.load(second, one.selectors_of)
    elif _is_yaml(second) and not _is_yaml(first):
        one = files.load(Path(first), other.selectors_of)
    return one, other


def _is_yaml(path: str | Path) -> bool:
    return Path(path).suffix.lower() in files.YAML_SUFFIXES
