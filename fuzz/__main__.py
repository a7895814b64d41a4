"""Runs targets with atheris, each in a process of its own.

    python -m fuzz [NAME …] [--seconds 60]

build/fuzz/NAME keeps the corpus between runs. An input that makes a target fail is written to
build/fuzz/NAME-crash-…; `python -m fuzz NAME --input FILE` repeats it.
"""

from __future__ import annotations

import argparse
import hashlib
import importlib
import logging
import pkgutil
import subprocess
import sys
from pathlib import Path

import fuzz

KEPT = Path("build/fuzz")
MEMORY_MB = 1500
"For one allocation."
PROCESS_MB = 6000
"For the process, whose instrumentation keeps records of each input."
LONGEST_INPUT_S = 60
"By the clock: on a busy machine an input of a tenth of a second may take long."
LONGEST_INPUT = 8192
"Bytes."


def names() -> list[str]:
    """Return the names of all targets."""
    found = (module.name for module in pkgutil.iter_modules(fuzz.__path__))
    return sorted(name for name in found if not name.startswith("_"))


def main() -> int:
    """Run the targets on the command line; return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m fuzz", description="Fuzz the parsers.")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(names())}; all")
    parser.add_argument("--seconds", type=int, default=60, help="for each target (60)")
    parser.add_argument("--input", type=Path, help="run a target on this file once, and no more")
    parser.add_argument("--here", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    for name in options.names:
        if name not in names():
            parser.error(f"no target {name}; there are {', '.join(names())}")
    if options.input is not None:
        for name in options.names:
            importlib.import_module(f"fuzz.{name}").one_input(options.input.read_bytes())
        return 0
    if options.here:
        fuzz_here(options.names[0], options.seconds)
    failed = []
    for name in options.names or names():
        print(f"== {name}", flush=True)
        command = [sys.executable, "-m", "fuzz", name, "--here", "--seconds", str(options.seconds)]
        if subprocess.run(command, check=False).returncode:
            failed.append(name)
    if failed:
        print(f"failed: {', '.join(failed)}; the inputs lie in {KEPT}")
    return bool(failed)


def fuzz_here(name: str, seconds: int) -> None:
    """Fuzz one target; the process ends with it."""
    try:
        import atheris
    except ImportError:
        sys.exit("fuzzing needs atheris: pip install atheris")
    with atheris.instrument_imports(include=["grabbergui", "fuzz"]):
        target = importlib.import_module(f"fuzz.{name}")
    logging.disable()
    corpus = KEPT / name
    corpus.mkdir(parents=True, exist_ok=True)
    for seed in target.seeds():
        (corpus / hashlib.sha1(seed, usedforsecurity=False).hexdigest()).write_bytes(seed)
    arguments = [
        f"-max_total_time={seconds}",
        f"-malloc_limit_mb={MEMORY_MB}",
        f"-rss_limit_mb={PROCESS_MB}",
        f"-timeout={LONGEST_INPUT_S}",
        f"-max_len={LONGEST_INPUT}",
        f"-artifact_prefix={KEPT}/{name}-",
        "-print_final_stats=1",
        "-verbosity=0",
    ]
    atheris.Setup([name, *arguments, str(corpus)], target.one_input)
    atheris.Fuzz()


if __name__ == "__main__":
    sys.exit(main())
