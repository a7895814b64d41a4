"""Runs the tests as `make test` does: on several workers, the slowest first.

Usage: python tests/run_tests.py [PATH or option of pytest ...] [--record]

Two cores carry several workers, the programs that the tests start, and a virtual machine. Every failure is
one: a test that fails beside others and passes alone waits too briefly, or shows a race in the product.

`--record` writes the slowest tests of this run to `slowest.txt`, by which the next run orders them.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from importlib.util import cache_from_source
from pathlib import Path
from xml.etree import ElementTree

import slowest

REPOSITORY = Path(__file__).parents[1]
PACKAGE = REPOSITORY / "grabbergui"
UNIT = REPOSITORY / "tests" / "unit"
OUTCOME = REPOSITORY / "build" / "tests"


def main(arguments: list[str]) -> int:
    """Run the tests and return the exit code."""
    record = "--record" in arguments
    arguments = [argument for argument in arguments if argument != "--record"]
    shutil.rmtree(OUTCOME, ignore_errors=True)
    began = time.monotonic()
    compile_package()
    compile_tests([Path(argument) for argument in arguments if Path(argument).is_dir()])
    code = pytest(*arguments, f"--junitxml={OUTCOME / 'together.xml'}")
    if record:
        slowest.record(durations(OUTCOME / "together.xml"))
    print(f"The tests took {time.monotonic() - began:.0f} s.")
    return code


def compile_package() -> None:
    """Compile the package once, its forms, and its loops over pixels; or each worker and program does it."""
    subprocess.run([sys.executable, "-m", "compileall", "-q", "-j", "0", "grabbergui"], cwd=REPOSITORY)
    code = []
    if any(not is_newer(Path(cache_from_source(str(form))), form) for form in PACKAGE.rglob("forms/*.ui")):
        code.append("from grabbergui.ui.form_loader import compile_forms; compile_forms()")
    loops = PACKAGE / "core" / "compiled_loops.py"
    if not any(is_newer(made, loops) for made in loops.parent.glob("__pycache__/compiled_loops.*.nbi")):
        code.append("from grabbergui.core.compiled_loops import wait; wait()")
    if code:
        subprocess.run([sys.executable, "-c", "\n".join(code)], cwd=REPOSITORY, env=environment())


def is_newer(made: Path, source: Path) -> bool:
    """Return whether a file was made from its source as that is now."""
    return made.exists() and made.stat().st_mtime >= source.stat().st_mtime


def compile_tests(folders: Sequence[Path]) -> None:
    """Have pytest compile the test modules that have changed.

    Workers collect the same modules at the same time. Each would rewrite the assertions of all of them, which
    takes three times as long as all else that a worker does before its first test.
    """
    modules = sorted(module for folder in folders for module in folder.rglob("test_*.py"))
    changed = [module for module in modules if not is_compiled(module)]
    cores = os.cpu_count() or 1
    collectors = [
        subprocess.Popen(
            [sys.executable, "-m", "pytest", "--collect-only", "-qqq", "-p", "no:cacheprovider", *some],
            cwd=REPOSITORY,
            env=environment(),
            stdout=subprocess.DEVNULL,  # errors are shown by the run itself
            stderr=subprocess.DEVNULL,
        )
        for some in (changed[core::cores] for core in range(cores))
        if some
    ]
    for collector in collectors:
        collector.wait()


def is_compiled(module: Path) -> bool:
    """Return whether pytest has compiled the module as it is now."""
    compiled = (module.parent / "__pycache__").glob(f"{module.stem}.*-pytest-*.pyc")
    return any(is_newer(file, module) for file in compiled)


def pytest(*arguments: str) -> int:
    """Run pytest with `arguments` on as many workers as suit the machine."""
    # Workers take a few tests at a time from one queue, which has the slowest first.
    command = ["-m", "pytest", "-n", "auto", "--dist", "load", "--maxschedchunk", "6"]
    command += arguments
    variables = environment()
    if never_waits(arguments):
        variables.setdefault("GRABBERGUI_TEST_WORKERS", str(os.cpu_count() or 1))
    return subprocess.run([sys.executable, *command], cwd=REPOSITORY, env=variables).returncode


def never_waits(arguments: Sequence[str]) -> bool:
    """Return whether these are unit tests only: more workers than cores would only load more modules."""
    paths = [Path(argument).resolve() for argument in arguments if not argument.startswith("-")]
    return bool(paths) and all(UNIT in (path, *path.parents) for path in paths)


def environment() -> dict[str, str]:
    """Return the environment variables of a run."""
    variables = {**os.environ, "QT_QPA_PLATFORM": "offscreen"}
    variables.pop("PYTHONDONTWRITEBYTECODE", None)  # or each of a hundred programs compiles all of it
    return variables


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
