"""The slowest tests and their seconds, so that they begin first and no worker ends long after the others.

`slowest.txt` is written by `python tests/run_tests.py --record`. A test that is missing there counts as
quick and keeps its place; a name that no test has any more does no harm.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TypeVar

import pytest

T = TypeVar("T", bound=pytest.Item)

REMEMBERED = Path(__file__).with_suffix(".txt")
SLOW = 1.5
"""Seconds from which a test is remembered. Quicker ones stay together with those of their module."""


def name(path: str, test: str) -> str:
    """Return a name that outlives a move to the other tier: the path from the tier's folder, and the test."""
    return f"{Path(*Path(path).with_suffix('').parts[2:])}::{test}"


def first(items: Iterable[T]) -> list[T]:
    """Return the tests with the slowest at the beginning."""
    seconds = remembered()
    return sorted(items, key=lambda item: -seconds.get(name(item.nodeid.split("::")[0], item.name), 0.0))


def remembered() -> dict[str, float]:
    """Return the seconds of the slow tests by name."""
    lines = REMEMBERED.read_text(encoding="utf-8").splitlines() if REMEMBERED.exists() else []
    pairs = (line.split(" ", 1) for line in lines)
    return {test: float(seconds) for seconds, test in pairs}


def record(durations: dict[str, float]) -> None:
    """Write down the slow tests of a run in place of those of an earlier one."""
    slow = sorted(((s, test) for test, s in durations.items() if s >= SLOW), reverse=True)
    REMEMBERED.write_text("".join(f"{s:.1f} {test}\n" for s, test in slow), encoding="utf-8")
