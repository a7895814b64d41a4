"""A fuzzer's bytes as choices and messages."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from grabbergui.core.errors import GrabberError, RemoteProtocolError

DATA = Path(__file__).parents[1] / "tests" / "data"


class Input:
    """Takes pieces off the front of some bytes; zeros where they end."""

    def __init__(self, data: bytes) -> None:
        self._data = data

    def take(self, count: int) -> bytes:
        """That many bytes, or what is left."""
        piece, self._data = self._data[:count], self._data[count:]
        return piece

    def number(self, size: int) -> int:
        """An unsigned number of so many bytes."""
        return int.from_bytes(self.take(size), "big")

    def rest(self) -> bytes:
        """All that is left."""
        return self.take(len(self._data))

    def messages(self) -> Iterator[bytes]:
        """Pieces of two bytes' length, each behind that length."""
        while self._data:
            yield self.take(self.number(2))


def joined(messages: list[bytes]) -> bytes:
    """What `messages` would split again."""
    return b"".join(len(message).to_bytes(2, "big") + message for message in messages)


def refusing(parse: Callable[..., Any], *arguments: Any) -> Any:
    """What a parser made of its input; None where it refused as it should."""
    with contextlib.suppress(RemoteProtocolError):
        return parse(*arguments)
    return None


def erring(call: Callable[..., Any], *arguments: Any) -> Any:
    """As `refusing`, for what may answer with any of our errors."""
    with contextlib.suppress(GrabberError):
        return call(*arguments)
    return None


def captured(kinds: str, *, most: int = 400) -> list[bytes]:
    """Datagrams that others wrote: C from the host, S and D from the camera, E events."""
    found = []
    for path in sorted((DATA / "gige").glob("*.txt")):
        lines = path.read_text().splitlines()
        found += [bytes.fromhex(line.split()[2]) for line in lines if line and line[0] in kinds]
    return found[:: max(len(found) // most, 1)]
