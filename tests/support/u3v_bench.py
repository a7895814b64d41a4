"""Recorded transfers, for the tests beside."""

from __future__ import annotations

from pathlib import Path

DATA = Path(__file__).parents[1] / "data" / "u3v"


def records(name: str, kind: str) -> list[bytes]:
    """The transfers of one kind (C, S, D) in a transcript; see its README."""
    lines = (DATA / name).read_text().splitlines()
    return [bytes.fromhex(line.split()[1]) for line in lines if line.startswith(f"{kind} ")]


def transcripts() -> list[str]:
    return sorted(path.name for path in DATA.glob("*.txt") if "descriptors" not in path.name)
