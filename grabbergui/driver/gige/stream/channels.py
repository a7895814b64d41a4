"""The stream channels of one device that are received, as one stream."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import fields

from grabbergui.core.errors import UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import StreamStatistics
from grabbergui.driver.device import StreamRequest
from grabbergui.driver.gige.bootstrap import STREAM_CHANNELS_MASK, Register
from grabbergui.driver.gige.control.link import DeviceMemory
from grabbergui.driver.gige.stream.channel import Stream

ALL_CHANNELS = -1
"In place of a channel's index."


def chosen_channels(memory: DeviceMemory, wanted: int) -> Sequence[int]:
    """Return the indices that `wanted` means for this device. Raises UsageError, and as registers do."""
    if wanted == 0:
        return (0,)  # every streaming device has channel 0, even if its register claims otherwise
    count = memory.read_register(Register.STREAM_CHANNELS) & STREAM_CHANNELS_MASK
    if wanted == ALL_CHANNELS:
        return range(max(count, 1))
    if wanted >= count:
        has = "only stream channel 0" if count < 2 else f"stream channels 0 to {count - 1}"
        raise UsageError(f"stream_channel={wanted}: this camera has {has}; choose one of them, or all")
    return (wanted,)


class Streams:
    """One or several open streams. `Frame.stream_channel` is the channel that a frame arrived on."""

    def __init__(self, channels: Sequence[Stream]) -> None:
        """Take at least one channel."""
        self._channels = channels

    def open(self, request: StreamRequest, deliver: Callable[[Frame], None], tick_frequency: int) -> None:
        """Start to receive; `deliver` is never called twice at a time. Raises as `Stream.open`."""
        if len(self._channels) > 1:
            deliver = _one_at_a_time(deliver)
        try:
            for channel in self._channels:
                channel.open(request, deliver, tick_frequency)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Close every channel and stop receiving. May be called twice; never raises."""
        for channel in self._channels:
            channel.close()

    def statistics(self) -> StreamStatistics:
        """Return a snapshot of the sums of all channels. Any thread."""
        total, *others = (channel.statistics() for channel in self._channels)
        for other in others:
            for counter in fields(StreamStatistics):
                value = getattr(total, counter.name) + getattr(other, counter.name)
                setattr(total, counter.name, value)
        return total

    @property
    def port(self) -> int:
        """The host's UDP port of the first channel; 0 before a stream."""
        return self._channels[0].port

    @property
    def packet_size(self) -> int:
        """Bytes of a packet of the first channel, headers included; 0 before a stream."""
        return self._channels[0].packet_size


def _one_at_a_time(deliver: Callable[[Frame], None]) -> Callable[[Frame], None]:
    lock = threading.Lock()

    def delivered(frame: Frame) -> None:
        with lock:
            deliver(frame)

    return delivered
