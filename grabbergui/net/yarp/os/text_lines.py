"""Text mode: lines, and Bottles that go on over several of them."""

from __future__ import annotations

from collections.abc import Callable

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.net.yarp.os.bottle_text import is_complete

LINE_LIMIT = 1 << 20
CONTINUED_LINES = 100
CONTINUED_BYTES = 1 << 18
"""Of a Bottle that goes on over several lines: each line is judged anew with all before it."""


class LineReader:
    """Cuts what arrives into lines, whether they end in CR LF or LF."""

    def __init__(self, limit: int = LINE_LIMIT) -> None:
        self._data = bytearray()
        self._searched = 0
        self._limit = limit

    @property
    def empty(self) -> bool:
        """Whether nothing of a next line has come."""
        return not self._data

    def feed(self, data: bytes) -> None:
        """Take what arrived. Raises RemoteProtocolError where a line has no end."""
        self._data += data
        if len(self._data) > self._limit and b"\n" not in self._data[: self._limit]:
            raise RemoteProtocolError(f"line of more than {self._limit} bytes")

    def line(self) -> str | None:
        """The next line without its end; None where it is not complete."""
        end = self._data.find(b"\n", self._searched)
        if end < 0:
            self._searched = len(self._data)
            return None
        line = bytes(self._data[:end]).rstrip(b"\r")
        del self._data[: end + 1]
        self._searched = 0
        return line.decode("utf-8", "surrogateescape")

    def bottle(self, next_line: Callable[[], str | None]) -> str | None:
        """A Bottle's text: it goes on after a backslash and while brackets or quotes are open."""
        text = next_line()
        size = lines = 0
        while text is not None:
            if text.endswith("\\"):
                joint, text = "", text[:-1]
            elif is_complete(text):
                return text
            else:
                joint = "\n"
            more = next_line()
            if more is None:
                return None
            size, lines = size + len(more), lines + 1
            if size > CONTINUED_BYTES or lines > CONTINUED_LINES:
                raise RemoteProtocolError("text of a Bottle without an end")
            text += joint + more
        return None
