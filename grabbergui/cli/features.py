"""`grabbergui features`, `get`, `set` and `run`: a camera's features."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from typing import Any

from grabbergui.cli.opening import add_source, opened
from grabbergui.core.errors import FeatureAccessError, UsageError
from grabbergui.core.features import AccessMode, Category, Feature, FeatureKind, format_value
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.selection import SettingKey
from grabbergui.models.features.text import typed_value


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    tree = commands.add_parser("features", help="show the feature tree with values and ranges")
    add_source(tree)
    tree.add_argument("--json", action="store_true", help="print one JSON array")
    tree.set_defaults(run=_features)

    getting = commands.add_parser("get", help="print NAME = VALUE UNIT, a line each")
    add_source(getting)
    getting.add_argument("names", metavar="NAME", nargs="+")
    getting.set_defaults(run=_get)

    setting = commands.add_parser("set", help="set features in order; print what the camera then reports")
    add_source(setting)
    setting.add_argument("assignments", metavar="NAME=VALUE", nargs="+")
    setting.set_defaults(run=_set)

    running = commands.add_parser("run", help="run a command of the camera")
    add_source(running)
    running.add_argument("command", metavar="COMMAND", help="e.g. TriggerSoftware")
    running.set_defaults(run=_run)


def assignment(text: str) -> tuple[SettingKey, str]:
    """`NAME=VALUE` in two; the name may have its selectors. Raises UsageError."""
    found = SettingKey.parse_assignment(text)
    if found is None:
        raise UsageError(f"'{text}' is not NAME=VALUE")
    return found


def write(grabber: FrameGrabber, key: SettingKey, text: str) -> Feature:
    """Write what was typed, a number perhaps with a unit (`20ms`); return what the camera then reports."""
    return grabber.write_setting(key, typed_value(text, grabber.feature(key.name))).feature


def report(feature: Feature) -> str:
    """`NAME = VALUE UNIT`."""
    unit = f" {feature.unit}" if feature.unit else ""
    return f"{feature.name} = {format_value(feature.value)}{unit}"


def _features(options: argparse.Namespace) -> int:
    with opened(options.source, reading=True) as grabber:
        if options.json:
            print(json.dumps([_as_dict(feature) for feature in grabber.features()], indent=2))
        else:
            for line in _tree_lines(grabber, grabber.feature_tree(), 0):
                print(line)
    return 0


def _get(options: argparse.Namespace) -> int:
    with opened(options.source, reading=True) as grabber:
        for name in options.names:
            feature = grabber.read_setting(SettingKey.parse(name))
            if feature.value is None:
                why = "is a command and has no value" if feature.kind is FeatureKind.COMMAND else None
                raise FeatureAccessError(f"{name} {why or feature.access_problem()}", name)
            print(report(feature))
    return 0


def _set(options: argparse.Namespace) -> int:
    assignments = [assignment(text) for text in options.assignments]
    with opened(options.source) as grabber:
        for key, text in assignments:
            print(report(write(grabber, key, text)))
    return 0


def _run(options: argparse.Namespace) -> int:
    with opened(options.source) as grabber:
        grabber.execute(options.command)
    return 0


def _tree_lines(grabber: FrameGrabber, category: Category, depth: int) -> Iterator[str]:
    for member in category.members:
        indent = "  " * depth
        if isinstance(member, Category):
            yield f"{indent}{member.title}"
            yield from _tree_lines(grabber, member, depth + 1)
        else:
            yield indent + _feature_line(grabber.feature(member.name))


def _feature_line(feature: Feature) -> str:
    if feature.problem:
        return f"{feature.name} (not available: {feature.problem})"
    if feature.kind is FeatureKind.COMMAND:
        return f"{feature.name} (command)"
    if feature.access is AccessMode.NOT_AVAILABLE:
        return f"{feature.name} (not available just now)"
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
        "display_name": feature.title,
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
