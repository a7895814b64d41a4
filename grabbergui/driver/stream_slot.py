"""Where a device of a library keeps its stream: the one that runs, or what the last one counted."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

from grabbergui.core.grabber import StreamStatistics


class Stream(Protocol):
    """Receives from its construction until it is closed."""

    def close(self) -> None:
        """Stop; nothing is delivered any more on return."""

    def statistics(self) -> StreamStatistics:
        """A snapshot. Any thread."""


class StreamSlot:
    """One thread fills and empties it; any may ask for the statistics, which never waits."""

    def __init__(self) -> None:
        self._stream: Stream | None = None
        self._last = StreamStatistics()

    @property
    def taken(self) -> bool:
        """Whether a stream runs."""
        return self._stream is not None

    def put(self, stream: Stream) -> None:
        """Keep a stream that just began."""
        self._stream = stream

    def close(self) -> None:
        """Close the stream, if there is one. May be called twice."""
        stream, self._stream = self._stream, None
        if stream is not None:
            stream.close()
            self._last = replace(stream.statistics(), frame_rate=0.0, bandwidth=0.0)

    def statistics(self) -> StreamStatistics:
        """Of the stream that runs, or of the last one."""
        stream = self._stream
        return stream.statistics() if stream is not None else replace(self._last)
