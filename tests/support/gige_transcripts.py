"""Reads the captured conversations in tests/data/gige."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

FOLDER = Path(__file__).parents[1] / "data" / "gige"
NAMES = sorted(path.stem for path in FOLDER.glob("*.txt"))
CAPTURES = [name for name in NAMES if not name.startswith(("probe-", "accept-"))]


@dataclass(frozen=True)
class Line:
    """One datagram."""

    kind: str
    "C host to device, S device to host, D stream, E event."
    peer: str
    "Tells host sockets apart."
    ms: float
    data: bytes


def lines(name: str, kinds: str = "CSDE") -> Iterator[Line]:
    """A conversation's datagrams of some kinds, in order."""
    for text in (FOLDER / f"{name}.txt").read_text().splitlines():
        if text and not text.startswith("#"):
            mark, ms, data = text.split()
            if mark[0] in kinds:
                yield Line(mark[0], mark[1:], float(ms), bytes.fromhex(data))
