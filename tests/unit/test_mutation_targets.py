"""Mutation testing names files and tests that exist."""

from __future__ import annotations

import runpy
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

SCRIPT = Path(__file__).parents[2] / "scripts" / "mutants"


@pytest.fixture(scope="module")
def mutants() -> Any:
    """Return what the script defines."""
    return SimpleNamespace(**runpy.run_path(str(SCRIPT), run_name="mutants"))


def test_each_target_has_files_and_tests(mutants: Any) -> None:
    assert {"gige/codecs", "gige/stream", "yarp/os", "core", "servo/gate"} <= set(mutants.TARGETS)
    for name, target in mutants.TARGETS.items():
        sources, tests = mutants.matches(name, target.sources), mutants.matches(name, target.tests)
        assert all(source.startswith("grabbergui/") for source in sources)
        assert tests and mutants.selection(name, target).count("not ") == len(target.deselected)


def test_what_does_not_exist_is_named(mutants: Any) -> None:
    with pytest.raises(SystemExit, match=r"^gone: nothing matches grabbergui/gone/\*\.py; correct TARGETS"):
        mutants.matches("gone", ("grabbergui/core/*.py", "grabbergui/gone/*.py"))
    target = mutants.Target(("grabbergui/core/*.py",), ("tests/unit/core",), ("test_that_is_gone",))
    with pytest.raises(SystemExit, match=r"^gone: no test is named test_that_is_gone; correct TARGETS"):
        mutants.selection("gone", target)
