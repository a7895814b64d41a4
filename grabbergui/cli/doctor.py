"""`grabbergui doctor`: what usually goes wrong, and how to mend it."""

from __future__ import annotations

import argparse
from typing import Any

from grabbergui.cli.stopping import dies_of_interrupt
from grabbergui.doctor.finding import Level


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    parser = commands.add_parser(
        "doctor", help="check this machine for what usually goes wrong; exit code 1 if something does"
    )
    parser.add_argument("--fix-udev", action="store_true", help="install the rule for USB3 Vision cameras")
    parser.add_argument(
        "--clear-shared-memory",
        action="store_true",
        help="remove what killed ROS 2 programs left in /dev/shm",
    )
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from grabbergui.doctor import network, shared_memory, software, usb

    if options.fix_udev:
        print(f"wrote {usb.install_udev_rule()}; plug the camera in again")
        return 0
    if options.clear_shared_memory:
        removed = shared_memory.clear(shared_memory.leftovers(shared_memory.FOLDER))
        print(f"freed {shared_memory.megabytes(removed)}: {len(removed)} segments and ports without an owner")
        return 0
    problems = 0
    with dies_of_interrupt():
        for checks in (network, usb, software, shared_memory):
            for finding in checks.check():
                problems += finding.level is Level.PROBLEM
                print(f"{finding.level.value:8}{finding.text}", flush=True)
                if finding.remedy:
                    print(f"{'':8}→ {finding.remedy}", flush=True)
    return 1 if problems else 0
