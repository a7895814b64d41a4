"""Requests and replies out of the recorded RPC conversations in `tests/data/yarp/rpc_*.txt`.

Recorded from YARP's own programs on a loopback interface: `_312` from YARP 3.12.3, `_40` from 4.0.0.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

DATA = Path(__file__).parents[1] / "data" / "yarp"

_INDEX = bytes.fromhex("59410a00 00005250")
_ACK = bytes.fromhex("59410000 00005250")
_CALL = bytes.fromhex("00000000 7e640001")


@dataclass(frozen=True)
class Exchange:
    """One request and what was answered, both without framing."""

    request: bytes
    reply: bytes


def exchanges(name: str) -> list[Exchange]:
    """The calls of a transcript, in order; a reply that never came is empty."""
    found: list[Exchange] = []
    request = b""
    for line in (DATA / f"{name}.txt").read_text().splitlines():
        side, _, digits = line.partition(" ")
        if side == "C":
            request = _request(bytes.fromhex(digits))
        elif side == "S" and request:
            found.append(Exchange(request, bytes.fromhex(digits).removesuffix(_ACK)))
            request = b""
    return found


def _request(message: bytes) -> bytes:
    start = message.find(_INDEX)
    if start < 0:
        return b""
    blocks = message[start + 8]
    payload = message[start + 18 + 4 * (blocks + 1) :]
    return payload[8:] if payload.startswith(_CALL) else b""
