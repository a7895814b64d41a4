"""Recorded conversations of real YARP programs, `tests/data/yarp/*.txt`, as bytes."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

DATA = Path(__file__).parents[1] / "data" / "yarp"


@dataclass
class Conversation:
    """One TCP connection, or one flow of datagrams."""

    client: bytes = b""
    server: bytes = b""
    turns: list[tuple[str, bytes]] = field(default_factory=list)
    "`C`, `S` or `U` (a datagram) and the bytes."


def read(name: str) -> list[Conversation]:
    found: list[Conversation] = []
    for line in (DATA / f"{name}.txt").read_text().splitlines():
        side, _, rest = line.partition(" ")
        if side == "conn":
            found.append(Conversation())
        elif side in ("C", "S", "U"):
            data = bytes.fromhex(rest)
            found[-1].turns.append((side, data))
            if side == "C":
                found[-1].client += data
            elif side == "S":
                found[-1].server += data
    return found


def streams(name: str, greeting: bytes) -> list[Conversation]:
    return [conversation for conversation in read(name) if conversation.client.startswith(greeting)]
