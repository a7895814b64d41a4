"""The newest frames of a camera's stream channels as the components of one frame."""

from __future__ import annotations

from dataclasses import replace

from grabbergui.core.frame import EncodedFrame, Frame

SILENCE = 2.0
"Seconds after which a channel that sends nothing is not shown any more."
MOST_CHANNELS = 16


class StreamChannels:
    """Merges the frames of several stream channels for display; with one channel, frames pass as they are.

    Channels need not run at one rate: each is shown as it was last. One thread at a time.
    """

    def __init__(self) -> None:
        self._latest: dict[int, tuple[Frame, float]] = {}

    def clear(self) -> None:
        """Forget all frames: another stream begins."""
        self._latest.clear()

    def merged(self, frame: Frame, now: float) -> Frame:
        """Take a frame that arrived at `now` (seconds); return it with the other channels' newest images.

        The result is the frame of the lowest channel; each component's `source` is its channel.
        """
        self._latest[frame.stream_channel] = (frame, now)
        latest = {
            channel: kept for channel, (kept, seen) in sorted(self._latest.items()) if now - seen < SILENCE
        }
        if len(latest) != len(self._latest):
            self._latest = {channel: self._latest[channel] for channel in latest}
        if len(latest) < 2 or any(isinstance(kept, EncodedFrame) for kept in latest.values()):
            return frame
        parts = tuple(
            replace(part, source=channel)
            for channel, kept in list(latest.items())[:MOST_CHANNELS]
            for part in kept.components
        )
        return replace(next(iter(latest.values())), parts=parts)
