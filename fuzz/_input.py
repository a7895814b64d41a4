"""A fuzzer's bytes as choices and messages."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from grabbergui.core.errors import GrabberError, RemoteProtocolError

DATA = Path(__file__).parents[1] / "tests" / "data"


class Input:
    """Takes pieces off the front of some bytes; after their end, zeros."""

    def __init__(self, data: bytes) -> None:
        self._data = data

    def take(self, count: int) -> bytes:
        """Return that many bytes, or the rest."""
        piece, self._data = self._data[:count], self._data[count:]
        return piece

    def number(self, size: int) -> int:
        """Return an unsigned big-endian number of that many bytes."""
        return int.from_bytes(self.take(size), "big")

    def rest(self) -> bytes:
        """Return the rest."""
        return self.take(len(self._data))

    def messages(self) -> Iterator[bytes]:
        """Return pieces, each after its length in two bytes."""
        while self._data:
            yield self.take(self.number(2))


def joined(messages: list[bytes]) -> bytes:
    """Join pieces as `messages` splits them."""
    return b"".join(len(message).to_bytes(2, "big") + message for message in messages)


def refusing(parse: Callable[..., Any], *arguments: Any) -> Any:
    """Return a parser's result, or None if it refused its input properly."""
    with contextlib.suppress(RemoteProtocolError):
        return parse(*arguments)
    return None


def erring(call: Callable[..., Any], *arguments: Any) -> Any:
    """Likewise, for a function that may raise any error of ours."""
    with contextlib.suppress(GrabberError):
        return call(*arguments)
    return None


def captured(kinds: str, *, most: int = 400) -> list[bytes]:
    """Return captured datagrams: C from the host, S and D from the camera, E events."""
    found = []
    for path in sorted((DATA / "gige").glob("*.txt")):
        lines = path.read_text().splitlines()
        found += [bytes.fromhex(line.split()[2]) for line in lines if line and line[0] in kinds]
    return found[:: max(len(found) // most, 1)]
