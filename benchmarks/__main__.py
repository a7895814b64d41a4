"""Runs all benchmarks, or the named one, and writes docs/benchmarks.md and docs/reliability.md.

    python -m benchmarks [NAME [OPTION …]]

A benchmark with a function `measure(arguments) -> Section` fills a section of the document; one that has only
`main(arguments)` prints.
"""

from __future__ import annotations

import argparse
import importlib
import pkgutil
import time
import traceback
from typing import Any

import benchmarks
from benchmarks import _document
from benchmarks._results import Section


def main() -> None:
    found = pkgutil.walk_packages(benchmarks.__path__, "benchmarks.")
    modules = {module.name.rpartition(".")[2]: module.name for module in found if not module.ispkg}
    names = sorted(name for name in modules if not name.startswith("_"))
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Options after a NAME are that benchmark's own: python -m benchmarks.NAME --help.",
    )
    parser.add_argument("name", nargs="?", metavar="NAME", choices=names, help=f"of {', '.join(names)}")
    options, rest = parser.parse_known_args()
    if rest and not options.name:
        parser.error(f"{' '.join(rest)}: name the benchmark that this is for")
    chosen = [options.name] if options.name else names
    failed = []
    for name in chosen:
        print(f"== {name}", flush=True)
        began = time.monotonic()
        if not run(name, importlib.import_module(modules[name]), rest):
            failed.append(name)
        print(f"== {name} took {time.monotonic() - began:.0f} s\n", flush=True)
    if failed:
        raise SystemExit(f"not measured: {', '.join(failed)}; the page keeps what it said of them")


def run(name: str, module: Any, arguments: list[str]) -> bool:
    """Measure, print and write; return whether that succeeded. A failure does not stop the others."""
    try:
        if hasattr(module, "measure"):
            section: Section = module.measure(arguments)
            print(_document.markdown(section))
            if not _document.put(section):
                print(f"{name}: without {section.lacking}, so the page keeps what it said.")
        elif hasattr(module, "main"):
            module.main(arguments)
    except SystemExit as reason:
        if reason.code in (None, 0):
            return True
        print(f"{name}: {reason.code}")
        return False
    except Exception:
        traceback.print_exc()
        return False
    return True


if __name__ == "__main__":
    main()
