"""Runs the tests as `make test` does: on several workers, then those that failed once more, alone.

Usage: python tests/run_tests.py [PATH or option of pytest ...] [--record]

Two cores carry several workers, the programs that the tests start, and a virtual machine. A test that fails
there and passes alone does not stop the build, because a busy machine may be the cause, but it is named at
the end of the output: it waits too briefly, or it shows a race in the product. A test that fails twice, or
more than a few failures, is a fault.

`--record` writes the slowest tests of this run to `slowest.txt`, by which the next run orders them.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path
from xml.etree import ElementTree

import slowest

REPOSITORY = Path(__file__).parents[1]
OUTCOME = REPOSITORY / "build" / "tests"
REPEATED = 10
"""So many failures are repeated. More of them are no coincidence."""
TESTS_FAILED = 1
"""Pytest's exit code when all tests ran and some failed."""


def main(arguments: list[str]) -> int:
    """Run the tests and return the exit code."""
    record = "--record" in arguments
    arguments = [argument for argument in arguments if argument != "--record"]
    shutil.rmtree(OUTCOME, ignore_errors=True)
    compile_package()
    began = time.monotonic()
    code = pytest(*arguments, f"--junitxml={OUTCOME / 'together.xml'}")
    if record:
        slowest.record(durations(OUTCOME / "together.xml"))
    if code == TESTS_FAILED:
        code = repeat_failures()
    print(f"The tests took {time.monotonic() - began:.0f} s.")
    return code


def compile_package() -> None:
    """Compile the package once; the tests start it as a program a hundred times."""
    subprocess.run([sys.executable, "-m", "compileall", "-q", "-j", "0", "grabbergui"], cwd=REPOSITORY)


def repeat_failures() -> int:
    """Run the tests that failed once more, one after the other with nothing beside them."""
    failed = failures()
    if not 0 < len(failed) <= REPEATED:
        print(f"{len(failed)} tests failed; at most {REPEATED} are repeated.")
        return TESTS_FAILED
    print(f"\n{len(failed)} failed beside others; each runs once more, alone.", flush=True)
    code = pytest("--last-failed", "--last-failed-no-failures=none", workers=1)
    if code == 0:
        print("\nFAILED BESIDE OTHERS, PASSED ALONE:", *failed, sep="\n    ")
        print("Such a test waits too briefly for a busy machine, or has found a race.\n")
    return code


def failures() -> list[str]:
    """Return the names of the tests that failed in the last run."""
    remembered = OUTCOME / "cache" / "v" / "cache" / "lastfailed"
    return sorted(json.loads(remembered.read_text())) if remembered.exists() else []


def pytest(*arguments: str, workers: int | None = None) -> int:
    """Run pytest with `arguments` on as many workers as suit the machine, or on `workers`."""
    environment = {**os.environ, "QT_QPA_PLATFORM": "offscreen"}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # or each of a hundred programs compiles all of it
    if workers is not None:
        environment["GRABBERGUI_TEST_WORKERS"] = str(workers)
    # Workers take a few tests at a time from one queue, which has the slowest first.
    command = ["-m", "pytest", "-n", "auto", "--dist", "load", "--maxschedchunk", "6"]
    command += ["-o", f"cache_dir={OUTCOME / 'cache'}", *arguments]
    return subprocess.run([sys.executable, *command], cwd=REPOSITORY, env=environment).returncode


def durations(outcome: Path) -> dict[str, float]:
    """Return the seconds that each test took, by its name as `slowest.name` gives it."""
    cases = ElementTree.parse(outcome).iter("testcase")
    return {
        slowest.name(case.get("classname", "").replace(".", "/") + ".py", case.get("name", "")): float(
            case.get("time", 0)
        )
        for case in cases
    }


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
