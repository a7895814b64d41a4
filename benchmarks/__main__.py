"""Runs every benchmark in turn, or those that are named, and writes docs/benchmarks.md.

    python -m benchmarks [NAME [OPTION …]] [--only-write]

A benchmark with a function `measure(arguments) -> Section` fills a section of the document; one that has only
`main(arguments)` prints.
"""

from __future__ import annotations

import argparse
import importlib
import pkgutil
import time
from typing import Any

import benchmarks
from benchmarks import _document
from benchmarks._results import Section


def main() -> None:
    names = sorted(module.name for module in pkgutil.iter_modules(benchmarks.__path__))
    names = [name for name in names if not name.startswith("_")]
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Options after a NAME are that benchmark's own: python -m benchmarks.NAME --help.",
    )
    parser.add_argument("name", nargs="?", metavar="NAME", choices=names, help=f"of {', '.join(names)}")
    parser.add_argument("--only-write", action="store_true", help="measure nothing; write what was kept")
    options, rest = parser.parse_known_args()
    if rest and not options.name:
        parser.error(f"{' '.join(rest)}: name the benchmark that this is for")
    chosen = [options.name] if options.name else names
    for name in [] if options.only_write else chosen:
        print(f"== {name}", flush=True)
        began = time.monotonic()
        run(name, importlib.import_module(f"benchmarks.{name}"), rest)
        print(f"== {name} took {time.monotonic() - began:.0f} s\n", flush=True)
    _document.rewrite()


def run(name: str, module: Any, arguments: list[str]) -> None:
    """Measure, show and keep. One that cannot run here says why and stops no other."""
    try:
        if not hasattr(module, "measure"):
            module.main(arguments)
            return
        section: Section = module.measure(arguments)
    except SystemExit as reason:
        if reason.code not in (None, 0):
            print(f"{name}: {reason.code}")
        return
    print(_document.markdown(section))
    section.keep(name)


if __name__ == "__main__":
    main()
