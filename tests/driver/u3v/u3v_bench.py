"""Recorded transfers and a wait with a deadline, for the tests beside."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

DATA = Path(__file__).parents[2] / "data" / "u3v"


def records(name: str, kind: str) -> list[bytes]:
    """The transfers of one kind (C, S, D) in a transcript; see its README."""
    lines = (DATA / name).read_text().splitlines()
    return [bytes.fromhex(line.split()[1]) for line in lines if line.startswith(f"{kind} ")]


def transcripts() -> list[str]:
    return sorted(path.name for path in DATA.glob("*.txt") if "descriptors" not in path.name)


def wait_for(condition: Callable[[], bool], timeout: float = 5.0) -> None:
    deadline = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < deadline, "it did not come to pass in time"
        time.sleep(0.005)
