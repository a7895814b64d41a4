"""Commands about features: one by one (`get`, `set`, `run`), or all in a file (`save`, `load`, `diff`)."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from grabbergui.cli import PartialResultError
from grabbergui.cli.arguments import add_source, counted, opened, remember_values
from grabbergui.cli.process import stop_on_signals
from grabbergui.core.environment import check_folder_of
from grabbergui.core.errors import FeatureAccessError, UsageError
from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.features import AccessMode, Category, Feature, FeatureKind, FeatureValue
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.settings import SettingKey
from grabbergui.core.visible_text import print_json, print_line, print_lines
from grabbergui.models.features.number_input import typed_value
from grabbergui.models.settings import files
from grabbergui.models.settings.feature_set import FeatureSet, capture, compare
from grabbergui.models.settings.loading import SETTLED, LoadReport, load_onto, roll_back

EXIT_DIFFERENT = 1


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    _add_features(commands)
    _add_settings(commands)


def _add_features(commands: Any) -> None:
    tree = commands.add_parser(
        "features", help="show the feature tree with values and ranges", example="grabbergui features gige:"
    )
    add_source(tree)
    tree.add_argument("--json", action="store_true", help="print one JSON array")
    tree.set_defaults(run=_features)

    getting = commands.add_parser(
        "get",
        help="print features as NAME = VALUE UNIT, one per line",
        example="grabbergui get gige: ExposureTime 'BalanceRatio[BalanceRatioSelector=Red]'",
    )
    add_source(getting)
    getting.add_argument("names", metavar="NAME", nargs="+", help="a feature, with any selectors in brackets")
    getting.add_argument("--json", action="store_true", help="print one JSON object, values by name")
    getting.set_defaults(run=_get)

    setting = commands.add_parser(
        "set",
        help="set features in this order, and print what the camera then reports",
        example="grabbergui set gige: ExposureAuto=Off ExposureTime=20ms",
    )
    add_source(setting)
    setting.add_argument(
        "assignments",
        metavar="NAME=VALUE",
        nargs="+",
        help="a feature and its value, with or without a unit; addresses as 192.168.0.5",
    )
    setting.add_argument("--json", action="store_true", help="print one JSON object, values by name")
    setting.set_defaults(run=_set)

    running = commands.add_parser(
        "run", help="run a command of the camera", example="grabbergui run gige: TriggerSoftware"
    )
    add_source(running)
    running.add_argument("command", metavar="COMMAND", help="the name of a command feature")
    running.set_defaults(run=_run)


def assignment(text: str) -> tuple[SettingKey, str]:
    """Split `NAME=VALUE`; the name may have selectors. Raises UsageError."""
    found = SettingKey.parse_assignment(text)
    if found is None:
        raise UsageError(f"'{text}' is not NAME=VALUE; write it in one word, as in ExposureTime=20ms")
    return found


def write(grabber: FeatureSource, key: SettingKey, text: str) -> Feature:
    """Write a typed value, perhaps a number with a unit (`20ms`); return the feature afterwards."""
    return grabber.write_setting(key, typed_value(text, grabber.feature(key.name))).feature


def report(feature: Feature, key: SettingKey | None = None) -> str:
    """Return `NAME = VALUE UNIT`, the name with the selectors of `key`."""
    unit = f" {feature.unit}" if feature.unit else ""
    return f"{key or feature.name} = {feature.text}{unit}"


def _features(options: argparse.Namespace) -> int:
    read: list[Feature] = []
    with opened(options.source, reading=True) as grabber:
        if options.json:
            read += grabber.features()
            print_json([_as_dict(feature) for feature in read], indent=2)
        else:
            for line in _tree_lines(grabber, grabber.feature_tree(), 0, read):
                print_line(line)
        remember_values(options.source, read)
    return 0


def _get(options: argparse.Namespace) -> int:
    values: dict[str, FeatureValue | None] = {}
    with opened(options.source, reading=True) as grabber:
        for name in options.names:
            key = SettingKey.parse(name)
            feature = grabber.read_setting(key)
            remember_values(options.source, [feature])
            if feature.value is None:
                why = "is a command and has no value" if feature.kind is FeatureKind.COMMAND else None
                raise FeatureAccessError(f"{name} {why or feature.access_problem()}", name)
            values[name] = feature.spelled(feature.value)
            if not options.json:
                print_line(report(feature, _with_selectors(grabber, key)))
    if options.json:
        print_json(values, indent=2)
    return 0


def _set(options: argparse.Namespace) -> int:
    assignments = [assignment(text) for text in options.assignments]
    values: dict[str, FeatureValue | None] = {}
    with opened(options.source) as grabber:
        for key, text in assignments:
            feature = write(grabber, key, text)
            remember_values(options.source, [feature])
            values[str(key)] = feature.spelled(feature.value)
            if not options.json:
                print_line(report(feature, _with_selectors(grabber, key)))
    if options.json:
        print_json(values, indent=2)
    return 0


def _with_selectors(grabber: FeatureSource, key: SettingKey) -> SettingKey:
    """Return a setting with all its selectors: those not given as the camera has them now."""
    present = grabber.setting(key.name)
    return SettingKey(key.name, tuple({**dict(present.selected), **dict(key.selected)}.items()))


def _run(options: argparse.Namespace) -> int:
    with opened(options.source) as grabber:
        grabber.execute(options.command)
    return 0


def _tree_lines(grabber: FeatureSource, category: Category, depth: int, read: list[Feature]) -> Iterator[str]:
    """Yield a line for each category and feature; add the features to `read`."""
    for member in category.members:
        indent = "  " * depth
        if isinstance(member, Category):
            yield f"{indent}{member.title}"
            yield from _tree_lines(grabber, member, depth + 1, read)
        else:
            read.append(grabber.feature(member.name))
            yield indent + _feature_line(read[-1])


def _feature_line(feature: Feature) -> str:
    if feature.problem:
        return f"{feature.name} (not available: {feature.problem})"
    if feature.kind is FeatureKind.COMMAND:
        return f"{feature.name} (command)"
    if feature.access is AccessMode.NOT_AVAILABLE:
        return f"{feature.name} (not available at the moment)"
    if feature.access is AccessMode.READ_ONLY:
        return f"{report(feature)} (read-only)"
    if feature.kind in (FeatureKind.STRING, FeatureKind.BOOLEAN):
        return report(feature)
    return f"{report(feature)} ({feature.range_text()})"


def _as_dict(feature: Feature) -> dict[str, Any]:
    return {
        "name": feature.name,
        "kind": feature.kind.value,
        "category": feature.category,
        "display_name": feature.display_name or feature.name,
        "value": feature.value,
        "minimum": feature.minimum,
        "maximum": feature.maximum,
        "increment": feature.increment,
        "unit": feature.unit,
        "representation": feature.representation.value,
        "access": feature.access.value,
        "visibility": feature.visibility.name.lower(),
        "tooltip": feature.tooltip,
        "entries": [entry.name for entry in feature.entries if entry.available],
        "auto": feature.auto,
        "selectors": list(feature.selectors),
        "problem": feature.problem,
    }


def _add_settings(commands: Any) -> None:
    saving = commands.add_parser(
        "save",
        help="save all settings to a file (.yaml, or GenICam's own format)",
        example="grabbergui save gige: camera.yaml",
    )
    add_source(saving)
    saving.add_argument(
        "file",
        metavar="FILE",
        type=Path,
        help="the file to write: YAML if it ends in .yaml or .yml, otherwise GenICam's format",
    )
    saving.add_argument("--json", action="store_true", help="print one JSON object")
    saving.set_defaults(run=_save)

    loading = commands.add_parser(
        "load",
        help="load settings from a file and report the outcome of each",
        example="grabbergui load gige: camera.yaml --dry-run",
    )
    add_source(loading)
    loading.add_argument(
        "file", metavar="FILE", type=Path, help="a settings file of `save` or of a vendor's viewer"
    )
    loading.add_argument("--json", action="store_true", help="print one JSON object")
    loading.add_argument("--dry-run", action="store_true", help="only report what would be written")
    loading.add_argument("--all-or-nothing", action="store_true", help="roll back if any setting is refused")
    loading.set_defaults(run=_load)

    differing = commands.add_parser(
        "diff",
        help="compare a camera or a file with a file; exit code 1 if they differ",
        example="grabbergui diff gige: camera.yaml",
    )
    differing.add_argument(
        "first", metavar="SOURCE|FILE", help="a camera with its current settings, or a file"
    )
    differing.add_argument("second", metavar="FILE", type=Path, help="the file to compare with")
    differing.add_argument("--json", action="store_true", help="print one JSON array")
    differing.set_defaults(run=_diff)


def _save(options: argparse.Namespace) -> int:
    check_folder_of(options.file)
    with opened(options.source, reading=True) as grabber:
        features = capture(grabber)
    files.save(features, options.file)
    if options.json:
        saved = {"file": str(options.file), "saved": len(features), "left_out": list(features.left_out)}
        print_json(saved, indent=2)
        return 0
    for text in features.left_out:
        print_line(f"left out {text}")
    print_line(f"saved {counted(len(features), 'setting')} to {options.file}")
    return 0


def _load(options: argparse.Namespace) -> int:
    with opened(options.source) as grabber:
        features = files.load(options.file, grabber.selectors.of)
        report, rolled_back = _apply(grabber, features, options)
    result = {**_loaded(report), "rolled_back": rolled_back}
    if not report.settled:
        unsettled = [setting for setting in report.settings if setting.outcome not in SETTLED]
        problem = report.problem  # lost before the written values were read back, for instance
        if unsettled or report.lost_lines:
            lines = len(report.lost_lines)
            problem = (
                f"{len(unsettled) + lines} of {len(report.settings) + lines}"
                f" settings are not as {options.file} has them"
            )
        raise PartialResultError(problem, result)
    if options.json:
        print_json(result, indent=2)
    return 0


def _apply(
    grabber: FrameGrabber, features: FeatureSet, options: argparse.Namespace
) -> tuple[LoadReport, str | None]:
    """Load settings, and roll them back with --all-or-nothing if any fails; return both outcomes."""
    with stop_on_signals() as cancelled:
        report = load_onto(grabber, features, dry_run=options.dry_run, cancelled=cancelled)
        rolled_back = None
        if not options.json:
            print_lines(report.lines())
        if options.all_or_nothing and not report.settled and not options.dry_run:
            after = roll_back(grabber, report)
            rolled_back = "; ".join(part for part in (after.problem, after.summary()) if part)
            if not options.json:
                print_line(f"rolled back: {rolled_back}")
    return report, rolled_back


def _loaded(report: LoadReport) -> dict[str, Any]:
    settings = [
        {
            "name": str(each.key),
            "outcome": each.outcome.value,
            "before": each.before,
            "wanted": each.wanted,
            "reason": each.reason,
        }
        for each in report.settings
    ]
    return {"settings": settings, "lost_lines": list(report.lost_lines), "problem": report.problem}


def _diff(options: argparse.Namespace) -> int:
    first, second = _two_sets(options.first, options.second)
    differences = compare(first, second)
    if options.json:
        rows = [{"name": str(each.key), "first": each.first, "second": each.second} for each in differences]
        print_json(rows, indent=2)
    else:
        for line in (*first.lost_lines, *second.lost_lines, *map(str, differences)):
            print_line(line)
    return EXIT_DIFFERENT if differences else 0


def _two_sets(first: str, second: Path) -> tuple[FeatureSet, FeatureSet]:
    """Return the sets of a camera and a file, or of two files; camera or YAML file provide the selectors."""
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
