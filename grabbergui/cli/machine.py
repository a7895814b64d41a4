"""Commands about this machine: `list` shows the sources in reach, `doctor` checks its configuration."""

from __future__ import annotations

import argparse
import json
from typing import Any

from grabbergui import sources
from grabbergui.cli.numbers import positive
from grabbergui.cli.process import dies_of_interrupt
from grabbergui.doctor.finding import Level
from grabbergui.setup.seen import Seen, somebody_types

_COLUMNS = ("uri", "vendor", "model", "serial", "address", "note")


_ROS2, _ROS2_MORE = "ros2:", 2.0
"""DDS participants announce themselves every three seconds: whoever missed an announcement hears the next one
in so many seconds more."""


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    _add_list(commands)
    _add_doctor(commands)


def _add_list(commands: Any) -> None:
    parser = commands.add_parser(
        "list", help="list every source found", example="grabbergui list --timeout 5 --json"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON array")
    parser.add_argument("--timeout", type=positive, default=2.0, metavar="S", help="seconds to search (2)")
    parser.set_defaults(run=_list)


def _list(options: argparse.Namespace) -> int:
    with dies_of_interrupt():
        found = sources.discover(options.timeout)
        if not any(info.uri.startswith(_ROS2) for info in found):
            found += sources.discover_kind("ros2", _ROS2_MORE)
    if somebody_types():
        Seen().keep_sources(info.uri for info in found)
    if options.json:
        print(json.dumps([info.as_dict() for info in found], indent=2))
        return 0
    rows = [tuple(column.upper() for column in _COLUMNS)]
    rows += [tuple(getattr(info, column) for column in _COLUMNS) for info in found]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        print("  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip())
    return 0


def _add_doctor(commands: Any) -> None:
    parser = commands.add_parser(
        "doctor",
        help="check this machine for what usually goes wrong; exit code 1 if something does",
        example="grabbergui doctor",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON array")
    # Its name before there was `setup udev`.
    parser.add_argument("--fix-udev", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument(
        "--clear-shared-memory",
        action="store_true",
        help="remove what killed ROS 2 programs left in /dev/shm",
    )
    parser.set_defaults(run=_doctor)


def _doctor(options: argparse.Namespace) -> int:
    from grabbergui.doctor import network, shared_memory, software, usb

    if options.fix_udev:
        from grabbergui.setup import udev

        print(f"wrote {udev.install()}; plug the camera in again")
        return 0
    if options.clear_shared_memory:
        removed = shared_memory.clear(shared_memory.leftovers(shared_memory.FOLDER))
        print(f"freed {shared_memory.megabytes(removed)}: {len(removed)} segments and ports without an owner")
        return 0
    findings = []
    with dies_of_interrupt():
        for checks in (network, usb, software, shared_memory):
            for finding in checks.check():
                findings.append(finding)
                if not options.json:
                    print(f"{finding.level.value:8}{finding.text}", flush=True)
                    if finding.remedy:
                        print(f"{'':8}→ {finding.remedy}", flush=True)
    if options.json:
        rows = [{"level": each.level.value, "text": each.text, "remedy": each.remedy} for each in findings]
        print(json.dumps(rows, indent=2))
    return 1 if any(finding.level is Level.PROBLEM for finding in findings) else 0
