"""`grabbergui list`: every source found."""

from __future__ import annotations

import argparse
import json
from typing import Any

from grabbergui import sources
from grabbergui.cli.numbers import positive
from grabbergui.cli.stopping import dies_of_interrupt

_COLUMNS = ("uri", "vendor", "model", "serial", "address", "note")


_ROS2, _ROS2_MORE = "ros2:", 2.0
"""DDS participants announce themselves every three seconds: whoever missed an announcement hears the next one
in so many seconds more."""


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    parser = commands.add_parser("list", help="list every source found")
    parser.add_argument("--json", action="store_true", help="print one JSON array")
    parser.add_argument("--timeout", type=positive, default=2.0, metavar="S", help="seconds to look (2)")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    with dies_of_interrupt():
        found = sources.discover(options.timeout)
        if not any(info.uri.startswith(_ROS2) for info in found):
            found += sources.discover_kind("ros2", _ROS2_MORE)
    if options.json:
        print(json.dumps([info.as_dict() for info in found], indent=2))
        return 0
    rows = [tuple(column.upper() for column in _COLUMNS)]
    rows += [tuple(getattr(info, column) for column in _COLUMNS) for info in found]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        print("  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip())
    return 0
