"""Injects every fault and writes docs/reliability.md.

python -m benchmarks reliability [NAME …] [--list] [--only-write]
"""

from __future__ import annotations

import argparse
import importlib
import pkgutil
import time
from collections.abc import Sequence
from dataclasses import replace

import benchmarks
from benchmarks._faults import DOCUMENT, FAULTS, document, keep, kept
from benchmarks._results import machine

MODULES = ("_faults_strangers", "_faults_outages", "_faults_servo", "_faults_stops", "_faults_ros2")
"""The modules that have faults, here or in a guest's folder, in the order of the page's tables."""


def order_faults() -> None:
    """Sort the faults by MODULES, whatever the order of imports was."""
    ordered = sorted(FAULTS.items(), key=lambda item: MODULES.index(item[1][1].__module__.rpartition(".")[2]))
    FAULTS.clear()
    FAULTS.update(ordered)


def load_faults() -> None:
    """Import the faults of all modules."""
    for module in pkgutil.walk_packages(benchmarks.__path__, "benchmarks."):
        if module.name.rpartition(".")[2] in MODULES:
            importlib.import_module(module.name)
    order_faults()


def write() -> None:
    """Write the page from the stored outcomes."""
    load_faults()
    DOCUMENT.write_text(document(kept()), encoding="utf-8")


def main(arguments: Sequence[str] | None = None) -> None:
    load_faults()
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.reliability",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help="the faults to inject (all)")
    parser.add_argument("--list", action="store_true", help="only print the names of the faults")
    parser.add_argument(
        "--only-write", action="store_true", help="inject nothing; write the page from stored outcomes"
    )
    options = parser.parse_args(arguments)
    if unknown := [name for name in options.names if name not in FAULTS]:
        parser.error(f"{', '.join(unknown)}: no such fault, there are {', '.join(FAULTS)}")
    if options.list:
        print("\n".join(FAULTS))
        return
    failed = []
    for name in () if options.only_write else options.names or FAULTS:
        begun = time.monotonic()
        outcome = replace(FAULTS[name][1](), machine=machine())
        keep(name, outcome)
        print(
            f"{name}: {outcome.times}; lost {outcome.lost}; well after {outcome.well_after} "
            f"({time.monotonic() - begun:.0f} s)",
            flush=True,
        )
        failed += [] if outcome.survived else [name]
    write()
    if failed:
        raise SystemExit(f"not survived: {', '.join(failed)}")


if __name__ == "__main__":
    main()
