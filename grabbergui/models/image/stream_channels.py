"""The stream channels that frames arrive on."""

from __future__ import annotations

from dataclasses import replace

from grabbergui.core.frame import EncodedFrame, Frame

CHANNEL_SILENCE = 2.0
"Seconds without a frame after which a channel is no longer shown."
MOST_CHANNELS = 16


class StreamChannels:
    """Merges the frames of several stream channels for display; with one channel, frames pass unchanged.

    Channels may have different rates: the newest frame of each is shown. One thread at a time.
    """

    def __init__(self) -> None:
        self._latest: dict[int, tuple[Frame, float]] = {}

    def clear(self) -> None:
        """Forget all frames, because another stream begins."""
        self._latest.clear()

    def merged(self, frame: Frame, now: float) -> Frame:
        """Add a frame that arrived at `now` (seconds), and return it with the other channels' images.

        The result is the frame of the lowest channel; each component's `source` is its channel.
        """
        self._latest[frame.stream_channel] = (frame, now)
        latest = {
            channel: kept
            for channel, (kept, seen) in sorted(self._latest.items())
            if now - seen < CHANNEL_SILENCE
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
